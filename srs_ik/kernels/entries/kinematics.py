"""Entry points: where the tip and the elbow of configurations are, and how they move with the joints."""

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import store7
from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.algebra.vectors import add, load3
from srs_ik.kernels.chain.arm_angle_rates import gradient, tangent
from srs_ik.kernels.chain.kinematics import forward_kinematics, tip_lines
from srs_ik.kernels.chain.newton import arm_angle, elbow_position
from srs_ik.kernels.jit import entry
from srs_ik.kernels.layout.limb import LIMITED, SHOULDER_CENTRE
from srs_ik.kernels.limb.branches import branch_of
from srs_ik.kernels.limb.triangle import shoulder_to_wrist, target_frame


@entry
def forward_range(family, q, first, last, out):
    """Write the tip poses of the configurations first to last - 1 of q (N, 7) into out (N, 4, 4)."""
    P = row(family, LIMITED)
    for i in range(first, last):
        x, y, z, p = forward_kinematics(P, read7(row(q, i)))
        for k in range(3):
            out[i, k, 0], out[i, k, 1], out[i, k, 2], out[i, k, 3] = x[k], y[k], z[k], p[k]
            out[i, 3, k] = 0.0
        out[i, 3, 3] = 1.0


@entry
def jacobian_range(family, q, first, last, out):
    """Write the Jacobians of the tip point, in base axes, of the same configurations into out (N, 6, 7)."""
    P = row(family, LIMITED)
    for i in range(first, last):
        tip_lines(P, read7(row(q, i)), out[i])


@entry
def arm_angle_jacobian(family, q, g):
    """Write d(arm angle)/dq into g (7,); returns whether it exists, else g is zero."""
    return gradient(row(family, LIMITED), read7(q), np.empty((6, 7)), g)[2]


@entry
def self_motion_tangent(family, q, out):
    """Write dq/d(arm angle) at rest of the tip into out (7,); returns whether it exists, else out is zero."""
    v, exists = tangent(row(family, LIMITED), read7(q))
    store7(out, 0, v)
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


@entry
def centres_range(family, q, first, last, out):
    """Write where shoulder, elbow and wrist centre of the same configurations are into out (3, N, 3)."""
    P = row(family, LIMITED)
    shoulder = load3(P, SHOULDER_CENTRE)
    for i in range(first, last):
        x, y, z, p = forward_kinematics(P, read7(row(q, i)))
        R = (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2])
        wrist = add(shoulder, shoulder_to_wrist(P, R, p))
        elbow = elbow_position(P, read7(row(q, i)))
        for k in range(3):
            out[0, i, k], out[1, i, k], out[2, i, k] = shoulder[k], elbow[k], wrist[k]
