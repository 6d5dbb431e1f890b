"""The eight branches of a near limb at an arm angle, on its true chain.

The closed form of the nearest exact limb gives the starts; Newton's method takes all of them to the true chain in step.
"""

import math

from srs_ik.kernels.algebra.joint_vectors import store7, with_joint
from srs_ik.kernels.algebra.lanes import ALL, as_bits, scatter
from srs_ik.kernels.algebra.pointers import read7, row, scratch
from srs_ik.kernels.chain.eight import in_own_branch, put_eight, sines_of_eight, take_eight
from srs_ik.kernels.chain.newton import STEPS, close_at_angle, pose_step
from srs_ik.kernels.chain.newton_eight import close_eight
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import ROW_COST
from srs_ik.kernels.layout.limb import COSINE_OFF, FAR, PHASE, SHIFT, SHOULDER, WRIST
from srs_ik.kernels.limb.branches import NO_BRANCH, UNSURE, branch_of, elbow_starts, side_posture
from srs_ik.kernels.limb.goal import NO_SEED, TIE, cost, turned
from srs_ik.kernels.limb.in_line import ROUNDED, closest, may_line_up, toward_of
from srs_ik.kernels.limb.postures_eight import eight_branches, farthest_turns, join_parts
from srs_ik.kernels.limb.surface import split, width_for_curves
from srs_ik.kernels.limb.triangle import elbow_side

MOST_BENT = 0.3
"""Widest bend of the elbow, rad, that counts as almost straight."""

AROUND = 4
BENT_AROUND = 0.5
"""Starts around the line S-W, next to a straight elbow, and their part of the bend of `bent_place`."""

SPLITS = 4
"""Postures along a free split from which a curve of postures may be found."""

SINGULAR_WRIST = 1e-2
"""Sine of q6 below which steps in eight, which divide by what axes 5 to 7 span, may lead elsewhere than steps with
pivots."""

FIRST = 8
WIDTH = 9
"""The branches are in the rows of the work space A (16, 9) from FIRST on: seven angles, the cost, one to spare."""


@kernel
def almost_straight(P):
    """Up to this bend of the elbow, rad, the true chain may have it straight."""
    return math.sqrt(2.0 * P[COSINE_OFF])


@kernel
def with_bend(place_, bend):
    """A place whose elbow is bent at least so far, rad."""
    t, h0, c, s, hand, miss = place_
    return place_ if s >= bend else (t, h0, math.copysign(math.sqrt(1.0 - bend * bend), c), bend, hand, miss)


@kernel
def bent_place(P, place_):
    """A place whose elbow is not almost straight: there the bend depends on the square root of what its cosine is off.

    The bends of the true chain at a pose are so different that Newton's method starts better from a wider one.
    """
    return with_bend(place_, min(MOST_BENT, almost_straight(P)))


@kernel
def evaluate_branch(P, target, psi, branch, goal, A):
    """Posture of one branch at an arm angle on the true chain: q, cost (NO_BRANCH where there is none)."""
    R, p, place_ = target
    side = elbow_side(P, place_, branch >> 2)
    seeded, seed, respect = goal
    q, _, lowest = side_posture(P, side, psi, (branch >> 1) & 1, branch & 1, seeded, seed, respect)
    if lowest >= NO_BRANCH:
        return q, lowest
    closed_q, closed = close_at_angle(P, q, R, p, place_[0], place_[1], psi, STEPS, A)
    if not closed or branch_of(P, closed_q) != branch:
        # Newton's method may have met the pose, but elsewhere: that is no answer.
        return q, NO_BRANCH
    q = turned(P, closed_q, seeded, seed, respect)
    return q, cost(P, q, seeded, seed, respect)


@kernel
def start_all(P, place_, psi, seeded, seed, respect, A):
    """Write the closed form's posture of every branch at an arm angle into A; which exist, as bits."""
    q, sure = eight_branches(P, place_, psi)
    if sure:
        put_eight(row(A, FIRST), WIDTH, ALL, q)
        return ALL
    exist = 0
    for elbow in range(2):
        if elbow_starts(P, place_, psi, elbow, seeded, seed, respect, A, FIRST + 4 * elbow):
            exist |= 0b1111 << 4 * elbow
    return exist


@kernel
def close_all(P, target, psi, wanted, goal, pivots, A):
    """The postures of all branches at an arm angle (or of one, 0 to 7) into A, and their costs.

    A cost is NO_BRANCH where there is no posture; where one is wanted, those of others tell no more. Steps with pivots
    follow where those in eight miss one (`pivots`), or only next to a singular wrist: from the same start, they seldom
    lead elsewhere. Returns whether steps in eight have led to every branch.
    """
    R, p, place_ = target
    seeded, seed, respect = goal
    bent = bent_place(P, place_)
    exist = start_all(P, bent, psi, seeded, seed, respect, A)
    rows = row(A, FIRST)
    closed, met = close_eight(P, take_eight(rows, WIDTH), R, p, place_[0], place_[1], psi, STEPS)
    sines = sines_of_eight(P, closed)
    met &= exist & in_own_branch(sines)
    if met == ALL and not seeded:
        closed, parts = farthest_turns(P, closed, respect)
        put_eight(rows, WIDTH, ALL, closed)
        scatter(rows, ROW_COST, WIDTH, join_parts(parts))
        return True
    again = exist if pivots else exist & ~as_bits(abs(sines[2]) > SINGULAR_WRIST)
    put_eight(rows, WIDTH, met, closed)
    for b in range(8):
        if wanted >= 0 and b != wanted:
            A[FIRST + b, ROW_COST] = 0.0 if (met >> b) & 1 == 1 else NO_BRANCH
            continue
        q, lowest = turned(P, read7(row(A, FIRST + b)), seeded, seed, respect), NO_BRANCH
        if (met >> b) & 1 == 1:
            lowest = cost(P, q, seeded, seed, respect)
        elif (again >> b) & 1 == 1:
            q, lowest = evaluate_branch(P, target, psi, b, goal, A)
        for j in range(7):
            A[FIRST + b, j] = q[j]
        A[FIRST + b, ROW_COST] = lowest
    return met == ALL


