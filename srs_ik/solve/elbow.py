"""Postures whose elbow is where it is wanted, or as near to it as limits leave."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.inputs.angles import NO_SEED, as_branch, as_seed, as_seeds
from srs_ik.inputs.elbow import as_elbow
from srs_ik.inputs.poses import PoseLike, as_matrices, as_matrix, invalid_pose, refuse_bad_poses
from srs_ik.kernels.entries import pose as entries
from srs_ik.kernels.layout.answer import ROW
from srs_ik.solve.packed import PackedArm
from srs_ik.solve.solution import Solution
from srs_ik.solve.solutions import BatchSolution
from srs_ik.solve.threads import run_in_threads
from srs_ik.system.arrays import Array


def wanted_angles(arm: PackedArm, T: Array, elbow: Any) -> Array:
    """The arm angles that bring the elbow nearest to where it is wanted: (1,) for all of the poses (n, 4, 4), or (n,).

    Infinite for a point on the line from shoulder to wrist, from which all elbows are equally far.

    Raises:
        InvalidConfiguration: neither a number nor points, or not finite.
    """
    psi, points = as_elbow(elbow, len(T))
    if psi is not None:
        return np.array([psi])
    angles = np.empty(len(T))
    entries.angles_towards(arm.family, T, np.ascontiguousarray(points), angles)
    return angles


def solve(
    arm: PackedArm, pose: PoseLike, elbow: Any, seed: ArrayLike | None, branch: int | None, respect: bool
) -> Solution:
    """See `Arm.solve`."""
    row, T = np.empty(ROW), as_matrix(pose)
    near = NO_SEED if seed is None else as_seed(seed, arm.lower, arm.upper)
    psi, chosen = float(wanted_angles(arm, T[None], elbow)[0]), as_branch(branch)
    verdict = entries.solve_near(arm.family, T, psi, chosen, near, seed is not None, respect, row)
    if verdict:
        raise invalid_pose(verdict)
    return Solution(row, arm.joint_names, arm.told[0 if chosen < 0 else 2])


def solve_batch(
    arm: PackedArm,
    poses: Any,
    elbow: Any,
    seed: ArrayLike | None,
    branch: int | None,
    respect: bool,
    threads: int | None,
) -> BatchSolution:
    """See `Arm.solve_batch`."""
    T = as_matrices(poses)
    n, chosen = len(T), as_branch(branch)
    psis, seeds = wanted_angles(arm, T, elbow), as_seeds(seed, len(T), arm.lower, arm.upper)
    out, verdicts = np.empty((n, ROW)), np.zeros(n, np.int8)

    def work(first: int, last: int) -> None:
        entries.solve_near_range(arm.family, T, first, last, psis, chosen, seeds, respect, out, verdicts)

    run_in_threads(work, n, threads)
    refuse_bad_poses(verdicts)
    return BatchSolution(out, arm.joint_names, arm.told[0 if chosen < 0 else 2])
