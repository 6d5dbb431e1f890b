"""How hard an arm's joints have to hold against its weight."""

from __future__ import annotations

from srs_ik.kernels.chain.gravity import hold
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.weights import SCALES

TORQUE = 5
"""Row of the work space that takes the torques, behind those of `hold`."""


@kernel
def squared_torque(P, W, q, work):
    """Sum of squared scaled gravity torques; work (6, 7) is work space."""
    hold(P, W, q, work, 0, TORQUE)
    total = 0.0
    for joint in range(7):
        torque = W[SCALES + joint] * work[TORQUE, joint]
        total += torque * torque
    return total
