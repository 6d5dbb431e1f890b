"""Where the tip is and how it moves, for many configurations at once, in compiled code."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from srs_ik.inputs.angles import as_bounded_joint_vector, as_joint_vectors
from srs_ik.kernels.entries.kinematics import centres_range, configuration_arm_angle, forward_range, jacobian_range
from srs_ik.solve.packed import PackedArm
from srs_ik.solve.threads import run_in_threads
from srs_ik.system.arrays import Array, equal_to_itself


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


@equal_to_itself
class Centres(NamedTuple):
    """The centres of an arm in the base frame, m: (3,) each, or (N, 3)."""

    shoulder: Array
    elbow: Array
    wrist: Array


def _one_or_many(q: Any) -> tuple[Array, bool]:
    """(N, 7) checked configurations, and whether more than one vector was given."""
    try:
        many = np.ndim(q) > 1
    except ValueError:  # lists of different lengths, of which `as_joint_vectors` speaks
        many = True
    return (as_joint_vectors(q) if many else as_bounded_joint_vector(q)[None]), many


def arm_angle(packed: PackedArm, q: Any) -> Any:
    """See `Arm.arm_angle`."""
    angles, many = _one_or_many(q)
    found = [configuration_arm_angle(packed.family, each)[0] for each in angles]
    return np.array(found, float) if many else float(found[0])


def branch(packed: PackedArm, q: Any) -> Any:
    """See `Arm.branch`."""
    angles, many = _one_or_many(q)
    found = [configuration_arm_angle(packed.family, each)[1] for each in angles]
    return np.array(found, np.int64) if many else int(found[0])


def centres(packed: PackedArm, q: Any) -> Centres:
    """See `Arm.centres`."""
    angles, many = _one_or_many(q)
    points = np.empty((3, len(angles), 3))
    centres_range(packed.family, angles, 0, len(angles), points)
    return Centres(*(points if many else points[:, 0]))
