"""Entry points: where a configuration is on its circle, and how joints and arm angle move together."""

from __future__ import annotations

import numpy as np

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.chain.arm_angle_rates import gradient, tangent
from srs_ik.kernels.chain.kinematics import forward_kinematics
from srs_ik.kernels.chain.newton import arm_angle
from srs_ik.kernels.jit import entry
from srs_ik.kernels.layout.limb import LIMITED
from srs_ik.kernels.limb.branches import branch_of
from srs_ik.kernels.limb.poses import read7
from srs_ik.kernels.limb.triangle import shoulder_to_wrist, target_frame


@entry
def arm_angle_jacobian(family, q, g):
    """Write d(arm angle)/dq into g (7,); returns whether it exists, else g is zero."""
    return gradient(row(family, LIMITED), read7(q), np.empty((6, 7)), g)[2]


@entry
def self_motion_tangent(family, q, out):
    """Write dq/d(arm angle) at rest of the tip into out (7,); returns whether it exists, else out is zero."""
    v, exists = tangent(row(family, LIMITED), read7(q))
    for joint in range(7):
        out[joint] = v[joint]
    return exists


@entry
def configuration_arm_angle(family, q):
    """Arm angle and branch of a configuration."""
    P = row(family, LIMITED)
    q = read7(q)
    x, y, z, p = forward_kinematics(P, q)
    R = (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2])
    _, t, h0 = target_frame(P, shoulder_to_wrist(P, R, p))
    return arm_angle(P, q, t, h0), branch_of(P, q)
