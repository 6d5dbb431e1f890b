"""Entry points: where the tip of many configurations is, and how it moves with the joints."""

from __future__ import annotations

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import add, cross
from srs_ik.kernels.chain.kinematics import forward_kinematics, joint_lines
from srs_ik.kernels.jit import entry
from srs_ik.kernels.layout.limb import LIMITED
from srs_ik.kernels.limb.poses import read7


@entry
def forward_range(family, q, first, last, out):
    """Write the tip poses of the configurations first to last - 1 of q (N, 7) into out (N, 4, 4)."""
    P = row(family, LIMITED)
    for i in range(first, last):
        x, y, z, p = forward_kinematics(P, read7(row(q, i)))
        for k in range(3):
            out[i, k, 0] = x[k]
            out[i, k, 1] = y[k]
            out[i, k, 2] = z[k]
            out[i, k, 3] = p[k]
            out[i, 3, k] = 0.0
        out[i, 3, 3] = 1.0


@entry
def jacobian_range(family, q, first, last, out):
    """Write the Jacobians of the tip point, in base axes, of the same configurations into out (N, 6, 7)."""
    P = row(family, LIMITED)
    for i in range(first, last):
        J = out[i]
        p = joint_lines(P, read7(row(q, i)), J)[3]
        for joint in range(7):
            moment = (J[0, joint], J[1, joint], J[2, joint])
            v = add(moment, cross((J[3, joint], J[4, joint], J[5, joint]), p))
            for k in range(3):
                J[k, joint] = v[k]
