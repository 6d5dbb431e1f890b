"""The best path within velocity limits.

What is best without them often keeps them, or almost, and is moved to within them. Where that costs more, the search
pays for each step beyond them. Next to the limits chords of coarse strips tell little: a step along them is shorter or
longer than it is. So in the end strips are fine, through which a path may lead that costs no more than the one at hand
does; as limits make no path cheaper, that is found out without them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from srs_ik.kernels.layout.path import BREAK
from srs_ik.solve.path.problem import EVERYWHERE, FINE_SPACING, JUST_ABOVE, Problem, Way, copy, evenly, too_fast, worth
from srs_ik.solve.path.search.blocks import KEPT, find_way, through
from srs_ik.solve.path.search.finer import finer
from srs_ik.solve.path.search.narrow import costs_to_end, find_narrow, held_below
from srs_ik.solve.path.search.planned import found
from srs_ik.solve.path.search.polish import FINE, improve, keep_limits

DEAR = 1.02
"""A path that costs so many times what the best one does without velocity limits may not be the best with them."""

AT_MOST = (1.3, 3.0)
"""While no path within the limits is known, what costs up to so many times the best one without them is looked at."""

ROUNDS, ONCE_WITHIN = 3, 2
"""Strips are made finer so often at most, and no more often once a path keeps the limits than the second figure."""

LEAST_GAIN = 1e-3
"""A search that gains less, relative to all, is the last one."""


def best_in_time(problem: Problem) -> Way:
    """The best path; with velocity limits and the sum of squares to be least, the best one within them.

    With the time to be least, the one without limits where that keeps them, else one that does.
    """
    if not problem.limited:
        return found(problem)
    way = found(replace(problem, limited=False))
    if not problem.even:
        for find, asked in ((found, problem), (best_in_time, evenly(problem))):
            if not keeps_limits(problem, way):
                way = better(problem, way, find(asked))
        return way
    least = way.cost
    if not keeps_limits(problem, way):
        keep_limits(problem, way, copy(way))
    if not way.reached.all() or is_done(problem, way, least):
        return way
    way = better(problem, way, found(problem))
    if least >= 0.5 * BREAK or is_done(problem, way, least):
        return way
    if keeps_limits(problem, way):
        return found_below(problem, way, way.cost)
    for part in AT_MOST:
        way = found_below(problem, way, part * least)
        if keeps_limits(problem, way):
            break
    return way


def is_done(problem: Problem, way: Way, least: float) -> bool:
    """Whether a path keeps the velocity limits, and costs about as little as the best one does without them."""
    return keeps_limits(problem, way) and way.cost <= DEAR * least


def better(problem: Problem, way: Way, other: Way) -> Way:
    """The better one of two paths."""
    return min(way, other, key=lambda each: worth(problem, each))


def keeps_limits(problem: Problem, way: Way) -> bool:
    """Whether a path keeps the velocity limits."""
    return bool((too_fast(problem, way) <= JUST_ABOVE).all())


def found_below(problem: Problem, way: Way, most: float) -> Way:
    """A path as good as one at hand or better, in strips of what costs at most so much, finer from round to round."""
    keys, near = np.arange(len(problem.T)), problem.is_near
    loose = replace(problem, limited=False)
    for number in range(ROUNDS):
        blocks = through(loose, keys, False)[1]
        if len(blocks) > KEPT:
            break
        rest = costs_to_end(loose, blocks, most)
        if near:
            loose = finer(held_below(loose, keys, blocks, rest, most))
            other = find_way(replace(loose, limited=True), keys, False)
        else:
            asked = replace(problem, radius=EVERYWHERE, spacing=FINE_SPACING)
            other, _ = find_narrow(loose, keys, blocks, rest, asked=asked)
        if other.cost >= 0.5 * BREAK or not other.reached.all():
            break
        improve(problem, other, FINE)
        kept, before = keeps_limits(problem, way), way.cost
        way = better(problem, way, other)
        if keeps_limits(problem, way):
            most = min(most, way.cost)
            # What does not keep the limits itself tells nothing of what is to be gained.
            told = kept and keeps_limits(problem, other)
            if number + 1 >= ONCE_WITHIN or (told and not before - way.cost > LEAST_GAIN * before):
                break
        if not near:
            break
    return way
