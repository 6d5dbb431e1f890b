"""Postures for one pose and for many: the best, one for every branch or interval, and batches of them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.errors import InvalidConfiguration
from srs_ik.inputs.angles import NO_SEED, as_arm_angle, as_branch, as_seed, as_seeds, per_pose
from srs_ik.inputs.poses import OR_FREE, PoseLike, as_matrices, as_matrix, invalid_pose, refuse_bad_poses
from srs_ik.kernels.entries import pose as entries
from srs_ik.kernels.layout.answer import MOST_INTERVALS, ROW
from srs_ik.solve.packed import PackedArm
from srs_ik.solve.solution import Solution
from srs_ik.solve.solutions import BatchSolution, Solutions
from srs_ik.solve.threads import run_in_threads
from srs_ik.system.arrays import Array


def solve(
    arm: PackedArm,
    pose: PoseLike,
    arm_angle: float | None = None,
    seed: ArrayLike | None = None,
    branch: int | None = None,
    respect_limits: bool = True,
) -> Solution:
    """See `Arm.solve`."""
    row = np.empty(ROW)
    T = as_matrix(pose, OR_FREE)
    chosen = -1 if branch is None else as_branch(branch)
    near = NO_SEED if seed is None else as_seed(seed, arm.lower, arm.upper)
    respect_limits = bool(respect_limits)
    if arm_angle is None:
        told = arm.told[0 if chosen < 0 else 2]
        verdict = entries.solve(arm.family, T, chosen, near, seed is not None, respect_limits, row)
    else:
        told = arm.told[1 if chosen < 0 else 3]
        psi = as_arm_angle(arm_angle)
        verdict = entries.solve_at(arm.family, T, psi, chosen, near, seed is not None, respect_limits, row)
    if verdict:
        raise invalid_pose(verdict)
    return Solution(row, arm.joint_names, told)


def lead(
    arm: PackedArm, T: Array, psi: float, branch: int, before: Array, seed: Array | None, respect: bool
) -> Solution | None:
    """The posture of a near limb at an arm angle, if one of its branch close by leads to it."""
    row = np.empty(ROW)
    near = NO_SEED if seed is None else seed
    met = entries.lead(arm.family, T, psi, branch, before, near, seed is not None, respect, row)
    return Solution(row, arm.joint_names, arm.elbow) if met else None


def solve_all(arm: PackedArm, pose: PoseLike, arm_angle: float | None, respect_limits: bool) -> Solutions:
    """See `Arm.solve_all`."""
    T = as_matrix(pose)
    if arm_angle is None:
        rows = np.empty((MOST_INTERVALS, ROW))
        count = entries.solve_intervals(arm.family, T, respect_limits, rows)
    else:
        rows = np.empty((8, ROW))
        psi = as_arm_angle(arm_angle)
        count = entries.solve_all(arm.family, T, psi, respect_limits, rows)
    if count < 0:
        raise invalid_pose(-count)
    solved = Solutions(rows if count == len(rows) else rows[:count], arm.joint_names, None, arm.elbow)
    if arm_angle is None:
        ok = solved.ok
        if not ok.all():
            solved = Solutions(rows[:count][ok], arm.joint_names, None, arm.elbow)
    if not len(solved._rows):
        best = solve(arm, T, arm_angle=arm_angle, respect_limits=respect_limits)
        if best:
            # Where only rounding leaves room for a posture, the looser search for one alone may still find it.
            return Solutions.of_one(best)
        solved.failure = best
    return solved


def solve_batch(
    arm: PackedArm,
    poses: Any,
    arm_angle: ArrayLike | None,
    seed: ArrayLike | None,
    branch: int | None,
    all_branches: bool,
    respect_limits: bool,
    threads: int | None,
) -> BatchSolution:
    """See `Arm.solve_batch`."""
    T = as_matrices(poses)
    n = len(T)
    psis = None if arm_angle is None else per_pose(arm_angle, (), n, "arm_angle")
    seeds = as_seeds(seed, n, arm.lower, arm.upper)
    chosen = as_branch(branch)
    if all_branches and psis is None:
        raise InvalidConfiguration("all_branches needs an arm_angle; without one, see solve_all and intervals")
    limb, verdicts = arm.family, np.zeros(n, np.int8)
    out = np.empty((8 * n if all_branches else n, ROW))

    def work(first: int, last: int) -> None:
        answer = (respect_limits, out, verdicts)
        if psis is None:
            entries.solve_range(limb, T, first, last, chosen, seeds, *answer)
        elif all_branches:
            entries.solve_all_range(limb, T, first, last, psis, *answer)
        else:
            entries.solve_at_range(limb, T, first, last, psis, chosen, seeds, *answer)

    run_in_threads(work, n, threads)
    refuse_bad_poses(verdicts)
    told = arm.told[(psis is not None) + 2 * (chosen >= 0)]
    return BatchSolution(out.reshape(n, 8, ROW) if all_branches else out, arm.joint_names, told)
