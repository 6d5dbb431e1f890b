"""The true chain: forward kinematics and geometric Jacobian from the joint axes as lines."""

import math

from srs_ik.kernels.algebra.lane_trig import seven_turns
from srs_ik.kernels.algebra.vectors import (
    add,
    apply,
    cross,
    dot,
    load3,
    load9,
    norm,
    rotate,
    rotation,
    scale,
    sub,
    times,
)
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import AXES, POINTS, TIP_POSITION, TIP_ROTATION


@kernel
def turn_about_line(P, joint, c, s, point):
    """A point of the base frame, turned about the zero-configuration line of a joint (0 to 6)."""
    origin = load3(P, POINTS + 3 * joint)
    return add(origin, rotate(load3(P, AXES + 3 * joint), c, s, sub(point, origin)))


@kernel
def turn_frame(P, joint, turn, x, y, p):
    """A frame, directions x and y and origin p, turned about the zero-configuration line of a joint, (cosine, sine)."""
    M = rotation(load3(P, AXES + 3 * joint), turn[0], turn[1])
    origin = load3(P, POINTS + 3 * joint)
    return apply(M, x), apply(M, y), add(origin, apply(M, sub(p, origin)))


@kernel
def tip_frame(P, turns):
    """The tip after the turns of all joints, of one posture or of eight: directions x, y and z, and origin."""
    H = load9(P, TIP_ROTATION)
    x, y, p = turn_frame(P, 6, turns[6], (H[0], H[3], H[6]), (H[1], H[4], H[7]), load3(P, TIP_POSITION))
    x, y, p = turn_frame(P, 5, turns[5], x, y, p)
    x, y, p = turn_frame(P, 4, turns[4], x, y, p)
    x, y, p = turn_frame(P, 3, turns[3], x, y, p)
    x, y, p = turn_frame(P, 2, turns[2], x, y, p)
    x, y, p = turn_frame(P, 1, turns[1], x, y, p)
    x, y, p = turn_frame(P, 0, turns[0], x, y, p)
    return x, y, cross(x, y), p


@kernel
def forward_kinematics(P, q):
    """Pose of the tip in the base frame: rotation columns x, y and z, and position."""
    return tip_frame(P, seven_turns(q))


@kernel
def turn_between(x, y, z, R):
    """The turn that leads from a frame, or eight, to a rotation: its axis by twice its sine, and twice its cosine."""
    wanted_x = (R[0], R[3], R[6])
    wanted_y = (R[1], R[4], R[7])
    wanted_z = (R[2], R[5], R[8])
    sine2 = add(add(cross(x, wanted_x), cross(y, wanted_y)), cross(z, wanted_z))
    return sine2, dot(x, wanted_x) + dot(y, wanted_y) + dot(z, wanted_z) - 1.0


@kernel
def half_turn(x, y, z, R):
    """The axis, of length 1, of a turn by half a circle, or almost, from a frame to a rotation; its sine tells none.

    Such a turn and the identity add up to twice the axis times its transpose: their longest column is along it.
    """
    wanted_x = (R[0], R[3], R[6])
    wanted_y = (R[1], R[4], R[7])
    wanted_z = (R[2], R[5], R[8])
    best = (1.0, 0.0, 0.0)
    longest = 0.0
    for i in range(3):
        unit = (1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0)
        column = add(unit, add(scale(x[i], wanted_x), add(scale(y[i], wanted_y), scale(z[i], wanted_z))))
        length = norm(column)
        if length > longest:
            longest, best = length, scale(1.0 / length, column)
    return best


@kernel
def frame_error(x, y, z, position, R, p):
    """Distance (m) and angle (rad) between a frame and a wanted pose (rotation matrix R, position p).

    The angle is taken from sine and cosine together: an arc cosine would lose half of the digits near zero. Where it is
    tiny, it is its tangent.
    """
    sine2, twice_cosine = turn_between(x, y, z, R)
    twice_sine = norm(sine2)
    if twice_sine < 1e-8 * twice_cosine:
        return norm(sub(p, position)), twice_sine / twice_cosine
    return norm(sub(p, position)), math.atan2(twice_sine, twice_cosine)


@kernel
def pose_error(P, q, R, p):
    """Distance (m) and angle (rad) between the tip at q and a wanted pose (rotation matrix R, position p)."""
    x, y, z, position = forward_kinematics(P, q)
    return frame_error(x, y, z, position, R, p)


@kernel
def joint_line(P, joint, turn, M, shift):
    """Axis and moment about the base origin of a joint, and the motion of points behind it as a matrix and a shift."""
    line = load3(P, AXES + 3 * joint)
    point = load3(P, POINTS + 3 * joint)
    origin = add(apply(M, point), shift)
    axis = apply(M, line)
    M = times(M, rotation(line, turn[0], turn[1]))
    return axis, cross(origin, axis), M, sub(origin, apply(M, point))


@kernel
def first_line(P, turn):
    """`joint_line` of joint 1, before which nothing moves."""
    line = load3(P, AXES)
    point = load3(P, POINTS)
    M = rotation(line, turn[0], turn[1])
    return line, cross(point, line), M, sub(point, apply(M, point))


@kernel
def put_line(J, joint, axis, moment):
    """Write the line of a joint into a column of J."""
    for i in range(3):
        J[i, joint] = moment[i]
        J[i + 3, joint] = axis[i]


@kernel
def joint_lines(P, q, J):
    """Write axis direction (rows 3 to 5) and moment point x axis (rows 0 to 2) of each joint at q into J (6, 7).

    J is the spatial Jacobian of the base origin. Returns the pose of the tip: rotation columns x, y, z, and position.
    """
    turns = seven_turns(q)
    axis, moment, M, shift = first_line(P, turns[0])
    put_line(J, 0, axis, moment)
    axis, moment, M, shift = joint_line(P, 1, turns[1], M, shift)
    put_line(J, 1, axis, moment)
    axis, moment, M, shift = joint_line(P, 2, turns[2], M, shift)
    put_line(J, 2, axis, moment)
    axis, moment, M, shift = joint_line(P, 3, turns[3], M, shift)
    put_line(J, 3, axis, moment)
    axis, moment, M, shift = joint_line(P, 4, turns[4], M, shift)
    put_line(J, 4, axis, moment)
    axis, moment, M, shift = joint_line(P, 5, turns[5], M, shift)
    put_line(J, 5, axis, moment)
    axis, moment, M, shift = joint_line(P, 6, turns[6], M, shift)
    put_line(J, 6, axis, moment)
    H = load9(P, TIP_ROTATION)
    return (
        apply(M, (H[0], H[3], H[6])),
        apply(M, (H[1], H[4], H[7])),
        apply(M, (H[2], H[5], H[8])),
        add(apply(M, load3(P, TIP_POSITION)), shift),
    )


@kernel
def point_velocity(J, joint, point):
    """Velocity of a point of the base frame when a joint turns; J holds the joint lines (see `joint_lines`)."""
    return add((J[0, joint], J[1, joint], J[2, joint]), cross((J[3, joint], J[4, joint], J[5, joint]), point))


@kernel
def tip_lines(P, q, J):
    """`joint_lines` with velocities of the tip point in place of the moments: its Jacobian in base axes."""
    x, y, z, position = joint_lines(P, q, J)
    for joint in range(7):
        v = point_velocity(J, joint, position)
        for i in range(3):
            J[i, joint] = v[i]
    return x, y, z, position
