"""The path whose largest joint step is least.

Between two postures of a strip joint angles are taken as straight, as cells. The least limit with which a path still
goes through is found by bisection, and the path is moved to the best one near it. Cells through which a better one may
lead are made finer, as far as that may change anything.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.layout.path import (
    BY_CONTINUITY,
    BY_VELOCITY,
    CELL,
    CELL_OFF,
    HELD_BRANCH,
    HELD_LINKED,
    HELD_PSI,
    INVERSE_PERIOD,
    PERIOD,
)
from srs_ik.solve.path.problem import (
    EVERYWHERE,
    FINE_SPACING,
    JUST_ABOVE,
    SUM_OF_SQUARES,
    Problem,
    Way,
    copy,
    steps_of,
    worth,
)
from srs_ik.solve.path.search.blocks import KEPT, through
from srs_ik.solve.path.search.finer import THIRDS, finer
from srs_ik.solve.path.search.limited import best_in_time
from srs_ik.solve.path.search.on_curves import worth_of
from srs_ik.solve.path.search.polish import FINE, polish, refine
from srs_ik.solve.path.search.reach import Cells, after, least_through, passed, reached
from srs_ik.system.arrays import Array

LEVELS = 3
"""Cells are made finer one time less at most."""

MOST_CELLS = 150
"""... and not where more of them than so many a pose may be on a better path: of all pairs, each is looked at."""

SAG = 0.1
"""Postures lie beside a cell by about this part of its squared length, rad."""

BISECTED = 0.003
"""The least limit is known to this part of it, ..."""

LOOSE = 1.005
"""... and a path begins with steps below so many times that."""

GAIN = 1e-4
"""Of the largest step; what gains less is not looked for."""


@dataclass
class Strips:
    """The postures of some poses, (h, HELD), in the order of their strips, and to which poses (h,) they belong."""

    rows: Array
    poses: NDArray[np.int64]

    def cells(self, problem: Problem, sag: float) -> tuple[Cells, NDArray[np.int64], NDArray[np.int64]]:
        """The cells between postures that are linked, and of single ones, and the rows of both ends of each."""
        linked = self.rows[:, HELD_LINKED] > 0.0
        first = np.flatnonzero(linked | ~np.append(False, linked[:-1]))
        last = first + linked[first]
        rows = np.zeros((len(first), CELL))
        rows[:, :7], rows[:, 7:14] = self.rows[first, :7], self.rows[last, :7] - self.rows[first, :7]
        rows[:, CELL_OFF] = sag * (rows[:, 7:14] ** 2).sum(axis=1)
        return Cells(rows, np.searchsorted(self.poses[first], np.arange(len(problem.T) + 1))), first, last

    def below(self, problem: Problem, way: Way) -> Strips:
        """Those that may be on a path with smaller steps than one at hand."""
        cells, first, last = self.cells(problem, SAG)
        some = passed(after(problem.seed, cells), limits_below(problem, way), problem.settings)[-len(first) :]
        kept, linked = np.zeros(len(self.rows), np.bool_), np.zeros(len(self.rows), np.bool_)
        kept[first[some]] = kept[last[some]] = True
        linked[first[some]] = first[some] < last[some]
        rows = self.rows[kept]
        rows[:, HELD_LINKED] = linked[kept]
        return Strips(rows, self.poses[kept])

    def finer(self, problem: Problem) -> Strips:
        """The same with postures closer together."""
        if problem.is_near:
            told = finer(replace(problem, held=self.rows, held_of=self.poses), THIRDS)
            return Strips(told.held, told.held_of)
        begin, end = self.ends()
        free: list[Array | None] = [None] * len(problem.T)
        for i, (a, b) in enumerate(pairwise(np.searchsorted(self.poses[begin], np.arange(len(problem.T) + 1)))):
            if b > a and not problem.has_known[i]:
                own = self.rows[begin[a:b]], self.rows[end[a:b]]
                free[i] = np.column_stack([own[0][:, HELD_BRANCH], own[0][:, HELD_PSI], own[1][:, HELD_PSI]])
        found = strips_of(replace(problem, free=free, radius=EVERYWHERE, spacing=FINE_SPACING))
        return self if found is None else found

    def ends(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The rows of the first posture of each strip, and of the last one."""
        last = np.flatnonzero(self.rows[:, HELD_LINKED] == 0.0)
        return np.append(0, last[:-1] + 1), last


def least_largest_step(problem: Problem) -> Way:
    """The path whose largest joint step is least, from that of the least sum of squares on."""
    way = best_in_time(replace(problem, objective=SUM_OF_SQUARES))
    polish(problem, way)
    loose = replace(problem, limited=False, objective=SUM_OF_SQUARES)
    whole = strips_of(loose)
    if whole is None:
        return way
    strips = whole
    for _ in range(LEVELS):
        if not len(strips.rows):
            break
        strips = strips.below(problem, way)
        other = path_through(problem, strips, way)
        if other is not None:
            if not problem.is_near:
                put_bounds(other, whole)
            refine(loose, other, FINE, 0.0)
            polish(problem, other)
            if worth_of(problem, other) < worth_of(problem, way):
                way = other
                strips = strips.below(problem, way)
        if not 0 < len(strips.rows) <= MOST_CELLS * len(problem.T):
            break
        strips = strips.finer(loose)
    return way


