"""What is better, of postures at known arm angles: for limbs on which no kernel searches in given intervals."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import minimize_scalar

from srs_ik.kernels.layout.limb import SMALLEST_RANGE
from srs_ik.solve import pose as pose_solver
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.packed import PackedArm
    from srs_ik.solve.solution import Solution

_WIDEST = 0.1
"""Arm angles of the first look at an interval are this far apart at most, rad."""

INSIDE = 1e-9
"""An arm angle this far inside the ends of its interval, rad, is safe from their rounding."""

_WORST = 1e6
"""Cost of an arm angle at which no posture is found."""


class Search:
    """The best posture over intervals of arm angles, by samples, and by closing in on the best of them.

    The cost is of seven joint angles, lower is better; joints come back in the turns of a seed, if there is one.
    """

    def __init__(self, arm: PackedArm, cost: Callable[[Array], float], seed: Array | None = None) -> None:
        self._arm = arm
        self.cost = cost
        self._seed = seed

    def best(self, answers: Iterable[Solution]) -> Solution | None:
        """The best of some postures; None where there is none."""
        return min(answers, key=lambda answer: self.cost(answer.q), default=None)

    def over(self, T: Array, free: Array, respect: bool) -> Solution | None:
        """The best posture found over intervals (n, 3) of a pose; None where none closes."""
        best: Solution | None = None
        lowest = _WORST
        for branch, lower, upper in free:
            room = min(INSIDE, 0.25 * (upper - lower))
            count = 2 + int((upper - lower) / _WIDEST)
            angles = np.linspace(lower + room, upper - room, count)
            answers: list[Solution | None] = []
            for psi in angles:
                answers.append(self._at(T, float(psi), int(branch), respect, answers[-1] if answers else None))
            costs = [_WORST if answer is None else self.cost(answer.q) for answer in answers]
            k = int(np.argmin(costs))
            if costs[k] < lowest:
                best, lowest = answers[k], costs[k]
            ends = float(angles[max(k - 1, 0)]), float(angles[min(k + 1, count - 1)])
            if costs[k] < _WORST and ends[0] < ends[1]:
                closer = self._close_in(T, ends, int(branch), respect, answers[k])
                if closer is not None and self.cost(closer.q) < lowest:
                    best, lowest = closer, self.cost(closer.q)
        return best

    def _at(self, T: Array, psi: float, branch: int, respect: bool, before: Solution | None) -> Solution | None:
        """The posture at an arm angle; one before it on its curve leads to it sooner."""
        if before is not None and not self._arm.closed:
            answer = pose_solver.lead(self._arm, T, psi, branch, before.q, self._seed, respect)
            if answer is not None:
                return answer
        return pose_solver.solve(self._arm, T, psi, self._seed, branch, respect) or None

    def _close_in(
        self, T: Array, ends: tuple[float, float], branch: int, respect: bool, before: Solution | None
    ) -> Solution | None:
        latest = before

        def cost(psi: float) -> float:
            nonlocal latest
            answer = self._at(T, psi, branch, respect, latest)
            if answer is None:
                return _WORST
            latest = answer
            return self.cost(answer.q)

        found = minimize_scalar(cost, bounds=ends, method="bounded", options={"xatol": 1e-9})
        return self._at(T, float(found.x), branch, respect, latest)


def goal_of(arm: PackedArm, seed: Array | None) -> Search:
    """The search that `solve` stands for: nearest to a seed, or farthest from the limits."""
    if seed is not None:
        return Search(arm, lambda q: float(np.sum((q - seed) ** 2)), seed)
    limited = np.isfinite(arm.lower) & np.isfinite(arm.upper)
    middle = 0.5 * (arm.lower[limited] + arm.upper[limited])
    half = 0.5 * np.maximum(arm.upper[limited] - arm.lower[limited], SMALLEST_RANGE)
    return Search(arm, lambda q: float(np.max(np.abs(q[limited] - middle) / half, initial=0.0)) - 1.0)
