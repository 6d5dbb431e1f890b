"""The best posture of those that hit nothing, for an objective: over free intervals of all branches."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.errors import InvalidTask
from srs_ik.solve import optimise as in_limits
from srs_ik.solve.goals import Search
from srs_ik.solve.in_scene.clearance import Clearance, widest
from srs_ik.solve.in_scene.pose import free_intervals, solve
from srs_ik.solve.in_scene.surroundings import narrowed
from srs_ik.solve.intervals import Interval
from srs_ik.solve.objectives import CLEARANCE, Objective, as_objective
from srs_ik.solve.optimise import Optimum
from srs_ik.solve.solution import Solution
from srs_ik.solve.turns import OverTurns
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.in_scene.surroundings import Surroundings
    from srs_ik.solve.packed import PackedArm


def optimise(
    around: Surroundings,
    T: Array,
    objective: str | Callable[[Array], float] | Objective,
    respect: bool,
    **parameters: Any,
) -> Optimum:
    """See `Arm.optimise`: the best within the limits where nothing hits it, else over what bodies leave, by samples."""
    if isinstance(objective, str) and objective == CLEARANCE:
        if parameters:
            raise InvalidTask(f"objective 'clearance' takes no parameter {next(iter(parameters))!r}")
        return _widest(around, T, around.all_free(T, respect), respect)
    free = free_intervals(around, T, respect)[0]
    objective = as_objective(objective, parameters)
    alone = in_limits.optimise(around.packed, around.arm, T, objective, respect)
    if alone and around.is_clear(alone.q):
        optimum = _optimum(alone, objective, objective.values(around.arm, alone.q), free, around.packed)
        if optimum.interval is None and not around.packed.closed:
            # Intervals of a near limb leave out what is not shown to be free.
            optimum.interval = Interval(alone.branch, alone.arm_angle, alone.arm_angle)
        if optimum.interval is not None:
            return optimum
    sign = -1.0 if objective.maximise else 1.0
    value = objective.evaluator(around.arm)
    cost = OverTurns(lambda q: sign * value(q), around.packed.lower, around.packed.upper, respect)
    found = Search(around.packed, cost, objective.parameters.get("reference")).over(T, free, respect)
    if objective.second >= 0 and found is not None:
        found = _second(around, T, free, respect, objective, sign * value(found.q)) or found
    if found is not None:
        found.q[:] = cost.turned(found.q)
    solution = found or solve(around, T, None, None, -1, respect)
    values = objective.values(around.arm, solution.q)
    return _optimum(solution, objective, values, free, around.packed)


def _second(
    around: Surroundings, T: Array, free: Array, respect: bool, objective: Objective, best: float
) -> Solution | None:
    """The best posture by the second objective of those whose first value is near enough to the best one."""
    sign = -1.0 if objective.maximise else 1.0
    worst = best + objective.tolerance * abs(best)

    def cost(q: Array) -> float:
        first, second = objective.values(around.arm, q)
        # Of the other sense, always.
        return -sign * second if sign * first <= worst else TOO_BAD

    found = Search(around.packed, cost).over(T, free, respect)
    return found if found is not None and cost(found.q) < TOO_BAD else None


TOO_BAD = 1e5
"""Cost of a posture whose first value is not near enough to the best one."""


def _widest(around: Surroundings, T: Array, free: Array, respect: bool) -> Optimum:
    """The posture of largest clearance, on an exact limb within a micrometre; see `Clearance`."""
    clearance = Clearance(around)
    goal = Objective(clearance, maximise=True)
    goal.unit = "m"
    solution = widest(clearance, T, free, respect) or solve(around, T, None, None, -1, respect)
    return _optimum(solution, goal, goal.values(around.arm, solution.q), free, around.packed)


def _optimum(solution: Solution, objective: Objective, values: Sequence[float], free: Array, arm: PackedArm) -> Optimum:
    """A posture as an optimum, with the free interval that it lies in."""
    interval = None
    if solution:
        own = free[free[:, 0] == solution.branch]
        inside = narrowed(np.column_stack([own[:, 0], own[:, 1] - 1e-9, own[:, 2] + 1e-9]), solution.arm_angle)
        if len(inside):
            k = int(np.argmax((solution.arm_angle - own[:, 1] + 1e-9) % (2 * np.pi) <= own[:, 2] - own[:, 1] + 2e-9))
            interval = Interval(int(own[k, 0]), float(own[k, 1]), float(own[k, 2]))
    optimum = Optimum(solution._row, arm.joint_names, objective, values, interval, solution._elbow)
    optimum.collision = solution.collision
    return optimum
