"""A path through poses that leave a turn free, moved to the best one near it: all postures at once.

Each posture moves along what its pose leaves free, two ways or more, so that a step of Gauss and Newton is one banded
system for the whole path. Joints that would pass their limits, and axes that would leave their cone, are put on these.
Each posture is then the nearest of its pose to where the step leads.
"""

from __future__ import annotations

import numpy as np

from srs_ik.inputs.freedom import FreeAxis
from srs_ik.solve.freedom import met_batch
from srs_ik.solve.kinematics import forward_kinematics_batch, jacobian_batch
from srs_ik.solve.packed import PackedArm
from srs_ik.system.arrays import Array

ROUNDS, STEPS, HALVINGS = 12, 12, 3
"""Most rounds, steps of a round, and how often one that gains nothing is made half as long."""

ENOUGH, ENOUGH_OF_ROUND = 1e-4, 3e-4
"""A step that gains less of all than this is the last one of its round, and a round that does is the last one."""

LONGEST_MOVE = 0.3
"""Longest move of a joint in one step, rad."""

HOLDS = 3
"""So often it is asked which joints would pass their limits."""

HELD = 1e6
"""Weight of a limit that is not to be passed."""

STILL = 1e-9
"""Weight of moves that nothing asks for."""

TOO_LONG = 1e4
"""Weight of what a joint step is beyond its limit."""

JUST_WITHIN = 0.998
"""Joint steps are too long from this part of their limit on: that weight leaves a little beyond."""


def relaxed(arm: PackedArm, T: Array, free: FreeAxis, q: Array, start: Array | None, longest: Array) -> Array:
    """(n, 7) the best path near one, q (n, 7), by the sum of squared steps, that from the start included.

    `free` is what poses T leave free, `start` (7,) the posture before the first one, or None. Joint steps beyond
    `longest` (7,), rad, become shorter where that goes.
    """
    longest = JUST_WITHIN * longest
    value = _cost(q, start, longest)
    for _ in range(ROUNDS):
        before = value
        for _ in range(STEPS):
            step = _step(arm, T, free, q, start, longest)
            q, value, gain = _moved(arm, T, free, q, (start, longest, value), step, HALVINGS)
            if gain <= ENOUGH * value:
                break
        for parity in (0, 1):
            q, value, _ = _moved(arm, T, free, q, (start, longest, value), _alone(q, start, parity), 1)
        if before - value <= ENOUGH_OF_ROUND * value:
            break
    return q


def _moved(
    arm: PackedArm,
    T: Array,
    free: FreeAxis,
    q: Array,
    known: tuple[Array | None, Array, float],
    move: Array,
    times: int,
) -> tuple[Array, float, float]:
    """A path moved as far as that makes it better, half as far each time: postures, cost, and what is gained."""
    start, longest, value = known
    for _ in range(times):
        moved = _taken(arm, T, free, q, move)
        now = _cost(moved, start, longest)
        if now < value:
            return moved, now, value - now
        move = 0.5 * move
    return q, value, 0.0


def _taken(arm: PackedArm, T: Array, free: FreeAxis, q: Array, move: Array) -> Array:
    """(n, 7) the postures of poses that are nearest to where a step leads; those that do not move stay."""
    some = np.flatnonzero(np.abs(move).max(axis=1) > 0.0)
    if not len(some):
        return q
    wanted = np.clip(q[some] + move[some], arm.lower, arm.upper)
    found, met = met_batch(arm, T[some], free, wanted)
    good = met & (np.abs(found - wanted).max(axis=1) < LONGEST_MOVE)
    moved = q.copy()
    moved[some[good]] = found[good]
    return moved


def _alone(q: Array, start: Array | None, parity: int) -> Array:
    """(n, 7) the way of every second posture to the middle of its neighbours, where limits bend what all do at once."""
    before = np.vstack([q[:1] if start is None else start[None], q[:-1]])
    behind = np.vstack([q[1:], q[-1:]])
    middle = 0.5 * (before + behind)
    middle[-1] = before[-1]
    if start is None:
        middle[0] = behind[0]
    move = middle - q
    move[1 - parity :: 2] = 0.0
    return np.asarray(move)


def _cost(q: Array, start: Array | None, longest: Array) -> float:
    steps = np.diff(q, axis=0)
    over = np.maximum(np.abs(steps) - longest, 0.0)
    first = 0.0 if start is None else ((q[0] - start) ** 2).sum()
    return float((steps**2).sum() + first + TOO_LONG * (over**2).sum())


