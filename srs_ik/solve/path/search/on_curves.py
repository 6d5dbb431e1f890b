"""A path of a near limb in free intervals: planned on the nearest exact limb, and moved along its true curves.

Planned postures that are taken to their poses one by one lie beside one another. Moved all at once they are the best,
but leave what is free where that costs less. Those stay on the ends of their intervals, and the others move again.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.entries import path as entries
from srs_ik.kernels.layout.answer import ROW, ROW_ARM_ANGLE, ROW_BRANCH
from srs_ik.solve.path.problem import Problem, Way, copy, steps_of, worth
from srs_ik.solve.path.search.polish import improve, take
from srs_ik.system.arrays import Array

ROUNDS = 8
"""Postures are put on ends of their intervals, or let go again, so often at most."""

HALVINGS = 12
"""An end is known to one part of as many times two of the way to it."""

ON_END = 1e-7
"""An arm angle beyond the end of an interval by less than this, rad, is on it."""

TURN = 2.0 * np.pi


def improve_in_free(problem: Problem, way: Way) -> None:
    """Move the postures of a path, in place, to the best ones near them that are in free intervals.

    Where that costs less, a posture that was put on an end is let go again.
    """
    best, lowest = copy(way), worth_of(problem, way)
    held, inwards = np.zeros(len(way.q), np.bool_), np.zeros((len(way.q), 7))
    for _ in range(ROUNDS):
        before = copy(way)
        improve(replace(problem, has_known=problem.has_known | held), way)
        out = np.flatnonzero(way.reached & ~problem.has_known & ~held & ~are_free(problem, way))
        put_on_ends(problem, before.q, way, out)
        inwards[out] = before.q[out] - way.q[out]
        value = worth_of(problem, way)
        if value < lowest:
            best, lowest = copy(way), value
        loose = held & ((pull_on(problem, way) * inwards).sum(axis=1) > 0.0)
        if not (len(out) or loose.any()):
            break
        held[out] = True
        held &= ~loose
    take(way, best)


def worth_of(problem: Problem, way: Way) -> tuple[int, int, float]:
    """What is compared of paths: breaks, postures that are not free, and with as many what is to be least."""
    missing, value = worth(problem, way)
    return missing, int((way.reached & ~are_free(problem, way)).sum()), value


def put_on_ends(problem: Problem, before: Array, way: Way, out: NDArray[np.int64]) -> None:
    """Take postures of a path that have left what is free, in place, back to where they did, from those before."""
    wanted, part = copy(way), np.zeros(len(way.q))
    way.q[out] = before[out]
    for k in range(1, HALVINGS + 1):
        middle = copy(wanted)
        t = (part[out] + 0.5**k)[:, None]
        middle.q[out] = before[out] + t * (wanted.q[out] - before[out])
        q, met = middle.q[out], np.zeros(len(out), np.bool_)
        entries.bridge(problem.arm.family, problem.T[out], q, met)
        middle.q[out] = q
        good = out[met & are_free(problem, middle)[out]]
        way.q[good], part[good] = middle.q[good], part[good] + 0.5**k


def pull_on(problem: Problem, way: Way) -> Array:
    """(n, 7) whereto each posture of a path is drawn by those beside it."""
    chain, pull = np.flatnonzero(way.reached), np.zeros((len(way.q), 7))
    steps = steps_of(problem, np.vstack([problem.start, way.q[chain]]))
    steps = np.vstack([np.zeros((1 - len(problem.start), 7)), steps, np.zeros((1, 7))])
    pull[chain] = np.diff(steps, axis=0)
    return pull


def are_free(problem: Problem, way: Way) -> NDArray[np.bool_]:
    """(n,) whether postures are in free intervals, by their arm angles and branches on the true chain."""
    rows, chain = np.zeros((len(way.q), ROW)), np.flatnonzero(way.reached)
    entries.finish(problem.arm.family, problem.T, chain, way.q, way.psi, np.full(len(way.q), -1), rows)
    allowed, ends = problem.allowed()
    free = ends[:, 0] < 0
    for i in chain[~free[chain]].tolist():
        own = allowed[slice(*ends[i])]
        ahead = (rows[i, ROW_ARM_ANGLE] - own[:, 1] + ON_END) % TURN
        free[i] = bool(((own[:, 0] == rows[i, ROW_BRANCH]) & (ahead <= own[:, 2] - own[:, 1] + 2.0 * ON_END)).any())
    return free
