"""The best posture of all that reach a pose: global over branches and arm angles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.inputs.poses import PoseLike, as_matrix, invalid_pose
from srs_ik.kernels.entries import optimum as entries
from srs_ik.kernels.layout import objectives as kinds
from srs_ik.kernels.layout import search as at
from srs_ik.kernels.layout.answer import ROW, ROW_ARM_ANGLE, ROW_BRANCH
from srs_ik.solve import intervals as feasible
from srs_ik.solve.intervals import Interval
from srs_ik.solve.objectives import Objective, as_objective
from srs_ik.solve.pose import solve
from srs_ik.solve.solution import ElbowRange, Solution
from srs_ik.solve.turns import OverTurns
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.kinematics import ChainKinematics
    from srs_ik.solve.packed import PackedArm


_ROUNDING = 1e-9
"""A posture this near to the end of an interval, rad, is on it."""

_USUAL_ROWS = 4096
"""Room for the samples of a pose; the few that have more are sampled again."""


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
    arm: PackedArm,
    chain: ChainKinematics,
    pose: PoseLike,
    objective: str | Callable[[Array], float] | Objective,
    respect_limits: bool = True,
    **parameters: Any,
) -> Optimum:
    """See `Arm.optimise`; `chain` is the arm as Pinocchio computes it, for what no kernel does."""
    objective, T = as_objective(objective, parameters), as_matrix(pose)
    respect_limits = bool(respect_limits)
    if objective.kind is None:
        return _by_function(arm, chain, T, objective, respect_limits)
    if objective.kind not in (kinds.LIMIT_MARGIN, kinds.REFERENCE):
        return _by_kernel(arm, chain, T, objective, respect_limits)
    # What `solve` is made for: alone on an exact limb. On a near one each may find what the other does not.
    seed = objective.parameters.get("reference")
    solution = solve(arm, T, seed=seed, respect_limits=respect_limits)
    if solution and not arm.closed:
        optimum = _by_kernel(arm, chain, T, objective, respect_limits)
        sign = -1.0 if objective.maximise else 1.0
        if optimum and sign * optimum.value <= sign * objective.values(chain, solution.q)[0]:
            return optimum
    return _judged(arm, chain, solution, T, objective, respect_limits)


def _judged(
    arm: PackedArm, chain: ChainKinematics, solution: Solution, T: Array, objective: Objective, respect_limits: bool
) -> Optimum:
    """A posture that `solve` gives, as an optimum."""
    interval = _interval_around(arm, T, solution, respect_limits) if solution else None
    values = objective.values(chain, solution.q)
    return Optimum(solution._row, arm.joint_names, objective, values, interval, arm.elbow)


def _interval_around(arm: PackedArm, T: Array, solution: Solution, respect_limits: bool) -> Interval:
    """The feasible interval with a solution in it, or at the rounding of its ends; a point where there is none."""
    psi = solution.arm_angle
    for interval in feasible.intervals(arm, T, respect_limits):
        if interval.branch == solution.branch:
            off = abs(np.remainder(psi - 0.5 * (interval.lower + interval.upper) + np.pi, 2.0 * np.pi) - np.pi)
            if off <= 0.5 * interval.width + _ROUNDING:
                return interval
    return Interval(solution.branch, psi, psi)


def _by_kernel(arm: PackedArm, chain: ChainKinematics, T: Array, objective: Objective, respect_limits: bool) -> Optimum:
    """The optimum of an objective that kernels compute."""
    row, out = np.empty(ROW), np.empty(at.OUT)
    found = entries.optimise(
        arm.family,
        T,
        objective.kind,
        objective.second,
        objective.tolerance,
        at.SHARP if objective.kind == kinds.LIMIT_MARGIN else at.SMOOTH,
        objective.packed(chain, arm.weights, respect_limits),
        respect_limits,
        row,
        out,
    )
    if found < 0:
        raise invalid_pose(-found)
    if found == at.NO_POSTURE:
        return _judged(arm, chain, solve(arm, T, respect_limits=respect_limits), T, objective, respect_limits)
    sign = -1.0 if objective.maximise else 1.0
    values = [sign * out[at.OUT_VALUE]]
    if objective.second >= 0:  # of the other sense, always
        values.append(-sign * out[at.OUT_SECOND])
    interval = Interval(int(row[ROW_BRANCH]), float(out[at.OUT_LOWER]), float(out[at.OUT_UPPER]))
    return Optimum(row, arm.joint_names, objective, values, interval)


def _by_function(
    arm: PackedArm, chain: ChainKinematics, T: Array, objective: Objective, respect_limits: bool
) -> Optimum:
    """The optimum of an objective that is a Python function, by the same search."""
    evaluate, sign = objective.evaluator(chain), -1.0 if objective.maximise else 1.0
    cost = OverTurns(lambda q: sign * evaluate(q), arm.lower, arm.upper, respect_limits)
    search = _Runs(arm, T, cost, at.SHARP if objective.function else at.SMOOTH, respect_limits)
    rows, k = search.sampled()
    best, run, best_row = search.least(rows, k, at.REFUSED)
    if run < 0:
        return _judged(arm, chain, solve(arm, T, respect_limits=respect_limits), T, objective, respect_limits)
    lower, upper = entries.interval(arm.family, T, rows, search.runs[run])
    for _ in range(at.ROUNDS):
        # On a surface, lines lead on from its best posture.
        rows, k = search.starred(best_row[:7].copy())
        if len(rows):
            lower = upper = best_row[ROW_ARM_ANGLE]
        value, run, row = search.least(rows, k, best - at.TIE * abs(best))
        if run < 0:
            break
        best, best_row = value, row
        lower = upper = best_row[ROW_ARM_ANGLE]
    interval = Interval(int(best_row[ROW_BRANCH]), float(lower), float(upper))
    best_row[:7] = cost.turned(best_row[:7])
    return Optimum(best_row, arm.joint_names, objective, [sign * best], interval)


class _Runs:
    """Runs of postures of a pose, sampled by kernels and searched for the least of a cost that Python computes.

    Attributes:
        runs: (MOST_RUNS, RUN) the runs that were sampled last.
    """

    def __init__(
        self, arm: PackedArm, T: Array, cost: Callable[[Array], float], kind: float, respect_limits: bool
    ) -> None:
        self._family, self._T, self._cost, self._kind, self._respect = arm.family, T, cost, kind, respect_limits
        self.runs = np.empty((at.MOST_RUNS, at.RUN))

    def sampled(self) -> tuple[Array, int]:
        """(n, SAMPLE) samples of all postures of the pose, and how many runs they are of.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
        """
        rows = np.empty((_USUAL_ROWS, entries.SAMPLE))
        n, k, verdict = entries.sample(self._family, self._T, self._respect, self.runs, rows)
        if verdict:
            raise invalid_pose(verdict)
        if n > len(rows):
            rows = np.empty((n, entries.SAMPLE))
            entries.sample(self._family, self._T, self._respect, self.runs, rows)
        return rows[:n], k

    def starred(self, q: Array) -> tuple[Array, int]:
        """The same of lines through a posture (7,) in all directions in which its pose leaves it free."""
        rows = np.empty((entries.SPARE_ROWS, entries.SAMPLE))
        n, k = entries.star(self._family, self._T, q, self._respect, self.runs, rows)
        return rows[:n], k

    def least(self, rows: Array, k: int, best: float) -> tuple[float, int, Array]:
        """Cost, run and row of the best posture of some runs; run -1 where none is below `best`."""
        values = np.array([self._cost(row[1 : entries.SAMPLE_WAY]) for row in rows])
        brackets = np.empty((at.MAX_BRACKETS, at.BRACKET))
        count = entries.brackets(rows, values, self.runs, k, brackets)
        best_run = -1
        state, row, best_row = np.empty(at.STATE), np.empty(ROW), np.empty(ROW)
        for bracket in brackets[:count]:
            if bracket[7] >= best:
                continue
            run = int(bracket[1])
            self._close_in(rows, bracket, state, row)
            if state[at.F_BEST] >= best:
                continue
            if self._posture(rows, run, state[at.BEST], row):
                best, best_run = float(state[at.F_BEST]), run
                best_row[:] = row
        return best, best_run, best_row

    def _close_in(self, rows: Array, bracket: Array, state: Array, row: Array) -> None:
        """Search between the ends of a bracket; `state` says what the best is, and where."""
        entries.begin(state, bracket, self._kind)
        while True:
            x, wanted = entries.next_point(state)
            if not wanted:
                return
            met = self._posture(rows, int(bracket[1]), x, row)
            entries.answer(state, self._cost(row[:7]) if met else at.REFUSED)

    def _posture(self, rows: Array, run: int, x: float, row: Array) -> bool:
        """Write the posture of a run at a place into a row; whether there is one."""
        return bool(entries.posture(self._family, self._T, rows, self.runs[run], x, self._respect, row))
