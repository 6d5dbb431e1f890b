"""Postures of a branch that follow one another: at an arm angle, in the turns of the posture before.

What the postures of an elbow branch of a pose share may be worked out once, and read again.
"""

import math

from srs_ik.kernels.algebra.joint_vectors import difference, largest
from srs_ik.kernels.algebra.lane_trig import angle_of, turn
from srs_ik.kernels.algebra.lanes import as_bits, gather, where, whole_number
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import load3, scale, store3
from srs_ik.kernels.chain.eight import sines_of_eight
from srs_ik.kernels.chain.newton import clipped
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import LOWER, RANGE_KIND, SHOULDER, UPPER, WRIST
from srs_ik.kernels.layout.path import SIDE, SIDE_ELBOW, SIDE_FOREARM, SIDE_LINE, SIDE_SHOULDER, SIDE_WRIST
from srs_ik.kernels.limb.limits import PER_TURN, TURN, turn_to_middle
from srs_ik.kernels.limb.self_motion import turned_rates
from srs_ik.kernels.limb.spherical import angles, columns_at, eight_middles, middle_angle, sines
from srs_ik.kernels.limb.triangle import elbow_side, target_of
from srs_ik.kernels.pose.moved import gather3

ON_LIMIT = 3e-7
"""A posture beyond its limits by less than this, rad, is put on them: intervals may be found with that much room."""

CLEAR = 1e-4
"""A sine of joints 2 or 6, from their phases, above which a spherical joint has two solutions that are far apart."""


@kernel
def turn_on(P, joint, angle, near, followed):
    """The turn of a joint angle: inside the limits if these tell, else the one nearest to the posture before."""
    if not followed or P[RANGE_KIND + joint] != 0.0:
        return turn_to_middle(P, joint, angle)
    return angle + TURN * math.floor((near - angle) / TURN + 0.5)


@kernel
def turn_all(P, q, near, followed):
    """`turn_on` for all joints."""
    return (
        turn_on(P, 0, q[0], near[0], followed),
        turn_on(P, 1, q[1], near[1], followed),
        turn_on(P, 2, q[2], near[2], followed),
        turn_on(P, 3, q[3], near[3], followed),
        turn_on(P, 4, q[4], near[4], followed),
        turn_on(P, 5, q[5], near[5], followed),
        turn_on(P, 6, q[6], near[6], followed),
    )


@kernel
def half_posture(P, k, motion, turn, sign, anchor):
    """One solution of a spherical joint at cosine and sine of an arm angle, and whether its axes can make it."""
    v, y = columns_at(motion, turn[0], turn[1])
    cm, sm, reached = middle_angle(P, k, v)
    return angles(P, k, v, y, cm, sm, sign, anchor), reached


@kernel
def posture_of(P, side, psi, branch, near, followed):
    """The posture of a branch of an exact limb at an arm angle, following another one, and whether there is one."""
    turn = (math.cos(psi), math.sin(psi))
    a, reached_s = half_posture(P, SHOULDER, side[1], turn, (branch >> 1) & 1, (followed, near[0], near[2], True))
    b, reached_w = half_posture(P, WRIST, side[2], turn, branch & 1, (followed, near[4], near[6], True))
    return turn_all(P, (a[0], a[1], a[2], side[0], b[0], b[1], b[2]), near, followed), reached_s and reached_w


@kernel
def settled(P, q, slack):
    """The posture with joints that lie outside their limits by rounding put on them, and whether it is inside then."""
    inside = True
    for j in range(7):
        inside = inside and q[j] <= P[UPPER + j] + slack and q[j] >= P[LOWER + j] - slack
    return clipped(P, q), inside


@kernel
def turned_away(q, near):
    """Largest joint step between two postures, whole turns left out."""
    return largest(difference(near, q))


@kernel
def along_cell(a, b):
    """The seven joint steps from one posture of a strip to the next."""
    return (b[0] - a[0], b[1] - a[1], b[2] - a[2], b[3] - a[3], b[4] - a[4], b[5] - a[5], b[6] - a[6])


@kernel
def write_circles(out, k, motion):
    """Write the first two of three circles, from column k on."""
    for i in range(3):
        store3(out, k + 3 * i, motion[0][i])
        store3(out, k + 9 + 3 * i, motion[1][i])


