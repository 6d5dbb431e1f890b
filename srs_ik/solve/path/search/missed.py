"""Paths where strips miss something: where they leap, and where two of three joint groups turn on the spot at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.layout.path import BREAK
from srs_ik.solve.intervals import intervals
from srs_ik.solve.path.problem import Problem, Way, steps_of, worth
from srs_ik.solve.path.search.around import ABOUT, LEAST_HELD, find_at, wider
from srs_ik.solve.path.search.blocks import find_way
from srs_ik.solve.path.search.bridges import bridged
from srs_ik.solve.path.search.polish import FINE, improve
from srs_ik.solve.path.search.singular import two_turns, with_turns

LEAP = 0.2
"""A joint step of a path that is longer than this, rad, may be there because strips miss a posture."""

TURNS = np.linspace(-np.pi, np.pi, 64), *(np.linspace(-width, width, 21) for width in (0.2, 0.04, 0.008))
"""Where two turn on the spot, angles of one of them from those of the path, rad, in turn."""

MOST_TURNED = 64
"""Of a path with more such poses, these take too long."""


def smoothed_leaps(problem: Problem, way: Way) -> Way:
    """A path with postures that strips miss where it leaps, if they make it better."""
    marks = np.zeros(len(way.q), np.bool_)
    marks[np.flatnonzero(way.reached)[:-1][leaps_of(problem, way)]] = True
    held = (way.reached & ~wider(marks)) | problem.has_known
    local = replace(problem, known=way.q.copy(), has_known=held)
    more = bridged(local)
    return way if more is local else held_and_improved(problem, way, more, held)


def held_and_improved(problem: Problem, way: Way, more: Problem, held: NDArray[np.bool_]) -> Way:
    """The best way of a problem in which some postures of a path stay, improved, or that path if it is better."""
    other = find_way(more, np.arange(len(held)), False)
    if other.cost >= 0.5 * BREAK:
        return way
    other.psi[held], other.branch[held], other.bounds[held] = way.psi[held], way.branch[held], way.bounds[held]
    improve(problem, other)
    return min(way, other, key=lambda each: worth(problem, each))


def searched_beside(problem: Problem, way: Way, moved: NDArray[np.bool_]) -> Way:
    """A path whose postures (n,) have been moved to their poses, or a better one that passes them, or goes beside them.

    Strips take joints next to a singular posture as turning on the spot, and limits with some room; beside a limit,
    rounding is as much as a tenth of a radian there. Within the intervals that limits leave, postures meet their poses.
    """
    beside = wider(moved, ABOUT)
    plans = [replace(problem, known=way.q.copy(), has_known=problem.has_known | moved)]
    if problem.free is None:
        plans.append(replace(problem, free=[_within(problem, i) if beside[i] else None for i in range(len(beside))]))
    for plan in plans:
        other = find_at(plan, way, beside)
        if other.cost < 0.5 * BREAK and other.reached.all():
            improve(plan, other, FINE)
            way = min(way, other, key=lambda each: worth(problem, each))
    return way


def _within(problem: Problem, i: int) -> NDArray[np.float64]:
    """(k, 3) the intervals of a pose that limits leave, without room for rounding: branch, first and last arm angle."""
    found = intervals(problem.arm, problem.T[i], True)
    return np.array([(each.branch, each.lower, each.upper) for each in found]).reshape(-1, 3)


def turned_on_the_spot(problem: Problem, way: Way) -> Way:
    """A path with other postures where two of shoulder, elbow and wrist turn on the spot, if it gets better."""
    some = two_turns(problem, way)
    for angles in TURNS if 0 < some.sum() <= MOST_TURNED else ():
        held = way.reached & ~wider(some, ABOUT)
        held = (held & (held.mean() >= LEAST_HELD)) | problem.has_known
        local = with_turns(replace(problem, known=way.q.copy(), has_known=held), way, some, angles)
        way = held_and_improved(problem, way, local, held)
        some = two_turns(problem, way)
    return way


def is_odd(problem: Problem, way: Way) -> bool:
    """Whether a path on an exact limb leaps, or fine strips about it are torn: its strips may miss postures."""
    return problem.arm.closed and (way.torn or bool(leaps_of(problem, way).any()))


def leaps_of(problem: Problem, way: Way) -> NDArray[np.bool_]:
    """(k - 1,) whether a path leaps, from each pose that is reached to the next."""
    return np.abs(steps_of(problem, way.q[way.reached])).max(axis=1, initial=0.0) > LEAP
