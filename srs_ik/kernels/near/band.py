"""How far the true chain of a near limb may be from its nearest exact limb: the shift, and the band that it makes."""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.joint_vectors import difference
from srs_ik.kernels.algebra.vectors import dot, load3
from srs_ik.kernels.chain.kinematics import forward_kinematics
from srs_ik.kernels.chain.newton import arm_angle
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import (
    A1,
    A1_A2,
    A2_A3,
    BAND,
    BOTTOM_GAP,
    LOWER,
    PHASE,
    SHIFT,
    SHOULDER,
    SIZE,
    STRAIGHT,
    TOP_GAP,
    UPPER,
    WRIST,
)
from srs_ik.kernels.limb.branches import branch_of, side_posture
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.limits import set_joint_limits, set_limit
from srs_ik.kernels.limb.triangle import elbow_side, place

WIDEST_BAND = 0.2
"""Wider bands tell too little."""

WELL_BENT = 0.5
"""Sine of a middle angle from which on shifts are measured."""

OBLIQUE = 1e-2
"""Cosine between neighbouring axes of a shoulder or wrist from which on a joint's limit is no circle about its axis."""

ALMOST_NOTHING = 1e-4
"""With a narrower band, rad, there are as many intervals as the nearest exact limb has, each end close to its own."""

LEAST_BEND = 1.6
"""The elbow is bent by at least so many bands, or it may be straight on the true chain."""


@kernel
def sines_of_middles(P, q):
    """How far shoulder and wrist are from singular."""
    return abs(math.sin(q[1] - P[SHOULDER + PHASE])), abs(math.sin(q[5] - P[WRIST + PHASE]))


@kernel
def certain_posture(P, side, branch, psi):
    """The posture of the nearest exact limb at an arm angle."""
    q, _, _ = side_posture(P, side, psi, (branch >> 1) & 1, branch & 1, False, NO_SEED, True)
    return q


@kernel
def shift(P, q):
    """How far the joint directions of a configuration are from those of the closed form at its pose and arm angle.

    Times the sine of the elbow's bend: with that it grows. Zero next to singularities, where it has no bound.
    """
    x, y, z, p = forward_kinematics(P, q)
    place_ = place(P, (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]), p)
    branch = branch_of(P, q)
    s2, s6 = sines_of_middles(P, q)
    if min(s2, s6, place_[3]) < WELL_BENT or abs(math.sin(q[3] - P[STRAIGHT])) < WELL_BENT:
        return 0.0
    psi = arm_angle(P, q, place_[0], place_[1])
    d = difference(q, certain_posture(P, elbow_side(P, place_, branch >> 2), branch, psi))
    outer = max(s2 * max(abs(d[0]), abs(d[2])), s6 * max(abs(d[4]), abs(d[6])))
    return place_[3] * max(outer, abs(d[1]), abs(d[3]), abs(d[5]))


@kernel
def band_of(P, place_):
    """The band of a pose, rad."""
    return P[SHIFT] / place_[3] if place_[3] > 0.0 else math.inf


@kernel
def may_predict(P, place_, band):
    """Whether a band tells enough: not with the elbow almost straight or folded, nor of oblique axes."""
    s, w = SHOULDER, WRIST
    oblique = max(abs(P[s + A1_A2]), abs(P[s + A2_A3]), abs(P[w + A1_A2]), abs(P[w + A2_A3])) > OBLIQUE
    narrow = band < ALMOST_NOTHING
    return band < WIDEST_BAND and place_[3] > LEAST_BEND * band and place_[5] == 0.0 and (narrow or not oblique)


@kernel
def widen(P, band, box):
    """Copy a packed limb to `box`, its limits drawn out by a band, or in by a negative one; whether it has any room."""
    for i in range(SIZE):
        box[i] = P[i]
    box[BAND] = band
    for j in range(1, 7, 2):
        lower, upper = P[LOWER + j] - band, P[UPPER + j] + band
        if lower > upper:
            return False
        set_limit(box, j, lower, upper)
    set_joint_limits(box, SHOULDER, 0)
    set_joint_limits(box, WRIST, 4)
    return True


@kernel
def is_close_to_singular(P, k, circle, psi, band):
    """Whether axes 1 and 3 of a spherical joint are closer to parallel than the band at an arm angle."""
    a1 = load3(P, k + A1)
    cosine = dot(a1, circle[0]) + dot(a1, circle[1]) * math.cos(psi) + dot(a1, circle[2]) * math.sin(psi)
    near = 0.25 * band * band * (2.0 - P[k + TOP_GAP] - P[k + BOTTOM_GAP])
    return cosine > 1.0 - P[k + TOP_GAP] - near or cosine < P[k + BOTTOM_GAP] + near - 1.0


@kernel
def is_near_singularity(P, side, psi, band):
    """Whether shoulder or wrist are so close to singular at an arm angle that the band tells nothing."""
    return is_close_to_singular(P, SHOULDER, side[1][0], psi, band) or is_close_to_singular(
        P, WRIST, side[2][0], psi, band
    )
