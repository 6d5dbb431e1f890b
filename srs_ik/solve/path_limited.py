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
from srs_ik.solve.path_blocks import KEPT, find_way, through
from srs_ik.solve.path_narrow import costs_to_end, find_narrow, held_below
from srs_ik.solve.path_polish import FINE, improve, keep_limits
from srs_ik.solve.path_problem import JUST_ABOVE, Problem, Way, copy, too_fast, worth
from srs_ik.solve.path_search import EVERYWHERE, fine_everywhere, finer, found

DEAR = 1.02
"""A path that costs so many times what the best one does without velocity limits may not be the best with them."""

ROUNDS = 4
"""Strips are made finer so often at most."""

LEAST_GAIN = 1e-3
"""A search that gains less, relative to all, is the last one."""


def search(problem: Problem) -> Way:
    """The best path; with velocity limits and the sum of squares to be least, the best one within them."""
    if not (problem.limited and problem.even):
        return found(problem)
    way = found(replace(problem, limited=False))
    most = DEAR * way.cost
    if not keeps_limits(problem, way):
        keep_limits(problem, way, copy(way))
    if way.reached.all() and not (keeps_limits(problem, way) and way.cost <= most):
        way = better(problem, way, found(problem))
        if not keeps_limits(problem, way):
            way = better(problem, way, found_in_fine(problem))
        if keeps_limits(problem, way) and way.cost > most and way.cost < 0.5 * BREAK:
            way = found_below(problem, way)
    return way


def better(problem: Problem, way: Way, other: Way) -> Way:
    """The better one of two paths."""
    return min(way, other, key=lambda each: worth(problem, each))


def keeps_limits(problem: Problem, way: Way) -> bool:
    """Whether a path keeps the velocity limits."""
    return bool((too_fast(problem, way) <= JUST_ABOVE).all())


def found_in_fine(problem: Problem) -> Way:
    """The best path in strips that are fine everywhere."""
    keys = np.arange(len(problem.T))
    way = find_way(fine_everywhere(problem, keys), keys, False)
    improve(problem, way, FINE)
    return way


def found_below(problem: Problem, way: Way) -> Way:
    """The best path that costs no more than one within the limits, in strips that are finer from round to round."""
    keys, near = np.arange(len(problem.T)), problem.work()[0] is not None
    loose = replace(problem, limited=False)
    for _ in range(ROUNDS):
        blocks = through(loose, keys, False)[1]
        if len(blocks) > KEPT:
            break
        after = costs_to_end(loose, blocks, way.cost)
        if near:
            loose = finer(held_below(loose, keys, blocks, after, way.cost))
            other = find_way(replace(loose, limited=True), keys, False)
        else:
            other = find_narrow(loose, keys, blocks, after, way, replace(problem, radius=EVERYWHERE))
        if other.cost >= 0.5 * BREAK or not other.reached.all():
            break
        improve(problem, other, FINE)
        gain = way.cost - other.cost
        way = better(problem, way, other)
        if not gain > LEAST_GAIN * way.cost:
            break
    return way
