"""When a joint path passes its poses, at the least time within limits of velocity and acceleration, from rest to rest.

Along a path of given shape the squared speed x of its parameter is what is looked for, by reachability (Pham and Pham
2018): backwards, the largest x at each pose from which the path can still come to rest; then forwards, as fast as that
allows. Limits hold for joint velocities between poses and their changes at poses, as `velocities` and `accelerations`
measure them. All times are stretched by what the derivatives of the path by its parameter miss of these.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from srs_ik.system.arrays import Array

STILL = 1e-12
"""Joint steps and speeds below this are none."""


LITTLE = 0.5
"""Limits that are left unused are raised by one over this at most, from round to round."""

ROUNDS = 6
"""How often they are."""


def passing_times(steps: Array, velocity: Array, acceleration: Array, stands: NDArray[np.bool_] | None = None) -> Array:
    """(N,) times at which a path of joint steps (N - 1, 7) passes its poses, s, the first one at 0.

    Largest joint velocities (7,) and accelerations (7,) are in rad/s and rad/s^2. Before and after steps on which the
    tip `stands` (N - 1,), it rests.
    """
    if stands is None or not stands.any():
        return _from_rest_to_rest(steps, velocity, acceleration)
    rests = np.flatnonzero(np.append(stands, True) | np.append(True, stands))
    pieces = [_from_rest_to_rest(steps[a:b], velocity, acceleration) for a, b in pairwise(rests)]
    return np.append(0.0, np.cumsum(np.concatenate([np.diff(piece) for piece in pieces])))


def _from_rest_to_rest(steps: Array, velocity: Array, acceleration: Array) -> Array:
    if not len(steps) or np.abs(steps).max() < STILL:
        return np.zeros(len(steps) + 1)
    eased = np.ones((len(steps) + 1, 2))
    best: Array | None = None
    for _ in range(ROUNDS):
        times = _durations(steps, velocity * eased[:, :1], acceleration * eased[:, 1:])
        fast, hard = _shares(steps, times, velocity, acceleration)
        stretched = times * max(fast.max(), np.sqrt(hard.max()))
        if best is None or stretched.sum() < best.sum():
            best = stretched
        # Where limits are passed, or left unused next to where they were, they are set anew.
        eased = np.minimum(eased / np.maximum(np.stack([fast, hard], axis=1), LITTLE), 1.0)
    assert best is not None
    return np.append(0.0, np.cumsum(best))


def _durations(steps: Array, velocity: Array, acceleration: Array) -> Array:
    """(N - 1,) how long steps take by limits (N, 7) at each pose."""
    slope, bend = _derivatives(steps)
    speed = np.sqrt(_fastest(slope, bend, velocity, acceleration))
    between = speed[:-1] + speed[1:]
    moves = np.abs(steps).max(axis=1) >= STILL
    # A step from rest to rest takes what it takes by itself; where the path stands still nothing takes time.
    alone = np.maximum(np.abs(steps) / velocity[:-1], np.sqrt(2.0 * np.abs(steps) / acceleration[:-1])).max(axis=1)
    return np.where(moves, np.where(between > STILL, 2.0 / np.maximum(between, STILL), alone), 0.0)


def velocities(steps: Array, durations: Array) -> Array:
    """(N - 1, 7) joint velocities between poses, rad/s; zero where nothing moves."""
    moves = durations > 0.0
    return np.where(moves[:, None], steps, 0.0) / np.where(moves, durations, 1.0)[:, None]


def accelerations(steps: Array, durations: Array) -> Array:
    """(N, 7) joint accelerations at poses, rad/s^2: from rest, from step to step, to rest."""
    moves = durations > 0.0
    v = np.vstack([np.zeros(7), velocities(steps, durations)[moves], np.zeros(7)])
    h = np.concatenate([[0.0], durations[moves], [0.0]])
    return np.diff(v, axis=0) / (0.5 * (h[:-1] + h[1:]))[:, None]


def _derivatives(steps: Array) -> tuple[Array, Array]:
    """(N, 7) first and second derivatives of a path by the number of its pose."""
    slope = np.vstack([steps[:1], 0.5 * (steps[1:] + steps[:-1]), steps[-1:]])
    bend = np.vstack([np.zeros((1, 7)), np.diff(steps, axis=0), np.zeros((1, 7))])
    return slope, bend


def _fastest(slope: Array, bend: Array, velocity: Array, acceleration: Array) -> Array:
    """(N,) squared speeds of the parameter, zero at both ends."""
    n = len(slope)
    moving = np.abs(slope) > STILL
    bent = np.abs(bend) > STILL
    by_velocity = np.where(moving, velocity / np.where(moving, np.abs(slope), 1.0), np.inf) ** 2
    by_bend = np.where(bent & ~moving, acceleration / np.where(bent, np.abs(bend), 1.0), np.inf)
    most = np.minimum(by_velocity.min(axis=1), by_bend.min(axis=1))
    # Bounds of the parameter's acceleration u by each joint, from -side - lean x to side - lean x.
    side = np.where(moving, acceleration / np.where(moving, np.abs(slope), 1.0), np.inf)
    lean = np.where(moving, bend / np.where(moving, slope, 1.0), 0.0)
    reachable = np.zeros(n)
    for i in range(n - 2, -1, -1):
        reachable[i] = _largest(side[i], lean[i], most[i], reachable[i + 1])
    x = np.zeros(n)
    for i in range(n - 1):
        u = (side[i] - lean[i] * x[i]).min()
        x[i + 1] = min(max(x[i] + 2.0 * u, 0.0), reachable[i + 1])
    return x


def _largest(side: Array, lean: Array, most: float, next_most: float) -> float:
    """The largest x up to `most` from which some u leads to x + 2 u from 0 to `next_most`."""
    low = np.append(-side, 0.0), np.append(-lean, -0.5)
    high = np.append(side, 0.5 * next_most), np.append(-lean, -0.5)
    apart = high[0][None] - low[0][:, None]
    rate = low[1][:, None] - high[1][None]
    rising = rate > STILL
    ends = np.where(rising & np.isfinite(apart), apart / np.where(rising, rate, 1.0), np.inf)
    return float(max(min(most, ends.min(), 1e12), 0.0))


def _shares(steps: Array, durations: Array, velocity: Array, acceleration: Array) -> tuple[Array, Array]:
    """(N,) which shares of the limits of velocity and acceleration are used about each pose."""
    by_step = (np.abs(velocities(steps, durations)) / velocity).max(axis=1)
    fast = np.maximum(np.append(by_step, 0.0), np.append(0.0, by_step))
    hard = np.zeros(len(steps) + 1)
    moves = durations > 0.0
    hard[np.append(np.flatnonzero(moves), len(steps))] = (np.abs(accelerations(steps, durations)) / acceleration).max(
        axis=1
    )
    return fast, hard
