"""Where the tip is and how it moves, for many configurations at once, in compiled code."""

from __future__ import annotations

from typing import Any

import numpy as np

from srs_ik.inputs.poses import as_joint_vectors
from srs_ik.kernels.entries.kinematics import forward_range, jacobian_range
from srs_ik.solve.packed import PackedArm
from srs_ik.solve.threads import run_in_threads
from srs_ik.system.arrays import Array


def forward_kinematics_batch(packed: PackedArm, q: Any, threads: int | None) -> Array:
    """See `Arm.forward_kinematics_batch`."""
    angles, family = as_joint_vectors(q), packed.family
    poses = np.empty((len(angles), 4, 4))
    run_in_threads(lambda first, last: forward_range(family, angles, first, last, poses), len(angles), threads)
    return poses


def jacobian_batch(packed: PackedArm, q: Any, threads: int | None) -> Array:
    """See `Arm.jacobian_batch`."""
    angles, family = as_joint_vectors(q), packed.family
    jacobians = np.empty((len(angles), 6, 7))
    run_in_threads(lambda first, last: jacobian_range(family, angles, first, last, jacobians), len(angles), threads)
    return jacobians
