"""What a path may be asked for instead of the least sum of squares: the least largest step, and a closed path."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.layout.path import BREAK, BY_CONTINUITY, BY_VELOCITY, INVERSE_SPEED, LEAST_INVERSE
from srs_ik.solve.path.around import RADIUS
from srs_ik.solve.path.blocks import find_way, held_in, through
from srs_ik.solve.path.limited import search
from srs_ik.solve.path.polish import WIDTHS, polish, refine
from srs_ik.solve.path.problem import (
    EVERYWHERE,
    FINE_SPACING,
    LARGEST_STEP,
    SUM_OF_SQUARES,
    Problem,
    Way,
    steps_of,
    worth,
)
from srs_ik.solve.path.search import THIRDS, finer, may_be_fine
from srs_ik.solve.path.timing import passing_times

Array = NDArray[np.float64]

SEARCHES = 3
"""A path with a smaller largest step is searched for so often at most ..."""

BELOW = 0.97
"""... where steps are to be below this part of the last one ..."""

JUST_BELOW = 0.995
"""... or below this one, if there is none so small."""

ALMOST = 1.05
"""Steps above this part of the last one are left out then: few of them can be moved below the limit."""

MORE = (0.0, 0.03)
"""... or so much longer, rad, for postures lie between those of strips, and what is reached of a strip may be less."""

MOST_FINE = 1000
"""Fine strips of a near limb take 80 kB a pose: paths of more poses have them about a path at hand alone."""

STARTS = 6
"""Most postures at which a closed path is tried to begin."""

TURNS = 3
"""How often the place moves at which a closed path is held."""


def best(problem: Problem) -> Way:
    """The best path by what it is asked to make least."""
    if problem.acceleration is not None:
        return quickest(problem, problem.acceleration)
    return least_largest_step(problem) if problem.objective == LARGEST_STEP else search(problem)


def quickest(problem: Problem, acceleration: Array) -> Way:
    """The path that takes the least time within limits of velocity and acceleration, of those best by each objective.

    The one of the least time at the velocity limits turns sharply; the one of the least sum of squares is even.
    """

    def lasts(way: Way) -> tuple[int, float]:
        steps = steps_of(problem, way.q[way.reached])
        return worth(problem, way)[0], float(passing_times(steps, problem.arm.velocity_limit, acceleration)[-1])

    even = replace(problem, acceleration=None, objective=SUM_OF_SQUARES)
    even.settings = problem.settings.copy()
    even.settings[[INVERSE_SPEED, LEAST_INVERSE]] = 0.0
    ways = [best(replace(even, objective=SUM_OF_SQUARES)), best(replace(problem, acceleration=None))]
    return min(ways, key=lasts)


def least_largest_step(problem: Problem) -> Way:
    """The path whose largest joint step is least, from that of the least sum of squares on.

    Moved all at once, a path is the best one near it; then one is searched for whose steps are smaller.
    """
    way = search(replace(problem, objective=SUM_OF_SQUARES))
    if way.cost >= 0.5 * BREAK:
        return way
    polish(problem, way)
    plans = Plans(problem, np.flatnonzero(way.reached))
    for _ in range(SEARCHES):
        better = plans.smaller(way, BELOW) or plans.smaller(way, JUST_BELOW)
        if better is None:
            break
        way = better
    return way


class Plans:
    """The strips in which paths with a smaller largest step are planned: those of a near limb are found once."""

    def __init__(self, problem: Problem, keys: NDArray[np.int64]) -> None:
        self.problem, self.keys = problem, keys
        self.strips = [replace(problem, limited=True, objective=SUM_OF_SQUARES)]
        if may_be_fine(problem):
            self.strips = [replace(self.strips[0], radius=EVERYWHERE, spacing=FINE_SPACING)]

    def strips_at(self, number: int, way: Way) -> Problem:
        """Coarse strips (0), or fine ones, of a long path about it alone."""
        if number and len(self.keys) > MOST_FINE:
            return replace(self.strips[0], near=way.q, radius=RADIUS)
        if number == len(self.strips):
            coarse = held_in(self.strips[0], self.keys, through(self.strips[0], self.keys, False)[1])
            self.strips = [coarse, finer(coarse, THIRDS)]
        return self.strips[number]

    def smaller(self, way: Way, part: float) -> Way | None:
        """A path with a smaller largest step, of those whose steps are about below a part of this one's."""
        problem, largest = self.problem, worth(self.problem, way)[1]
        for number in range(2 if problem.is_near and part == BELOW else 1):
            for more in MORE if part == BELOW else MORE[:1]:
                settings = problem.settings.copy()
                settings[BY_VELOCITY] = part * largest
                settings[BY_CONTINUITY] = np.minimum(settings[BY_CONTINUITY], ALMOST * largest + more)
                plan = replace(self.strips_at(number, way), settings=settings)
                other = find_way(plan, self.keys, False)
                # Planned steps may be longer than those near them: chords are off the curves of their strips.
                refine(plan, other, WIDTHS, 0.0)
                polish(problem, other)
                if worth(problem, other) < worth(problem, way):
                    return other
        return None


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
    free = problem.reordered(order)
    narrow = replace(problem, T=problem.T[order], seed=None, known=near, has_known=has_known, free=free)
    found = best(narrow)
    if not worth(narrow, found) < worth(narrow, turned):
        return way
    back = np.append(np.roll(np.arange(n - 1), by), 0 if by == 0 else (n - 1 - by) % (n - 1))
    result = Way(n)
    result.q, result.psi, result.branch = found.q[back], found.psi[back], found.branch[back]
    result.bounds, result.reached, result.cost = found.bounds[back], found.reached[back], found.cost
    result.q[-1] = result.q[0]
    return result
