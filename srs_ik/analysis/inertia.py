"""How little inertia stands against the torque of a joint, by Pinocchio's mass matrix."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.kinematics import ChainKinematics

DRAWN = 256
"""Configurations that are looked at, half of them with joints 2, 4 and 6 as straight as their limits let them."""

ALONE = 1e-9
"""Part of the largest eigenvalue of a mass matrix below which a motion has no inertia."""


def least_inertias(arm: ChainKinematics) -> Array:
    """(7,) least inertia, kg m^2, of each joint with all others free to move, over drawn configurations.

    That is one over the diagonal of the inverse of the mass matrix; zero where some motion of joints moves no mass.
    """
    rng = np.random.default_rng(0)
    lower, upper = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    drawn = lower + (upper - lower) * rng.uniform(size=(DRAWN, 7))
    drawn[::2, 1:6:2] = np.clip(0.0, lower, upper)[1:6:2]
    model, data = arm.model, arm.model.createData()
    M = np.array([pin.crba(model, data, arm.configuration(q)) for q in drawn])
    # Pinocchio fills the upper triangle alone.
    values, axes = np.linalg.eigh(M, UPLO="U")
    if (values[:, 0] <= ALONE * values[:, -1]).any():
        return np.zeros(7)
    return np.asarray(1.0 / (axes**2 / values[:, None]).sum(axis=2).max(axis=0))
