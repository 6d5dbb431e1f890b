"""Postures that strips miss: where a path seems to break, Newton's method looks for what rounding took away.

Where joints lie on several limits at once, or the elbow is straight, a pose may have a single posture, or an interval
as wide as rounding, and none of it may be found. From each strip that ends, its postures are taken to the next pose.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.entries import path as entries
from srs_ik.kernels.entries.kinematics import configuration_arm_angle
from srs_ik.kernels.layout.limb import LIMITED, PHASE, SHOULDER, STRAIGHT, WRIST
from srs_ik.kernels.layout.path import BY_CONTINUITY, HELD, HELD_BRANCH, HELD_PSI, INVERSE_PERIOD, PERIOD
from srs_ik.solve.path.problem import Problem, Way
from srs_ik.solve.path.search.blocks import Block
from srs_ik.solve.pose import solve_all
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.packed import PackedArm

MOST_STARTS = 24
"""So many postures of a pose are taken to the next one at most, ..."""

MOST_OF_ALL = 4000
"""... and so many of a path."""

LOST = 0.4
"""A posture with none of the next pose closer than this part of the longest step has lost its strip."""

SPACING = 0.45
"""Farthest that a joint moves between two postures of a strip, rad."""

ALIGNED = 1e-7
"""Sine of a middle angle below which two joints turn about one axis."""

APART = 1e-4
"""Postures closer than this, rad, are one."""


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
    held = _rows(problem.arm, np.vstack([np.empty((0, 7)), *found]))
    if not len(held):
        return problem
    return replace(problem, held=held, held_of=np.repeat(np.arange(len(found)), [len(new) for new in found]))


def flat_turns(problem: Problem, way: Way) -> NDArray[np.bool_]:
    """(n,) where a straight elbow and either the shoulder or the wrist may turn on the spot, so that both may."""
    arm, P = problem.arm, problem.arm.family[LIMITED]
    if not arm.closed or problem.free is not None:
        return np.zeros(len(way.q), np.bool_)
    aligned = np.abs(np.sin(way.q[:, [1, 3, 5]] - P[[SHOULDER + PHASE, STRAIGHT, WRIST + PHASE]])) < ALIGNED
    return aligned[:, 1] & (aligned[:, 0] ^ aligned[:, 2]) & way.reached & ~problem.has_known


def with_turns(problem: Problem, way: Way, flat: NDArray[np.bool_], angles: Array) -> Problem:
    """The problem with postures at arm angles (k,) from those of a path, of poses that a strip holds a line of alone.

    There, postures have two freedoms. Each posture brings the turn of its shoulder or wrist along, as every held one.
    """
    rows, poses = [], []
    for i in np.flatnonzero(flat):
        for angle in angles:
            found = solve_all(problem.arm, problem.T[i], float(way.psi[i] + angle), True)
            same = [one for one in found if np.abs(one.q[[1, 3, 5]] - way.q[i, [1, 3, 5]]).max() < APART]
            rows += [one.q for one in same[:1]]
            poses += [i] * len(same[:1])
    if not rows:
        return problem
    return replace(problem, held=_rows(problem.arm, np.array(rows)), held_of=np.array(poses))


def _rows(arm: PackedArm, postures: Array) -> Array:
    """(h, HELD) postures; singular ones, whose joints may turn, with their arm angles and branches."""
    rows = np.zeros((len(postures), HELD))
    rows[:, :HELD_PSI], rows[:, HELD_BRANCH] = postures, -1.0
    P = arm.family[LIMITED]
    middles = postures[:, [1, 5]] - P[[SHOULDER + PHASE, WRIST + PHASE]]
    for i in np.flatnonzero((np.abs(np.sin(middles)) < ALIGNED).any(axis=1) & arm.closed):
        rows[i, HELD_PSI : HELD_BRANCH + 1] = configuration_arm_angle(arm.family, postures[i])
    return rows


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
