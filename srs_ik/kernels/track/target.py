"""Poses that a tracker keeps, ways between them, and how fast what is followed moves."""

import math

from srs_ik.kernels.algebra.vectors import along, cross, dot, load_pose, norm, rotate, scale
from srs_ik.kernels.chain.newton import twist_to
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.track import PACE, PERIOD, ROTATION

PACED = 0.005
"""Seconds over which the velocity of what is followed is averaged."""

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
def keep_pace(S, C, before):
    """Average how fast what is followed moves, from its pose before; what has jumped is at rest."""
    linear, angular = way_to(before, load_pose(S, ROTATION))
    jumped = norm(linear) > JUMP or norm(angular) > JUMP_TURN
    share = C[PERIOD] / (C[PERIOD] + PACED)
    for i in range(3):
        S[PACE + i] = 0.0 if jumped else S[PACE + i] + share * (linear[i] / C[PERIOD] - S[PACE + i])
        S[PACE + 3 + i] = 0.0 if jumped else S[PACE + 3 + i] + share * (angular[i] / C[PERIOD] - S[PACE + 3 + i])


@kernel
def load_pace(S):
    """How fast what is followed moves, linear and angular."""
    return (S[PACE], S[PACE + 1], S[PACE + 2]), (S[PACE + 3], S[PACE + 4], S[PACE + 5])
