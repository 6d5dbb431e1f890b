"""A path of a near limb moved to the best one near it along the curves of its true chain, within free intervals.

Moved all at once, postures leave what is free where that costs less. Those are put on the ends of what is free, and the
others move again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.entries import path as entries
from srs_ik.kernels.layout.answer import ROW, ROW_ARM_ANGLE, ROW_BRANCH
from srs_ik.solve.path.problem import Problem, Way, copy, steps_of, take, worth
from srs_ik.system.arrays import Array

Numbers = NDArray[np.int64]

ROUNDS = 8
"""Postures are put on ends of their intervals, or let go again, so often at most."""

HALVINGS = 12
"""An end is known to one part of as many times two of the way to it."""

ON_END = 1e-7
"""An arm angle beyond the end of an interval by less than this, rad, is on it."""

TURN = 2.0 * np.pi


def move_in_free(problem: Problem, way: Way, move: Callable[[Problem, Way], None]) -> None:
    """Move the postures of a path, in place, to the best ones near them that are in free intervals.

    `move` moves all at once, those that are given excepted. Where that costs less, a posture that was put on an end is
    let go again.
    """
    best, lowest = copy(way), worth_of(problem, way)
    held, inwards = np.zeros(len(way.q), np.bool_), np.zeros((len(way.q), 7))
    for _ in range(ROUNDS):
        before = copy(way)
        move(replace(problem, has_known=problem.has_known | held), way)
        out = np.flatnonzero(way.reached & ~problem.has_known & ~held & ~are_free(problem, way))
        way.q[out] = last_free(problem, out, before.q[out], way.q[out])
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
    """What is compared of paths: breaks, postures that are not free, and with as many what is to be least.

    Moved along its true curves, a near arm alone may leave what is free.
    """
    missing, value = worth(problem, way)
    if problem.free is None or not problem.is_near:
        return missing, 0, value
    return missing, int((way.reached & ~are_free(problem, way)).sum()), value


def last_free(problem: Problem, poses: Numbers, inside: Array, outside: Array) -> Array:
    """(k, 7) on the way from postures of poses to others that are not free, the last ones that are."""
    found, part = inside.copy(), np.zeros((len(poses), 1))
    for k in range(1, HALVINGS + 1):
        q, met = inside + (part + 0.5**k) * (outside - inside), np.zeros(len(poses), np.bool_)
        entries.bridge(problem.arm.family, problem.T[poses], q, met)
        good = met & (which_free(problem, poses, *places_of(problem, poses, q)) >= 0)
        found[good] = q[good]
        part[good] += 0.5**k
    return found


def pull_on(problem: Problem, way: Way) -> Array:
    """(n, 7) whereto each posture of a path is drawn by those beside it."""
    chain, pull = np.flatnonzero(way.reached), np.zeros((len(way.q), 7))
    steps = steps_of(problem, np.vstack([problem.start, way.q[chain]]))
    steps = np.vstack([np.zeros((1 - len(problem.start), 7)), steps, np.zeros((1, 7))])
    pull[chain] = np.diff(steps, axis=0)
    return pull


def are_free(problem: Problem, way: Way) -> NDArray[np.bool_]:
    """(n,) whether postures of a path are in free intervals of their poses."""
    poses = np.arange(len(way.q))
    return which_free(problem, poses, *places_of(problem, poses, way.q)) >= 0


def places_of(problem: Problem, poses: Numbers, q: Array) -> tuple[Array, Numbers]:
    """(k,) arm angles and branches of postures (k, 7) of some poses on the true chain."""
    rows, chain, none = np.zeros((len(q), ROW)), np.arange(len(q)), np.full(len(q), -1)
    q = np.ascontiguousarray(q)
    entries.finish(problem.arm.family, problem.T[poses], chain, q, np.zeros(len(q)), none, rows)
    return rows[:, ROW_ARM_ANGLE], rows[:, ROW_BRANCH].astype(np.int64)


def which_free(problem: Problem, poses: Numbers, psi: Array, branch: Numbers) -> Numbers:
    """(k,) in which free interval of its pose an arm angle of a branch is; -1 for none."""
    own = np.full(len(poses), -1)
    allowed, ends = problem.allowed()
    order = np.argsort(poses, kind="stable")
    first = np.searchsorted(poses[order], np.arange(len(problem.T) + 1))
    for i in np.unique(poses).tolist():
        each = order[first[i] : first[i + 1]]
        if not len(ends) or ends[i, 0] < 0:
            own[each] = 0
            continue
        some = allowed[slice(*ends[i])]
        ahead = (psi[each, None] - some[:, 1] + ON_END) % TURN
        inside = (some[:, 0] == branch[each, None]) & (ahead <= some[:, 2] - some[:, 1] + 2.0 * ON_END)
        if len(some):
            own[each] = np.where(inside.any(axis=1), inside.argmax(axis=1), -1)
    return own
