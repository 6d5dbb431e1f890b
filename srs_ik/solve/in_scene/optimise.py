"""The best posture of those that hit nothing, for an objective: over free intervals of all branches."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.errors import InvalidTask
from srs_ik.kernels.layout import collision as at
from srs_ik.solve import pose as pose_solver
from srs_ik.solve.goals import Search
from srs_ik.solve.in_scene.pose import free_intervals, solve
from srs_ik.solve.in_scene.surroundings import narrowed
from srs_ik.solve.objectives import CLEARANCE, Objective
from srs_ik.solve.optimise import Optimum
from srs_ik.solve.solution import Interval, Solution
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
    """See `Arm.optimise`: over what bodies leave, by samples and by closing in on the best; `clearance` certainly."""
    if isinstance(objective, str) and objective == CLEARANCE:
        if parameters:
            raise InvalidTask(f"objective 'clearance' takes no parameter {next(iter(parameters))!r}")
        return _widest(around, T, around.all_free(T, respect), respect)
    free = free_intervals(around, T, respect)[0]
    if not isinstance(objective, Objective):
        objective = Objective(objective, **parameters)
    elif parameters:
        raise InvalidTask(
            f"an Objective has its parameters already; {next(iter(parameters))!r} belongs to its constructor"
        )
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


class Clearance:
    """Least distance, m, of what an arm must not let meet, by the spheres: a function of joint angles."""

    __name__ = CLEARANCE

    def __init__(self, around: Surroundings) -> None:
        self._around = around

    def __call__(self, q: Array) -> float:
        """Clearance at (7,) joint angles, rad."""
        arm = self._around.arm
        elbow, psi = arm.branch(q) >> 2, arm.arm_angle(q)  # type: ignore[attr-defined]
        return float(self._around.clearance(arm.forward_kinematics(q).homogeneous, elbow, psi)[at.WIDE_CLEARANCE])


def _widest(around: Surroundings, T: Array, free: Array, respect: bool) -> Optimum:
    """The posture of largest clearance, within a micrometre, by the spheres."""
    goal = Objective(Clearance(around), maximise=True)
    goal.unit = "m"
    if not len(free):
        solution = solve(around, T, None, None, -1, respect)
        return _optimum(solution, goal, goal.values(around.arm, solution.q), free, around.packed)
    wide = around.widest(T, free)
    branch = int(wide[at.WIDE_BRANCH])
    solution = pose_solver.solve(around.packed, T, float(wide[at.WIDE_ARM_ANGLE]), None, branch, respect)
    return _optimum(solution, goal, [float(wide[at.WIDE_CLEARANCE])], free, around.packed)


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
