"""What no path through some poses costs less than: a bound for how far from the best a path may be.

The programme over cells that hold all postures, each step counted as its least between two cells. Cells through which
no path as good as the one at hand can lead are left out, the others cut, and so on.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from srs_ik.kernels.entries import path_bound as entries
from srs_ik.kernels.layout.path import BY_CONTINUITY, CELL, WORTH, WORTH_BEGIN, WORTH_END, WORTH_SAG
from srs_ik.solve.path.problem import TIME, Problem
from srs_ik.solve.path.search.reach import Cells, after, least_through, passed, posture_cell
from srs_ik.system.arrays import Array

LENGTHS = (0.4, 0.15, 0.06, 0.025, 0.01)
"""Longest cells, rad, from round to round."""

TIMED = 3
"""Rounds where the time is bounded."""

CLOSE = 0.01
"""A bound so close below the path, relative to it, is close enough."""

BISECTED = 0.2
"""A largest step is known to this part of that."""

ROOM = 1 << 17
"""Cells of a block: about twenty megabytes."""

MOST_CELLS = 1500
"""Cells a pose, in the mean, for the sum of squares and the time: more of them take over 50 ms a pose."""

MOST_FOR_LARGEST = 600
"""The same for the largest step, where each cell is looked at from all of the pose before it, some ten times."""

ROUNDING = 1e-9
"""Relative."""


MOST_ROOM = 1 << 19
"""Cells of one pose at most: joints of many turns may have more, and the bound is then what is known without them."""


class TooManyCells(Exception):
    """A pose has more than `MOST_ROOM` cells."""


Source = Callable[[int, int], Cells]
"""The cells of as many poses from number `first` on as go into so many rows."""


@dataclass
class Front:
    """The cells of the last pose that has some, what they cost at least, and whether poses without any follow."""

    rows: Array
    worth: Array
    gap: bool = False


def least_sum(problem: Problem, q: Array, value: float, may_leap: bool) -> float:
    """What the squared joint steps of any path sum up to at least, with breaks or (unless it `may_leap`) without.

    Those of a path `q` (n, 7) that is found, NaN where it reaches no posture, sum up to `value`.
    """
    if not value > 0.0:
        return 0.0
    settings = problem.settings.copy()
    if may_leap or problem.seed is not None:
        # The step from a seed is no break, however long.
        settings[BY_CONTINUITY] = np.inf
    bound, kept = 0.0, None
    # Times lie closer together than sums of squares, so that fewer cells can be left out.
    lengths = LENGTHS[:TIMED] if problem.objective == TIME else LENGTHS
    for longest, finer in pairwise((*lengths, 0.0)):
        source = _source(problem, q, kept, longest)
        try:
            least, kept = _round(problem, source, settings, value, finer > 0.0)
        except TooManyCells:
            break
        bound = max(bound, least)
        if value - bound < CLOSE * value or _are_too_many(kept, longest, finer, MOST_CELLS):
            break
    return min(max(bound * (1.0 - ROUNDING), 0.0), value)


def _round(problem: Problem, source: Source, settings: Array, value: float, keep: bool) -> tuple[float, Cells]:
    """What a path costs at least by cells, and those cells through which one may lead that is as good as a value."""
    n = len(problem.T)
    front = None if problem.seed is None else Front(posture_cell(problem.seed), np.zeros((1, WORTH)))
    firsts, forth, first = [], [], 0
    while first < n:
        cells = _some(source, first)
        worth, front = _relaxed(cells, front, False, settings)
        firsts.append(first)
        forth.append(worth)
        first += len(cells.ends) - 1
    if front is None:
        return 0.0, Cells(np.empty((0, CELL)), np.zeros(n + 1, np.int64))
    bound = float(_lowest(front.worth).min())
    if not keep or value - bound < CLOSE * value:
        return bound, Cells(np.empty((0, CELL)), np.zeros(n + 1, np.int64))
    front, parts, counts = None, [], []
    for first, worth in zip(reversed(firsts), reversed(forth), strict=True):
        cells = _some(source, first)
        back, front = _relaxed(cells, front, True, settings)
        kept = _lowest(worth + back) <= value * (1.0 + ROUNDING)
        parts.append(cells.rows[kept])
        counts.append(np.diff(np.append(0, np.cumsum(kept))[cells.ends]))
    ends = np.append(0, np.cumsum(np.concatenate(counts[::-1])))
    return bound, Cells(np.vstack(parts[::-1]), ends)


def least_largest(problem: Problem, q: Array, value: float, may_leap: bool) -> float:
    """What the largest joint step of any path is at least; arguments as in `least_sum`."""
    if not value > 0.0:
        return 0.0
    bound, kept = 0.0, None
    begin = 0 if problem.seed is None else 1
    most = np.full((begin + len(problem.T), 7), np.inf)
    if not may_leap:
        most[:] = problem.settings[BY_CONTINUITY]
    # The step from a seed is no break, however long.
    most[: 2 * begin] = np.inf
    above = np.minimum(value * (1.0 + ROUNDING), most)
    for longest, finer in pairwise((*LENGTHS[1:], 0.0)):
        try:
            cells = _all_of(_source(problem, q, kept, longest), len(problem.T))
        except TooManyCells:
            break
        whole = after(problem.seed, cells)
        bound = least_through(whole, bound, value, BISECTED * CLOSE * value, problem.settings, most)
        if value - bound < CLOSE * value:
            break
        kept = cells.where(passed(whole, above, problem.settings)[-len(cells.rows) :])
        if _are_too_many(kept, longest, finer, MOST_FOR_LARGEST):
            break
    return min(max(bound * (1.0 - ROUNDING), 0.0), value)


def _are_too_many(cells: Cells, longest: float, finer: float, most: int) -> bool:
    """Whether cells so long would be more than `most` a pose at a finer length; at length zero they are."""
    return finer * most * (len(cells.ends) - 1) <= longest * len(cells.rows)


def _all_of(source: Source, n: int) -> Cells:
    """The cells of all poses."""
    rows, counts, first = [], [], 0
    while first < n:
        cells = _some(source, first)
        rows.append(cells.rows)
        counts.append(np.diff(cells.ends))
        first += len(cells.ends) - 1
    return Cells(np.vstack(rows), np.append(0, np.cumsum(np.concatenate(counts))))


def _some(source: Source, first: int) -> Cells:
    room = ROOM
    while len((cells := source(first, room)).ends) < 2:
        room *= 4
        if room > MOST_ROOM:
            raise TooManyCells
    return cells


def _lowest(worth: Array) -> Array:
    """Least of parabolas (m, WORTH)."""
    a, b, sag = worth[:, WORTH_BEGIN], worth[:, WORTH_END], worth[:, WORTH_SAG]
    inside = sag > np.abs(b - a)
    t = np.where(inside, 0.5 * (1.0 - (b - a) / np.where(inside, sag, 1.0)), 0.0)
    return np.where(inside, a + t * (b - a) - sag * t * (1.0 - t), np.minimum(a, b))


def _relaxed(cells: Cells, front: Front | None, backward: bool, settings: Array) -> tuple[Array, Front | None]:
    """(m, WORTH) what cells cost at least, from a front on, or back from it; and the front behind them."""
    rows, ends, worth = cells.rows, cells.ends, np.zeros((len(cells.rows), WORTH))
    own = slice(0, len(rows))
    if front is not None:
        more = len(front.rows)
        gap = [0] if front.gap else []
        if backward:
            rows, worth = np.vstack([rows, front.rows]), np.vstack([worth, front.worth])
            ends = np.concatenate([ends, [ends[-1]] if gap else [], [ends[-1] + more]]).astype(np.int64)
        else:
            rows, worth = np.vstack([front.rows, rows]), np.vstack([front.worth, worth])
            ends = np.concatenate([[0], [more] if gap else [], ends + more]).astype(np.int64)
            own = slice(more, None)
    entries.relax(rows, ends, backward, settings, worth)
    worth = worth[own]
    some = np.flatnonzero(np.diff(cells.ends))
    if not len(some):
        return worth, None if front is None else Front(front.rows, front.worth, True)
    at, edge = (some[0], 0) if backward else (some[-1], len(cells.ends) - 2)
    last = slice(cells.ends[at], cells.ends[at + 1])
    return worth, Front(cells.rows[last].copy(), worth[last].copy(), bool(at != edge))


def _source(problem: Problem, q: Array, kept: Cells | None, longest: float) -> Source:
    """Cells at most so long: all, or those in the place of some."""
    if kept is None:
        return _covering(problem, np.ascontiguousarray(q), longest)
    return _cutting(problem, kept, longest)


def _covering(problem: Problem, q: Array, longest: float) -> Source:
    """Cells that hold all postures of all poses, and those given."""

    def cover(first: int, room: int) -> Cells:
        rows, ends = np.empty((room, CELL)), np.zeros(len(problem.T) - first + 1, np.int64)
        told = problem.T, first, problem.known, problem.has_known, q
        done = entries.cover(problem.family, *told, longest, rows, ends)
        return Cells(rows[: ends[done]], ends[: done + 1])

    return cover


def _cutting(problem: Problem, coarse: Cells, longest: float) -> Source:
    """Finer cells in the place of others."""

    def cut(first: int, room: int) -> Cells:
        rows, ends = np.empty((room, CELL)), np.zeros(len(problem.T) - first + 1, np.int64)
        told = problem.T[first:], coarse.rows, coarse.ends[first:]
        done = entries.cut(problem.family, *told, longest, rows, ends)
        return Cells(rows[: ends[done]], ends[: done + 1])

    return cut