def _step(arm: PackedArm, T: Array, free: FreeAxis, q: Array, start: Array | None, longest: Array) -> Array:
    """(n, 7) how the postures move in a step."""
    ways, edge, room = ways_of(arm, T, free, q)
    n, _, m = ways.shape
    d = np.diff(q, axis=0)
    # Rows of what may not be passed: joints, and the axis at the edge of its cone; by how far each is from it.
    rows = np.concatenate([ways, edge[:, None]], axis=1)
    low = np.column_stack([arm.lower - q, np.full(n, -np.inf)])
    high = np.column_stack([arm.upper - q, room])
    weights, to = np.zeros((n, 8)), np.zeros((n, 8))
    steps, long = d, np.zeros(d.shape, np.bool_)
    x = np.zeros((n, m))
    for _ in range(HOLDS):
        more = np.abs(steps) > longest + STILL
        long |= more
        # Half the slope of the sum of squares, and half its second derivatives.
        heavy = np.where(long, 1.0 + TOO_LONG, 1.0)
        pull = d + np.where(long, TOO_LONG * (d - np.copysign(longest, steps)), 0.0)
        slope, own = np.zeros((n, 7)), np.zeros((n, 7))
        slope[1:] += pull
        slope[:-1] -= pull
        own[1:] += heavy
        own[:-1] += heavy
        if start is not None:
            slope[0] += q[0] - start
            own[0] += 1.0
        held = np.einsum("kji,kj,kjl->kil", ways, own, ways) + STILL * np.eye(m)
        held += np.einsum("kji,kj,kjl->kil", rows, weights, rows)
        next_to = -np.einsum("kji,kj,kjl->kil", ways[:-1], heavy, ways[1:])
        right = np.einsum("kji,kj->ki", rows, weights * to) - np.einsum("kji,kj->ki", ways, slope)
        x = _solved(held, next_to, right)
        move = np.einsum("kji,ki->kj", ways, x)
        reached = np.einsum("kji,ki->kj", rows, x)
        steps = d + np.diff(move, axis=0)
        over = ((reached < low - STILL) | (reached > high + STILL)) & (weights == 0.0)
        if not (over.any() or ((np.abs(steps) > longest + STILL) & ~long).any()):
            break
        weights[over], to[over] = HELD, np.where(reached < low, low, high)[over]
    part = np.abs(move).max(axis=1, initial=0.0)
    return np.asarray(move * min(1.0, LONGEST_MOVE / max(float(part.max()), LONGEST_MOVE)))


def ways_of(arm: PackedArm, T: Array, free: FreeAxis, q: Array) -> tuple[Array, Array, Array]:
    """Of each posture: (7, m) the ways its pose leaves, (m,) how the axis leans out along them, and its room, rad."""
    jacobians, tips = jacobian_batch(arm, q, 1), forward_kinematics_batch(arm, q, 1)
    is_axis, ought = tips[:, :3, :3] @ free.axis, T[:, :3, :3] @ free.axis
    kept = jacobians[:, :3]
    if free.cone == 0.0:
        # The axis keeps its direction: no turn across it.
        across = np.linalg.svd(is_axis[:, None])[2][:, 1:]
        kept = np.concatenate([kept, across @ jacobians[:, 3:]], axis=1)
    ways = np.swapaxes(np.linalg.svd(kept)[2][:, kept.shape[1] :], 1, 2)
    out = np.cross(ought, is_axis)
    sine = np.linalg.norm(out, axis=1)
    leaning = np.where(sine > STILL, 1.0 / np.maximum(sine, STILL), 0.0)[:, None] * out
    edge = np.einsum("ki,kij,kjl->kl", leaning, jacobians[:, 3:], ways)
    room = free.cone - np.arctan2(sine, np.einsum("ki,ki->k", is_axis, ought))
    return ways, edge, room if free.cone > 0.0 else np.full(len(q), np.inf)


def _solved(own: Array, next_to: Array, right: Array) -> Array:
    """(n, m) the solution of a system of blocks (n, m, m) and (n - 1, m, m) above these."""
    from scipy.linalg import solveh_banded

    n, m, _ = own.shape
    band = np.zeros((2 * m, n * m))
    for i in range(m):
        for j in range(i, m):
            band[2 * m - 1 - (j - i), j::m] = own[:, i, j]
        for j in range(m):
            band[m - 1 - j + i, m + j :: m] = next_to[:, i, j]
    return np.asarray(solveh_banded(band, right.ravel(), check_finite=False)).reshape(n, m)
