"""Questions that name a branch for each pose: one batch a branch, and the nearest posture of every branch."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.errors import InvalidPose
from srs_ik.inputs.angles import as_branches, as_joint_vector, per_pose
from srs_ik.inputs.poses import PoseLike, as_matrices, as_matrix, refuse_bad_poses
from srs_ik.kernels.entries.pose import check_pose
from srs_ik.kernels.layout.answer import ROW
from srs_ik.solve.packed import PackedArm
from srs_ik.solve.solution import Collision
from srs_ik.solve.solutions import BatchSolution, Solutions

if TYPE_CHECKING:
    from srs_ik.solve.in_limits import InLimits
    from srs_ik.solve.in_scene.questions import InScene

SAME = 1e-9
"""Postures that differ by less, rad, are one, on the border of two branches."""


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


def nearest_of_each(
    arm: PackedArm, asked: InLimits | InScene, pose: PoseLike, arm_angle: float | None, seed: Any, respect: bool
) -> Solutions:
    """The posture of every branch that is nearest to a seed, the nearest of all first; see `Arm.solve_all`."""
    near = as_joint_vector(seed, "seed")
    poses = np.tile(as_matrix(pose), (8, 1, 1))
    found = solve_batch(arm, asked.solve_batch, poses, arm_angle, near, np.arange(8), False, respect, 1)
    rows = found._rows[found.ok]
    rows = rows[np.argsort(np.linalg.norm(rows[:, :7] - near, axis=1), kind="stable")]
    kept = rows[:0]
    for row in rows:
        if not (np.abs(kept[:, :7] - row[:7]).max(axis=1, initial=0.0) < SAME).any():
            kept = np.vstack([kept, row])
    failure = None if len(kept) else asked.solve(pose, arm_angle, near, None, respect)
    return Solutions(kept, arm.joint_names, failure, arm.elbow)
