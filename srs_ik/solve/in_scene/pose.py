"""Postures that hit nothing, of one pose and of many: the best in what bodies leave, or who is in the way of all."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.errors import InvalidConfiguration
from srs_ik.inputs.angles import NO_SEED, NO_SEEDS, as_branch, as_seeds, per_pose, seed_of
from srs_ik.inputs.poses import as_matrices, invalid_pose, refuse_bad_poses
from srs_ik.kernels.entries import collision as entries
from srs_ik.kernels.layout import collision as at
from srs_ik.kernels.layout.answer import ROW, ROW_STATUS
from srs_ik.solve import intervals as in_limits
from srs_ik.solve import pose as pose_solver
from srs_ik.solve.goals import goal_of
from srs_ik.solve.in_scene.surroundings import chosen, narrowed
from srs_ik.solve.intervals import IntervalsBatch, gathered
from srs_ik.solve.solution import Collision, Solution, Status
from srs_ik.solve.solutions import BatchSolution, Solutions
from srs_ik.solve.threads import run_in_threads
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.in_scene.surroundings import Surroundings

_WIDE_ENOUGH = 1e-3
"""Of postures that all hit something, one whose clearance is this near to the largest is given, m."""

_SAME = 1e-9
"""Joint angles that differ by less, rad, are one posture."""


def solve(
    around: Surroundings, T: Array, psi: float | None, near: Array | None, branch: int, respect: bool
) -> Solution:
    """The best posture that hits nothing, of one branch or of all (-1), at one arm angle or at all.

    Raises:
        InvalidPose: the pose is no finite rigid transform.
    """
    if psi is None and around.in_closed_form:
        rows, verdicts = np.empty((1, ROW)), np.zeros(1, np.int8)
        seeds = NO_SEEDS if near is None else near[None]
        around.solve_range(T[None], 0, 1, branch, seeds, respect, rows, verdicts)
        if verdicts[0]:
            raise invalid_pose(int(verdicts[0]))
        found = Solution(rows[0], around.packed.joint_names, around.packed.elbow)
        if found:
            return found
    else:
        solution = best_free(around, T, psi, near, branch, respect, around.is_exact)
        if solution is not None:
            return solution
    return _where_nothing_is_free(around, T, psi, near, branch, respect)


def free_intervals(around: Surroundings, T: Array, respect: bool) -> tuple[Array, float]:
    """(n, 3) the free intervals of a pose, by real shapes where spheres leave none; the width left undecided, rad.

    Raises:
        InvalidPose: the pose is no finite rigid transform.
    """
    free = around.free_and_undecided(T, respect)
    return free if len(free[0]) or around.is_exact else around.by_shapes(T, respect)


def _where_nothing_is_free(
    around: Surroundings, T: Array, psi: float | None, near: Array | None, branch: int, respect: bool
) -> Solution:
    """The best posture that the real shapes leave where spheres leave none, or what is in the way."""
    found = chosen(around.feasible(T, respect), branch, psi)
    if not len(found):
        # Where rounding leaves no interval, there may be a posture.
        return _judged(around, pose_solver.solve(around.packed, T, psi, near, None if branch < 0 else branch, respect))
    if not around.is_exact:
        solution = best_free(around, T, psi, near, branch, respect, True)
        if solution is not None:
            return solution
    return _hitting(around, T, found, psi, respect)


def best_free(
    around: Surroundings, T: Array, psi: float | None, near: Array | None, branch: int, respect: bool, by_shapes: bool
) -> Solution | None:
    """The best posture that spheres leave, or the real shapes; None where they leave none."""
    if not around.packed.closed:
        return _best_of_near(around, T, psi, near, branch, respect, by_shapes)
    if by_shapes:
        solution = _best_of_all(around, T, near, branch, respect) if psi is None else None
        if solution is not None:
            return solution
        free = around.by_shapes(T, respect, branch=branch, psi=psi)[0]
    else:
        free = chosen(around.all_free(T, respect), branch, psi)
    return best(around, T, free, psi, near, respect) if len(free) else None


def _best_of_near(
    around: Surroundings, T: Array, psi: float | None, near: Array | None, branch: int, respect: bool, by_shapes: bool
) -> Solution | None:
    """The same of a near limb: the best posture within the limits, of all or of each branch, where that is free."""
    arm, goal = around.packed, goal_of(around.packed, near)
    if psi is None:
        wanted = pose_solver.solve(arm, T, None, near, None if branch < 0 else branch, respect)
        if not wanted or around.is_clear(wanted.q, by_shapes):
            return wanted or None
    alone = [pose_solver.solve(arm, T, psi, near, k, respect) for k in (range(8) if branch < 0 else (branch,))]
    alone = [answer for answer in alone if answer]
    found = goal.best(answer for answer in alone if around.is_clear(answer.q, by_shapes))
    # Of a branch whose best posture hits something, another one may be better than those of the other branches.
    least = np.inf if found is None else goal.cost(found.q)
    better = [answer.branch for answer in alone if goal.cost(answer.q) < least]
    if psi is None and better:
        own = by_shapes == around.is_exact
        rows = around.all_free(T, respect) if own else around.by_shapes(T, respect, branch=branch)[0]
        if not (len(rows) or by_shapes):
            # Real shapes tell of all arm angles then.
            return None
        other = goal.over(T, rows[np.isin(rows[:, 0], better)], respect)
        found = goal.best(each for each in (found, other) if each is not None)
    return found


def _best_of_all(around: Surroundings, T: Array, near: Array | None, branch: int, respect: bool) -> Solution | None:
    """The best posture of an exact limb within its limits, if real shapes leave it; then nothing has to be searched."""
    wanted = pose_solver.solve(around.packed, T, None, near, None if branch < 0 else branch, respect)
    if not wanted:
        return None
    free = around.by_shapes(T, respect, branch=wanted.branch, psi=wanted.arm_angle)[0]
    found = best(around, T, free, wanted.arm_angle, near, respect) if len(free) else None
    # Next to a singularity an arm angle has many postures, and another one than this was looked at.
    same = found is not None and float(np.abs(found.q - wanted.q).max()) < _SAME
    return found if same else None


def best(
    around: Surroundings, T: Array, free: Array, psi: float | None, near: Array | None, respect: bool
) -> Solution | None:
    """The best posture in free intervals; None where none of them closes."""
    arm = around.packed
    if psi is not None:
        goal = goal_of(arm, near)
        answers = (pose_solver.solve(arm, T, psi, near, int(row[0]), respect) for row in free)
        return goal.best(answer for answer in answers if answer)
    if not arm.closed:
        return goal_of(arm, near).over(T, free, respect)
    row = np.empty(ROW)
    seed = NO_SEED if near is None else near
    entries.best_within(arm.family, T, free, len(free), -1, seed, near is not None, respect, row)
    solution = Solution(row, arm.joint_names, arm.elbow)
    return solution or None


def _hitting(around: Surroundings, T: Array, found: Array, psi: float | None, respect: bool) -> Solution:
    """The posture with the largest clearance of those that all hit something; or one that hits nothing after all."""
    among = found
    for kept in (around.in_range, around.not_meeting):
        in_range = kept(T, found, respect)
        if psi is not None:
            in_range = narrowed(in_range, psi)
        if len(in_range):
            among = in_range
            break
    wide = around.widest(T, among, _WIDE_ENOUGH) if psi is None else around.clearance(T, int(among[0, 0]) >> 2, psi)
    branch = int(wide[at.WIDE_BRANCH]) if psi is None else int(among[0, 0])
    # Too narrow a set of free angles may not have been found, and yet this posture be in it.
    return _judged(around, pose_solver.solve(around.packed, T, float(wide[at.WIDE_ARM_ANGLE]), None, branch, respect))


def _judged(around: Surroundings, solution: Solution) -> Solution:
    """A posture with what it hits by the real shapes, if it is one and hits anything."""
    hit = around.deepest_at(solution.q) if solution else None
    if hit is not None:
        solution._row[ROW_STATUS] = Status.COLLISION
        solution.collision = hit
    return solution


def solve_all(around: Surroundings, T: Array, psi: float | None, respect: bool) -> Solutions:
    """One posture for every free interval, or those at an arm angle."""
    arm = around.packed
    free = chosen(free_intervals(around, T, respect)[0], -1, psi)
    each = (best(around, T, row[None], psi, None, respect) for row in free)
    rows = [answer._row for answer in each if answer is not None]
    if rows:
        return Solutions(np.array(rows), arm.joint_names, None, arm.elbow)
    failure = solve(around, T, psi, None, -1, respect)
    if failure:
        return Solutions.of_one(failure)
    return Solutions(np.empty((0, ROW)), arm.joint_names, failure, arm.elbow)


def solve_batch(
    around: Surroundings,
    poses: Any,
    arm_angle: ArrayLike | None,
    seed: ArrayLike | None,
    branch: int | None,
    all_branches: bool,
    respect: bool,
    threads: int | None,
) -> BatchSolution:
    """See `Arm.solve_batch`."""
    arm, T = around.packed, as_matrices(poses)
    n = len(T)
    psis = None if arm_angle is None else per_pose(arm_angle, (), n, "arm_angle")
    seeds = as_seeds(seed, n, arm.lower, arm.upper)
    wanted = as_branch(branch)
    if all_branches and psis is None:
        raise InvalidConfiguration("all_branches needs an arm_angle; without one, see solve_all and intervals")
    if psis is None and around.in_closed_form:
        return _in_kernels(around, T, wanted, seeds, respect, threads)

    def answer(i: int, branch: int) -> Solution:
        psi = None if psis is None else float(psis[i if len(psis) > 1 else 0])
        return solve(around, T[i], psi, seed_of(seeds, i), branch, respect)

    told = arm.told[(psis is not None) + 2 * (wanted >= 0)]
    if not all_branches:
        rows, hits = answered(n, threads, lambda i: answer(i, wanted))
        return BatchSolution(rows, arm.joint_names, told, hits)
    rows, hits = answered(8 * n, threads, lambda k: answer(*divmod(k, 8)))
    hits = {divmod(k, 8): hit for (k,), hit in hits.items()}
    return BatchSolution(rows.reshape(n, 8, ROW), arm.joint_names, told, hits)


def answered(
    count: int, threads: int | None, answer: Callable[[int], Solution]
) -> tuple[Array, dict[tuple[int, ...], Collision]]:
    """(count, ROW) rows of the answers to as many questions, and what hits what in them, by their index."""
    rows = np.empty((count, ROW))
    hits: dict[tuple[int, ...], Collision] = {}

    def work(first: int, last: int) -> None:
        for i in range(first, last):
            found = answer(i)
            rows[i] = found._row
            if found.collision is not None:
                hits[(i,)] = found.collision

    run_in_threads(work, count, threads)
    return rows, hits


def _in_kernels(
    around: Surroundings, T: Array, branch: int, seeds: Array, respect: bool, threads: int | None
) -> BatchSolution:
    """The best postures of many poses of an exact limb by its spheres; where there is none, pose by pose."""
    arm = around.packed
    rows, verdicts = np.empty((len(T), ROW)), np.zeros(len(T), np.int8)

    def work(first: int, last: int) -> None:
        around.solve_range(T, first, last, branch, seeds, respect, rows, verdicts)

    run_in_threads(work, len(T), threads)
    refuse_bad_poses(verdicts)
    left = np.flatnonzero(rows[:, ROW_STATUS] != Status.OK).tolist()

    def answer(k: int) -> Solution:
        return _where_nothing_is_free(around, T[left[k]], None, seed_of(seeds, left[k]), branch, respect)

    rows[left], hits = answered(len(left), threads, answer)
    told = arm.told[0 if branch < 0 else 2]
    return BatchSolution(rows, arm.joint_names, told, {(left[k],): hit for (k,), hit in hits.items()})


def intervals_batch(around: Surroundings, poses: Any, respect: bool, threads: int | None) -> IntervalsBatch:
    """See `Arm.intervals_batch`."""
    T = as_matrices(poses)
    rest = np.arange(len(T))
    known = IntervalsBatch(np.empty(0, np.int64), np.empty(0), np.empty(0), np.zeros(len(T) + 1, np.int64))
    if around.in_closed_form:
        known = gathered(len(T), threads, partial(around.free_range, T), respect)
        rest = np.flatnonzero(known.counts == 0)
        rest = rest[in_limits.intervals_batch(around.packed, T[rest], respect, threads).counts > 0]
    found: list[Array] = [np.empty((0, 3))] * len(rest)

    def work(first: int, last: int) -> None:
        for i in range(first, last):
            found[i] = free_intervals(around, T[rest[i]], respect)[0].copy()

    run_in_threads(work, len(rest), threads)
    branch, lower, upper = np.concatenate([np.empty((0, 3)), *found]).T
    counts = known.counts
    counts[rest] = [len(rows) for rows in found]
    at = np.repeat(known.offsets[rest], counts[rest])
    return IntervalsBatch(
        np.insert(known.branch, at, branch.astype(np.int64)),
        np.insert(known.lower, at, lower),
        np.insert(known.upper, at, upper),
        np.cumsum([0, *counts]),
    )
