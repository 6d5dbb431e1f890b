"""Eight postures of an exact limb in step, each at an arm angle and in a branch of its own.

The equations are those of `spherical`; where a shoulder or a wrist is singular they do not tell, and the posture counts
as unsure.
"""

import math

from srs_ik.kernels.algebra.lane_trig import angle_of
from srs_ik.kernels.algebra.lanes import (
    ALL,
    as_bits,
    as_mask,
    choose,
    eight_of,
    larger,
    one_of,
    smaller,
    where,
    whole_number,
)
from srs_ik.kernels.algebra.vectors import swing
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import (
    INVERSE_HALF_RANGE,
    LOWER,
    MIDDLE,
    SHOULDER,
    SLACK_LIMIT,
    UPPER,
    WRIST,
)
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE, TIE
from srs_ik.kernels.limb.limits import PER_TURN, TURN
from srs_ik.kernels.limb.spherical import eight_middles, joint_at, joints_of, middles_of, sines, sines_of
from srs_ik.kernels.limb.triangle import elbow_at, frame_at, shoulder_columns, wrist_columns

BEYOND_STRAIGHT = 0b11110000
BEYOND_SHOULDER = 0b11001100
BEYOND_WRIST = 0b10101010
"""The branches, as the bits of their numbers, with q4, q2 and q6 below their phases."""

WRIST_LANES = 0b11110000
BELOW_LANES = 0b10101010
"""Of `halves`, those of the wrist, and those below the phase of the middle joint."""


@kernel
def swung(below, circles, c, s):
    """Eight vectors on circles of either side of the elbow, at arm angles given as cosines and sines."""
    a, b = circles
    return swing((choose(below, b[0], a[0]), choose(below, b[1], a[1]), choose(below, b[2], a[2])), c, s)


@kernel
def three_angles(P, k, v, y, side):
    """One solution each of the spherical joint at block k, on a side (1.0, -1.0) of its phase, and which are sure."""
    c, s, missed = eight_middles(P, k, v)
    q1, q2, q3, length = sines(P, k, v, y, c, side * s)
    # Out of reach, they count as unsure.
    sure = where(missed, 0.0, length) > 0.0
    return (angle_of(q1[0], q1[1]), angle_of(q2[0], q2[1]), angle_of(q3[0], q3[1])), sure


@kernel
def in_middle_turn(P, joint, q):
    """Eight angles of a joint in the turns nearest to the middle of its range."""
    return q + TURN * whole_number((P[MIDDLE + joint] - q) * PER_TURN)


@kernel
def eight_postures(P, sides, branches, c, s):
    """Postures in eight branches, at eight arm angles given as cosines and sines; as bits, which are sure.

    `sides` are both sides of the elbow, from `triangle.elbow_side`. Angles are in the turns nearest to their middles.
    """
    below = branches > 3.5
    rest = branches - where(below, 4.0, 0.0)
    opposite = rest > 1.5
    last = rest - where(opposite, 2.0, 0.0)
    (q4, shoulder_a, wrist_a, _), (q4_below, shoulder_b, wrist_b, _) = sides
    v, y = swung(below, (shoulder_a[0], shoulder_b[0]), c, s), swung(below, (shoulder_a[1], shoulder_b[1]), c, s)
    a, sure_s = three_angles(P, SHOULDER, v, y, where(opposite, -1.0, 1.0))
    v, y = swung(below, (wrist_a[0], wrist_b[0]), c, s), swung(below, (wrist_a[1], wrist_b[1]), c, s)
    b, sure_w = three_angles(P, WRIST, v, y, 1.0 - 2.0 * last)
    q = (
        in_middle_turn(P, 0, a[0]),
        in_middle_turn(P, 1, a[1]),
        in_middle_turn(P, 2, a[2]),
        in_middle_turn(P, 3, where(below, q4_below, q4)),
        in_middle_turn(P, 4, b[0]),
        in_middle_turn(P, 5, b[1]),
        in_middle_turn(P, 6, b[2]),
    )
    return q, as_bits(sure_s & sure_w)


@kernel
def of_both(shoulder, wrist):
    """What both sides of the elbow ask of the shoulder, each in two lanes, and of the wrist, in the other four."""
    (a, b), (c, d) = shoulder, wrist
    return (
        eight_of(a[0], a[0], b[0], b[0], c[0], c[0], d[0], d[0]),
        eight_of(a[1], a[1], b[1], b[1], c[1], c[1], d[1], d[1]),
        eight_of(a[2], a[2], b[2], b[2], c[2], c[2], d[2], d[2]),
    )


@kernel
def halves(P, shoulder, wrist):
    """Both solutions of what `of_both` asks, above and below a middle joint's phase: angles; whether all are sure."""
    joint = joints_of(as_mask(WRIST_LANES), joint_at(P, WRIST), joint_at(P, SHOULDER))
    v, y = of_both(shoulder[0], wrist[0]), of_both(shoulder[1], wrist[1])
    c, s, missed = middles_of(joint, v)
    q1, q2, q3, length = sines_of(joint, v, y, c, where(as_mask(BELOW_LANES), -s, s))
    # Out of reach, they count as unsure.
    sure = as_bits(where(missed, 0.0, length) > 0.0) == ALL
    return (angle_of(q1[0], q1[1]), angle_of(q2[0], q2[1]), angle_of(q3[0], q3[1])), sure


