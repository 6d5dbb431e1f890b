"""Bodies two joints apart: how near they come, told by the joint between them alone, on the real shapes.

How the second of these bodies lies to the first depends on two joint angles. For each small range of the first one, the
least distance over all angles of the second is bounded from below: by distances in the middle of ranges, less how far
any point can move within. So such a pair is watched by a range of one joint, with which limits are found as ever, and
not by spheres.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

Array = NDArray[np.float64]

BOXES = 128
"""Ranges of the first joint, each with a bound of its own."""

_LOOSE = 0.002
"""The least distance is found to this, m."""

_TRIES = 400


@dataclass(frozen=True, eq=False)
class JointRange:
    """What one joint says of the distance of two bodies.

    Attributes:
        first: place of one body.
        second: place of the other.
        joint: 0 to 6.
        edges: (n + 1,) angles between which bounds hold, rad.
        bounds: (n,) distance below which the bodies do not come, m.
    """

    first: int
    second: int
    joint: int
    edges: Array
    bounds: Array

    def bound_at(self, angle: float) -> float:
        """Distance below which the bodies do not come at an angle of the joint, m."""
        lower, upper = self.edges[0], self.edges[-1]
        if not lower <= angle <= upper:
            angle = (angle - lower) % (2.0 * np.pi) + lower
        k = min(int(np.searchsorted(self.edges, angle, side="right")) - 1, len(self.bounds) - 1)
        return float(self.bounds[k])

    def allowed(self, margin: float = 0.0) -> tuple[float, float] | None:
        """The widest range of the joint in which the bodies are farther apart than a margin, m; None for none."""
        kept = self.bounds > margin
        if kept.all():
            return float(self.edges[0]), float(self.edges[-1])
        starts = np.flatnonzero(kept & ~np.concatenate([[False], kept[:-1]]))
        ends = np.flatnonzero(kept & ~np.concatenate([kept[1:], [False]])) + 1
        if not len(starts):
            return None
        k = int(np.argmax(self.edges[ends] - self.edges[starts]))
        return float(self.edges[starts[k]]), float(self.edges[ends[k]])


def least_distances(
    distance: Callable[[float, float], float],
    edges: Array,
    turn: tuple[float, float],
    reaches: tuple[float, float],
) -> Array:
    """(n,) bounds below the least distance, for each range of the first of two angles.

    Args:
        distance: of two bodies at two angles, m.
        edges: (n + 1,) of the ranges of the first angle, rad.
        turn: range of the second angle, rad.
        reaches: how far a point of the second body moves with each angle at most, m/rad.
    """
    bounds = np.empty(len(edges) - 1)
    for k in range(len(bounds)):
        first, half = 0.5 * (edges[k] + edges[k + 1]), 0.5 * (edges[k + 1] - edges[k])
        bounds[k] = _least(partial(distance, first), turn, reaches[1]) - half * reaches[0]
    return bounds


def _least(distance: Callable[[float], float], turn: tuple[float, float], reach: float) -> float:
    """A bound below the least distance over a range of an angle, by branch and bound."""
    parts: list[tuple[float, float, float]] = []
    smallest = np.inf

    def look(lower: float, upper: float) -> None:
        nonlocal smallest
        value = distance(0.5 * (lower + upper))
        smallest = min(smallest, value)
        parts.append((value - 0.5 * reach * (upper - lower), lower, upper))

    for a, b in zip(*(np.linspace(*turn, 9)[s] for s in (slice(0, -1), slice(1, None))), strict=True):
        look(float(a), float(b))
    for _ in range(_TRIES):
        bound, lower, upper = min(parts)
        if smallest <= 0.0 or bound >= smallest - _LOOSE:
            return min(bound, smallest)
        parts.remove((bound, lower, upper))
        middle = 0.5 * (lower + upper)
        look(lower, middle)
        look(middle, upper)
    return min(parts)[0]


def tightened(
    ranges: Iterable[JointRange], lower: Array, upper: Array, margin: float = 0.0
) -> tuple[Array, Array, JointRange | None]:
    """Limits (7,) within which no such pair comes within a margin, m, and the pair that leaves none, if any does."""
    low, high = np.array(lower), np.array(upper)
    for each in ranges:
        allowed = each.allowed(margin)
        if allowed is None:
            return low, high, each
        k = each.joint
        if np.isinf(upper[k] - lower[k]) and (allowed[0], allowed[1]) == (each.edges[0], each.edges[-1]):
            continue
        low[k], high[k] = max(low[k], allowed[0]), min(high[k], allowed[1])
        if low[k] > high[k]:
            return low, high, each
    return low, high, None


def key_of(*arrays: Any) -> bytes:
    """What tells one question for ranges from another."""
    return b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)
