"""How many postures a near limb has at an arm angle next to a singular shoulder, counted.

There the closed form fixes joints 1 and 3, of which the true chain knows little more than what they turn together. At
each angle of joint 1 the others come as close to pose and arm angle as they can. What they leave across changes around
joint 1 as smoothly as axes miss their centre: a few waves tell all of it, and postures are where it is zero.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.lane_trig import turn, turns_of
from srs_ik.kernels.algebra.lanes import ALL, as_bits, eight_of
from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.algebra.vectors import along, cross, dot, scale
from srs_ik.kernels.algebra.waves import waves_of, zeros_of
from srs_ik.kernels.chain.newton_eight import (
    dot_four,
    elbow_rates,
    half_planes,
    inverse,
    largest,
    reduced,
    turned_by_all,
    with_wrist,
)
from srs_ik.kernels.chain.starts import FIRST
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import ROW_COST
from srs_ik.kernels.layout.limb import PHASE, SHOULDER
from srs_ik.kernels.limb.branches import NO_BRANCH, is_on_border, side_posture
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE

STEPS = 2
SETTLED = 2e-3
"""Steps of joints 2 to 7, which change what they leave by their square; none where the next one is longer, rad."""

OF_THIRD, OF_FOURTH, OF_CONSTANT = 0.2, 2.0, 5e-4
"""What turns around farther from zero than these parts of its waves is as far from it with all waves that do not count,
and at arm angles that are the same as well as floats tell."""

BARELY = 1e-3
"""Rounding may decide about a posture that is outside its limits by less, in squared rad."""


@kernel
def left_across(P, turns, target, b):
    """What joints 2 to 7 leave, across all that they can do, of pose and half-plane (normal b) at eight postures.

    And the steps of all joints towards the rest, that of joint 1 none.
    """
    made = reduced(P, turns, target.R, target.p)
    _, e2, e3, e = elbow_rates(P, made, b)
    _, s2, s3, s4 = made.s
    across = along(scale(e2, cross(s3, s4)), -e3, cross(s2, s4))
    left = dot(across, made.rest) - e * dot(s2, cross(s3, s4))
    # The shortest way, by the inverse of the squares of their columns.
    none = 0.0 * e
    x, y, z = (s2[0], s2[1], s2[2], e2), (s3[0], s3[1], s3[2], e3), (s4[0], s4[1], s4[2], none)
    r = (made.rest[0], made.rest[1], made.rest[2], e)
    u, v, w = dot_four(x, r), dot_four(y, r), dot_four(z, r)
    xx, yy, zz = dot_four(x, x), dot_four(y, y), dot_four(z, z)
    xy, xz, yz = dot_four(x, y), dot_four(x, z), dot_four(y, z)
    cx, cy, cz = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    share = inverse(xx * cx + xy * cy + xz * cz)
    d2 = share * (cx * u + cy * v + cz * w)
    d3 = share * (cy * u + (xx * zz - xz * xz) * v + (xy * xz - xx * yz) * w)
    d4 = share * (cz * u + (xy * xz - xx * yz) * v + (xx * yy - xy * xy) * w)
    return left, with_wrist(made, made.angular, none, d2, d3, d4)


@kernel
def shared(P, q):
    """Eight postures all around joint 1, with the sum of joints 1 and 3 and the axis of joint 3 as in one of them."""
    around = 0.25 * math.pi * eight_of(0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0)
    none = 0.0 * around
    top = math.cos(q[1] - P[SHOULDER + PHASE]) > 0.0
    middle = P[SHOULDER + PHASE] + (0.0 if top else math.pi)
    off = math.atan2(math.sin(q[1] - middle), math.cos(q[1] - middle))
    q3 = q[2] - around if top else q[2] + around
    return q[0] + around, middle + off * turn(around)[0], q3, q[3] + none, q[4] + none, q[5] + none, q[6] + none


@kernel
def count_postures(P, target, psi, side, wrist):
    """How many postures there are at an arm angle, of a side of the elbow and the wrist; -1 where it is not told."""
    t, h0, _, _, _, _ = target.place
    q, _, _ = side_posture(P, side, psi, 0, wrist, False, NO_SEED, False)
    _, b = half_planes(t, h0, (math.cos(psi), math.sin(psi)))
    around = shared(P, q)
    turns = turns_of(around)
    left = size = 0.0 * around[0]
    for k in range(STEPS + 1):
        left, d = left_across(P, turns, target, b)
        size = largest(d)
        if k < STEPS:
            turns = turned_by_all(turns, d)
    waves = waves_of(left)
    count, nearest = zeros_of(waves)
    vague = OF_THIRD * (abs(waves.third[0]) + abs(waves.third[1])) + OF_FOURTH * waves.fourth
    clear = nearest > vague + OF_CONSTANT * abs(waves.constant) and as_bits(size < SETTLED) == ALL
    return count if clear else -1


@kernel
def count_met(P, first, A):
    """How many of two branches, of either side of the shoulder, have a posture in A; -1 where rounding decides."""
    count = 0
    for branch in range(first, first + 3, 2):
        value = A[FIRST + branch, ROW_COST]
        if OUTSIDE <= value < OUTSIDE + BARELY:
            return -1
        if value < NO_BRANCH:
            if is_on_border(P, read7(row(A, FIRST + branch)), branch ^ 2):
                return -1
            count += 1
    return count
