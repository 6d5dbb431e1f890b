"""The eight branches at an arm angle, on the exact limb.

A branch is numbered 4 e + 2 s + w: e = 0 where q4 - STRAIGHT is positive, s = 0 and w = 0 where q2 and q6 lie above
their phase. Two elbow angles give two rotations of the arm; each has two shoulder and two wrist solutions.
"""

import math

from srs_ik.kernels.algebra.pointers import copy
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import ROW_COST
from srs_ik.kernels.layout.limb import A1_A2, A2_A3, LOWER, PHASE, SHIFT, SHOULDER, SIZE, STRAIGHT, UPPER, WRIST
from srs_ik.kernels.limb.goal import NO_SEED, TIE, elbow_part, join, part
from srs_ik.kernels.limb.limits import TURN, set_joint_limits, set_limit
from srs_ik.kernels.limb.postures_eight import farthest_branch
from srs_ik.kernels.limb.spherical import angles, columns_at, middle_angle, mirrored
from srs_ik.kernels.limb.triangle import shoulder_columns, side_frames, wrist_columns

NO_BRANCH = 1e12
"""Cost of a branch that does not exist: oblique axes of a spherical joint cannot make the rotation."""

NEARLY_SINGULAR = 1e-6
"""Sine of a middle angle under which each solution of a spherical joint is computed for itself."""

ON_BORDER = 1e-5
WITHIN_BORDER = 0.99
"""A posture with a middle joint this close to its singularity, as a sine, is of the branches on either side; searches
in a branch go to this part of it."""

UNSURE = 3.0
"""Branches are unsure within so many times the shift of a limb."""


@kernel
def branch_of(P, q):
    """Branch of a configuration, from the sides of its elbow, shoulder and wrist."""
    e = 0 if math.sin(q[3] - P[STRAIGHT]) >= 0.0 else 4
    s = 0 if math.sin(q[1] - P[SHOULDER + PHASE]) >= 0.0 else 2
    w = 0 if math.sin(q[5] - P[WRIST + PHASE]) >= 0.0 else 1
    return e + s + w


@kernel
def phase_of(P, middle):
    """The angle at which a middle joint is singular."""
    return P[STRAIGHT] if middle == 1 else P[(SHOULDER if middle == 0 else WRIST) + PHASE]


@kernel
def bit_of(middle):
    """The bit of a branch that tells the side of a middle angle."""
    return 2 if middle == 0 else (4 if middle == 1 else 1)


@kernel
def sine_of(P, q, middle):
    """How far a middle angle is from singular: its branch's bit is 0 where this is zero or more."""
    return math.sin(q[1 + 2 * middle] - phase_of(P, middle))


@kernel
def singular_sines(P, q):
    """How far shoulder, elbow and wrist are from singular, each as the sine of its middle angle."""
    return abs(sine_of(P, q, 0)), abs(sine_of(P, q, 1)), abs(sine_of(P, q, 2))


@kernel
def out_of_branch(P, q, branch):
    """How far a posture is out of a branch: minus the least sine of a middle angle to its side."""
    shoulder = sine_of(P, q, 0) * (-1.0 if branch & 2 else 1.0)
    elbow = sine_of(P, q, 1) * (-1.0 if branch & 4 else 1.0)
    wrist = sine_of(P, q, 2) * (-1.0 if branch & 1 else 1.0)
    return -min(shoulder, elbow, wrist)


@kernel
def is_on_border(P, q, branch):
    """Whether a posture is in a branch, or next to it on the other side of a singularity."""
    return out_of_branch(P, q, branch) < ON_BORDER


@kernel
def reaches(P, joint, centre, half):
    """Whether angles on either side of a centre reach into the limits of a joint."""
    return centre - half <= P[UPPER + joint] and centre + half >= P[LOWER + joint]


@kernel
def draw_to_branch(P, branch, q, box):
    """Copy the packed limb to `box` with limits of joints 2, 4 and 6 that keep a branch, its borders included.

    Of several turns of a joint in the branch, they keep the one inside the limits that is closest to a configuration.
    Returns False where there is none.
    """
    copy(P, box, SIZE)
    for middle in range(3):
        j = 1 + 2 * middle
        centre = phase_of(P, middle) + (-0.5 if branch & bit_of(middle) else 0.5) * math.pi
        inside = min(max(q[j], P[LOWER + j]), P[UPPER + j])
        centre += TURN * math.floor((inside - centre) / TURN + 0.5)
        half = 0.5 * math.pi + WITHIN_BORDER * ON_BORDER
        if not reaches(P, j, centre, half):
            centre += TURN if inside > centre else -TURN
        if not reaches(P, j, centre, half):
            return False
        lower, upper = max(P[LOWER + j], centre - half), min(P[UPPER + j], centre + half)
        set_limit(box, j, lower, upper)
    set_joint_limits(box, SHOULDER, 0)
    set_joint_limits(box, WRIST, 4)
    return True


