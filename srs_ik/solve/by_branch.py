"""A batch of poses of which each has a branch of its own: one batch a branch."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from srs_ik.errors import InvalidPose
from srs_ik.inputs.angles import as_branches, per_pose
from srs_ik.inputs.poses import as_matrices, refuse_bad_poses
from srs_ik.kernels.entries.pose import check_pose
from srs_ik.kernels.layout.answer import ROW
from srs_ik.solve.packed import PackedArm
from srs_ik.solve.solution import Collision
from srs_ik.solve.solutions import BatchSolution


def solve_batch(
    arm: PackedArm, ask: Callable[..., BatchSolution], poses: Any, arm_angle: Any, seed: Any, branch: Any, *others: Any
) -> BatchSolution:
    """See `Arm.solve_batch`; `ask` takes the same arguments with one branch for all.

    Raises:
        InvalidPose: a pose is no finite rigid transform.
        InvalidConfiguration: seed, arm angle or branch are malformed.
    """
    T = as_matrices(poses)
    n = len(T)
    branches = as_branches(branch, n)
    each = [
        None if given is None else np.broadcast_to(per_pose(given, shape, n, what), (n, *shape))
        for given, shape, what in ((arm_angle, (), "arm_angle"), (seed, (7,), "seed"))
    ]
    rows = np.empty((n, ROW))
    hits: dict[tuple[int, ...], Collision] = {}
    for number in np.unique(branches).tolist():
        at = np.flatnonzero(branches == number)
        psis, seeds = (None if given is None else given[at] for given in each)
        try:
            found = ask(T[at], psis, seeds, number, *others)
        except InvalidPose:
            # By its number among all.
            refuse_bad_poses(np.array([check_pose(pose) for pose in T]))
            raise
        rows[at] = found._rows
        hits.update({(int(at[place[0]]),): hit for place, hit in found.collisions.items()})
    return BatchSolution(rows, arm.joint_names, arm.told[2 if arm_angle is None else 3], hits)
