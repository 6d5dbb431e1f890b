"""Where impedances act: tip point and orientation, elbow centre, arm angle, and joints near their limits.

The torques of all ports add up, each by the transpose of its own Jacobian. Nothing is inverted.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.vectors import add, dot, load3, load9, scale, sub
from srs_ik.kernels.chain.arm_angle_rates import gradient, point_velocity
from srs_ik.kernels.chain.newton import arm_angle, elbow_position, twist_to
from srs_ik.kernels.control.impedance import pull
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.control import ARM_ANGLE, ELBOW, JOINT, KIND, ORIENTATION, TARGET, TIP
from srs_ik.kernels.limb.spherical import wrap
from srs_ik.kernels.limb.triangle import shoulder_to_wrist, target_frame

STEEPEST = 20.0
"""Largest length of the derivatives of the arm angle, rad/rad, that torques follow; beyond, they are scaled to it."""


@kernel
def pull_point(port, state, point, J, v, joints, torque):
    """Pull a point, carried by the first so many joints, to the target of a port."""
    velocity = (0.0, 0.0, 0.0)
    for joint in range(joints):
        velocity = add(velocity, scale(v[joint], point_velocity(J, joint, point)))
    h = pull(port, state, sub(load3(port, TARGET), point), velocity)
    for joint in range(joints):
        torque[joint] += dot(point_velocity(J, joint, point), h)


@kernel
def turn_tip(port, state, frame, J, v, torque):
    """Turn the tip to the rotation of a port, about the axis of the shortest turn."""
    x, y, z, p = frame
    _, turn = twist_to(x, y, z, p, load9(port, TARGET), p)
    velocity = (0.0, 0.0, 0.0)
    for joint in range(7):
        velocity = add(velocity, scale(v[joint], (J[3, joint], J[4, joint], J[5, joint])))
    h = pull(port, state, turn, velocity)
    for joint in range(7):
        torque[joint] += dot((J[3, joint], J[4, joint], J[5, joint]), h)


@kernel
def angle_at(P, q, frame):
    """Arm angle of a configuration whose tip frame is known."""
    x, y, z, p = frame
    R = (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2])
    _, t, h0 = target_frame(P, shoulder_to_wrist(P, R, p))
    return arm_angle(P, q, t, h0)


@kernel
def turn_elbow(P, port, state, frame, q, J, v, derivatives, torque):
    """Turn the elbow about the line from shoulder to wrist, to the arm angle of a port."""
    exists = gradient(P, q, J, derivatives)[2]
    rate = 0.0
    steepness = 0.0
    for joint in range(7):
        steepness = math.hypot(steepness, derivatives[joint])
    share = min(1.0, STEEPEST / steepness) if steepness > 0.0 else 0.0
    for joint in range(7):
        derivatives[joint] *= share
        rate += derivatives[joint] * v[joint]
    error = wrap(port[TARGET] - angle_at(P, q, frame)) if exists else 0.0
    h = pull(port, state, (error, 0.0, 0.0), (rate, 0.0, 0.0))
    for joint in range(7):
        torque[joint] += derivatives[joint] * h[0]


@kernel
def keep_off(port, state, q, v, torque):
    """Push a joint out of the zone before its lower or upper limit."""
    joint = int(port[JOINT])
    error = max(port[TARGET] - q[joint], 0.0) + min(port[TARGET + 1] - q[joint], 0.0)
    speed = v[joint] if error != 0.0 else 0.0
    torque[joint] += pull(port, state, (error, 0.0, 0.0), (speed, 0.0, 0.0))[0]


@kernel
def act(P, port, state, frame, q, J, v, derivatives, torque):
    """Add the torques of one port."""
    kind = port[KIND]
    if kind == TIP:
        pull_point(port, state, frame[3], J, v, 7, torque)
    elif kind == ORIENTATION:
        turn_tip(port, state, frame, J, v, torque)
    elif kind == ELBOW:
        pull_point(port, state, elbow_position(P, q), J, v, 3, torque)
    elif kind == ARM_ANGLE:
        turn_elbow(P, port, state, frame, q, J, v, derivatives, torque)
    else:
        keep_off(port, state, q, v, torque)
