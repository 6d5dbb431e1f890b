"""Postures that hit nothing, their elbow as near as can be to where it is wanted."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.inputs.angles import as_branch, as_seeds, seed_of
from srs_ik.inputs.poses import as_matrices, refuse_bad_poses
from srs_ik.kernels.entries.pose import check_pose
from srs_ik.solve import elbow as in_limits
from srs_ik.solve.elbow import wanted_angles
from srs_ik.solve.goals import INSIDE
from srs_ik.solve.in_scene.pose import answered, best, solve
from srs_ik.solve.in_scene.surroundings import chosen, narrowed
from srs_ik.solve.solution import Solution
from srs_ik.solve.solutions import BatchSolution
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.in_scene.surroundings import Surroundings


def nearest_free(
    around: Surroundings, T: Array, psi: float, near: Array | None, respect: bool, branch: int = -1
) -> tuple[float, Solution] | None:
    """How far the nearest free arm angle is from a wanted one, rad, and its best posture; None where there is none."""
    arm = around.packed
    if not arm.closed:
        # Intervals of a near limb leave out what is not shown to be free.
        wanted = in_limits.solve(arm, T, psi, near, None if branch < 0 else branch, respect)
        if wanted and around.is_clear(wanted.q):
            return abs(math.remainder(wanted.arm_angle - psi, 2.0 * math.pi)), wanted
    free = chosen(around.all_free(T, respect), branch, None)
    found = _nearest_in(around, T, free, psi, near, respect)
    if found is None and not around.is_exact:
        # Spheres leave nothing: what do the real shapes?
        found = _nearest_in(around, T, around.by_shapes(T, respect, branch=branch)[0], psi, near, respect)
    return found


def _nearest_in(
    around: Surroundings, T: Array, free: Array, psi: float, near: Array | None, respect: bool
) -> tuple[float, Solution] | None:
    ends = [_beside(psi, float(lower), float(upper)) for _, lower, upper in free]
    for lost, wanted in sorted(set(ends)):
        answer = best(around, T, narrowed(free, wanted), wanted, near, respect)
        if answer is not None:
            return lost, answer
    return None


def _beside(psi: float, lower: float, upper: float) -> tuple[float, float]:
    """How far the nearest angle of an interval is from another angle, rad, and that angle."""
    if (psi - lower) % (2.0 * math.pi) <= upper - lower:
        return 0.0, psi
    room = min(INSIDE, 0.25 * (upper - lower))
    ends = (lower + room, upper - room)
    return min((abs(math.remainder(end - psi, 2.0 * math.pi)), end) for end in ends)


def solve_near(around: Surroundings, T: Array, psi: float, near: Array | None, branch: int, respect: bool) -> Solution:
    """See `Arm.solve`, with a wanted elbow; an infinite arm angle says that all elbows are as near."""
    found = nearest_free(around, T, psi, near, respect, branch) if math.isfinite(psi) else None
    return solve(around, T, None, near, branch, respect) if found is None else found[1]


def solve_near_batch(
    around: Surroundings,
    poses: Any,
    elbow: Any,
    seed: ArrayLike | None,
    branch: int | None,
    respect: bool,
    threads: int | None,
) -> BatchSolution:
    """See `Arm.solve_batch`, with wanted elbows."""
    arm, T, wanted = around.packed, as_matrices(poses), as_branch(branch)
    refuse_bad_poses(np.array([check_pose(pose) for pose in T]))
    psis, seeds = wanted_angles(arm, T, elbow), as_seeds(seed, len(T), arm.lower, arm.upper)

    def answer(i: int) -> Solution:
        psi = float(psis[i if len(psis) > 1 else 0])
        return solve_near(around, T[i], psi, seed_of(seeds, i), wanted, respect)

    rows, hits = answered(len(T), threads, answer)
    told = arm.told[0 if wanted < 0 else 2]
    return BatchSolution(rows, arm.joint_names, told, hits)
