"""Eight postures of an exact limb in step, each at an arm angle and in a branch of its own.

The equations are those of `spherical`; where a shoulder or a wrist is singular they do not tell, and the posture counts
as unsure.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.lane_trig import angle_of
from srs_ik.kernels.algebra.lanes import as_bits, eight_of, where, whole_number
from srs_ik.kernels.algebra.vectors import swing
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import MIDDLE, SHOULDER, WRIST
from srs_ik.kernels.limb.limits import PER_TURN, TURN
from srs_ik.kernels.limb.spherical import eight_middles, sines
from srs_ik.kernels.limb.triangle import shoulder_columns, side_frames, wrist_columns


@kernel
def choose(which, a, b):
    """Eight vectors, each of two, by a mask."""
    return where(which, a[0], b[0]), where(which, a[1], b[1]), where(which, a[2], b[2])


@kernel
def choose_both(which, a, b):
    """`choose` for two vectors of each."""
    return choose(which, a[0], b[0]), choose(which, a[1], b[1])


@kernel
def swung(below, circles, c, s):
    """Eight vectors on circles of either side of the elbow, at arm angles given as cosines and sines."""
    a, b = circles
    return swing(choose(below, b[0], a[0]), choose(below, b[1], a[1]), choose(below, b[2], a[2]), c, s)


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
def eight_branches(P, place_, psi):
    """The postures of all branches at an arm angle, and as bits, which are sure."""
    c, s = math.cos(psi), math.sin(psi)
    below = eight_of(0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0) > 0.5
    base, arm, c4, s4 = side_frames(P, place_, 0, c, s)
    _, arm_below, c4_below, s4_below = side_frames(P, place_, 1, c, s)
    v, y = choose_both(below, shoulder_columns(P, base, arm_below), shoulder_columns(P, base, arm))
    a, sure_s = three_angles(P, SHOULDER, v, y, eight_of(1.0, 1.0, -1.0, -1.0, 1.0, 1.0, -1.0, -1.0))
    wrist = wrist_columns(P, place_, base, arm, c4, s4)
    v, y = choose_both(below, wrist_columns(P, place_, base, arm_below, c4_below, s4_below), wrist)
    b, sure_w = three_angles(P, WRIST, v, y, eight_of(1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0))
    q4 = where(below, math.atan2(s4_below, c4_below), math.atan2(s4, c4))
    return (a[0], a[1], a[2], q4, b[0], b[1], b[2]), as_bits(sure_s & sure_w)
