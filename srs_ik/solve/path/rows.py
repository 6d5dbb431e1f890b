"""The answers of a path: rows of its postures, each taken to its pose once more."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from srs_ik.kernels.entries import path as entries
from srs_ik.kernels.layout.answer import ROW, ROW_ORIENTATION_ERROR, ROW_POSITION_ERROR, ROW_STATUS
from srs_ik.kernels.layout.path import BY_CONTINUITY
from srs_ik.solve.path.problem import Problem, Way, limbs_of, steps_of
from srs_ik.solve.solution import Status
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.packed import PackedArm

ON_POSE = 1e-10
"""A posture that is farther off its pose than this, m and rad, is taken to it once more."""


def rows_of(problem: Problem, way: Way) -> Array:
    """Rows of the postures of a path; where there is none, that of the search for one pose near the one before."""
    arm, T = problem.arm, problem.T
    rows = np.full((len(T), ROW), np.nan)
    chain = np.flatnonzero(way.reached)
    entries.finish(arm.family, T, chain, way.q, way.psi, way.branch, rows)
    errors = rows[chain, ROW_POSITION_ERROR : ROW_ORIENTATION_ERROR + 1].max(axis=1, initial=0.0)
    off = chain[(rows[chain, ROW_STATUS] != Status.OK) | (errors > ON_POSE)]
    if len(off):
        # Rounding left them beside their poses, or limits with room for it did.
        q, met = way.q[off], np.zeros(len(off), np.bool_)
        entries.bridge(arm.family, T[off], q, met)
        for k in np.flatnonzero(~met).tolist():
            # Where Newton's method turns joints too little: at a singular posture with others on limits.
            q[k], met[k] = nearest_of_all(problem, int(off[k]), way.q[off[k]])
        way.q[off[met]], way.branch[off[met]] = q[met], -1
        entries.finish(arm.family, T, off[met], way.q, way.psi, way.branch, rows)
    on_pose = rows[:, ROW_STATUS] == Status.OK
    way.q[on_pose] = rows[on_pose, :7]
    for i in np.flatnonzero(~way.reached | ~on_pose).tolist():
        rows[i] = problem.solve(i, rows[i - 1, :7] if i else problem.seed)._row
    return rows


def joint_steps(rows: Array) -> Array:
    """(n - 1, 7) the joint steps of a path of these rows, those over poses that are not reached in even parts.

    Before the first pose that is reached, and behind the last one, there are none.
    """
    met = np.flatnonzero(rows[:, ROW_STATUS] == Status.OK)
    steps = np.zeros((len(rows) - 1, 7))
    if len(met):
        passed = np.diff(met)
        parts = np.diff(rows[met, :7], axis=0) / passed[:, None]
        steps[met[0] : met[-1]] = np.repeat(parts, passed, axis=0)
    return steps


def nearest_of_all(problem: Problem, i: int, near: Array) -> tuple[Array, bool]:
    """The posture of a pose nearest to another one, of intervals narrow as a point too; is it a step away at most?"""
    found = [each.q for each in (problem.solve(i, near), *problem.solve_all(i)) if each]
    if not found:
        return near, False
    steps = [np.abs(steps_of(problem, np.vstack([near, q]))).max() for q in found]
    k = int(np.argmin(steps))
    return found[k], bool(steps[k] <= problem.settings[BY_CONTINUITY, 0])


def off_poses(arm: PackedArm, poses: Array, q: Array) -> Array:
    """(k,) how far postures (k, 7) are off poses (k, 4, 4), the larger of m and rad."""
    rows, chain = np.empty((len(q), ROW)), np.arange(len(q))
    entries.finish(limbs_of(arm, True)[0], poses, chain, q, np.zeros(len(q)), np.full(len(q), -1), rows)
    return np.asarray(rows[:, ROW_POSITION_ERROR : ROW_ORIENTATION_ERROR + 1].max(axis=1, initial=0.0))


def on_straight_lines(problem: Problem) -> Problem:
    """The problem with the postures known between two given ones if these are on the straight line from one to another.

    No path is shorter, and none has smaller steps. Where several joints turn on the spot at once, that line is one of
    many that a strip does not hold.
    """
    given = np.flatnonzero(problem.has_known)
    q, has_known = problem.known.copy(), problem.has_known.copy()
    most = problem.settings[: BY_CONTINUITY + 1].min(axis=0)
    for first, last in pairwise(given if problem.seed is None else np.append(-1, given)):
        begin = problem.start[0] if first < 0 else q[first]
        step = steps_of(problem, np.vstack([begin, q[last]]))[0] / (last - first)
        line = begin + step * np.arange(1, last - first)[:, None]
        between = np.arange(first + 1, last)
        if not len(line) or (np.abs(step) > most).any():
            continue
        inside = (line >= problem.arm.lower) & (line <= problem.arm.upper)
        if inside.all() and (off_poses(problem.arm, problem.T[between], line) < ON_POSE).all():
            q[between], has_known[between] = line, True
    return replace(problem, known=q, has_known=has_known)
