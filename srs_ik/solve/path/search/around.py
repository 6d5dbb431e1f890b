"""A path searched for again about one at hand, where strips are finer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.layout.path import BREAK
from srs_ik.solve.path.problem import Problem, Way
from srs_ik.solve.path.search.blocks import find_way
from srs_ik.solve.path.search.polish import FINE, improve

ROUNDS = 4
RADIUS = 0.25
"""A path is searched for again so often at most, so far around the last one, rad."""

ABOUT = 16
"""So many poses to both sides of one at which a path changes branch are searched again."""

BESIDE = 4
"""So many to both sides of one at which no posture is near the straight line between planned ones."""

LEAST_HELD = 0.25
"""At some poses alone is searched if this part of all is left out by that."""

LEAST_GAIN = 1e-3
"""A search that gains less, relative to all, is the last one."""

AROUND = 8
"""So many poses to both sides of one are planned too where a path between planned poses does something of its own."""


def wider(some: NDArray[np.bool_], by: int = AROUND) -> NDArray[np.bool_]:
    """Some poses with so many around them."""
    return np.convolve(some, np.ones(2 * by + 1), "same") > 0.5 if len(some) > 2 * by else some | some.any()


def find_around(problem: Problem, way: Way, chain: NDArray[np.int64]) -> Way:
    """The best way through strips that are fine about a path, and nowhere else."""
    return find_way(replace(problem, near=way.q, radius=RADIUS), chain, False)


def find_at(problem: Problem, way: Way, some: NDArray[np.bool_]) -> Way:
    """`find_around` at some poses (n,) alone; the others of the path stay."""
    chain = np.flatnonzero(way.reached)
    held = way.reached & ~some
    if held.mean() < LEAST_HELD:
        return find_around(problem, way, chain)
    held |= problem.has_known
    again = find_around(replace(problem, known=way.q.copy(), has_known=held), way, chain)
    again.psi[held], again.branch[held], again.bounds[held] = way.psi[held], way.branch[held], way.bounds[held]
    return again


def find_about_changes(problem: Problem, way: Way, chain: NDArray[np.int64]) -> Way:
    """`find_around` near changes of branch alone: elsewhere, all postures moved at once are the best there are."""
    changes = np.flatnonzero(np.diff(way.branch[chain]))
    marks = np.zeros(len(way.q), np.bool_)
    marks[chain[changes]] = marks[chain[changes + 1]] = True
    return find_at(problem, way, wider(marks, ABOUT)) if problem.even else find_around(problem, way, chain)


def search_around(problem: Problem, way: Way) -> Way:
    """The best path around one: strips are finer there, so branches change where that is best."""
    chain = np.flatnonzero(way.reached)
    for _ in range(ROUNDS):
        if problem.even and (problem.is_near or not np.diff(way.branch[chain]).any()):
            # Along one curve, all postures moved at once are the best.
            break
        again = find_about_changes(problem, way, chain)
        way.torn = again.cost >= way.cost + 0.5 * BREAK
        if way.torn or not again.reached[chain].all():
            break
        improve(problem, again, FINE)
        gain = way.cost - again.cost
        if gain > 0.0:
            way = again
        if not gain > LEAST_GAIN * way.cost:
            break
    return way
