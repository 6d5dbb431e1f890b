"""Where impedances act: tip point and orientation, elbow centre, arm angle, and joints near their limits or too fast.

The torques of all ports add up, each by the transpose of its own Jacobian. Nothing is inverted.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from srs_ik.kernels.algebra.joint_vectors import short_way
from srs_ik.kernels.algebra.vectors import add, dot, load3, load9, scale, sub
from srs_ik.kernels.chain.arm_angle_rates import gradient
from srs_ik.kernels.chain.kinematics import point_velocity
from srs_ik.kernels.chain.newton import arm_angle, elbow_position, twist_to
from srs_ik.kernels.control.impedance import pull, pull_angle
from srs_ik.kernels.control.profile import force
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import control as at
from srs_ik.kernels.limb.triangle import shoulder_to_wrist, target_frame

STEEPEST = 20.0
"""Largest length of the derivatives of the arm angle, rad/rad, that torques follow; beyond, they are scaled to it."""


class Motion(NamedTuple):
    """How the arm moves in a tick."""

    q: Any  # seven joint angles
    v: Any  # seven joint speeds
    frame: Any  # directions x, y and z of the tip, and its point
    J: Any  # (6, 7) lines of the joints


@kernel
def pull_point(port, state, point, joints, motion, torque):
    """Pull a point, carried by the first so many joints, to the target of a port."""
    velocity = (0.0, 0.0, 0.0)
    for joint in range(joints):
        velocity = add(velocity, scale(motion.v[joint], point_velocity(motion.J, joint, point)))
    h = pull(port, state, sub(load3(port, at.TARGET), point), velocity)
    for joint in range(joints):
        torque[joint] += dot(point_velocity(motion.J, joint, point), h)


@kernel
def turn_tip(port, state, motion, torque):
    """Turn the tip to the rotation of a port, about the axis of the shortest turn."""
    J = motion.J
    x, y, z, p = motion.frame
    _, turn = twist_to(x, y, z, p, load9(port, at.TARGET), p)
    velocity = (0.0, 0.0, 0.0)
    for joint in range(7):
        velocity = add(velocity, scale(motion.v[joint], (J[3, joint], J[4, joint], J[5, joint])))
    h = pull(port, state, turn, velocity)
    for joint in range(7):
        torque[joint] += dot((J[3, joint], J[4, joint], J[5, joint]), h)


@kernel
def angle_at(P, motion):
    """Arm angle of a configuration whose tip frame is known."""
    x, y, z, p = motion.frame
    R = (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2])
    _, t, h0 = target_frame(P, shoulder_to_wrist(P, R, p))
    return arm_angle(P, motion.q, t, h0)


@kernel
def turn_elbow(P, port, state, motion, work):
    """Turn the elbow about the line from shoulder to wrist, to the arm angle of a port."""
    derivatives = work[at.DERIVATIVES]
    exists = gradient(P, motion.q, motion.J, derivatives)[2]
    rate, steepness = 0.0, 0.0
    for joint in range(7):
        steepness = math.hypot(steepness, derivatives[joint])
    share = min(1.0, STEEPEST / steepness) if steepness > 0.0 else 0.0
    for joint in range(7):
        derivatives[joint] *= share
        rate += derivatives[joint] * motion.v[joint]
    error = short_way(port[at.TARGET] - angle_at(P, motion)) if exists else 0.0
    h = pull_angle(port, state, error, rate, share)
    for joint in range(7):
        work[at.TORQUE, joint] += derivatives[joint] * h


@kernel
def keep_off(port, state, motion, torque):
    """Push a joint out of the zone before its lower or upper limit."""
    joint = int(port[at.JOINT])
    error = max(port[at.TARGET] - motion.q[joint], 0.0) + min(port[at.TARGET + 1] - motion.q[joint], 0.0)
    speed = motion.v[joint] if error != 0.0 else 0.0
    torque[joint] += pull_angle(port, state, error, speed, 1.0)


@kernel
def slow_down(port, state, motion, torque):
    """Brake a joint that is faster than its port lets it be, the more the faster."""
    joint = int(port[at.JOINT])
    v = motion.v[joint]
    beyond = max(abs(v) - port[at.TARGET], 0.0)
    h = -math.copysign(force(port, beyond), v)
    state[at.ERROR] = -math.copysign(beyond, v)
    state[at.FORCE] = h
    state[at.POWER] = h * v
    torque[joint] += h


@kernel
def act(P, port, state, motion, work):
    """Add the torques of one port to the row TORQUE of the work of a tick."""
    kind = port[at.KIND]
    torque = work[at.TORQUE]
    if kind == at.TIP:
        pull_point(port, state, motion.frame[3], 7, motion, torque)
    elif kind == at.ORIENTATION:
        turn_tip(port, state, motion, torque)
    elif kind == at.ELBOW:
        pull_point(port, state, elbow_position(P, motion.q), 3, motion, torque)
    elif kind == at.ARM_ANGLE:
        turn_elbow(P, port, state, motion, work)
    elif kind == at.JOINT_LIMIT:
        keep_off(port, state, motion, torque)
    else:
        slow_down(port, state, motion, torque)
