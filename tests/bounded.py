"""How well a tracker follows a target that can be followed, by what the limits imply for any motion whatever.

All is reckoned from where the tracker's own joints are, by two computations that share no code with it:

- *Nobody could*: by its limits, each joint is within an interval after a time. Where no posture of the target lies
  within the seven intervals, no motion within the limits is on the target then, whatever it knows.
- *Somebody could*: linear programmes look for accelerations of the joints that keep the tip on the target, whose future
  they know. What they find is a motion, tested sample by sample, so that a target that is said to have been within
  reach of the limits was so.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from motions import joint_motion, minimum_jerk
from scipy import sparse
from scipy.interpolate import CubicSpline
from scipy.optimize import linprog
from tracked import BEYOND, EVERY, GONE_FOR, LOST, NEAR_TARGET, SECONDS, box_after, velocities, ways_to

KINDS = ("joints", "limits", "singular")
"""Motions whose joint angles are known."""

PAUSE = 0.5
"""Seconds in which a target comes to rest, rests, and in which it goes on again."""

JUMP = 0.1
"""How far joints jump, rad, standard deviation."""

JITTER = 5e-4
"""Of the joint angles behind a pose that is given, rad, standard deviation."""

LONG = 10
"""A target that is gone for so many samples may be anywhere."""

ASK_AGAIN = 25
"""Periods between two permissions to reconfigure."""

BEFORE, FORESEEN, AFTER = 0.1, 0.2, 0.1
"""A motion that stays on its target begins so many seconds before the tracker leaves it, or those with more foresight,
and stays so long after."""

BLOCK = 5
LOOKED_AT = (2, 4, 5)
"""Periods of one acceleration of such a motion, and those of them in which errors are looked at."""

FOLLOWED = (1e-4, 1e-3)
"""It is on the target to a tenth of what counts for a tracker, m and rad: corners are not to be cut."""

ROUNDS, STEP = 12, 0.3
"""Linear programmes one after the other, and how far a joint may go from one to the next, rad, at first."""

BETWEEN = 0.05
"""Postures between those of a grid of arm angles, 2 degrees apart, are nearer by no more than this, rad."""

SPARE = 1e-6
"""Share of the limits that linear programmes leave, for their rounding."""

Bounds = tuple[np.ndarray, np.ndarray]


@dataclass
class Known:
    """A target's joint angles, one row a period, and what comes of them: none where lost is true."""

    q: np.ndarray
    given: np.ndarray
    lost: np.ndarray
    shaken: bool