@kernel
def put_around(P, target, psi, wanted, goal, each, A):
    """Take over better postures into A, as `close_all` leaves it, from starts all around the line S-W.

    Next to a straight elbow a branch may have two postures at an arm angle: the elbow turns on a circle beside that
    line, and the half-plane of the arm angle cuts it twice. Another branch has none then.
    """
    R, p, place_ = target
    seeded, seed, respect = goal
    bent = with_bend(place_, BENT_AROUND * min(MOST_BENT, almost_straight(P)))
    others = scratch(16, 9)
    for k in range(AROUND + 1):
        # The last ones are as straight as the closed form says.
        start = bent if k < AROUND else place_
        exist = start_all(P, start, psi + 2.0 * math.pi / AROUND * k, False, NO_SEED, False, others)
        closed, met = close_eight(P, take_eight(row(others, FIRST), WIDTH), R, p, place_[0], place_[1], psi, STEPS)
        put_eight(row(others, FIRST), WIDTH, met, closed)
        for b in range(8):
            if (met & exist) >> b & 1 == 1:
                q = turned(P, read7(row(others, FIRST + b)), seeded, seed, respect)
                branch, value = branch_of(P, q), cost(P, q, seeded, seed, respect)
                known = A[FIRST + branch, ROW_COST]
                # Curves, on which each branch is looked for that is missed, tell more.
                if wanted in (-1, branch) and value < known and not (each and known >= NO_BRANCH):
                    store7(row(A, FIRST + branch), 0, q)
                    A[FIRST + branch, ROW_COST] = value


@kernel
def best_row(rows, first, wanted):
    """The branch of least cost among eight rows, of equal ones the lowest, or the wanted one (0 to 7)."""
    if wanted >= 0:
        return wanted
    best = 0
    for branch in range(1, 8):
        if rows[first + branch, ROW_COST] < rows[first + best, ROW_COST] - TIE:
            best = branch
    return best


@kernel
def best_of_all(P, target, psi, wanted, goal, A):
    """Best posture at an arm angle over all branches, or in one (0 to 7): q, branch, cost."""
    close_all(P, target, psi, wanted, goal, wanted < 0, A)
    return best_in(A, wanted)


@kernel
def best_in(A, wanted):
    """The best posture of those in A, or that of a branch: q, branch, cost."""
    best = best_row(A, FIRST, wanted)
    return read7(row(A, FIRST + best)), best, A[FIRST + best, ROW_COST]


@kernel
def is_one_line(P, q, target, first, J):
    """Whether the outer axes of a spherical joint, in line by their directions, are one line of the true chain too."""
    pose_step(P, q, target.R, target.p, J)
    toward = toward_of(P, SHOULDER if first == 0 else WRIST, q[first + 1])
    off = 0.0
    for i in range(3):
        off = max(off, abs(J[i, first] - toward * J[i, first + 2]))
    return off < ROUNDED * P[FAR]


@kernel
def width_of_splits(P, place_):
    """How close to one line outer axes of the nearest exact limb are, rad, where those of the true chain may be one."""
    return max(width_for_curves(P), UNSURE * P[SHIFT] / max(place_[3], almost_straight(P)))


@kernel
def put_splits(P, target, J, starts, n):
    """Append postures along which a sum of two joints alone is fixed, on the true chain too, or almost; their number.

    They are a curve of their own, or where others cross it almost, a part of these: rounding decides which way those
    are followed on.
    """
    width = width_of_splits(P, target.place)
    if not may_line_up(P, target.place, width):
        return n
    for i in range(16):
        k, first, end = (SHOULDER, 0, i & 1) if i & 2 == 0 else (WRIST, 4, i & 1)
        side = elbow_side(P, target.place, i >> 3)
        psi, off, _ = closest(P, k, side[1] if first == 0 else side[2], end)
        if off > width:
            continue
        other = (i >> 2) & 1
        q, _, _ = side_posture(P, side, psi, other, other, False, NO_SEED, False)
        q = with_joint(q, first + 1, P[k + PHASE] + end * math.pi)
        for m in range(SPLITS if n + SPLITS <= starts.shape[0] and is_one_line(P, q, target, first, J) else 0):
            store7(row(starts, n), 0, split(P, k, q, 2.0 * math.pi * m / SPLITS))
            n += 1
    return n
