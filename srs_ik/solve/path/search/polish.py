"""A path moved to the best one near it: corridors, then all arm angles at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.entries import path as entries
from srs_ik.kernels.layout.path import BREAK, BY_CONTINUITY, BY_VELOCITY, LARGEST, SLOWEST, WITHIN
from srs_ik.solve.path.problem import (
    JUST_ABOVE,
    LARGEST_STEP,
    TIME,
    Problem,
    Way,
    breaks_in,
    copy,
    steps_of,
    take,
    too_fast,
    worth,
)
from srs_ik.solve.path.search.on_curves import move_in_free, worth_of
from srs_ik.system.arrays import Array

Breaks = NDArray[np.bool_]

WIDTHS = np.array([0.12, 0.04])
"""Joint steps between the postures of a corridor, rad, before all arm angles move at once."""

FINE: Array = np.empty(0)
"""None, where strips were fine already."""

FINE_WIDTHS: Array = 0.12 * 0.5 ** np.arange(12.0)
"""The same where corridors alone have to do."""

BARRIERS = np.geomspace(0.3, 1e-7, 10)
"""Weights of barriers, by what they are added to for each of their terms: the last one leaves so much of the best."""

KEPT_BARRIERS = np.geomspace(0.1, 1e-6, 7)
"""The same where limits are kept, of which few are reached."""

ENOUGH = 3e-7
"""What may be left to gain by moving all postures, relative to all, by how gains shrink from step to step ..."""

ROUGHLY = 1e-4
"""... and where a path only tells what others may cost."""

JUST_WITHIN = 1.0 - 1e-8
"""Of a limit; closing postures on their poses once more may take this much of it."""

WELL_WITHIN = 0.98
"""Of a limit; from steps this short on a path is moved to the best one within it."""


def improve(problem: Problem, way: Way, widths: Array = WIDTHS, enough: float = ENOUGH) -> None:
    """Move the postures of a path, in place, to the best ones near them, or within a part `enough` of these."""
    if not way.reached.any():
        return
    if problem.free is None or not problem.is_near:
        _improve(problem, way, widths, enough)
        return
    move_in_free(problem, way, lambda asked, moved: _improve(asked, moved, widths, enough))
    # Moves nothing, but tells what it costs.
    refine(replace(problem, has_known=np.ones(len(way.q), np.bool_)), way, FINE, 0.0)


def _improve(problem: Problem, way: Way, widths: Array, enough: float) -> None:
    """`improve`, wherever that leads within the limits."""
    if problem.even:
        planned = copy(way)
        refine(replace(problem, limited=False), way, widths, enough)
        if way.cost > planned.cost + 0.5 * BREAK:
            # A step that was just short enough has become a break, which has a smaller sum.
            keep_limits(continuous(problem), way, copy(planned))
        if problem.limited and (too_fast(problem, way) > JUST_ABOVE).any():
            keep_limits(problem, way, planned)
        return
    refine(problem, way, WIDTHS, 0.0)
    if problem.objective == TIME:
        polish(problem, way)


def continuous(problem: Problem) -> Problem:
    """The problem with the longest continuous steps as limits."""
    settings = problem.settings.copy()
    settings[BY_VELOCITY] = JUST_WITHIN * settings[BY_CONTINUITY]
    return replace(problem, settings=settings, limited=True)


def keep_limits(problem: Problem, way: Way, planned: Way) -> None:
    """Take a path, in place, to the best one within the velocity limits: first to within them, then along them.

    It begins at the path and at the plan, as that is on its poses: between postures of strips it is beside them. No
    more steps are breaks than those of the plan.
    """
    loose = breaks_in(problem, planned)
    starts = (way,) if np.array_equal(way.q, planned.q) else (way, planned)
    refine(problem, planned, FINE, 0.0)
    slow = [slowed(problem, start, loose) for start in starts]
    if not any(keeps(problem, each, loose) for each in slow):
        refine(problem, planned, FINE_WIDTHS, 0.0)
    take(way, min((planned, *slow), key=lambda each: worth(problem, each)))
    way.cost = entries.refine(*_told(problem, way, FINE, 0.0), problem.limited, *_line(way))


def keeps(problem: Problem, way: Way, loose: Breaks) -> bool:
    """Whether all steps of a path that are not loose are within the velocity limits."""
    return bool((too_fast(problem, way, loose) < JUST_WITHIN).all())


def slowed(problem: Problem, way: Way, loose: Breaks) -> Way:
    """The best path within the velocity limits near one, or one whose fastest step is as slow as can be."""
    slow = copy(way)
    limits = JUST_WITHIN * problem.settings[BY_VELOCITY]
    scale = np.where(np.isfinite(limits), 1.0 / limits, 0.0)
    polish_kind(problem, slow, LARGEST, scale, loose, WELL_WITHIN)
    if not keeps(problem, slow, loose):
        # The step from the seed is free.
        polish_kind(replace(problem, seed=None), slow, LARGEST, scale, loose, WELL_WITHIN)
    if keeps(problem, slow, loose):
        polish_kind(problem, slow, WITHIN, scale, loose)
    return slow


def polish(problem: Problem, way: Way) -> None:
    """Move a path, in place, to the least largest step or the least time near it, unless that is worse or hits more."""
    found, passed = copy(way), np.diff(np.flatnonzero(way.reached))
    if problem.objective == LARGEST_STEP:
        # Over poses that are not reached steps may be as many times as long.
        polish_kind(problem, found, LARGEST, np.ones(7), passed > 1)
    elif problem.objective == TIME:
        polish_kind(problem, found, SLOWEST, 1.0 / problem.arm.velocity_limit, np.zeros(len(passed), np.bool_))
    if worth_of(problem, found) < worth_of(problem, way):
        take(way, found)


def polish_kind(problem: Problem, way: Way, kind: int, scale: Array, loose: Breaks, enough: float = 0.0) -> None:
    """Move all postures of a path at once, in place, by barriers less and less wide; steps (k - 1,) may be loose.

    The largest step need not be less than `enough`.
    """
    chain = np.flatnonzero(way.reached)
    q = way.q[chain]
    steps = np.abs(steps_of(problem, np.vstack([problem.start, q])))
    if not len(steps):
        return
    if kind == WITHIN:
        weights = KEPT_BARRIERS * float((steps**2).sum()) / max(steps.size, 1)
    else:
        most = (steps * scale).max(axis=1, initial=0.0)
        weights = BARRIERS * (most.max(initial=0.0) / max(steps.size, 1) if kind == LARGEST else most.mean() / 7.0)
    if not (weights > 0.0).all():
        return
    fixed = problem.has_known | (way.branch < 0)
    free = np.append(False, loose)
    told = problem.T, chain, fixed, free, way.bounds, problem.start, problem.settings, kind, scale, weights, enough
    entries.polish(problem.limb, *told, *_line(way))


def refine(problem: Problem, way: Way, widths: Array, enough: float) -> None:
    """Move the postures of a path, in place, through corridors of some widths, and all at once where that will do."""
    way.cost = entries.refine(*_told(problem, way, widths, enough), problem.limited, *_line(way))


def _told(problem: Problem, way: Way, widths: Array, enough: float) -> tuple[object, ...]:
    chain = np.flatnonzero(way.reached)
    fixed = problem.has_known | (way.branch < 0)
    return problem.limb, problem.T, chain, fixed, way.bounds, widths, enough, problem.start, problem.settings


def _line(way: Way) -> tuple[Array, Array, NDArray[np.int64]]:
    return way.q, way.psi, way.branch
