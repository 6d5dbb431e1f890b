"""The search for a joint path: planned at some poses, filled in between, refined, and searched for again about it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from srs_ik.inputs.poses import refuse_bad_poses
from srs_ik.kernels.entries import path as entries
from srs_ik.kernels.layout.answer import ROW, ROW_ORIENTATION_ERROR, ROW_POSITION_ERROR, ROW_STATUS
from srs_ik.kernels.layout.path import BREAK
from srs_ik.solve.path_blocks import find_way
from srs_ik.solve.path_bridges import bridged
from srs_ik.solve.path_polish import FINE, improve, keep_limits
from srs_ik.solve.path_problem import JUST_ABOVE, Problem, Way, copy, too_fast, worth
from srs_ik.solve.solution import Status

if TYPE_CHECKING:
    from srs_ik.solve.packed import PackedArm

Array = NDArray[np.float64]

ROUNDS = 4
RADIUS = 0.25
"""A path is searched for again so often at most, so far around the last one, rad."""

SHORT = 32
"""A path of so many poses at most is planned at each of them, and with strips that are fine everywhere."""

FINE_POSES = 256
"""The same where a path with smaller steps is looked for."""

EVERYWHERE = 4.0
"""Farther than any joint angle from any other, whole turns left out, rad."""

LEAST_GAIN = 1e-3
"""A search that gains less, relative to all, is the last one."""


def search(problem: Problem) -> Way:
    """The best path: planned at key poses, filled in between, and refined."""
    if not (problem.limited and problem.even):
        return found(problem)
    # What is best without velocity limits often keeps them, or almost.
    way = found(replace(problem, limited=False))
    if (too_fast(problem, way) > JUST_ABOVE).any():
        keep_limits(problem, way, copy(way))
    if (too_fast(problem, way) > JUST_ABOVE).any():
        way = min(way, found(problem), key=lambda each: worth(problem, each))
    if (too_fast(problem, way) > JUST_ABOVE).any() and way.reached.all() and may_be_fine(problem):
        other = find_way(replace(problem, radius=EVERYWHERE), np.arange(len(problem.T)), False)
        improve(problem, other, FINE)
        way = min(way, other, key=lambda each: worth(problem, each))
    return way


def may_be_fine(problem: Problem) -> bool:
    """Whether strips may be fine everywhere: a short path, of an arm in closed form."""
    return len(problem.T) <= FINE_POSES and problem.work()[0] is None


def found(problem: Problem) -> Way:
    """`search`, with velocity limits among what steps cost."""
    if problem.arm.closed or problem.in_closed_form:
        return planned(problem)
    # A near limb moves almost like the exact one next to it: what is best for that one is closed on the true chain.
    way = planned(replace(problem, in_closed_form=True))
    if problem.free is not None:
        # Along the true curves, a path would leave what is free.
        close(problem, way)
        return way
    if way.cost < 0.5 * BREAK and way.reached.all() and close(problem, way):
        improve(problem, way)
        if way.cost < 0.5 * BREAK:
            return way
    return planned(problem)


def close(problem: Problem, way: Way) -> bool:
    """Take the postures of a path to their poses, on the true chain and inside the limits; whether all could be."""
    met = np.zeros(len(way.q), np.bool_)
    entries.bridge(problem.arm.family, problem.T, way.q, met, *problem.arm.work())
    way.bounds[:] = -np.inf, np.inf
    way.psi[:] = 0.0
    way.branch[~problem.has_known] = 0
    return bool(met.all())


def planned(problem: Problem) -> Way:
    """`search` on the true chain, or on the nearest exact limb."""
    arm, T = problem.arm, problem.T
    marks, verdicts = np.zeros(len(T), np.bool_), np.zeros(len(T), np.int64)
    entries.choose_keys(arm.family, T, problem.has_known, marks, verdicts)
    refuse_bad_poses(verdicts)
    if problem.free is not None:
        marks[:] = True
    fine = problem
    if len(T) <= SHORT and problem.work()[0] is None:
        marks[:] = True
        fine = replace(problem, radius=EVERYWHERE)
    while True:
        keys = np.flatnonzero(marks)
        way = find_way(fine, keys, False)
        whole = way.cost < 0.5 * BREAK and bool(way.reached[keys].all())
        missed = np.zeros(len(T), np.bool_)
        if whole:
            place = way.q, way.psi, way.branch, way.bounds, missed
            entries.fill_between(arm.family, T, keys, way.reached, problem.settings, *place, *problem.work())
            if not missed.any():
                improve(problem, way)
                return search_around(problem, way)
        if marks.all():
            break
        # Between two planned poses the path does something of its own: every pose is planned then.
        marks[:] = True
    if way.cost >= 0.5 * BREAK and problem.free is None:
        more = bridged(problem) if not problem.in_closed_form or arm.closed else problem
        again = find_way(more, keys, False) if more is not problem else way
        if again.cost < way.cost - 0.5 * BREAK:
            problem, way = more, again
    if way.cost >= 0.5 * BREAK:
        walls = way.walls
        way = find_way(problem, keys, True)
        way.walls = walls
    improve(problem, way)
    return search_around(problem, way)


def find_around(problem: Problem, way: Way, chain: NDArray[np.int64]) -> Way:
    """The best way through strips that are fine about a path, and nowhere else."""
    return find_way(replace(problem, near=way.q, radius=RADIUS), chain, False)


def search_around(problem: Problem, way: Way) -> Way:
    """The best path around one: strips are finer there, so branches change where that is best."""
    chain = np.flatnonzero(way.reached)
    for _ in range(ROUNDS):
        if problem.even and not np.diff(way.branch[chain]).any():
            break
        again = find_around(problem, way, chain)
        if not again.reached[chain].all():
            break
        improve(problem, again, FINE)
        gain = way.cost - again.cost
        if gain > 0.0:
            way = again
        if not gain > LEAST_GAIN * way.cost:
            break
    return way


def rows_of(problem: Problem, way: Way) -> Array:
    """Rows of the postures of a path; where there is none, that of the search for one pose near the one before."""
    arm, T = problem.arm, problem.T
    rows = np.full((len(T), ROW), np.nan)
    chain = np.flatnonzero(way.reached)
    entries.finish(arm.family, T, chain, way.q, way.psi, way.branch, *arm.work(), rows)
    off = chain[rows[chain, ROW_STATUS] != Status.OK]
    if len(off):
        # Rounding left them beside their poses, or beyond a limit.
        q, met = way.q[off], np.zeros(len(off), np.bool_)
        entries.bridge(arm.family, T[off], q, met, np.empty((6, 7)), np.empty((16, 9)))
        way.q[off[met]], way.branch[off[met]] = q[met], -1
        entries.finish(arm.family, T, off[met], way.q, way.psi, way.branch, *arm.work(), rows)
    for i in np.flatnonzero(~way.reached | (rows[:, ROW_STATUS] != Status.OK)).tolist():
        rows[i] = problem.solve(i, rows[i - 1, :7] if i else problem.seed)._row
    return rows


def off_pose(arm: PackedArm, pose: Array, q: Array) -> float:
    """How far a posture is off a pose, the larger of m and rad."""
    rows = np.empty((1, ROW))
    one = np.zeros(1, np.int64)
    entries.finish(arm.family, pose[None], one, q[None], np.zeros(1), one - 1, None, None, rows)
    return float(rows[0, ROW_POSITION_ERROR : ROW_ORIENTATION_ERROR + 1].max())
