"""Postures that strips miss: where a path seems to break, Newton's method looks for what rounding took away.

Where joints lie on several limits at once, or the elbow is straight, a pose may have a single posture, or an interval
as wide as rounding, and none of it may be found. From each strip that ends, its postures are taken to the next pose.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from srs_ik.kernels.entries import path as entries
from srs_ik.kernels.layout.path import BY_CONTINUITY, INVERSE_PERIOD, PERIOD
from srs_ik.solve.path.problem import Problem
from srs_ik.solve.path.search.blocks import Block
from srs_ik.solve.path.search.singular import APART, held_rows
from srs_ik.system.arrays import Array

MOST_STARTS = 24
"""So many postures of a pose are taken to the next one at most, ..."""

MOST_OF_ALL = 4000
"""... and so many of a path."""

LOST = 0.4
"""A posture with none of the next pose closer than this part of the longest step has lost its strip."""

SPACING = 0.45
"""Farthest that a joint moves between two postures of a strip, rad."""


def bridged(problem: Problem) -> Problem:
    """The problem with postures that its strips miss; the same one if there are none."""
    found: list[Array] = []
    first, before, tried = 0, None, 0
    keys = np.arange(len(problem.T))
    reachable = problem.start
    while first < len(keys) and tried < MOST_OF_ALL:
        block = Block(problem, keys, first, False, before)
        nodes, _, _, ends = block.fill()
        for pose in range(first, first + block.count):
            a, b = ends[pose - first + 1, :2]
            there = nodes[a:b, :7]
            if problem.has_known[pose] and (pose == 0 or problem.has_known[pose - 1]):
                found.append(np.empty((0, 7)))
                reachable = there
                continue
            apart = _distances(problem, reachable, there)
            new = np.empty((0, 7))
            if pose > 0 and tried < MOST_OF_ALL and not problem.has_known[pose]:
                lost = reachable[apart.min(axis=1, initial=np.inf) > LOST * problem.settings[BY_CONTINUITY, 0]]
                starts = lost[np.unique(np.linspace(0, len(lost) - 1, min(len(lost), MOST_STARTS)).astype(int))]
                tried += len(starts)
                new = _taken(problem, pose, starts)
            found.append(new)
            near = apart.min(axis=0, initial=np.inf) < problem.settings[BY_CONTINUITY, 0] + SPACING
            reachable = np.vstack([there[near], new])
            if not len(reachable):
                reachable = there
        before, first = block.carry(), first + block.count
    held = held_rows(problem.arm, np.vstack([np.empty((0, 7)), *found]))
    if not len(held):
        return problem
    return replace(problem, held=held, held_of=np.repeat(np.arange(len(found)), [len(new) for new in found]))


def _distances(problem: Problem, a: Array, b: Array) -> Array:
    """(k, m) largest joint steps between postures (k, 7) and (m, 7)."""
    most = np.zeros((len(a), len(b)))
    for j in range(7):
        d = b[:, j] - a[:, j, None]
        if problem.settings[PERIOD, j] > 0.0:
            d -= problem.settings[PERIOD, j] * np.round(d * problem.settings[INVERSE_PERIOD, j])
        np.maximum(most, np.abs(d, out=d), out=most)
    return most


def _taken(problem: Problem, pose: int, starts: Array) -> Array:
    """The postures of a pose that are met from others nearby, each once."""
    q = starts.copy()
    met = np.zeros(len(q), np.bool_)
    poses = np.repeat(problem.T[pose : pose + 1], len(q), axis=0)
    entries.bridge(problem.arm.family, poses, q, met)
    if not met.any():
        return np.empty((0, 7))
    near = np.diag(_distances(problem, starts, q)) <= problem.settings[BY_CONTINUITY, 0]
    found = q[met & near]
    same = np.abs(found[:, None] - found).max(axis=2) <= APART
    return found[~np.tril(same, -1).any(axis=1)]
