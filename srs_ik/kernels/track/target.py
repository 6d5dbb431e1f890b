"""The target: what is left of jitter, how fast it moves, and where it goes on while it is lost."""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.vectors import along, cross, dot, load3, norm, rotate, scale
from srs_ik.kernels.chain.newton import twist_to
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.track import (
    ALPHA,
    BETA,
    ESTIMATE,
    GAMMA,
    LOST,
    PACE,
    PATIENCE,
    PERIOD,
    ROTATION,
    STARTED,
    TREND_JOLT,
    TREND_PACE,
    TREND_PUSH,
    TWIST,
)

PACED = 0.005
"""Seconds over which the velocity of the smoothed target is averaged."""

JUMP = 0.05
"""A target this far from where it was expected, metres, has jumped: its velocity is not known any more."""

JUMP_TURN = 0.25
"""The same for its orientation, rad."""


@kernel
def turned_frame(x, y, turn):
    """Two axes of a frame, turned by a rotation vector and made orthonormal again."""
    angle = norm(turn)
    axis = scale(1.0 / angle if angle > 0.0 else 0.0, turn)
    c, s = math.cos(angle), math.sin(angle)
    x, y = rotate(axis, c, s, x), rotate(axis, c, s, y)
    x = scale(1.0 / norm(x), x)
    y = along(y, -dot(x, y), x)
    return x, scale(1.0 / norm(y), y)


@kernel
def load_target(S):
    """Rotation, position, and linear and angular velocity of the target."""
    v = (S[TWIST], S[TWIST + 1], S[TWIST + 2])
    w = (S[TWIST + 3], S[TWIST + 4], S[TWIST + 5])
    R, p = load_pose(S, ROTATION)
    return R, p, v, w


@kernel
def load_pose(S, k):
    """Rotation and position from place k on."""
    R = (S[k], S[k + 1], S[k + 2], S[k + 3], S[k + 4], S[k + 5], S[k + 6], S[k + 7], S[k + 8])
    return R, (S[k + 9], S[k + 10], S[k + 11])


@kernel
def store_pose(S, k, R, p):
    """Write a rotation and a position from place k on."""
    for i in range(9):
        S[k + i] = R[i]
    for i in range(3):
        S[k + 9 + i] = p[i]


@kernel
def store_twist(S, v, w):
    """Keep the velocity of the target."""
    for i in range(3):
        S[TWIST + i] = v[i]
        S[TWIST + 3 + i] = w[i]


@kernel
def moved_on(R, p, v, w, seconds):
    """A pose after a while at a constant velocity."""
    x, y = turned_frame((R[0], R[3], R[6]), (R[1], R[4], R[7]), scale(seconds, w))
    z = cross(x, y)
    return (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]), along(p, seconds, v)


@kernel
def way_to(from_pose, to_pose):
    """Linear and angular way from a pose to another."""
    R, p = from_pose
    return twist_to((R[0], R[3], R[6]), (R[1], R[4], R[7]), (R[2], R[5], R[8]), p, to_pose[0], to_pose[1])


@kernel
def part_of_way(from_pose, share, linear, angular):
    """The pose after a share of a way."""
    R, _ = moved_on(from_pose[0], from_pose[1], linear, angular, share)
    return R, along(from_pose[1], share, linear)


@kernel
def take_target(S, C, R, p):
    """A new target: smoothed, and its velocity known better; the first one, and one that jumped, as it is, at rest.

    An observer of position and velocity estimates the target, and what is followed comes after that estimate at the
    velocity of it: at constant velocity neither lags.
    """
    S[LOST] = 0.0
    still = (0.0, 0.0, 0.0)
    if S[STARTED] == 1.0:
        _, _, v, w = load_target(S)
        before = load_pose(S, ESTIMATE)
        expected = moved_on(before[0], before[1], v, w, C[PERIOD])
        linear, angular = way_to(expected, (R, p))
        if norm(linear) < JUMP and norm(angular) < JUMP_TURN:
            v, w = along(v, C[BETA] / C[PERIOD], linear), along(w, C[BETA] / C[PERIOD], angular)
            store_twist(S, v, w)
            if C[ALPHA] < 1.0:
                R, p = part_of_way(expected, C[ALPHA], linear, angular)
                shown = load_pose(S, ROTATION)
                shown = moved_on(shown[0], shown[1], v, w, C[PERIOD])
                linear, angular = way_to(shown, (R, p))
                store_pose(S, ESTIMATE, R, p)
                R, p = part_of_way(shown, C[GAMMA], linear, angular)
                store_pose(S, ROTATION, R, p)
                return
        else:
            store_twist(S, still, still)
    S[STARTED] = 1.0
    store_pose(S, ROTATION, R, p)
    store_pose(S, ESTIMATE, R, p)


@kernel
def lose_target(S, C):
    """No target: it is expected to go on by its trend, at first as it was, then more and more slowly."""
    period = C[PERIOD]
    gone = period * S[LOST] / C[PATIENCE]
    slower = math.exp(-period / C[PATIENCE] * min(gone, 1.0))
    for i in range(6):
        S[TREND_PACE + i] *= slower
        S[TREND_PUSH + i] *= slower
        S[TREND_JOLT + i] *= slower
    v = along(load3(S, TREND_PACE), 0.5 * period, load3(S, TREND_PUSH))
    w = along(load3(S, TREND_PACE + 3), 0.5 * period, load3(S, TREND_PUSH + 3))
    R, p = load_pose(S, ROTATION)
    R, p = moved_on(R, p, v, w, period)
    store_pose(S, ROTATION, R, p)
    store_pose(S, ESTIMATE, R, p)
    store_twist(S, v, w)
    S[LOST] += 1.0


@kernel
def keep_pace(S, C, before):
    """Average how fast the smoothed target moves, from its pose before; what has jumped is at rest."""
    linear, angular = way_to(before, load_pose(S, ROTATION))
    jumped = norm(linear) > JUMP or norm(angular) > JUMP_TURN
    share = C[PERIOD] / (C[PERIOD] + PACED)
    for i in range(3):
        S[PACE + i] = 0.0 if jumped else S[PACE + i] + share * (linear[i] / C[PERIOD] - S[PACE + i])
        S[PACE + 3 + i] = 0.0 if jumped else S[PACE + 3 + i] + share * (angular[i] / C[PERIOD] - S[PACE + 3 + i])


@kernel
def load_pace(S):
    """How fast the smoothed target moves, linear and angular."""
    return (S[PACE], S[PACE + 1], S[PACE + 2]), (S[PACE + 3], S[PACE + 4], S[PACE + 5])
