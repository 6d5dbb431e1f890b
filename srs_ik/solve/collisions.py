"""Postures that hit nothing: the intervals that bodies leave, and the best posture in them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from srs_ik.collision.ranges import JointRange, tightened
from srs_ik.collision.scene import Scene, as_margin
from srs_ik.errors import InvalidConfiguration, InvalidScene, InvalidTask
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
from srs_ik.solve.goals import Search, goal_of
from srs_ik.solve.intervals import IntervalsBatch
from srs_ik.solve.objectives import Objective
from srs_ik.solve.optimise import Optimum
from srs_ik.solve.packed import pack_family
from srs_ik.solve.solution import BatchSolution, Collision, Interval, Solution, Solutions, Status
from srs_ik.solve.threads import run_in_threads

if TYPE_CHECKING:
    from srs_ik.collision.owner import BodyOwner
    from srs_ik.collision.real import RealWorld
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
        self.tight, self.jammed = _tight_family(arm, packed, self.tables)

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
        """(n, 3) intervals in which bodies two joints apart do not meet; `found` are those that keep the limits."""
        family = self.tight[bool(respect)]
        if family is None:
            return found
        if self.jammed is not None or not len(found):
            return found[:0]
        rows = np.empty((MOST_INTERVALS, 3))
        return rows[: interval_entries.intervals(family, T, True, *self.packed.work(), rows)]

    def free(self, T: Array, found: Array, respect: bool) -> Array:
        """(n, 3) what bodies leave of the intervals of a pose that keep the limits."""
        return self.free_and_undecided(T, found, respect)[0]

    def all_free(self, T: Array, respect: bool) -> Array:
        """(n, 3) all free intervals of a pose.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
        """
        family = self.tight[respect]
        if family is None or self.jammed is not None or (self.scene.exact and self.packed.closed):
            return self.free(T, self.feasible(T, respect), respect)
        rows = np.empty((MOST_INTERVALS, 3))
        count = interval_entries.intervals(family, T, True, *self.packed.work(), rows)
        if count < 0:
            raise invalid_pose(-count)
        return self.by_spheres(T, rows[:count])

    def free_and_undecided(self, T: Array, found: Array, respect: bool) -> tuple[Array, float]:
        """The same, and the width of what is counted as forbidden without having been decided, rad."""
        if self.scene.exact and self.packed.closed and len(found):
            from srs_ik.solve.certified import certified_free

            return certified_free(self, T, found, respect)
        return self.by_spheres(T, self.in_range(T, found, respect)), 0.0

    def by_spheres(self, T: Array, found: Array) -> Array:
        """(n, 3) what the spheres leave of some intervals."""
        return self._cut(T, found, self.tables.pairs)

    def clear_of_formless(self, T: Array, found: Array) -> Array:
        """(n, 3) what clouds and half-spaces leave of some intervals."""
        return self._cut(T, found, self.tables.formless)

    def _cut(self, T: Array, found: Array, pairs: NDArray[np.int64]) -> Array:
        if not (len(found) and len(pairs)):
            return found
        tables = self.tables
        out = np.empty((MOST_INTERVALS, 3))
        count = entries.free_intervals(
            self.packed.family,
            T,
            tables.bodies,
            tables.groups,
            pairs,
            self.slack,
            *tables.work(),
            found,
            len(found),
            out,
        )
        return out[:count]

    def real_world(self) -> RealWorld:
        """The real forms, for coal."""
        from srs_ik.collision.real import RealWorld

        state = self.arm.__dict__
        world: RealWorld | None = state.get("_real_world")
        now = self.scene.version, self.scene.moves
        if world is None or world.scene is not self.scene or world.version != now:
            world = state["_real_world"] = RealWorld(self.arm, self.scene)
        return world

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
        rows = self.all_free(T, respect)
        return [Interval(int(b), float(lower), float(upper)) for b, lower, upper in rows]

    def intervals_batch(self, poses: Any, respect: bool, threads: int | None) -> IntervalsBatch:
        """See `Arm.intervals_batch`."""
        T = as_matrices(poses)
        found: list[Array] = [np.empty((0, 3))] * len(T)

        def work(first: int, last: int) -> None:
            for i in range(first, last):
                found[i] = self.all_free(T[i], respect).copy()

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
        """Which bodies two joints apart meet at a posture, and how deep by the bound on their distance."""
        worst = None
        for each in self.tables.ranges:
            lower, upper = each.edges[0], each.edges[-1]
            angle = q[each.joint]
            if not lower <= angle <= upper:
                angle = (angle - lower) % (2.0 * np.pi) + lower
            k = min(int(np.searchsorted(each.edges, angle, side="right")) - 1, len(each.bounds) - 1)
            # Of a pair that is proved apart elsewhere, no depth is known.
            missing = -max(float(each.bounds[k]), -1.0)
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
    free = _chosen(around.all_free(T, respect), branch, psi)
    solution = _best(around, T, free, psi, near, respect) if len(free) else None
    if solution is not None:
        return solution
    found = _chosen(around.feasible(T, respect), branch, psi)
    if not len(found):
        return pose_solver.solve(around.packed, T, psi, near, None if branch < 0 else branch, respect)
    return _hitting(around, T, found, psi, respect)


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
        goal = goal_of(arm, near)
        answers = (pose_solver.solve(arm, T, psi, near, int(row[0]), respect) for row in free)
        return goal.best(answer for answer in answers if answer)
    if not arm.closed:
        return goal_of(arm, near).over(T, free, respect)
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
    free = _chosen(around.all_free(T, respect), -1, psi)
    each = (_best(around, T, row[None], psi, None, respect) for row in free)
    rows = [answer._row for answer in each if answer is not None]
    if rows:
        return Solutions(np.array(rows), arm.joint_names, None, arm.elbow)
    failure = solve(around, T, psi, None, -1, respect)
    if failure:
        return Solutions.of_one(failure)
    return Solutions(np.empty((0, ROW)), arm.joint_names, failure, arm.elbow)


def optimise(
    around: Surroundings,
    pose: PoseLike,
    objective: str | Callable[[Array], float] | Objective,
    respect: bool,
    **parameters: Any,
) -> Optimum:
    """See `Arm.optimise`: over what bodies leave, by samples and by closing in on the best; `clearance` certainly."""
    T = as_matrix(pose)
    free = around.all_free(T, respect)
    if isinstance(objective, str) and objective == CLEARANCE:
        if parameters:
            raise InvalidTask(f"objective 'clearance' takes no parameter {next(iter(parameters))!r}")
        return _widest(around, T, free, respect)
    if not isinstance(objective, Objective):
        objective = Objective(objective, **parameters)
    elif parameters:
        raise InvalidTask(
            f"an Objective has its parameters already; {next(iter(parameters))!r} belongs to its constructor"
        )
    if objective.second >= 0:
        raise InvalidTask(f"objective {objective.name!r}, one after another, is not known beside a scene")
    sign = -1.0 if objective.maximise else 1.0
    value = objective.evaluator(around.arm)
    found = Search(around.packed, lambda q: sign * value(q)).over(T, free, respect)
    solution = found or solve(around, T, None, None, -1, respect)
    values = objective.values(around.arm, solution.q)
    return _optimum(solution, objective, values, free, around.packed)


CLEARANCE = "clearance"


def _widest(around: Surroundings, T: Array, free: Array, respect: bool) -> Optimum:
    """The posture of largest clearance, within a micrometre, by the spheres."""

    def clearance(q: Array) -> float:
        elbow, psi = around.arm.branch(q) >> 2, around.arm.arm_angle(q)  # type: ignore[attr-defined]
        return float(around.clearance(T, elbow, psi)[at.WIDE_CLEARANCE])

    goal = Objective(clearance, maximise=True)
    if not len(free):
        solution = solve(around, T, None, None, -1, respect)
        return Optimum(solution._row, around.packed.joint_names, goal, [clearance(solution.q)], None)
    wide = around.widest(T, free)
    branch = int(wide[at.WIDE_BRANCH])
    solution = pose_solver.solve(around.packed, T, float(wide[at.WIDE_ARM_ANGLE]), None, branch, respect)
    return _optimum(solution, goal, [float(wide[at.WIDE_CLEARANCE])], free, around.packed)


def _optimum(solution: Solution, objective: Objective, values: Sequence[float], free: Array, arm: PackedArm) -> Optimum:
    """A posture as an optimum, with the free interval that it lies in."""
    interval = None
    if solution:
        own = free[free[:, 0] == solution.branch]
        inside = _at(np.column_stack([own[:, 0], own[:, 1] - 1e-9, own[:, 2] + 1e-9]), solution.arm_angle)
        if len(inside):
            k = int(np.argmax((solution.arm_angle - own[:, 1] + 1e-9) % (2 * np.pi) <= own[:, 2] - own[:, 1] + 2e-9))
            interval = Interval(int(own[k, 0]), float(own[k, 1]), float(own[k, 2]))
    optimum = Optimum(solution._row, arm.joint_names, objective, values, interval, solution._elbow)
    optimum.collision = solution.collision
    return optimum


def _tight_family(
    arm: BodyOwner, packed: PackedArm, tables: Tables
) -> tuple[tuple[Array | None, Array | None], JointRange | None]:
    """Packed limbs whose limits keep bodies two joints apart from each other: without and with the other limits.

    None where these need no limits. The second is what leaves no range at all.
    """
    if not tables.ranges:
        return (None, None), None
    known: dict[str, Any] = arm.__dict__
    if "_tight" not in known:
        families: list[Array | None] = []
        jammed = None
        for lower, upper in ((np.full(7, -np.inf), np.full(7, np.inf)), (packed.lower, packed.upper)):
            low, high, jammed = tightened(tables.ranges, lower, upper)
            same = np.array_equal(low, lower) and np.array_equal(high, upper) and jammed is None
            families.append(None if same else pack_family(arm.limb, low, np.maximum(low, high)))
        known["_tight"] = (families[0], families[1]), jammed
    found: tuple[tuple[Array | None, Array | None], JointRange | None] = known["_tight"]
    return found
