"""Bodies two joints apart: how near they come, told by the joint between them alone, on the real shapes.

How the second of these bodies lies to the first depends on two joint angles. For each small range of the first one, the
least distance over all angles of the second is bounded from below: by distances in the middle of ranges, less how far
any point can move within. So such a pair is watched by a range of one joint, with which limits are found as ever, and
not by spheres.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from heapq import heappop, heappush
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

BOXES = 128
"""Ranges of the first joint at first, each with bounds of its own."""

FINE = 3e-4
"""Next to where bodies begin to meet, ranges are halved down to this, rad."""

_LOOSE = 0.002
"""The least distance is found to this, m, ..."""

_CLOSE = 1e-4
"""... and to this in those that are halved."""

PART = 0.05
"""... or to this part of it, where that is more."""

_TRIES = 2000

_APART = 1e-5
"""Bodies nearer than this, m, are not taken to be apart: coal's own tolerance is 1e-6."""


@dataclass(frozen=True, eq=False)
class JointRange:
    """What one joint says of the distance of two bodies."""

    first: int  # place of one body
    second: int  # place of the other
    joint: int  # 0 to 6
    edges: Array  # (n + 1,) angles between which bounds hold, rad
    bounds: Array  # (n,) distance below which the bodies do not come, m
    tops: Array  # (n,) distance above which they never are, m; infinite where none is known. Minus it is a depth.

    def bound_at(self, angle: float) -> float:
        """Distance below which the bodies do not come at an angle of the joint, m."""
        lower, upper = self.edges[0], self.edges[-1]
        if not lower <= angle <= upper:
            angle = (angle - lower) % (2.0 * np.pi) + lower
        k = min(int(np.searchsorted(self.edges, angle, side="right")) - 1, len(self.bounds) - 1)
        return float(self.bounds[k])

    def possible(self, margin: float = 0.0) -> tuple[float, float] | None:
        """A range of the joint outside of which the bodies are nearer than a margin, m, for certain; None for none."""
        kept = np.flatnonzero(self.tops > margin)
        return (float(self.edges[kept[0]]), float(self.edges[kept[-1] + 1])) if len(kept) else None

    def share(self) -> float:
        """The part of the joint's range in which the bodies do not meet."""
        allowed = self.allowed()
        return (allowed[1] - allowed[0]) / float(self.edges[-1] - self.edges[0]) if allowed else 0.0

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


class Bounds:
    """Bounds of the distance of two bodies over ranges of the first of two angles.

    `distance` is that at two angles, m, where they meet minus a depth that they have at least; `turn` the range of the
    second angle, rad; `reaches` how far a point of one body moves against the other with each angle at most, m/rad.
    """

    def __init__(
        self, distance: Callable[[float, float], float], turn: tuple[float, float], reaches: tuple[float, float]
    ) -> None:
        self._distance, self._turn, self._reaches = distance, turn, reaches

    def over(self, lower: float, upper: float) -> Array:
        """(n, 4) ranges that cover one, finer where bodies begin to meet: lower and upper end, least and largest."""
        edges = np.linspace(lower, upper, BOXES + 1).tolist()
        rows = [self._row(a, b, _LOOSE) for a, b in pairwise(edges)]
        while True:
            halved: list[tuple[float, float, float, float]] = []
            for k, row in enumerate(rows):
                beside = rows[max(k - 1, 0)], rows[min(k + 1, len(rows) - 1)]
                if row[1] - row[0] > FINE and _is_doubtful(row) and not all(_is_doubtful(each) for each in beside):
                    middle = 0.5 * (row[0] + row[1])
                    halved += [self._row(row[0], middle, _CLOSE), self._row(middle, row[1], _CLOSE)]
                else:
                    halved.append(row)
            if len(halved) == len(rows):
                return np.array(rows)
            rows = halved

    def _row(self, lower: float, upper: float, loose: float) -> tuple[float, float, float, float]:
        first, moves = 0.5 * (lower + upper), 0.5 * (upper - lower) * self._reaches[0] + _APART
        least = _least(partial(self._distance, first), self._turn, self._reaches[1], loose) - moves
        if least > 0.0:
            return lower, upper, least, np.inf
        depth = _least(lambda second: -self._distance(first, second), self._turn, self._reaches[1], loose) - moves
        return lower, upper, least, -depth if depth > 0.0 else np.inf


def _is_doubtful(row: tuple[float, float, float, float]) -> bool:
    return row[2] <= 0.0 < row[3]


def _least(distance: Callable[[float], float], turn: tuple[float, float], reach: float, loose: float) -> float:
    """A bound below the least distance over a range of an angle, by branch and bound; not positive if that is not."""
    parts: list[tuple[float, float, float]] = []
    smallest = np.inf

    def look(lower: float, upper: float) -> None:
        nonlocal smallest
        value = distance(0.5 * (lower + upper))
        smallest = min(smallest, value)
        heappush(parts, (value - 0.5 * reach * (upper - lower), lower, upper))

    for a, b in pairwise(np.linspace(*turn, 9).tolist()):
        look(a, b)
    for _ in range(_TRIES):
        bound, lower, upper = parts[0]
        if smallest <= 0.0 or bound >= smallest - max(loose, PART * smallest):
            break
        heappop(parts)
        middle = 0.5 * (lower + upper)
        look(lower, middle)
        look(middle, upper)
    return min(parts[0][0], smallest)


def tightened(
    ranges: Iterable[JointRange], lower: Array, upper: Array, margin: float = 0.0
) -> tuple[Array, Array, JointRange | None]:
    """Limits (7,) within which no such pair comes within a margin, m, and the pair that leaves none, if any does."""
    return _cut(((each, each.allowed(margin)) for each in ranges), lower, upper)


def loosened(
    ranges: Iterable[JointRange], lower: Array, upper: Array, margin: float = 0.0
) -> tuple[Array, Array, JointRange | None]:
    """Limits (7,) outside of which some such pair is nearer than a margin, m, for certain; else as `tightened`."""
    return _cut(((each, each.possible(margin)) for each in ranges), lower, upper)


def _cut(
    ranges: Iterable[tuple[JointRange, tuple[float, float] | None]], lower: Array, upper: Array
) -> tuple[Array, Array, JointRange | None]:
    low, high = np.array(lower), np.array(upper)
    for each, kept in ranges:
        if kept is None:
            return low, high, each
        k = each.joint
        if np.isinf(upper[k] - lower[k]) and (kept[0], kept[1]) == (each.edges[0], each.edges[-1]):
            continue
        low[k], high[k] = max(low[k], kept[0]), min(high[k], kept[1])
        if low[k] > high[k]:
            return low, high, each
    return low, high, None
