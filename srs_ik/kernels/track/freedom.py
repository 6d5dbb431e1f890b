"""Targets that leave a turn free: which rotation they are taken for where one whole rotation is needed."""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import rotation, times
from srs_ik.kernels.chain.freedom import allowed, as_rotation, free_error, read_freedom, turn_left
from srs_ik.kernels.chain.kinematics import forward_kinematics, pose_error
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.freedom import Freedom
from srs_ik.kernels.layout.track import FREE, GOAL, HAS_FREE, ROTATION, STARTED, STUCK
from srs_ik.kernels.limb.poses import read7
from srs_ik.kernels.limb.triangle import place
from srs_ik.kernels.track.target import load_pose

TURNED = 2.4
"""Where no posture is at hand, a turn so much farther on is looked at each time, rad: they fill the circle."""


@kernel
def columns(R):
    """The directions of a frame."""
    return (R[0], R[3], R[6]), (R[1], R[4], R[7]), (R[2], R[5], R[8])


@kernel
def whole_rotation(P, C, q, R):
    """The rotation that a target allows and that is nearest to the tip's, for what knows of no freedom.

    It lies on the edge of a cone. `error_at` takes the target itself: there the cone counts, and nowhere else.
    """
    if C[HAS_FREE] == 0.0:
        return R
    x, y, z, _ = forward_kinematics(P, q)
    return allowed(read_freedom(row(C, FREE)), (x, y, z), R)


@kernel
def free_way(C, T, R):
    """The shortest turn from a rotation of the tip, T, to what a target allows: unit axis, angle."""
    axis, angle, _ = turn_left(read_freedom(row(C, FREE)), columns(T), R)
    return axis, angle


@kernel
def wanted(P, S, C, R):
    """The rotation of a new target without the roll that it leaves free: that nearest to the target before."""
    if C[HAS_FREE] == 0.0:
        return R
    freedom = read_freedom(row(C, FREE))
    before, _ = load_pose(S, ROTATION)
    frame = columns(before)
    if S[STARTED] == 0.0:
        x, y, z, _ = forward_kinematics(P, read7(row(S, GOAL)))
        frame = (x, y, z)
    if freedom.cone >= math.pi:
        return as_rotation(frame)
    return allowed(Freedom(freedom.axis, 0.0), frame, R)


@kernel
def error_left(P, C, q, R, p):
    """Distance (m) and angle (rad) between the tip and a target, but for what that leaves free."""
    if C[HAS_FREE] == 0.0:
        return pose_error(P, q, R, p)
    return free_error(P, q, R, p, read_freedom(row(C, FREE)))


@kernel
def turned_about(C, R, angle):
    """A rotation, turned about the free axis of the tip."""
    axis = (C[FREE], C[FREE + 1], C[FREE + 2])
    return times(R, rotation(axis, math.cos(angle), math.sin(angle)))


@kernel
def other_turn(P, S, C, place_):
    """What postures of the target share, at one turn after the other where one is free."""
    if C[HAS_FREE] == 0.0:
        return place_
    R, p = load_pose(S, ROTATION)
    return place(P, turned_about(C, whole_rotation(P, C, read7(row(S, GOAL)), R), TURNED * (S[STUCK] // 25.0)), p)