def strips_of(problem: Problem) -> Strips | None:
    """The strips of all poses; None where they are too many to be kept."""
    blocks = through(problem, np.arange(len(problem.T)), False)[1]
    if len(blocks) > KEPT:
        return None
    rows, poses = zip(*(block.held() for block in blocks), strict=True)
    return Strips(np.vstack(rows), np.concatenate(poses))


def limits_below(problem: Problem, way: Way) -> Array:
    """(k, 7) the longest steps to the seed, if there is one, and to each pose that make a better path of one at hand.

    They are smaller than its largest one, continuous, and not too fast; where it breaks, they are only smaller. The
    step from the seed may be fast.
    """
    begin, settings, chain = len(problem.start), problem.settings, np.flatnonzero(way.reached)
    limit = (1.0 - GAIN) * worth(problem, way)[1]
    most = np.tile(np.minimum(limit, settings[BY_CONTINUITY]), (begin + len(way.q), 1))
    if problem.limited:
        most[2 * begin :] = np.minimum(most[2 * begin :], settings[BY_VELOCITY])
    steps = np.abs(steps_of(problem, np.vstack([problem.start, way.q[chain]])))
    broken = (steps > JUST_ABOVE * settings[BY_CONTINUITY]).any(axis=1)
    most[begin + chain[len(chain) - len(steps) :][broken]] = limit
    return most


def path_through(problem: Problem, strips: Strips, way: Way) -> Way | None:
    """The path through strips with the least largest step, as they are straight; None where none is below a path's."""
    own, first, last = strips.cells(problem, 0.0)
    cells, limits = after(problem.seed, own), limits_below(problem, way)
    if not len(first) or not reached(cells, limits, problem.settings)[0]:
        return None
    most = float(limits.max())
    until = BISECTED * most
    least = least_through(cells, 0.0, most, until, problem.settings, limits) + until
    limits = np.minimum(limits, LOOSE * least)
    spans = reached(cells, limits, problem.settings)[1]
    numbers, parts = way_back(cells, spans, limits, problem.settings)
    found = copy(way)
    for i in np.flatnonzero(numbers[-len(problem.T) :] >= 0):
        k = numbers[i - len(problem.T)] - len(cells.rows) + len(first)
        a, b, t = strips.rows[first[k]], strips.rows[last[k]], parts[i - len(problem.T)]
        found.q[i], found.psi[i] = a[:7] + t * (b[:7] - a[:7]), a[HELD_PSI] + t * (b[HELD_PSI] - a[HELD_PSI])
        found.branch[i] = int(a[HELD_BRANCH])
        found.bounds[i] = -np.inf, np.inf
    return found


def way_back(cells: Cells, spans: Array, limits: Array, settings: Array) -> tuple[NDArray[np.int64], Array]:
    """A path back from the last pose through what is reached: (k,) its cells, and how far along each it is.

    Each posture is the nearest to the one behind it. What is reached of a cell may have gaps: where no posture is close
    enough, that is taken which is too far away by least.
    """
    n = len(cells.ends) - 1
    numbers, parts = np.full(n, -1), np.zeros(n)
    behind = None
    for i in range(n - 1, -1, -1):
        a, b = cells.ends[i], cells.ends[i + 1]
        some = a + np.flatnonzero(spans[a:b, 0] <= spans[a:b, 1])
        if not len(some):
            behind = None
            continue
        low, high = spans[some].T
        chord = cells.rows[some, 7:14]
        if behind is None:
            k = int(np.argmax((high - low) ** 2 * (chord**2).sum(axis=1)))
            t = 0.5 * (low + high)
        else:
            step = behind - cells.rows[some, :7]
            step -= settings[PERIOD] * np.round(step * settings[INVERSE_PERIOD])
            t = np.clip((step * chord).sum(axis=1) / np.maximum((chord**2).sum(axis=1), 1e-300), low, high)
            t = np.clip(t, *between_limits(step, chord, limits[i + 1], low, high))
            off = step - t[:, None] * chord
            over = np.maximum(np.abs(off) - limits[i + 1], 0.0).max(axis=1)
            k = int(np.lexsort(((off**2).sum(axis=1), over))[0])
        numbers[i], parts[i] = some[k], t[k]
        behind = cells.rows[some[k], :7] + t[k] * chord[k]
    return numbers, parts


def between_limits(step: Array, chord: Array, limits: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """Of the parts of cells from `low` to `high`, those with short steps, or the middle between where they would be."""
    turning = np.abs(chord) > 1e-12
    slope = np.where(turning, chord, 1.0)
    one, other = (step - limits) / slope, (step + limits) / slope
    first = np.maximum(np.where(turning, np.minimum(one, other), -np.inf).max(axis=1), low)
    last = np.minimum(np.where(turning, np.maximum(one, other), np.inf).min(axis=1), high)
    middle = np.clip(0.5 * (first + last), low, high)
    return np.where(first <= last, first, middle), np.where(first <= last, last, middle)


def put_bounds(way: Way, strips: Strips) -> None:
    """Give the postures of a path the ends of their strips."""
    begin, end = strips.ends()
    pose, branch = strips.poses[begin], strips.rows[begin, HELD_BRANCH]
    low, high = strips.rows[begin, HELD_PSI], strips.rows[end, HELD_PSI]
    own = (branch == way.branch[pose]) & (low <= way.psi[pose]) & (way.psi[pose] <= high)
    bounds = np.column_stack([np.where(low > -np.pi, low, -np.inf), np.where(high < np.pi, high, np.inf)])
    way.bounds[pose[own]] = bounds[own]