@kernel
def is_unsure(P, q):
    """Whether a posture of a near limb is so close to a singularity that there may be others at its arm angle.

    Shoulder and wrist may be singular within the shift between the limb and its nearest exact one, which a straight
    elbow makes larger; the elbow's own bend depends on the square root of it.
    """
    s2, s4, s6 = singular_sines(P, q)
    return s4 * min(s2, s4, s6) < UNSURE * P[SHIFT]


@kernel
def anchor(first, seeded, seed, respect):
    """Where joints 1 and 3 of a spherical joint go when it is singular: near the seed, or far from the limits."""
    return seeded, seed[first], seed[first + 2], respect


@kernel
def two_solutions(P, k, v, y, seeded, first, seed, respect):
    """Both solutions of a spherical joint for R a3 = v and R ACROSS_3 = y, and whether v can be reached."""
    c, s, reached = middle_angle(P, k, v)
    here = anchor(first, seeded, seed, respect)
    above = angles(P, k, v, y, c, s, 0, here)
    if s > NEARLY_SINGULAR and P[k + A1_A2] == 0.0 and P[k + A2_A3] == 0.0:
        return above, mirrored(P[k + PHASE], above), reached
    return above, angles(P, k, v, y, c, s, 1, here), reached


@kernel
def better_half(P, k, first, v, y, wanted, seeded, seed, respect):
    """The better of the two solutions of a spherical joint (or the wanted one): angles, sign 0 or 1, cost."""
    seed3 = (seed[first], seed[first + 1], seed[first + 2])
    if wanted >= 0:
        c, s, reached = middle_angle(P, k, v)
        q = angles(P, k, v, y, c, s, wanted, anchor(first, seeded, seed, respect))
        q, cost = part(P, first, q, seeded, seed3, respect)
        return q, wanted, (cost if reached else NO_BRANCH)
    above, below, reached = two_solutions(P, k, v, y, seeded, first, seed, respect)
    q, cost = part(P, first, above, seeded, seed3, respect)
    other, cost_other = part(P, first, below, seeded, seed3, respect)
    if not reached:
        return q, 0, NO_BRANCH
    if cost_other < cost - (0.0 if seeded else TIE):
        return other, 1, cost_other
    return q, 0, cost


@kernel
def best_half(P, k, first, motion, cos_psi, sin_psi, wanted, seeded, seed, respect):
    """`better_half` on the circles of a motion at an arm angle."""
    v, y = columns_at(motion, cos_psi, sin_psi)
    return better_half(P, k, first, v, y, wanted, seeded, seed, respect)


@kernel
def whole(P, q4, a, sign_s, cost_s, b, sign_w, cost_w, seeded, seed, respect):
    """Shoulder, elbow and wrist put together: q, branch without its elbow bit, cost."""
    e, cost_e = elbow_part(P, q4, seeded, seed[3], respect)
    total = join(join(cost_s, cost_w, seeded, respect), cost_e, seeded, respect)
    if max(cost_s, cost_w) >= NO_BRANCH:
        total = NO_BRANCH
    return (a[0], a[1], a[2], e, b[0], b[1], b[2]), 2 * sign_s + sign_w, total


@kernel
def side_posture(P, side, psi, shoulder, wrist, seeded, seed, respect):
    """Best posture on one side of the elbow at an arm angle (signs -1: any): q, branch without its elbow bit, cost."""
    q4, motion_s, motion_w, _ = side
    c = math.cos(psi)
    s = math.sin(psi)
    a, sign_s, cost_s = best_half(P, SHOULDER, 0, motion_s, c, s, shoulder, seeded, seed, respect)
    b, sign_w, cost_w = best_half(P, WRIST, 4, motion_w, c, s, wrist, seeded, seed, respect)
    return whole(P, q4, a, sign_s, cost_s, b, sign_w, cost_w, seeded, seed, respect)


