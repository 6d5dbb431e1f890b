"""How far the tip is from a pose that leaves a turn free: roll about an axis, a cone around it, or all turns."""

import math

from srs_ik.kernels.algebra.vectors import across, along, apply, cross, dot, norm, rotate, scale, sub
from srs_ik.kernels.chain.kinematics import forward_kinematics
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.freedom import FREE_AXIS, FREE_CONE, Freedom

NO_LEAN = 1e-15
"""Sine of an angle that has no axis."""


@kernel
def read_freedom(F):
    """The freedom in an array (FREEDOM,)."""
    return Freedom((F[FREE_AXIS], F[FREE_AXIS + 1], F[FREE_AXIS + 2]), F[FREE_CONE])


@kernel
def pointing(axis, x, y, z):
    """Where an axis of the tip frame points in the base frame, the frame's directions being x, y and z."""
    return along(along(scale(axis[0], x), axis[1], y), axis[2], z)


@kernel
def any_across(u):
    """A unit vector across another one."""
    v = across((1.0, 0.0, 0.0) if abs(u[0]) < 0.7 else (0.0, 1.0, 0.0), u)
    return scale(1.0 / norm(v), v)


@kernel
def lean(u, t):
    """The shortest turn from a direction to another: unit axis, angle."""
    n = cross(u, t)
    sine = norm(n)
    axis = scale(1.0 / sine, n) if sine > NO_LEAN else any_across(u)
    return axis, math.atan2(sine, dot(u, t))


@kernel
def turn_left(freedom, frame, R):
    """The shortest turn from the tip's frame (x, y, z) to one that a pose allows: unit axis, angle, where it points."""
    u = pointing(freedom.axis, frame[0], frame[1], frame[2])
    axis, angle = lean(u, apply(R, freedom.axis))
    return axis, max(angle - freedom.cone, 0.0), u


@kernel
def free_error(P, q, R, p, freedom):
    """Distance (m) and angle (rad) between the tip at q and the nearest pose that is allowed."""
    x, y, z, position = forward_kinematics(P, q)
    _, angle, _ = turn_left(freedom, (x, y, z), R)
    return norm(sub(p, position)), angle


@kernel
def turned_columns(axis, c, s, frame):
    """The three directions of a frame, turned about a unit axis."""
    return rotate(axis, c, s, frame[0]), rotate(axis, c, s, frame[1]), rotate(axis, c, s, frame[2])


@kernel
def as_rotation(frame):
    """Three directions as a rotation matrix."""
    x, y, z = frame
    return (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2])


@kernel
def allowed(freedom, frame, R):
    """The rotation that a pose allows and that is nearest to a frame (x, y, z)."""
    axis, angle, _ = turn_left(freedom, frame, R)
    return as_rotation(turned_columns(axis, math.cos(angle), math.sin(angle), frame))
