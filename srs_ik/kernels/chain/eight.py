"""Eight postures at once: read from rows and written there, measured on the true chain, sorted into branches."""

from srs_ik.kernels.algebra.lane_trig import turn, turns_of
from srs_ik.kernels.algebra.lanes import ALL, LANES, as_bits, as_mask, eight_of, gather, one_of, root, scatter, where
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import dot, sub
from srs_ik.kernels.chain.kinematics import tip_frame, turn_between
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import PHASE, SHOULDER, STRAIGHT, WRIST
from srs_ik.kernels.limb.postures_eight import BEYOND_SHOULDER, BEYOND_STRAIGHT, BEYOND_WRIST


@kernel
def take_ways(rows, first, width):
    """Seven figures from one on, of eight rows, each as eight floats."""
    return (
        gather(rows, first, width),
        gather(rows, first + 1, width),
        gather(rows, first + 2, width),
        gather(rows, first + 3, width),
        gather(rows, first + 4, width),
        gather(rows, first + 5, width),
        gather(rows, first + 6, width),
    )


@kernel
def take_eight(rows, width):
    """The first seven figures of eight rows, each as eight floats."""
    return take_ways(rows, 0, width)


@kernel
def rows_of(figures, first, last, width):
    """A figure of up to eight rows as eight floats, that of the last one again and again."""
    return eight_of(
        figures[width * first],
        figures[width * min(first + 1, last)],
        figures[width * min(first + 2, last)],
        figures[width * min(first + 3, last)],
        figures[width * min(first + 4, last)],
        figures[width * min(first + 5, last)],
        figures[width * min(first + 6, last)],
        figures[width * min(first + 7, last)],
    )


@kernel
def postures_of(nodes, first, last, width):
    """Joint angles of up to eight postures."""
    return (
        rows_of(nodes, first, last, width),
        rows_of(row(nodes, 1), first, last, width),
        rows_of(row(nodes, 2), first, last, width),
        rows_of(row(nodes, 3), first, last, width),
        rows_of(row(nodes, 4), first, last, width),
        rows_of(row(nodes, 5), first, last, width),
        rows_of(row(nodes, 6), first, last, width),
    )


@kernel
def highest(x):
    """The largest of eight floats."""
    most = one_of(x, 0)
    for k in range(1, LANES):
        most = max(most, one_of(x, k))
    return most


@kernel
def put_some(rows, column, width, which, x):
    """Write one figure into those of eight rows that a mask names."""
    scatter(rows, column, width, where(which, x, gather(rows, column, width)))


@kernel
def put_eight(rows, width, which, q):
    """Write seven figures into those of eight rows that are named by bits."""
    mask = as_mask(which)
    put_some(rows, 0, width, mask, q[0])
    put_some(rows, 1, width, mask, q[1])
    put_some(rows, 2, width, mask, q[2])
    put_some(rows, 3, width, mask, q[3])
    put_some(rows, 4, width, mask, q[4])
    put_some(rows, 5, width, mask, q[5])
    put_some(rows, 6, width, mask, q[6])


@kernel
def tip_errors(P, q, R, p):
    """How far the tips are from a pose (m), tangents of the angles they are off, and where these are angles, as a mask.

    See `kinematics.frame_error`: a tangent is the angle where it is tiny.
    """
    x, y, z, tip = tip_frame(P, turns_of(q))
    sine2, twice_cosine = turn_between(x, y, z, R)
    twice_sine = root(dot(sine2, sine2))
    off = sub(p, tip)
    return root(dot(off, off)), twice_sine / twice_cosine, twice_sine < 1e-8 * twice_cosine


@kernel
def sines_of_eight(P, q):
    """Sines of the middle angles of eight postures, from their phases on: shoulder, elbow, wrist."""
    _, s2 = turn(q[1] - P[SHOULDER + PHASE])
    _, s4 = turn(q[3] - P[STRAIGHT])
    _, s6 = turn(q[5] - P[WRIST + PHASE])
    return s2, s4, s6


@kernel
def in_own_branch(sines):
    """Which of eight postures, as bits, lie each in the branch of its place among them, told by `sines_of_eight`."""
    s2, s4, s6 = sines
    wrong = as_bits(s4 < 0.0) ^ BEYOND_STRAIGHT
    wrong |= as_bits(s2 < 0.0) ^ BEYOND_SHOULDER
    wrong |= as_bits(s6 < 0.0) ^ BEYOND_WRIST
    return ALL & ~wrong


@kernel
def branches_of(sines):
    """The branches of eight postures, as eight floats, from the sines of their middle angles."""
    s2, s4, s6 = sines
    none = 0.0 * s2
    return where(s4 < 0.0, none + 4.0, none) + where(s2 < 0.0, none + 2.0, none) + where(s6 < 0.0, none + 1.0, none)
