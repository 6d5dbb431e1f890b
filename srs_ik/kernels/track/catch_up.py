"""A tip close to its target, but not on it: it comes back on the straight way, and brakes so that it does not pass."""

import math

from srs_ik.kernels.algebra.joint_vectors import along7, between
from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.algebra.vectors import add, along, dot, load_pose, scale
from srs_ik.kernels.chain.kinematics import forward_kinematics
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.freedom import FREE_CONE
from srs_ik.kernels.layout.limb import FAR
from srs_ik.kernels.layout.track import ACCELERATION, FREE, HAS_FREE, PERIOD, ROTATION, Q, V
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.track.closest import DAMPING, approach
from srs_ik.kernels.track.freedom import free_way
from srs_ik.kernels.track.limits import stopping_speed
from srs_ik.kernels.track.target import load_pace, part_of_way, way_to

CLOSE_BY = 0.05
"""A tip this close to its target, m and, by the reach, rad, comes back on the straight way."""

STAYS = 0.6
"""One that is on that way keeps to it up to so far away, unless the target jumps: joints that go to a posture each for
itself swing the tip aside. Farther away, the way has led into a dead end."""

LEVER = 0.1
"""Turning by a radian counts as much as moving by this, m, where joints cannot bring all of the tip back at once: 1 mm
as much as 10 mrad. By the reach, the tip would be left aside so that it stays straight."""

ALL_OF_IT = 5e-4
"""The closer the tip is than this, m, the more turning counts, up to the reach: all of it comes back."""

GENTLE = 0.05
GENTLY = 1e-4
USUAL = 0.002
"""Weight of the step that is planned, m^2, where the tip is farther away than this, m, at a period of this, s: it comes
back, but not at any price. What steps differ by is accelerations times the square of the period."""

BRAKING = 0.4
"""The tip brakes with so much of what the slowest joint can do at the end of the stretched arm."""


@kernel
def tip_pose(P, q):
    """Rotation and position of the tip."""
    x, y, z, p = forward_kinematics(P, q)
    return (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]), p


@kernel
def way_left(P, S, C):
    """The way of the tip to what the target allows, linear and angular, and its size: metres, turns by the reach."""
    tip = tip_pose(P, read7(row(S, Q)))
    linear, angular = way_to(tip, load_pose(S, ROTATION))
    if C[HAS_FREE] == 1.0:
        axis, angle = free_way(C, tip[0], load_pose(S, ROTATION)[0])
        angular = scale(angle, axis)
    size = math.sqrt(dot(linear, linear) + P[FAR] ** 2 * dot(angular, angular))
    return tip, linear, angular, size


@kernel
def one_sided(S, C, T, w):
    """What counts of a target's turning, and the way on from the edge of a cone to its middle; T is the tip's rotation.

    A cone presses along one line alone, and not at all within.
    """
    if C[HAS_FREE] == 0.0 or C[FREE + FREE_CONE] == 0.0:
        return w, (0.0, 0.0, 0.0)
    axis, angle = free_way(C, T, load_pose(S, ROTATION)[0])
    outside = 1.0 if angle > 0.0 else 0.0
    return scale(outside * dot(axis, w), axis), scale(outside * C[FREE + FREE_CONE], axis)


@kernel
def catch_up(P, S, C, left, own, box, work):
    """The step that brings the tip closest to where it should be after a period, on its way back to the target."""
    period = C[PERIOD]
    tip, linear, angular, _ = left
    v, w = load_pace(S)
    w, to_middle = one_sided(S, C, tip[0], w)
    # The way relative to a target that moves on.
    behind, turned = along(linear, -period, v), along(angular, -period, w)
    size = math.sqrt(dot(behind, behind) + P[FAR] ** 2 * dot(turned, turned))
    push = C[ACCELERATION]
    for j in range(7):
        push = min(push, C[ACCELERATION + j])
    speed = stopping_speed(size, BRAKING * P[FAR] * push, period)
    share = min(period * speed / max(size, 1e-15), 1.0)
    step = along((period * v[0], period * v[1], period * v[2]), share, behind)
    turn = along((period * w[0], period * w[1], period * w[2]), share, turned)
    care = max(DAMPING, GENTLE * (USUAL / period) ** 2 * min(size / GENTLY, 1.0))
    low, high = along7(NO_SEED, period, box[0]), along7(NO_SEED, period, box[1])
    lever = LEVER + (P[FAR] - LEVER) * max(1.0 - size / ALL_OF_IT, 0.0)
    choice = (between(along7(NO_SEED, period, read7(row(S, V))), low, high), own, (lever, 0.0, care), low, high)
    there = part_of_way(tip, 1.0, step, add(turn, to_middle))
    d, _ = approach(P, C, there, read7(row(S, Q)), choice, 2, work)
    return d
