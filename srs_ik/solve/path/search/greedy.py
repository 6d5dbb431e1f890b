"""A greedy path, from each posture to the nearest one of the next pose, where a path breaks or turns for nothing.

At poses with a singular shoulder or wrist, strips may miss the posture that a path with short steps takes. The path
found swings joints that the tip does not ask to move, by which it is known. The nearest posture of a pose is found in
closed form.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.entries.kinematics import jacobian_range
from srs_ik.kernels.entries.pose import solve as nearest
from srs_ik.kernels.layout.answer import OK, ROW, ROW_STATUS
from srs_ik.kernels.layout.limb import LIMITED, SHIFT
from srs_ik.kernels.layout.path import BY_CONTINUITY
from srs_ik.solve.path.problem import JUST_ABOVE, ROUNDED, Problem, Stopped, Way, steps_of, worth
from srs_ik.solve.path.search.around import RADIUS
from srs_ik.solve.path.search.blocks import find_way
from srs_ik.solve.path.search.missed import turned_on_the_spot
from srs_ik.solve.path.search.polish import FINE, improve
from srs_ik.solve.path.search.singular import held_rows, two_turns
from srs_ik.system.arrays import Array

SWINGS = 2.0
"""Of ordinary best paths squared steps are less than so many times what the tip asks for."""

DAMPED = 0.01
"""A direction in which the tip moves by less than this for a joint's rad, m or rad, asks for no step."""

MIDDLES = (np.arange(8) + 0.5) / 8.0
"""Steps are looked at where the sum of squares has come to these parts."""

ROOM = 2.0
"""Squared steps of a greedy path may come to so many times those of the path, for they are made less."""


def greedy_where_it_swings(problem: Problem, way: Way) -> Way:
    """A path, or a better one about a greedy one, while joints turn by far more than the tip asks for."""
    forth = np.arange(len(way.q))
    for order in (forth, forth[::-1]):
        q = greedy(problem, way, order) if may_swing(problem, way) else None
        if q is not None:
            other = turned_on_the_spot(problem, about(problem, evened(problem, q)))
            way = min(way, other, key=lambda each: worth(problem, each))
    return way


def may_swing(problem: Problem, way: Way) -> bool:
    """Whether a path breaks, its squared steps are far above what the tip asks for, or two joints turn on the spot."""
    is_exact = problem.arm.family[LIMITED, SHIFT] < ROUNDED and not problem.in_closed_form
    if problem.free is not None or not is_exact or problem.has_known.all():
        return False
    breaks = worth(problem, way)[0] > 0
    return breaks or share_asked(problem, way.q) * SWINGS < 1.0 or bool(two_turns(problem, way).any())


def share_asked(problem: Problem, q: Array) -> float:
    """About which part of the squared steps of a path the tip asks for at least.

    The steps that are looked at are as many for the same part of the sum, wherever that is.
    """
    steps = steps_of(problem, q)
    squares = (steps**2).sum(axis=1)
    sums = np.cumsum(squares)
    if not len(sums) or not sums[-1] > 0.0:
        return 1.0
    some = np.searchsorted(sums, sums[-1] * MIDDLES)
    middles, T, after = q[some] + 0.5 * steps[some], problem.T[some], problem.T[some + 1]
    J = np.empty((len(some), 6, 7))
    jacobian_range(problem.arm.family, middles, 0, len(some), J)
    R = after[:, :3, :3] @ T[:, :3, :3].transpose(0, 2, 1)
    turned = 0.5 * (R[:, [2, 0, 1], [1, 2, 0]] - R[:, [1, 2, 0], [2, 0, 1]])
    moved = np.hstack([after[:, :3, 3] - T[:, :3, 3], turned])
    back = J.transpose(0, 2, 1)
    asked = back @ np.linalg.solve(J @ back + DAMPED**2 * np.eye(6), moved[..., None])
    return float(np.minimum((asked[..., 0] ** 2).sum(axis=1) / squares[some], 1.0).mean())


def greedy(problem: Problem, way: Way, order: NDArray[np.int64]) -> Array | None:
    """(n, 7) the nearest posture of each pose to that before it, in an order that begins with the first of a path.

    None where such steps come to far more than those of the path, if that has no break, or one is a break.
    """
    q, most = way.q.copy(), ROOM * float((steps_of(problem, way.q) ** 2).sum())
    if worth(problem, way)[0] > 0:
        most = np.inf
    if order[0] == 0 and problem.seed is not None and not put_nearest(problem, q, 0, problem.seed):
        return None
    for before, i in zip(order[:-1].tolist(), order[1:].tolist(), strict=True):
        if not put_nearest(problem, q, i, q[before]):
            return None
        step = steps_of(problem, q[[before, i]])[0]
        most -= float(step @ step)
        if most <= 0.0 or (np.abs(step) > JUST_ABOVE * problem.settings[BY_CONTINUITY]).any():
            return None
    return q


def evened(problem: Problem, q: Array) -> Array:
    """A path (n, 7), each posture the nearest one to the middle of those beside it, which makes steps the least."""
    q = q.copy()
    for i in range(len(q)):
        beside = q[max(i - 1, 0) : i + 2 : 2] if i else np.vstack([problem.start, q[1:2]])
        if len(beside):
            put_nearest(problem, q, i, beside[0] + steps_of(problem, beside).sum(axis=0) / len(beside))
    return q


def put_nearest(problem: Problem, q: Array, i: int, seed: Array) -> bool:
    """Write the posture of a pose that is given, or the nearest one to a seed; whether there is one."""
    if problem.stop[0]:
        raise Stopped
    if problem.has_known[i]:
        q[i] = problem.known[i]
        return True
    row = np.empty(ROW)
    nearest(problem.arm.family, problem.T[i], -1, np.ascontiguousarray(seed), True, True, row)
    met = bool(row[ROW_STATUS] == OK)
    if met:
        q[i] = row[:7]
    return met


def about(problem: Problem, q: Array) -> Way:
    """The best path about one (n, 7), whose postures are put to those of strips."""
    n = np.arange(len(q))
    local = replace(problem, held=held_rows(problem.arm, q), held_of=n, near=q, radius=RADIUS)
    way = find_way(local, n, False)
    improve(problem, way, FINE)
    return way
