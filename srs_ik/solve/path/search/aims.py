"""What a path may be asked for instead of the least sum of squares: the least largest step, and a closed path."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from srs_ik.solve.path.problem import LARGEST_STEP, Problem, Way, evenly, stands, steps_of, worth
from srs_ik.solve.path.search.least_step import least_largest_step
from srs_ik.solve.path.search.limited import best_in_time
from srs_ik.solve.path.timing import passing_times
from srs_ik.system.arrays import Array

STARTS = 6
"""Most postures at which a closed path is tried to begin."""

TURNS = 3
"""How often the place moves at which a closed path is held."""


def best(problem: Problem) -> Way:
    """The best path by what it is asked to make least."""
    if problem.acceleration is not None:
        return quickest(problem, problem.acceleration)
    return least_largest_step(problem) if problem.objective == LARGEST_STEP else best_in_time(problem)


def quickest(problem: Problem, acceleration: Array) -> Way:
    """The path that takes the least time within limits of velocity and acceleration, of those best by each objective.

    The one of the least time at the velocity limits turns sharply; the one of the least sum of squares is even.
    """

    def lasts(way: Way) -> tuple[int, float]:
        steps, limit = steps_of(problem, way.q[way.reached]), problem.arm.velocity_limit
        times = passing_times(steps, limit, acceleration, stands(problem.T[way.reached]))
        return worth(problem, way)[0], float(times[-1])

    ways = [best(replace(each, acceleration=None)) for each in (evenly(problem), problem)]
    return min(ways, key=lasts)


def closed(problem: Problem) -> Way:
    """A path that ends in the posture in which it begins."""
    n = len(problem.T)
    free = best(problem)
    others = problem.solve_all(0)
    starts = [free.q[0], free.q[-1], *(s.q for s in others)][:STARTS] if free.reached[[0, -1]].all() else []
    if problem.has_known[[0, -1]].any():
        starts = [problem.known[0 if problem.has_known[0] else -1]]
    found, lowest = free, (len(problem.T) + 1, np.inf)
    for start in starts:
        known, has_known = problem.known.copy(), problem.has_known.copy()
        known[[0, -1]] = start
        has_known[[0, -1]] = True
        way = best(replace(problem, known=known, has_known=has_known))
        if worth(problem, way) < lowest:
            found, lowest = way, worth(problem, way)
    if problem.seed is not None or problem.has_known.any() or lowest[0] or not found.reached.all():
        return found
    # The start was no free choice: held in its middle, the same circle may move there.
    for _ in range(TURNS):
        found = _rolled(problem, found, n // 2)
    return found


def _rolled(problem: Problem, way: Way, by: int) -> Way:
    """A closed path made better while it is held at another pose."""
    n = len(way.q)
    order = np.append(np.roll(np.arange(n - 1), -by), by)
    turned = Way(n)
    turned.q, turned.psi, turned.branch = way.q[order], way.psi[order], way.branch[order]
    turned.bounds, turned.reached = way.bounds[order], way.reached[order]
    # The ends were held: which branch they are in, and how far they may move, is known by the arm alone.
    has_known = np.zeros(n, np.bool_)
    has_known[[0, -1]] = True
    near = turned.q.copy()
    told = {"seed": None, "known": near, "has_known": has_known, **problem.reordered(order)}
    narrow = replace(problem, T=problem.T[order], **told)
    found = best(narrow)
    if not worth(narrow, found) < worth(narrow, turned):
        return way
    back = np.append(np.roll(np.arange(n - 1), by), 0 if by == 0 else (n - 1 - by) % (n - 1))
    result = Way(n)
    result.q, result.psi, result.branch = found.q[back], found.psi[back], found.branch[back]
    result.bounds, result.reached, result.cost = found.bounds[back], found.reached[back], found.cost
    result.q[-1] = result.q[0]
    return result
