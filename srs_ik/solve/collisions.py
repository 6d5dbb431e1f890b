"""Postures that hit nothing: the intervals that bodies leave, and the best posture in them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from srs_ik.collision.ranges import tightened
from srs_ik.collision.scene import Scene, as_margin
from srs_ik.errors import InvalidConfiguration, InvalidScene
from srs_ik.inputs.poses import (
    PoseLike,
    as_arm_angle,
    as_branch,
    as_matrices,
    as_matrix,
    as_seed,
    as_seeds,
    invalid_pose,
    per_pose,
)
from srs_ik.kernels.entries import collision as entries
from srs_ik.kernels.entries import intervals as interval_entries
from srs_ik.kernels.layout import collision as at
from srs_ik.kernels.layout.answer import MOST_INTERVALS, ROW, ROW_STATUS
from srs_ik.solve import pose as pose_solver
from srs_ik.solve.goals import Goal
from srs_ik.solve.intervals import IntervalsBatch
from srs_ik.solve.packed import pack_family
from srs_ik.solve.solution import BatchSolution, Collision, Interval, Solution, Solutions, Status
from srs_ik.solve.threads import run_in_threads

if TYPE_CHECKING:
    from srs_ik.collision.owner import BodyOwner
    from srs_ik.collision.tables import Tables
    from srs_ik.solve.packed import PackedArm

Array = NDArray[np.float64]


class Surroundings:
    """An arm in a scene, with the margin that is to be kept.

    Raises:
        InvalidScene: no `Scene`, or no margin.
        NoBodies: no shapes of the arm are at hand.
    """

    def __init__(self, arm: BodyOwner, packed: PackedArm, scene: Scene, margin: Any) -> None:
        if not isinstance(scene, Scene):
            raise InvalidScene(f"a scene is a srs_ik.Scene, not {type(scene).__name__}")
        self.arm = arm
        self.packed = packed
        self.scene = scene
        self.margin = scene.margin + as_margin(margin)
        self.tables: Tables = arm.tables(scene)
        self.slack = self.tables.with_margin(self.margin)
        self.tight, self.jammed = _tight_family(arm, packed, self.tables, self.margin)

    def feasible(self, T: Array, respect: bool) -> Array:
        """(n, 3) intervals of a pose that keep the limits, whatever they hit: branch, lower, upper.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
        """
        found = np.empty((MOST_INTERVALS, 3))
        count = interval_entries.intervals(self.packed.family, T, respect, *self.packed.work(), found)
        if count < 0:
            raise invalid_pose(-count)
        return found[:count]

    def in_range(self, T: Array, found: Array, respect: bool) -> Array:
        """(n, 3) intervals in which bodies two joints apart keep the margin; `found` are those that keep the limits."""
        family = self.tight[bool(respect)]
        if family is None:
            return found
        if self.jammed is not None or not len(found):
            return found[:0]
        rows = np.empty((MOST_INTERVALS, 3))
        return rows[: interval_entries.intervals(family, T, True, *self.packed.work(), rows)]

    def free(self, T: Array, found: Array, respect: bool) -> Array:
        """(n, 3) what bodies leave of the intervals of a pose that keep the limits."""
        if not self.scene.exact:
            found = self.in_range(T, found, respect)
        if not len(found):
            return found
        if self.scene.exact:
            from srs_ik.solve.certified import certified_free

            return certified_free(self, T, found)
        tables = self.tables
        out = np.empty((MOST_INTERVALS, 3))
        count = entries.free_intervals(
            self.packed.family,
            T,
            tables.bodies,
            tables.groups,
            tables.pairs,
            self.slack,
            *tables.work(),
            found,
            len(found),
            out,
        )
        return out[:count]

    def widest(self, T: Array, found: Array) -> Array:
        """(WIDE,) the arm angle of largest clearance over some intervals of a pose."""
        tables = self.tables
        out = np.empty(at.WIDE)
        entries.widest(
            self.packed.family,
            T,
            tables.bodies,
            tables.groups,
            tables.pairs,
            *tables.work(),
            found,
            len(found),
            out,
        )
        return out

    def clearance(self, T: Array, elbow: int, psi: float) -> Array:
        """(WIDE,) clearance at one arm angle of an elbow."""
        tables = self.tables
        out = np.empty(at.WIDE)
        entries.clearance(
            self.packed.family,
            T,
            tables.bodies,
            tables.groups,
            tables.pairs,
            *tables.work(),
            elbow,
            psi,
            out,
        )
        return out

    def intervals(self, pose: PoseLike, respect: bool) -> list[Interval]:
        """See `Arm.intervals`."""
        T = as_matrix(pose)
        rows = self.free(T, self.feasible(T, respect), respect)
        return [Interval(int(b), float(lower), float(upper)) for b, lower, upper in rows]

    def intervals_batch(self, poses: Any, respect: bool, threads: int | None) -> IntervalsBatch:
        """See `Arm.intervals_batch`."""
        T = as_matrices(poses)
        found: list[Array] = [np.empty((0, 3))] * len(T)

        def work(first: int, last: int) -> None:
            for i in range(first, last):
                found[i] = self.free(T[i], self.feasible(T[i], respect), respect).copy()

        run_in_threads(work, len(T), threads)
        offsets = np.cumsum([0, *(len(rows) for rows in found)])
        branch, lower, upper = np.concatenate([np.empty((0, 3)), *found]).T
        return IntervalsBatch(branch.astype(np.int64), lower.copy(), upper.copy(), offsets)

    def solve(
        self, pose: PoseLike, arm_angle: float | None, seed: ArrayLike | None, branch: int | None, respect: bool
    ) -> Solution:
        """See `Arm.solve`."""
        arm = self.packed
        near = None if seed is None else as_seed(seed, arm.lower, arm.upper)
        psi = None if arm_angle is None else as_arm_angle(arm_angle)
        return solve(self, as_matrix(pose), psi, near, -1 if branch is None else as_branch(branch), respect)

    def solve_all(self, pose: PoseLike, arm_angle: float | None, respect: bool) -> Solutions:
        """See `Arm.solve_all`."""
        return solve_all(self, as_matrix(pose), None if arm_angle is None else as_arm_angle(arm_angle), respect)

    def solve_batch(
        self,
        poses: Any,
        arm_angle: ArrayLike | None,
        seed: ArrayLike | None,
        branch: int | None,
        all_branches: bool,
        respect: bool,
        threads: int | None,
    ) -> BatchSolution:
        """See `Arm.solve_batch`."""
        arm, T = self.packed, as_matrices(poses)
        n = len(T)
        psis = None if arm_angle is None else per_pose(arm_angle, (), n, "arm_angle")
        seeds = None if seed is None else as_seeds(seed, n, arm.lower, arm.upper)
        chosen = as_branch(branch)
        if all_branches and psis is None:
            raise InvalidConfiguration("all_branches needs an arm_angle; without one, see solve_all and intervals")
        branches = range(8) if all_branches else (chosen,)
        rows = np.empty((n, len(branches), ROW))
        hits: dict[tuple[int, ...], Collision] = {}

        def work(first: int, last: int) -> None:
            for i in range(first, last):
                psi = None if psis is None else float(psis[i if len(psis) > 1 else 0])
                near = None if seeds is None else seeds[i if len(seeds) > 1 else 0]
                for k, b in enumerate(branches):
                    answer = solve(self, T[i], psi, near, b, respect)
                    rows[i, k] = answer._row
                    if answer.collision is not None:
                        hits[(i, k) if all_branches else (i,)] = answer.collision

        run_in_threads(work, n, threads)
        return BatchSolution(rows if all_branches else rows[:, 0], arm.joint_names, arm.elbow, hits)

    def jam(self, q: Array) -> Collision | None:
        """Which bodies two joints apart come too close at a posture, and how much is missing to the margin at least."""
        worst = None
        for each in self.tables.ranges:
            lower, upper = each.edges[0], each.edges[-1]
            angle = q[each.joint]
            if not lower <= angle <= upper:
                angle = (angle - lower) % (2.0 * np.pi) + lower
            k = min(int(np.searchsorted(each.edges, angle, side="right")) - 1, len(each.bounds) - 1)
            missing = self.margin - float(each.bounds[k])
            if worst is None or missing > worst.depth:
                names = self.tables.names
                worst = Collision(names[each.first], names[each.second], max(missing, 0.0))
        return worst

    def collision(self, wide: Array) -> Collision | None:
        """Who is nearest to whom at an arm angle, and how much is missing to the margin."""
        if wide[at.WIDE_FIRST] < 0:
            return None
        names = self.tables.names
        first, second = names[int(wide[at.WIDE_FIRST])], names[int(wide[at.WIDE_SECOND])]
        return Collision(first, second, max(self.margin - float(wide[at.WIDE_CLEARANCE]), 0.0))


def solve(
    around: Surroundings, T: Array, psi: float | None, near: Array | None, branch: int, respect: bool
) -> Solution:
    """The best posture that hits nothing, of one branch or of all (-1), at one arm angle or at all."""
    every = around.feasible(T, respect)
    found = _chosen(every, branch, psi)
    if not len(found):
        return pose_solver.solve(around.packed, T, psi, near, None if branch < 0 else branch, respect)
    free = _chosen(around.free(T, every, respect), branch, psi)
    solution = _best(around, T, free, psi, near, respect) if len(free) else None
    return solution or _hitting(around, T, found, psi, respect)


def _chosen(found: Array, branch: int, psi: float | None) -> Array:
    """Those of some intervals that are of a branch (-1: any), and hold an arm angle, if there is one."""
    if branch >= 0:
        found = found[found[:, 0] == branch]
    return found if psi is None else _at(found, psi)


def _at(found: Array, psi: float) -> Array:
    """Those of some intervals that an arm angle lies in, each narrowed to it."""
    turn = 2.0 * np.pi
    inside = (psi - found[:, 1]) % turn <= found[:, 2] - found[:, 1]
    narrowed = found[inside]
    narrowed[:, 1:] = psi
    return narrowed


def _best(
    around: Surroundings, T: Array, free: Array, psi: float | None, near: Array | None, respect: bool
) -> Solution | None:
    """The best posture in free intervals; None where none of them closes."""
    arm = around.packed
    if psi is not None:
        goal = Goal(arm, near)
        answers = (pose_solver.solve(arm, T, psi, near, int(row[0]), respect) for row in free)
        return goal.best(answer for answer in answers if answer)
    if not arm.closed:
        return Goal(arm, near).search(T, free, respect)
    row = np.empty(ROW)
    seed = np.zeros(7) if near is None else near
    entries.best_within(arm.family, T, free, len(free), -1, seed, near is not None, respect, row)
    solution = Solution(row, arm.joint_names, arm.elbow)
    return solution or None


def _hitting(around: Surroundings, T: Array, found: Array, psi: float | None, respect: bool) -> Solution:
    """The posture with the largest clearance of those that all hit something."""
    in_range = around.in_range(T, found, respect)
    if psi is not None:
        in_range = _at(in_range, psi)
    among = in_range if len(in_range) else found
    wide = around.widest(T, among) if psi is None else around.clearance(T, int(among[0, 0]) >> 2, psi)
    branch = int(wide[at.WIDE_BRANCH]) if psi is None else int(among[0, 0])
    solution = pose_solver.solve(around.packed, T, float(wide[at.WIDE_ARM_ANGLE]), None, branch, respect)
    solution._row[ROW_STATUS] = Status.COLLISION
    solution.collision = around.jam(solution.q) if not len(in_range) else around.collision(wide)
    return solution


def solve_all(around: Surroundings, T: Array, psi: float | None, respect: bool) -> Solutions:
    """One posture for every free interval, or those at an arm angle."""
    arm = around.packed
    free = _chosen(around.free(T, around.feasible(T, respect), respect), -1, psi)
    each = (_best(around, T, row[None], psi, None, respect) for row in free)
    rows = [answer._row for answer in each if answer is not None]
    if rows:
        return Solutions(np.array(rows), arm.joint_names, None, arm.elbow)
    failure = solve(around, T, psi, None, -1, respect)
    if failure:
        return Solutions.of_one(failure)
    return Solutions(np.empty((0, ROW)), arm.joint_names, failure, arm.elbow)


def _tight_family(
    arm: BodyOwner, packed: PackedArm, tables: Tables, margin: float
) -> tuple[tuple[Array | None, Array | None], Any]:
    """Packed limbs whose limits keep bodies two joints apart from each other: without and with the other limits.

    None where these need no limits. The second is what leaves no range at all.
    """
    if not tables.ranges:
        return (None, None), None
    known: dict[float, Any] = arm.__dict__.setdefault("_tight", {})
    if margin not in known:
        if len(known) >= _MARGINS:
            known.clear()
        families: list[Array | None] = []
        jammed = None
        for lower, upper in ((np.full(7, -np.inf), np.full(7, np.inf)), (packed.lower, packed.upper)):
            low, high, jammed = tightened(tables.ranges, margin, lower, upper)
            same = np.array_equal(low, lower) and np.array_equal(high, upper) and jammed is None
            families.append(None if same else pack_family(arm.limb, low, np.maximum(low, high)))
        known[margin] = tuple(families), jammed
    found: tuple[tuple[Array | None, Array | None], Any] = known[margin]
    return found


_MARGINS = 64
"""Most margins for which limits are kept."""
