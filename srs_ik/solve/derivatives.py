"""How the joint angles of a solution change with the pose and with the arm angle."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from srs_ik.system.arrays import Array, equal_to_itself

SMALLEST = 1e-9
"""Where a motion of the tip asks for joint motions larger by the inverse of this, there are no derivatives."""


@equal_to_itself
class SolutionDerivatives(NamedTuple):
    """First derivatives of the joint angles that `Arm.solve` gives for a pose and an arm angle.

    With ``dx`` a small motion of the tip, linear part first (metres, rad; the tip point, base axes), and ``dpsi`` one
    of the arm angle, the solution of the moved pose is q + ``pose @ dx + arm_angle * dpsi``, to first order.
    """

    pose: Array
    """(7, 6) dq/dx at a constant arm angle."""
    arm_angle: Array
    """(7,) dq/d(arm angle) with the tip at rest, rad/rad."""
    exist: bool
    """Whether there are any; else both arrays are zero."""


def solution_derivatives(by_pose: Array, by_angle: Array) -> SolutionDerivatives:
    """See `Arm.solution_derivatives`; from the Jacobian (6, 7) of the tip point and that (7,) of the arm angle."""
    U, stretch, V = np.linalg.svd(np.vstack([by_pose, by_angle]))
    if stretch[-1] < SMALLEST:
        return SolutionDerivatives(np.zeros((7, 6)), np.zeros(7), False)
    inverse = (V.T / stretch) @ U.T
    return SolutionDerivatives(inverse[:, :6].copy(), inverse[:, 6].copy(), True)
