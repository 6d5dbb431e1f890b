"""What a path may be asked for instead of the least sum of squares: the least largest step, and a closed path."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from srs_ik.kernels.layout.path import BREAK, INVERSE_SPEED, POWER
from srs_ik.solve.path_search import FINE_WIDTHS, Problem, Way, copy, find_way, refine, search, search_around, steps_of
from srs_ik.solve.pose import solve_all

POWERS = (8.0, 32.0, 128.0)
"""Powers of the largest step of each pose whose sum is made least, one after the other: the higher, the more it counts
how large the largest of all is."""

STARTS = 6
"""Most postures at which a closed path is tried to begin."""

TURNS = 3
"""How often the place moves at which a closed path is held."""


def largest_step(problem: Problem, way: Way) -> float:
    """Largest joint step of a path, that from the seed included."""
    q = way.q[way.reached]
    if problem.seed is not None:
        q = np.vstack([problem.seed, q])
    return float(np.abs(steps_of(problem, q)).max(initial=0.0))


def least_largest_step(problem: Problem) -> Way:
    """The path whose largest joint step is least."""
    way = search(replace(problem, even=True))
    if way.cost >= 0.5 * BREAK:
        return way
    chain = np.flatnonzero(way.reached)
    for power in POWERS:
        settings = problem.settings.copy()
        settings[INVERSE_SPEED] = 1.0 / max(largest_step(problem, way), 1e-12)
        settings[POWER] = power
        steep = replace(problem, settings=settings, even=False)
        found = find_way(steep, chain, False) if power == POWERS[0] else copy(way)
        refine(steep, found, FINE_WIDTHS, False)
        if found.cost < 0.5 * BREAK and largest_step(problem, found) <= largest_step(problem, way):
            way = search_around(steep, found)
            if largest_step(problem, way) > largest_step(problem, found):
                way = found
    return way


def closed(problem: Problem) -> Way:
    """A path that ends in the posture in which it begins."""
    n = len(problem.T)
    free = search(problem)
    others = solve_all(problem.arm, problem.T[0], None, True)
    starts = [free.q[0], free.q[-1], *(s.q for s in others)][:STARTS] if free.reached[[0, -1]].all() else []
    if problem.has_known[[0, -1]].any():
        starts = [problem.known[0 if problem.has_known[0] else -1]]
    best = free
    lowest = np.inf
    for start in starts:
        known, has_known = problem.known.copy(), problem.has_known.copy()
        known[[0, -1]] = start
        has_known[[0, -1]] = True
        way = search(replace(problem, known=known, has_known=has_known))
        if way.cost < lowest:
            best, lowest = way, way.cost
    if problem.seed is not None or problem.has_known.any() or not np.isfinite(lowest) or not best.reached.all():
        return best
    # The start was no free choice: held in its middle, the same circle may move there.
    for _ in range(TURNS):
        best = _rolled(problem, best, n // 2)
    return best


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
    narrow = replace(problem, T=problem.T[order], seed=None, known=near, has_known=has_known)
    found = search(narrow)
    if not found.cost < way.cost:
        return way
    back = np.append(np.roll(np.arange(n - 1), by), 0 if by == 0 else (n - 1 - by) % (n - 1))
    result = Way(n)
    result.q, result.psi, result.branch = found.q[back], found.psi[back], found.branch[back]
    result.bounds, result.reached, result.cost = found.bounds[back], found.reached[back], found.cost
    result.q[-1] = result.q[0]
    return result
