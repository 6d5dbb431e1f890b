"""The search for a joint path: planned at some poses, filled in between, refined, and searched for again about it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from srs_ik.inputs.poses import refuse_bad_poses
from srs_ik.kernels.entries import path as entries
from srs_ik.kernels.layout.answer import ROW, ROW_ORIENTATION_ERROR, ROW_POSITION_ERROR, ROW_STATUS
from srs_ik.kernels.layout.limb import LIMITED, SHIFT
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

STRAIGHT = 4.0
"""The elbow of a near limb is almost straight where the sine of its bend is below so many shifts of the limb."""

FAR_OFF = 0.15
"""Postures that move farther than this when they are closed on the true chain, rad, were planned on the wrong one."""

AROUND = 3
"""So many poses to both sides of one are planned as it is."""

MIXED = 4
"""Plans for both limbs at once."""

MOST_FOLLOWED = 0.6
"""With a larger part of the poses on the true chain, all are planned there."""

ABOUT_AS_GOOD = 1.02
"""On the true chain a path costs so many times what was planned at most."""

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
    if problem.free is not None:
        # Along the true curves, a path would leave what is free.
        way = planned(replace(problem, in_closed_form=True))
        close(problem, way)
        return way
    return nearly(problem) or planned(problem)


def nearly(problem: Problem) -> Way | None:
    """The path of a near limb, which moves almost like the exact one next to it: planned for that one, then closed.

    Poses whose elbow is almost straight, or whose postures move far when closed, are planned on the true chain. None
    where that does not lead to a path that is about as good as planned.
    """
    n = len(problem.T)
    marks, bends = keys_of(problem)
    followed = wider(bends <= STRAIGHT * float(problem.arm.family[LIMITED, SHIFT]))
    for _ in range(MIXED):
        if followed.mean() > MOST_FOLLOWED:
            return None
        mixed = replace(problem, followed=followed)
        if followed.any():
            way = find_way(mixed, np.flatnonzero(marks), False)
        else:
            way = planned(replace(problem, in_closed_form=True))
        if way.cost >= 0.5 * BREAK:
            return None
        if not way.reached.all():
            missed, place = np.zeros(n, np.bool_), (way.q, way.psi, way.branch, way.bounds)
            told = problem.arm.family, problem.T, np.flatnonzero(marks), way.reached, problem.settings
            entries.fill_between(*told, *place, missed, *problem.work())
            if missed.any():
                marks[:] = True
                continue
        planned_cost, before = way.cost, way.q.copy()
        met = close(problem, way)
        off = wider(~met | (np.abs(way.q - before).max(axis=1) > FAR_OFF))
        if (off & ~followed).any():
            followed |= off
            continue
        improve(problem, way)
        way = search_around(problem, way)
        return way if way.cost < ABOUT_AS_GOOD * planned_cost else None
    return None


def wider(some: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Some poses with those around them."""
    return np.convolve(some, np.ones(2 * AROUND + 1), "same") > 0.5 if len(some) > 2 * AROUND else some | some.any()


def keys_of(problem: Problem) -> tuple[NDArray[np.bool_], Array]:
    """The poses at which a path is planned, and the sines of the elbow's bend, -1 out of reach of the exact limb."""
    n = len(problem.T)
    marks, verdicts, bends = np.zeros(n, np.bool_), np.zeros(n, np.int64), np.zeros(n)
    entries.choose_keys(problem.arm.family, problem.T, problem.has_known, marks, verdicts, bends)
    refuse_bad_poses(verdicts)
    return marks, bends


def close(problem: Problem, way: Way) -> NDArray[np.bool_]:
    """Take the postures of a path to their poses, on the true chain and inside the limits; (n,) which could be."""
    met = np.zeros(len(way.q), np.bool_)
    entries.bridge(problem.arm.family, problem.T, way.q, met, *problem.arm.work())
    way.bounds[:] = -np.inf, np.inf
    way.psi[:] = 0.0
    way.branch[~problem.has_known] = 0
    return met


def planned(problem: Problem) -> Way:
    """`search` on the true chain, or on the nearest exact limb."""
    arm, T = problem.arm, problem.T
    marks, _ = keys_of(problem)
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