def known_motion(arm: Any, seed: int, dt: float) -> Known:
    """Sines in all joints, that pause, jump there and back, and are lost; those of odd seeds with jitter."""
    rng = np.random.default_rng(seed + 40_000_000)
    n = round(SECONDS / dt)
    t = dt * np.arange(-1, n)
    q = joint_motion(arm, np.random.default_rng(seed), n, dt, KINDS[seed % len(KINDS)], 0.5, 0.5)
    q = np.vstack([q[:1], q])
    begins = rng.uniform(0.1, 0.5) * SECONDS
    pace = 1.0 - minimum_jerk((t - begins) / PAUSE) + minimum_jerk((t - begins) / PAUSE - 2.0)
    q = CubicSpline(t, q)(np.concatenate([[t[0]], t[0] + np.cumsum(dt * 0.5 * (pace[1:] + pace[:-1]))]))
    q = np.clip(q[1:], arm.lower, arm.upper)
    at = int(rng.integers(n // 4, n // 2))
    there = slice(at, at + n // 8)
    q[there] += np.clip(rng.normal(0.0, JUMP, 7), arm.lower - q[there].min(axis=0), arm.upper - q[there].max(axis=0))
    lost = rng.uniform(size=n) < LOST
    gone = int(rng.integers(n // 2, 3 * n // 4))
    lost[gone : gone + round(GONE_FOR / dt)] = True
    lost[0] = False
    shaken = seed % 2 == 1
    given = np.clip(q + rng.normal(0.0, JITTER, q.shape), arm.lower, arm.upper) if shaken else q
    return Known(q, given, lost, shaken)


def can_be_followed(q: np.ndarray, bounds: Bounds, dt: float) -> np.ndarray:
    """Which samples a motion of the joints, at rest before it, comes to within limits of velocity and acceleration."""
    velocity = np.diff(np.vstack([q[:1], q[:1], q]), axis=0) / dt
    acceleration = np.diff(velocity, axis=0) / dt
    fast = (np.abs(velocity[1:]) > bounds[0] + BEYOND).any(axis=1)
    return np.asarray(~fast & (np.abs(acceleration) <= bounds[1] + BEYOND).all(axis=1))


def off_by(forward: Any, q: np.ndarray, T: Any) -> np.ndarray:
    """Metres and radians between the tip and a target."""
    tip = forward(q)
    return np.array(
        [np.linalg.norm(tip.translation - T.translation), np.linalg.norm(pin.log3(tip.rotation.T @ T.rotation))]
    )


@dataclass
class Run:
    """What a tracker made of a motion, its first row the state before the first period; targets by Pinocchio."""

    known: Known
    q: np.ndarray
    v: np.ndarray
    targets: list[Any]
    off: np.ndarray
    free: np.ndarray
    noise: np.ndarray

    @property
    def on(self) -> np.ndarray:
        """Which samples are met to 1 mm and 10 mrad, beside what jitter hides."""
        return np.asarray((self.off <= np.array(NEAR_TARGET) + self.noise).all(axis=1))


def run(arm: Any, forward: Any, known: Known, dt: float) -> tuple[Run, Bounds]:
    """A motion through a tracker, whose user allows another configuration where only such a one reaches the target."""
    q0 = known.q[0]
    tracker = arm.tracker(q0, dt, velocities(arm))
    bounds = tracker.velocity_limit, tracker.acceleration_limit
    q, v = np.empty((len(known.q) + 1, 7)), np.zeros((len(known.q) + 1, 7))
    q[0] = q0
    targets = [forward(each) for each in known.q]
    noise, asked = np.zeros(2), -ASK_AGAIN
    for k, lost in enumerate(known.lost):
        shown = forward(known.given[k])
        if known.shaken and not lost:
            noise = np.maximum(noise, off_by(forward, known.given[k], targets[k]))
        step = tracker.update(None if lost else shown.homogeneous)
        q[k + 1], v[k + 1] = step.q, step.velocity
        if "reconfigure()" in step.message and k >= asked + ASK_AGAIN:
            tracker.reconfigure()
            asked = k
    off = np.array([off_by(forward, each, T) for each, T in zip(q[1:], targets, strict=True)])
    # Of jitter, the target is known no better than that.
    return Run(known, q, v, targets, off, can_be_followed(known.q, bounds, dt), noise), bounds


def begins_anew(found: Run) -> np.ndarray:
    """Samples from which on a target can be followed again, after a jump or a long time without one."""
    lost, n = found.known.lost, len(found.off)
    gone = np.array([k >= LONG and lost[k - LONG : k].all() for k in range(n)])
    return np.asarray(~found.free | (gone & ~lost))


@dataclass
class Start:
    """Joint angles and velocities at rest or on the way, and what the arm may do from there."""

    arm: Any
    forward: Any
    q: np.ndarray
    v: np.ndarray
    bounds: Bounds
    dt: float

    def motion(self, pushes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Joint angles and velocities, one row a period, by accelerations, one row a block."""
        v = self.v + self.dt * np.cumsum(np.repeat(pushes, BLOCK, axis=0), axis=0)
        return self.q + self.dt * np.cumsum(v, axis=0), v

    def worst(self, q: np.ndarray, targets: list[Any]) -> float:
        """How far tips are from their targets at most, in parts of `FOLLOWED`."""
        return max(
            float((off_by(self.forward, x, T) / np.array(FOLLOWED)).max()) for x, T in zip(q, targets, strict=True)
        )


def linear_programme(start: Start, q: np.ndarray, targets: list[Any], step: float) -> np.ndarray | None:
    """Accelerations that bring the worst error down most, to first order about the joint angles of a motion.

    The unknowns are accelerations, velocities and joint angles at the ends of blocks, and the largest component of an
    error; errors are looked at within blocks, too.
    """
    blocks, dt = len(q) // BLOCK, start.dt
    n, scale = 7 * blocks, np.repeat(FOLLOWED, 3)
    identity, before, nothing = sparse.identity(n), sparse.eye(n, n, -7), sparse.csr_matrix((n, 1))

    def after(periods: int) -> tuple[Any, np.ndarray]:
        """Joint angles so far into each block, by the unknowns, and what is known of them."""
        known = np.zeros(n)
        known[:7] = start.q + periods * dt * start.v
        by_push = 0.5 * periods * (periods + 1) * dt**2 * identity
        return sparse.hstack([by_push, periods * dt * before, before, nothing]), known

    rows, right = [], []
    for periods in LOOKED_AT:
        jacobians, left = [], []
        for k in range(periods - 1, len(q), BLOCK):
            tip, T = start.forward(q[k]), targets[k]
            turn = tip.rotation @ pin.log3(tip.rotation.T @ T.rotation)
            jacobians.append(start.arm.jacobian(q[k]) / scale[:, None])
            left.append(np.concatenate([T.translation - tip.translation, turn]) / scale + jacobians[-1] @ q[k])
        J, (angles, known) = sparse.block_diag(jacobians), after(periods)
        error = sparse.csr_matrix(np.eye(1, 3 * n + 1, 3 * n).repeat(6 * blocks, axis=0))
        rows += [J @ angles - error, -J @ angles - error]
        right += [np.concatenate(left) - J @ known, J @ known - np.concatenate(left)]
    angles, known = after(BLOCK)
    v = np.zeros(n)
    v[:7] = start.v
    chain = sparse.vstack(
        [
            sparse.hstack([-BLOCK * dt * identity, identity - before, sparse.csr_matrix((n, n)), nothing]),
            sparse.hstack([sparse.csr_matrix((n, 2 * n)), identity, nothing]) - angles,
        ]
    )
    most = [np.tile((1.0 - SPARE) * limit, blocks) for limit in start.bounds[::-1]]
    x = q[BLOCK - 1 :: BLOCK].ravel()
    low = np.minimum(np.maximum(np.tile(start.arm.lower, blocks), x - step), x)
    high = np.maximum(np.minimum(np.tile(start.arm.upper, blocks), x + step), x)
    ends = [*([-limit, limit] for limit in most), [low, high]]
    bounds = np.vstack([*(np.stack(each, axis=1) for each in ends), [[0.0, np.inf]]])
    cost = np.eye(1, 3 * n + 1, 3 * n)[0]
    # Interior points: a vertex would change accelerations from one end to the other, where nothing asks for it.
    found = linprog(
        cost, sparse.vstack(rows), np.concatenate(right), chain, np.concatenate([v, known]), bounds, "highs-ipm"
    )
    return found.x[:n].reshape(-1, 7) if found.status == 0 else None


def best_motion(
    start: Start, targets: list[Any], pushes: np.ndarray, rounds: int = ROUNDS
) -> tuple[np.ndarray, np.ndarray, float]:
    """Joint angles and velocities of a motion within limits that keeps to its targets, and its worst error.

    Args:
        start: where the joints are.
        targets: one a period, a whole number of blocks.
        pushes: accelerations to begin with, one row a block.
        rounds: linear programmes at most.
    """
    q, v = start.motion(np.clip(pushes, -start.bounds[1], start.bounds[1]))
    worst, step = start.worst(q, targets), STEP
    for _ in range(rounds):
        if worst <= 1.0:
            break
        better = linear_programme(start, q, targets, step)
        if better is None:
            step *= 2.0
            continue
        new_q, new_v = start.motion(better)
        here = start.worst(new_q, targets)
        if here < worst:
            q, v, worst = new_q, new_v, here
        else:
            step *= 0.4
    return q, v, worst


def leaves(found: Run, before: float, dt: float) -> list[int]:
    """Samples at which the tip leaves a target that it was on, and that has not jumped nor been gone thereabouts."""
    on, lost = found.on, found.known.lost
    first, after = round(before / dt), round(AFTER / dt)
    gone = np.convolve(lost, np.ones(LONG), "same") >= LONG
    odd = gone | begins_anew(found)
    return [
        k
        for k in range(first + LONG, len(on) - after)
        if on[k - first : k].all() and not on[k] and not odd[k - first - LONG : k + after].any()
    ]


def kept_to(arm: Any, forward: Any, found: Run, k: int, before: float, bounds: Bounds, dt: float) -> float:
    """How closely a motion within limits, from where the joints were, keeps to the target left at k, by `FOLLOWED`."""
    at, end = k - round(before / dt), k + round(AFTER / dt)
    start = Start(arm, forward, found.q[at], found.v[at], bounds, dt)
    pushes = np.diff(found.v[at : end + 1 : BLOCK], axis=0) / (BLOCK * dt)
    return best_motion(start, found.targets[at:end], pushes)[2]


def nobody(arm: Any, start: Bounds, ahead: list[Any], bounds: Bounds, dt: float) -> int:
    """For how many samples no motion within the limits can be on the target; one in `EVERY` is looked at."""
    for k in range(0, len(ahead), EVERY):
        low, high = box_after(arm, start, dt * (k + 1), bounds)
        near = start[0] + ways_to(arm, start[0], ahead[k].homogeneous)
        if np.maximum(low - near, near - high).max(axis=1, initial=-np.inf).min(initial=np.inf) < BETWEEN:
            return k
    return len(ahead)


def late(arm: Any, found: Run, bounds: Bounds, dt: float) -> np.ndarray:
    """Which samples the tip is off its target in though somebody might be on it, from where the joints were.

    That is where the tip left it, or where it jumped or came back. Somebody may be on it as soon as a posture of the
    target is within reach of the joints, and is taken to be so from then on.
    """
    off, anew = ~found.on, begins_anew(found)
    out = np.zeros(len(off), bool)
    k = 0
    while k < len(off):
        if not off[k]:
            k += 1
            continue
        ends = np.flatnonzero(~off[k:] | (anew[k:] & (np.arange(len(off) - k) > 0)))
        end = k + int(ends[0]) if len(ends) else len(off)
        out[k + nobody(arm, (found.q[k], found.v[k]), found.targets[k:end], bounds, dt) : end] = True
        k = end
    return out
