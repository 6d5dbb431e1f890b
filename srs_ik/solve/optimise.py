"""The best posture of all that reach a pose: global over branches and arm angles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from srs_ik.errors import InvalidTask
from srs_ik.inputs.poses import PoseLike, as_matrix, invalid_pose
from srs_ik.kernels.algebra import minimum as line
from srs_ik.kernels.curves.runs import MAX_RUNS, RUN
from srs_ik.kernels.entries import optimum as kernel
from srs_ik.kernels.layout import IS_CLOSED, LIMITED, ROW, ROW_BRANCH
from srs_ik.kernels.optimum import objectives as kinds
from srs_ik.kernels.optimum.search import BRACKET, REFUSED
from srs_ik.solve.objectives import Objective
from srs_ik.solve.solution import ElbowRange, Interval, Solution

if TYPE_CHECKING:
    from srs_ik.arm import Arm

Array = NDArray[np.float64]


_ROUNDING = 1e-9
"""A posture this near to the end of an interval, rad, is on it."""


class Optimum(Solution):
    """The best posture for an objective.

    A `Solution`, and with it:

    Attributes:
        objective: the `Objective`.
        value: its value at `q`, in its own sign and unit; in every status.
        second_value: value of the second objective of a lexicographic one, else None.
        interval: the feasible `Interval` of arm angles in which the posture lies; None where there is no solution.
    """

    __slots__ = ("interval", "objective", "second_value", "value")

    def __init__(
        self,
        row: Array,
        joint_names: Sequence[str],
        objective: Objective,
        values: Sequence[float],
        interval: Interval | None,
        elbow: ElbowRange | None = None,
    ) -> None:
        super().__init__(row, joint_names, elbow)
        self.objective = objective
        self.value = float(values[0])
        self.second_value = float(values[1]) if len(values) > 1 else None
        self.interval = interval

    def __repr__(self) -> str:
        return f"Optimum({self.objective.name}={self.value:.6g}, {super().__repr__()})"


def optimise(
    arm: Arm,
    pose: PoseLike,
    objective: str | Callable[[Array], float] | Objective,
    respect_limits: bool = True,
    **parameters: Any,
) -> Optimum:
    """See `Arm.optimise`."""
    if not isinstance(objective, Objective):
        objective = Objective(objective, **parameters)
    elif parameters:
        raise InvalidTask(
            f"an Objective has its parameters already; {next(iter(parameters))!r} belongs to its constructor"
        )
    T = as_matrix(pose)
    respect_limits = bool(respect_limits)
    if objective.kind is None:
        return _by_function(arm, T, objective, respect_limits)
    if objective.kind in (kinds.LIMIT_MARGIN, kinds.REFERENCE) and arm._family[LIMITED, IS_CLOSED]:
        # What `solve` is made for, on an exact limb.
        seed = objective.parameters.get("reference")
        return _judged(arm, arm.solve(T, seed=seed, respect_limits=respect_limits), T, objective, respect_limits)
    return _by_kernel(arm, T, objective, respect_limits)


def _judged(arm: Arm, solution: Solution, T: Array, objective: Objective, respect_limits: bool) -> Optimum:
    """A posture that `Arm.solve` gives, as an optimum."""
    interval = _interval_around(arm, T, solution, respect_limits) if solution else None
    values = objective.values(arm, solution.q)
    return Optimum(solution._row, arm.joint_names, objective, values, interval, arm._elbow)


def _interval_around(arm: Arm, T: Array, solution: Solution, respect_limits: bool) -> Interval:
    """The feasible interval with a solution in it, or at the rounding of its ends; a point where there is none."""
    psi = solution.arm_angle
    for interval in arm.intervals(T, respect_limits):
        if interval.branch == solution.branch:
            off = abs(np.remainder(psi - 0.5 * (interval.lower + interval.upper) + np.pi, 2.0 * np.pi) - np.pi)
            if off <= 0.5 * interval.width + _ROUNDING:
                return interval
    return Interval(solution.branch, psi, psi)


def _by_kernel(arm: Arm, T: Array, objective: Objective, respect_limits: bool) -> Optimum:
    """The optimum of an objective that kernels compute."""
    row, out = np.empty(ROW), np.empty(kernel.OUT)
    found = kernel.optimise(
        arm._family,
        T,
        objective.kind,
        objective.second,
        objective.tolerance,
        line.SHARP if objective.kind == kinds.LIMIT_MARGIN else line.SMOOTH,
        objective.packed(arm, respect_limits),
        respect_limits,
        row,
        out,
    )
    if found < 0:
        raise invalid_pose(-found)
    if found == kernel.NO_POSTURE:
        return _judged(arm, arm.solve(T, respect_limits=respect_limits), T, objective, respect_limits)
    sign = -1.0 if objective.maximise else 1.0
    values = [sign * out[kernel.OUT_VALUE]]
    if objective.second >= 0:  # of the other sense, always
        values.append(-sign * out[kernel.OUT_SECOND])
    interval = Interval(int(row[ROW_BRANCH]), float(out[kernel.OUT_LOWER]), float(out[kernel.OUT_UPPER]))
    return Optimum(row, arm.joint_names, objective, values, interval)


def _by_function(arm: Arm, T: Array, objective: Objective, respect_limits: bool) -> Optimum:
    """The optimum of an objective that is a Python function, by the same search."""
    evaluate = objective.evaluator(arm)
    sign = -1.0 if objective.maximise else 1.0
    runs = np.empty((MAX_RUNS, RUN))
    rows, k, verdict = kernel.sample(arm._family, T, respect_limits, runs)
    if verdict:
        raise invalid_pose(verdict)
    values = np.array([sign * evaluate(row[1:]) for row in rows])
    brackets = np.empty((kernel.MAX_BRACKETS, BRACKET))
    count = kernel.brackets(rows, values, runs, k, brackets)

    best, best_run = REFUSED, -1
    state, row, best_row = np.empty(line.STATE), np.empty(ROW), np.empty(ROW)
    for bracket in brackets[:count]:
        if bracket[7] >= best:
            continue
        run = int(bracket[1])
        kernel.begin(state, bracket, line.SHARP if objective.function else line.SMOOTH)
        while True:
            x, wanted = kernel.next_point(state)
            if not wanted:
                break
            value = REFUSED
            if kernel.posture(arm._family, T, rows, runs[run], x, respect_limits, row):
                value = sign * evaluate(row[:7])
            kernel.answer(state, value)
        if state[line.F_BEST] >= best:
            continue
        if kernel.posture(arm._family, T, rows, runs[run], state[line.BEST], respect_limits, row):
            best, best_run = float(state[line.F_BEST]), run
            best_row[:] = row
    if best_run < 0:
        return _judged(arm, arm.solve(T, respect_limits=respect_limits), T, objective, respect_limits)
    lower, upper = kernel.interval(arm._family, T, rows, runs[best_run])
    interval = Interval(int(best_row[ROW_BRANCH]), float(lower), float(upper))
    return Optimum(best_row, arm.joint_names, objective, [sign * best], interval)
