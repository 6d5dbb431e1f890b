"""Strips made finer: where chords of coarse ones may be off by more than tells which path is the best."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.entries import path as entries
from srs_ik.kernels.layout.path import BREAK, BY_CONTINUITY, HELD_LINKED
from srs_ik.solve.path.problem import EVERYWHERE, FINE_SPACING, Problem, Way, worth
from srs_ik.solve.path.search.blocks import held_in, through
from srs_ik.solve.path.search.narrow import costs_to_end, held_below
from srs_ik.solve.path.search.polish import improve
from srs_ik.system.arrays import Array

PARTS = np.array([0.25, 0.5, 0.75])
THIRDS = np.array([1.0, 2.0]) / 3.0
FARTHEST, MOST_HELD = 0.1, 4096
"""Where strips of a near limb are fine, postures at these parts of the way are put between two, so far off it, rad, if
a pose has no more than so many then."""

COARSE = 1.5
"""Off the curves of a near limb, chords of coarse strips may tell of paths that cost more than they do, by less ..."""

LONGER = 1.2
"""... and that take longer steps."""


def is_whole(way: Way, keys: NDArray[np.int64]) -> bool:
    """Whether a path is planned at all of some poses, without a break."""
    return way.cost < 0.5 * BREAK and bool(way.reached[keys].all())


def fine_everywhere(problem: Problem, keys: NDArray[np.int64]) -> Problem:
    """The problem with fine strips at all key poses; those of a near limb get postures between theirs."""
    if not problem.is_near:
        return replace(problem, radius=EVERYWHERE, spacing=FINE_SPACING)
    settings = problem.settings.copy()
    # Chords of coarse strips may be too long where steps of a path are not.
    settings[BY_CONTINUITY] *= LONGER
    told = replace(problem, settings=settings)
    way, blocks = through(told, keys, False)
    whole, least = is_whole(way, keys), way.cost
    if whole:
        improve(problem, way)
    if not whole or worth(problem, way)[0]:
        return finer(held_in(problem, keys, blocks))
    # Where no path leads that costs about as little as one at hand, or its plan, postures would be put between in vain.
    most = COARSE * max(least, way.cost)
    few = held_below(told, keys, blocks, costs_to_end(told, blocks, most), most)
    return finer(replace(few, settings=problem.settings))


def finer(problem: Problem, parts: Array = PARTS) -> Problem:
    """The problem with strips of a near limb that are known, others of their postures put between each two."""
    rows, poses = problem.held, problem.held_of
    first = np.flatnonzero(rows[:, HELD_LINKED])
    straight = rows[first, None, :7] + parts[:, None] * (rows[first + 1, :7] - rows[first, :7])[:, None]
    q = straight.reshape(-1, 7).copy()
    met, where = np.zeros(len(q), np.bool_), np.repeat(poses[first], len(parts))
    entries.bridge(problem.arm.family, problem.T[where], q, met)
    good = met & (np.abs(q - straight.reshape(-1, 7)).max(axis=1) < FARTHEST)
    between = np.repeat(rows[first], len(parts), axis=0)
    between[:, :7] = q
    places = np.append(np.arange(len(rows)), (first[:, None] + parts).ravel()[good])
    order = np.argsort(places, kind="stable")
    held, held_of = np.vstack([rows, between[good]])[order], np.append(poses, where[good])[order]
    return problem if np.bincount(held_of).max(initial=0) > MOST_HELD else replace(problem, held=held, held_of=held_of)