@kernel
def posture_at(P, place_, elbow, c, s, shoulder, wrist, seeded, seed, respect, bound):
    """`side_posture` for cosine and sine of one arm angle, without the circles that many would share.

    What costs as much as the bound is not looked at further: no part takes anything off a cost.
    """
    base, arm, c4, s4 = side_frames(P, place_, elbow, c, s)
    q4 = math.atan2(s4, c4)
    _, cost_e = elbow_part(P, q4, seeded, seed[3], respect)
    if cost_e >= bound:
        return seed, 0, cost_e
    v, y = shoulder_columns(P, base, arm)
    a, sign_s, cost_s = better_half(P, SHOULDER, 0, v, y, shoulder, seeded, seed, respect)
    if cost_s >= bound:
        return seed, 0, cost_s
    v, y = wrist_columns(P, place_, base, arm, c4, s4)
    b, sign_w, cost_w = better_half(P, WRIST, 4, v, y, wrist, seeded, seed, respect)
    return whole(P, q4, a, sign_s, cost_s, b, sign_w, cost_w, seeded, seed, respect)


@kernel
def best_branch(P, place_, psi, branch, seeded, seed, respect):
    """The best posture at an arm angle over all branches (or in the wanted one, 0 to 7): q, branch, cost."""
    if not seeded:
        q, best, lowest = farthest_branch(P, place_, psi, branch, respect)
        if best >= 0:
            return q, best, lowest
    c = math.cos(psi)
    s = math.sin(psi)
    if branch >= 0:
        wanted_s = (branch >> 1) & 1
        q, _, lowest = posture_at(P, place_, branch >> 2, c, s, wanted_s, branch & 1, seeded, seed, respect, math.inf)
        return q, branch, lowest
    q, best, lowest = posture_at(P, place_, 0, c, s, -1, -1, seeded, seed, respect, math.inf)
    other, b, value = posture_at(P, place_, 1, c, s, -1, -1, seeded, seed, respect, lowest)
    if value < lowest - (0.0 if seeded else TIE):
        return other, 4 + b, value
    return q, best, lowest


@kernel
def side_solutions(P, place_, psi, elbow, seeded, seed, respect):
    """On one side of the elbow: q4, both shoulder solutions, both wrist solutions, whether each joint can be so."""
    base, arm, c4, s4 = side_frames(P, place_, elbow, math.cos(psi), math.sin(psi))
    v, y = shoulder_columns(P, base, arm)
    shoulder = two_solutions(P, SHOULDER, v, y, seeded, 0, seed, respect)
    v, y = wrist_columns(P, place_, base, arm, c4, s4)
    return math.atan2(s4, c4), shoulder, two_solutions(P, WRIST, v, y, seeded, 4, seed, respect)


@kernel
def elbow_branches(P, place_, psi, elbow, respect, Q, first):
    """The four branches on one side of the elbow into four rows of Q: seven angles, their cost, work space."""
    q4, shoulders, wrists = side_solutions(P, place_, psi, elbow, False, NO_SEED, False)
    none = (0.0, 0.0, 0.0)
    e, cost_e = elbow_part(P, q4, False, 0.0, respect)
    for sign in range(2):
        a, cost_s = part(P, 0, shoulders[0] if sign == 0 else shoulders[1], False, none, respect)
        b, cost_w = part(P, 4, wrists[0] if sign == 0 else wrists[1], False, none, respect)
        cost_s = cost_s if shoulders[2] else NO_BRANCH
        cost_w = cost_w if wrists[2] else NO_BRANCH
        for other in range(2):
            with_s = first + 2 * sign + other
            with_w = first + 2 * other + sign
            for i in range(3):
                Q[with_s, i] = a[i]
                Q[with_w, 4 + i] = b[i]
            Q[with_s, 3] = e
            Q[with_s, ROW_COST] = join(cost_s, cost_e, False, respect)
            Q[with_w, ROW_COST + 1] = cost_w
    for row in range(first, first + 4):
        Q[row, ROW_COST] = max(Q[row, ROW_COST], Q[row, ROW_COST + 1])


@kernel
def elbow_starts(P, place_, psi, elbow, seeded, seed, respect, Q, first):
    """The same without turns and costs; returns whether these branches exist."""
    q4, shoulders, wrists = side_solutions(P, place_, psi, elbow, seeded, seed, respect)
    for i in range(4):
        a = shoulders[0] if i < 2 else shoulders[1]
        b = wrists[0] if i % 2 == 0 else wrists[1]
        for j in range(3):
            Q[first + i, j] = a[j]
            Q[first + i, 4 + j] = b[j]
        Q[first + i, 3] = q4
    return shoulders[2] and wrists[2]