@kernel
def of_shoulder(x):
    """Of `halves`, the shoulder's of each branch."""
    a, b, c, d = one_of(x, 0), one_of(x, 1), one_of(x, 2), one_of(x, 3)
    return eight_of(a, a, b, b, c, c, d, d)


@kernel
def of_wrist(x):
    """Of `halves`, the wrist's of each branch."""
    a, b, c, d = one_of(x, 4), one_of(x, 5), one_of(x, 6), one_of(x, 7)
    return eight_of(a, b, a, b, c, d, c, d)


@kernel
def eight_branches(P, place_, psi):
    """The postures of all branches at an arm angle, and whether all are sure."""
    base = frame_at(place_, math.cos(psi), math.sin(psi))
    c4, s4, arm = elbow_at(P, place_, 0)
    c4_below, s4_below, arm_below = elbow_at(P, place_, 1)
    v, y = shoulder_columns(P, base, arm)
    v_below, y_below = shoulder_columns(P, base, arm_below)
    shoulder = (v, v_below), (y, y_below)
    v, y = wrist_columns(P, place_, base, arm, c4, s4)
    v_below, y_below = wrist_columns(P, place_, base, arm_below, c4_below, s4_below)
    (a, b, c), sure = halves(P, shoulder, ((v, v_below), (y, y_below)))
    below = as_mask(BEYOND_STRAIGHT)
    q4 = angle_of(where(below, c4_below, c4), where(below, s4_below, s4))
    return (of_shoulder(a), of_shoulder(b), of_shoulder(c), q4, of_wrist(a), of_wrist(b), of_wrist(c)), sure


@kernel
def farthest_turn(P, joint, q, respect):
    """`limits.turn_to_middle` of eight angles of a joint, and what each costs."""
    q = in_middle_turn(P, joint, q)
    inside = smaller(larger(q, P[LOWER + joint]), P[UPPER + joint])
    q = where(abs(q - inside) < P[SLACK_LIMIT], inside, q)
    cost = abs(q - P[MIDDLE + joint]) * P[INVERSE_HALF_RANGE + joint] - 1.0
    if respect:
        outside = abs(q - inside)
        cost = where(outside > 0.0, OUTSIDE + outside, cost)
    return q, cost


@kernel
def farthest_turns(P, q, respect):
    """Eight postures in the turns farthest from the limits; costs of shoulder, elbow, wrist."""
    a, cost_a = farthest_turn(P, 0, q[0], respect)
    b, cost_b = farthest_turn(P, 1, q[1], respect)
    c, cost_c = farthest_turn(P, 2, q[2], respect)
    d, elbow = farthest_turn(P, 3, q[3], respect)
    e, cost_e = farthest_turn(P, 4, q[4], respect)
    f, cost_f = farthest_turn(P, 5, q[5], respect)
    g, cost_g = farthest_turn(P, 6, q[6], respect)
    shoulder, wrist = larger(larger(cost_a, cost_b), cost_c), larger(larger(cost_e, cost_f), cost_g)
    return (a, b, c, d, e, f, g), (shoulder, elbow, wrist)


@kernel
def farthest_branches(P, place_, psi, respect):
    """`eight_branches` in the turns farthest from the limits; whether all are sure; costs of shoulder, elbow, wrist."""
    q, sure = eight_branches(P, place_, psi)
    q, parts = farthest_turns(P, q, respect)
    return q, sure, parts


@kernel
def join_parts(parts):
    """The costs of whole postures."""
    return larger(larger(parts[0], parts[1]), parts[2])


@kernel
def farthest_branch(P, place_, psi, branch, respect):
    """The posture at an arm angle that is farthest from the limits, in a branch (-1: any): q, branch, cost.

    On each side of the elbow it has the better shoulder and the better wrist, also where these do not decide. The
    branch is -1 where not all are sure.
    """
    q, sure, parts = farthest_branches(P, place_, psi, respect)
    if not sure:
        return NO_SEED, -1, 0.0
    shoulder, _, wrist = parts
    costs = join_parts(parts)
    best, lowest = branch, math.inf
    for first in range(0, 8 if branch < 0 else 0, 4):
        here = first + (2 if one_of(shoulder, first + 2) < one_of(shoulder, first) - TIE else 0)
        here += 1 if one_of(wrist, first + 1) < one_of(wrist, first) - TIE else 0
        if one_of(costs, here) < lowest - TIE:
            best, lowest = here, one_of(costs, here)
    a, b, c, d, e, f, g = q
    posture = (
        one_of(a, best),
        one_of(b, best),
        one_of(c, best),
        one_of(d, best),
        one_of(e, best),
        one_of(f, best),
        one_of(g, best),
    )
    return posture, best, one_of(costs, best)
