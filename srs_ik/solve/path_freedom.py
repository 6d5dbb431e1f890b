"""Joint paths through poses that leave a turn free: the turns are chosen first, on samples, and then the path.

At some poses postures are looked at for sampled turns, and the chain of them with the least joint steps is found; its
turns, and those between them, make whole poses of all, through which a path is found as ever. Then every posture in
turn goes where its turn is best for its neighbours.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from srs_ik.inputs.freedom import FreeAxis
from srs_ik.solve.freedom import solve, solve_batch
from srs_ik.solve.pose import solve_all

if TYPE_CHECKING:
    from srs_ik.solve.packed import PackedArm
    from srs_ik.solve.path import PathSolution

Array = NDArray[np.float64]

KEYS = 24
"""Poses at most at which turns are sampled."""

ROLLS = 16
MOST_TURNS = 48
"""Rolls that are sampled, and rotations at most where the axis may lean."""

SWEEPS = 40
ENOUGH = 1e-3
"""How often postures go where they are best for their neighbours; a sweep that gains less than this is the last."""

SAME = 1e-6
"""A posture of a path is the nearest one to itself, rad."""

TOO_LONG = 1e3
"""Cost of a joint step that is no continuous one, in squared rad."""


def solve_free_path(
    arm: PackedArm,
    T: Array,
    free: FreeAxis,
    find: Callable[[Array], PathSolution],
    limits: tuple[Array | None, Array],
) -> PathSolution:
    """A path through poses that leave a turn free.

    Args:
        arm: the arm.
        T: (n, 4, 4) poses.
        free: what they leave free.
        find: a path through whole poses.
        limits: (7,) posture to start from, or None; (7,) longest joint steps, rad.
    """
    start, longest = limits
    whole = whole_poses(arm, T, free, start, longest)
    ways = [find(each) for each in (T, whole) if each is not None]
    best = min(ways, key=lambda way: (len(way.breaks), not way, _squares(way.q, start)))
    if not best:
        return best
    most = np.maximum(longest, np.abs(best.steps).max(axis=0, initial=0.0))
    q = best.q
    ways_on = [followed(arm, T, free, best.q[0]), followed(arm, T[::-1], free, best.q[-1])[::-1], best.q]
    if start is not None:
        # The first pose as the arm may meet it from where it is.
        nearest = solve(arm, T[0], free, start, True)
        ways_on += [followed(arm, T, free, nearest.q)] if nearest else []
    for other in ways_on:
        if np.isfinite(other).all():
            other = relaxed(arm, T, free, other, start is not None)
            if (np.abs(np.diff(other, axis=0)) <= most).all() and _squares(other, start) < _squares(q, start):
                q = other
    found = solve_batch(arm, T, free, q, True, 1)
    if not found.ok.all() or np.abs(found.q - q).max() > SAME:
        return best
    return type(best)(found._rows, arm.joint_names, np.diff(found.q, axis=0), [], arm.elbow)


def whole_poses(arm: PackedArm, T: Array, free: FreeAxis, start: Array | None, longest: Array) -> Array | None:
    """(n, 4, 4) poses with the turns of a chain of postures that is as short as sampled ones are; None without one."""
    keys = np.unique(np.linspace(0, len(T) - 1, min(KEYS, len(T))).round().astype(int))
    turns = free.sampled(ROLLS if free.cone == 0.0 else MOST_TURNS)
    postures, owners = [], []
    for key in keys.tolist():
        found = [solve_all(arm, _turned(T[key], turn), None, True) for turn in turns]
        postures.append(np.concatenate([s.q for s in found if len(s)] or [np.empty((0, 7))]))
        owners.append(np.repeat(np.arange(len(turns)), [len(s) for s in found]))
        if not len(postures[-1]):
            return None
    chosen = _chain(postures, start, longest * np.diff(keys, prepend=0).clip(1)[:, None])
    at_keys = [turns[owner[i]] for owner, i in zip(owners, chosen, strict=True)]
    return _between(T, keys, np.array(at_keys))


def followed(arm: PackedArm, T: Array, free: FreeAxis, first: Array) -> Array:
    """(n, 7) a path from a posture of its first pose, each next one the nearest; NaN from where there is none."""
    q = np.full((len(T), 7), np.nan)
    q[0] = first
    for k in range(1, len(T)):
        found = solve(arm, T[k], free, q[k - 1], True)
        if not found:
            break
        q[k] = found.q
    return q


def relaxed(arm: PackedArm, T: Array, free: FreeAxis, q: Array, fixed_first: bool) -> Array:
    """(n, 7) the same path with every posture where it is best for its neighbours, the sum of squared steps falling."""
    q = q.copy()
    value = _squares(q)
    for _ in range(SWEEPS):
        before = q.copy()
        for parity in (0, 1):
            some = np.arange(parity, len(q), 2)
            some = some[(some > 0) | (not fixed_first)]
            if len(some):
                left, right = q[np.maximum(some - 1, 0)], q[np.minimum(some + 1, len(q) - 1)]
                left = np.where((some == 0)[:, None], right, left)
                right = np.where((some == len(q) - 1)[:, None], left, right)
                found = solve_batch(arm, T[some], free, np.clip(0.5 * (left + right), arm.lower, arm.upper), True, 1)
                better = found.ok & (np.abs(found.q - q[some]).max(axis=1) < 0.3)
                q[some[better]] = found.q[better]
        now = _squares(q)
        if not now < value:
            return before
        if value - now < ENOUGH * value:
            break
        value = now
    return q


def _turned(T: Array, turn: Array) -> Array:
    turned = T.copy()
    turned[:3, :3] = T[:3, :3] @ turn
    return turned


def _squares(q: Array, start: Array | None = None) -> float:
    return float((np.diff(q if start is None else np.vstack([start, q]), axis=0) ** 2).sum())


def _chain(postures: list[Array], start: Array | None, longest: Array) -> list[int]:
    """Indices of the postures, one a key, with the least sum of squared steps."""
    cost = np.zeros(len(postures[0])) if start is None else ((postures[0] - start) ** 2).sum(axis=1)
    back: list[NDArray[np.int64]] = []
    for before, here, limit in zip(postures, postures[1:], longest[1:], strict=False):
        steps = here[:, None] - before[None]
        price = (steps**2).sum(axis=2) + TOO_LONG * np.maximum(np.abs(steps) - limit, 0.0).max(axis=2)
        total = price + cost
        back.append(total.argmin(axis=1))
        cost = total.min(axis=1)
    chosen = [int(cost.argmin())]
    for step in reversed(back):
        chosen.append(int(step[chosen[-1]]))
    return chosen[::-1]


def _between(T: Array, keys: NDArray[np.int64], turns: Array) -> Array:
    """Poses whose turns go evenly from those of a key to those of the next one."""
    import pinocchio as pin

    whole = T.copy()
    for first, last, a, b in zip(keys, keys[1:], turns, turns[1:], strict=False):
        way = pin.log3(a.T @ b)
        for k in range(first, last + 1):
            whole[k, :3, :3] = T[k, :3, :3] @ a @ pin.exp3(way * (k - first) / (last - first))
    if len(keys) == 1:
        whole[:, :3, :3] = T[:, :3, :3] @ turns[0]
    return whole
