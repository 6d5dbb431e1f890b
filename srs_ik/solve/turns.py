"""Turns of joints whose limits are more than a turn apart: poses leave them open, functions of joint angles do not."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from srs_ik.system.arrays import Array

TURN = 2.0 * math.pi

MOST_TURNS = 16
"""A joint with more turns between its limits is as one without end."""


class OverTurns:
    """A cost of postures, lower is better, as the least in all turns that their joints have between limits (7,), rad.

    Joints are turned one after another, until that makes nothing less. Joints without end, or with more turns than
    `MOST_TURNS`, stay as they are, and so do all where limits do not count.
    """

    def __init__(self, cost: Callable[[Array], float], lower: Array, upper: Array, respect: bool) -> None:
        self._cost = cost
        self._lower, self._upper = lower, upper
        wide = (upper - lower >= TURN) & (upper - lower <= MOST_TURNS * TURN)
        self._wide = np.flatnonzero(wide).tolist() if respect else []

    def __call__(self, q: Array) -> float:
        """The least cost of a posture (7,), rad."""
        return self._least(q)[0]

    def turned(self, q: Array) -> Array:
        """(7,) the posture in the turns of the least cost, rad."""
        return self._least(q)[1]

    def _least(self, q: Array) -> tuple[float, Array]:
        best, least = q, self._cost(q)
        better = True
        while better:
            better = False
            for joint in self._wide:
                for angle in self._turns_of(joint, float(best[joint])):
                    other = best.copy()
                    other[joint] = angle
                    cost = self._cost(other)
                    if cost < least:
                        best, least, better = other, cost, True
        return least, best

    def _turns_of(self, joint: int, angle: float) -> list[float]:
        """An angle in all other turns between the limits of its joint."""
        lower, upper = float(self._lower[joint]), float(self._upper[joint])
        first, last = math.floor((lower - angle) / TURN), math.ceil((upper - angle) / TURN)
        others = [angle + k * TURN for k in range(first, last + 1) if k]
        return [other for other in others if lower <= other <= upper]