@kernel
def read_circles(side, k):
    """Three circles as they are in `elbow_side`; nobody here asks for the third one."""
    v = load3(side, k), load3(side, k + 3), load3(side, k + 6)
    y = load3(side, k + 9), load3(side, k + 12), load3(side, k + 15)
    return v, y, v


@kernel
def write_side(P, T, branch, out):
    """Write what the postures of a branch of a pose share, (SIDE,)."""
    place_ = target_of(P, T).place
    angle, shoulder, wrist, from_forearm = elbow_side(P, place_, branch >> 2)
    out[SIDE_ELBOW] = angle
    store3(out, SIDE_LINE, place_[0])
    store3(out, SIDE_FOREARM, from_forearm)
    write_circles(out, SIDE_SHOULDER, shoulder)
    write_circles(out, SIDE_WRIST, wrist)


@kernel
def read_side(side):
    """The elbow branch as `elbow_side` gives it, but for its third circles."""
    shoulder, wrist = read_circles(side, SIDE_SHOULDER), read_circles(side, SIDE_WRIST)
    return side[SIDE_ELBOW], shoulder, wrist, load3(side, SIDE_FOREARM)


@kernel
def eight_circles(sides, k):
    """The first two of three circles of eight poses."""
    v = gather3(sides, k, SIDE), gather3(sides, k + 3, SIDE), gather3(sides, k + 6, SIDE)
    return v, (gather3(sides, k + 9, SIDE), gather3(sides, k + 12, SIDE), gather3(sides, k + 15, SIDE))


@kernel
def turned_near(x, near):
    """Eight angles in the turns nearest to others."""
    return x + TURN * whole_number((near - x) * PER_TURN)


@kernel
def eight_halves(P, k, circles, turns, near):
    """Eight solutions of a spherical joint at cosines and sines of arm angles, following others; which are clear cut.

    The others are three angles each, and the sines of the middle ones.
    """
    q, side = near
    v, y = columns_at(circles, turns[0], turns[1])
    c, s, missed = eight_middles(P, k, v)
    one, two, three, _ = sines(P, k, v, y, c, where(side < 0.0, -s, s))
    clear = as_bits((s > CLEAR) & (abs(side) > CLEAR)) & ~as_bits(missed)
    first = turned_near(angle_of(one[0], one[1]), q[0])
    return (first, turned_near(angle_of(two[0], two[1]), q[1]), turned_near(angle_of(three[0], three[1]), q[2])), clear


@kernel
def eight_followed(P, sides, psi, q):
    """The postures of eight poses at arm angles, in the branches and turns of others beside them; which are clear cut.

    Of the others, which are no farther than half a turn, the middle joints tell the branches.
    """
    turns = turn(psi)
    s2, _, s6 = sines_of_eight(P, q)
    a, clear_s = eight_halves(P, SHOULDER, eight_circles(sides, SIDE_SHOULDER), turns, ((q[0], q[1], q[2]), s2))
    b, clear_w = eight_halves(P, WRIST, eight_circles(sides, SIDE_WRIST), turns, ((q[4], q[5], q[6]), s6))
    elbow = turned_near(gather(sides, SIDE_ELBOW, SIDE), q[3])
    return (a[0], a[1], a[2], elbow, b[0], b[1], b[2]), clear_s & clear_w


@kernel
def eight_rates(P, sides, q):
    """Joint rates of eight poses with the arm angle at a posture of each, and as bits, which are clear cut."""
    r1, r2, r3, v = turned_rates(P, SHOULDER, turn(q[0]), turn(q[1]), gather3(sides, SIDE_LINE, SIDE))
    back = scale(-1.0, gather3(sides, SIDE_FOREARM, SIDE))
    r5, r6, r7, w = turned_rates(P, WRIST, turn(q[4]), turn(q[5]), back)
    s2, _, s6 = sines_of_eight(P, q)
    return (r1 / v, r2 / v, r3 / v, 0.0 * v, r5 / w, r6 / w, r7 / w), as_bits((abs(s2) > CLEAR) & (abs(s6) > CLEAR))


@kernel
def write_sides(P, course, branch):
    """Write the sides of all postures of a path that may move."""
    for c in range(course.chain.shape[0]):
        i = course.chain[c]
        if not course.fixed[i]:
            write_side(P, row(course.poses, i), branch[i], row(course.sides, i))
