"""What the samples of a curve tell: branch, arm angle, and how fast that and middle joints change."""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.joint_vectors import along7, short_way
from srs_ik.kernels.algebra.lane_trig import angle_of, turn, turns_of
from srs_ik.kernels.algebra.lanes import as_bits, root, scatter
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import cross, dot, load3, sub
from srs_ik.kernels.chain.eight import branches_of, sines_of_eight
from srs_ik.kernels.chain.kinematics import turn_about_line
from srs_ik.kernels.chain.newton import arm_angle
from srs_ik.kernels.chain.newton_eight import all_along, curve_step
from srs_ik.kernels.curves.follow import tangent_at
from srs_ik.kernels.curves.in_step import SAMPLE, load_sample, short_ways, take_ways
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import ELBOW_CENTRE, SHOULDER_CENTRE
from srs_ik.kernels.limb.branches import sine_of

TOLD = 9
TOLD_BRANCH, TOLD_PSI, TOLD_RATE, TOLD_MIDDLES = range(4)
TOLD_SINES = 6
"""What a sample tells: its branch, its arm angle, rad, the rates of that and of joints 2, 4, 6 along the curve, and the
sines of these joints from their phases on."""

LITTLE = 1e-6
"""A step that tells how an arm angle changes, rad."""

TURNING_WRIST = 1e-4
"""Sine of q6 below which a way along a curve is asked for alone: in step it divides by what axes 5 to 7 span."""


@kernel
def angle_at(P, by, q):
    """The arm angle of a posture for the pose."""
    return arm_angle(P, q, by.target.place[0], by.target.place[1])


@kernel
def arm_angles(P, place_, q):
    """The arm angles of eight postures."""
    t, h0 = place_[0], place_[1]
    turn_1, turn_2, turn_3 = turn(q[0]), turn(q[1]), turn(q[2])
    elbow = turn_about_line(P, 2, turn_3[0], turn_3[1], load3(P, ELBOW_CENTRE))
    elbow = turn_about_line(P, 1, turn_2[0], turn_2[1], elbow)
    elbow = turn_about_line(P, 0, turn_1[0], turn_1[1], elbow)
    upper_arm = sub(elbow, load3(P, SHOULDER_CENTRE))
    c, s = dot(upper_arm, h0), dot(upper_arm, cross(t, h0))
    share = 1.0 / root(c * c + s * s)
    return angle_of(share * c, share * s)


@kernel
def rate_along(P, by, q, way):
    """How fast the arm angle changes along a way from a posture."""
    return short_way(angle_at(P, by, along7(q, LITTLE, way)) - angle_at(P, by, q)) / LITTLE


@kernel
def rate_at(P, by, q):
    """How fast the arm angle changes along a curve at a posture."""
    way, _ = tangent_at(P, by, q)
    return rate_along(P, by, q, way)


@kernel
def turn_at(P, by, q):
    """Whether the arm angle rises (1.0) or falls (-1.0) along a curve at a posture."""
    return math.copysign(1.0, rate_at(P, by, q))


@kernel
def tell_one(P, by, q, told):
    """Write arm angle and rates of a posture."""
    way, _ = tangent_at(P, by, q)
    told[TOLD_PSI], told[TOLD_RATE] = angle_at(P, by, q), rate_along(P, by, q, way)
    for middle in range(3):
        told[TOLD_MIDDLES + middle] = way[1 + 2 * middle]
        told[TOLD_SINES + middle] = sine_of(P, q, middle)


@kernel
def tell_samples(P, by, curve, told):
    """Write what the samples of a curve tell, eight at a time."""
    rows, first, last = curve
    R, p, place_ = by.target
    for i in range(first, last, 8):
        # The last eight rows there are may begin before.
        k = min(i, rows.shape[0] - 8)
        q = take_ways(row(rows, k), 1, SAMPLE)
        eight = row(told, k)
        psi = arm_angles(P, place_, q)
        _, way, _, _ = curve_step(P, turns_of(q), R, p, q, 0.0 * q[0])
        sines = sines_of_eight(P, q)
        scatter(eight, TOLD_BRANCH, TOLD, branches_of(sines))
        scatter(eight, TOLD_PSI, TOLD, psi)
        scatter(eight, TOLD_RATE, TOLD, short_ways(arm_angles(P, place_, all_along(q, LITTLE, way)) - psi) / LITTLE)
        scatter(eight, TOLD_MIDDLES, TOLD, way[1])
        scatter(eight, TOLD_MIDDLES + 1, TOLD, way[3])
        scatter(eight, TOLD_MIDDLES + 2, TOLD, way[5])
        scatter(eight, TOLD_SINES, TOLD, sines[0])
        scatter(eight, TOLD_SINES + 1, TOLD, sines[1])
        scatter(eight, TOLD_SINES + 2, TOLD, sines[2])
        sure = as_bits(abs(sines[2]) > TURNING_WRIST)
        for m in range(k, min(k + 8, last)):
            if (sure >> (m - k)) & 1 == 0:
                tell_one(P, by, load_sample(rows[m]), told[m])
