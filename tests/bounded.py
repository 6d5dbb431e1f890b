"""How far a tip may be off a target that can be followed: what the limits imply, by followers that are no trackers.

A target that comes from a motion of the joints within their limits can be followed. From where a tracker's joints are
when its tip was on the target last, a follower takes each joint for itself in the shortest time to a posture of the
target. It keeps the limits, so that they allow a tip that is never farther off than the follower's on that way, and on
its target from its end on: that is the bound.

There are two followers. The `Chaser` knows what a tracker knows, the poses so far: it makes for the posture that can be
met soonest. The `Follower` is told the joint angles behind the poses, and so where no later pose leads out of the
limits. No tracker can hold its bound for sure: the same poses may come from other joint angles, and go on otherwise.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from motions import joint_motion, minimum_jerk
from scipy.interpolate import CubicSpline
from tracked import BEYOND, GONE_FOR, LOST, NEAR_TARGET, SECONDS, SMOOTHING, least_time, velocities, ways_to

KINDS = ("joints", "limits", "singular")
"""Motions whose joint angles are known."""

PAUSE = 0.5
"""Seconds in which a target comes to rest, rests, and in which it goes on again."""

JUMP = 0.1
"""How far joints jump, rad, standard deviation."""

JITTER = 5e-4
"""Of the joint angles behind a pose that is given, rad, standard deviation."""

LONG = 10
"""A target that is gone for so many samples may be anywhere: its follower begins anew."""

TOGETHER = 1e-6
"""Joints this close to the target's, rad, have caught up with it."""

ASK_AGAIN = 25
"""Periods between two permissions to reconfigure."""

CHOOSE_EVERY = 10
"""Periods after which a chaser looks for the posture that it can meet soonest."""

SOONEST, EVERY = 40, 4
"""Of so many postures, by the time to a pose that rests, one in so many is looked at with the velocity that it has."""

SOONER = 0.9
"""A posture that is met in less than this share of the time to the one that is chosen is met clearly sooner."""

DAMPING = 1e-6
"""Of the velocities of postures next to singular ones, m^2."""

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


def stopping(room: np.ndarray, hardest: np.ndarray, dt: float) -> np.ndarray:
    """Largest velocities for a period after which joints can stop within a distance, in whole periods."""
    most = hardest * dt
    n = np.floor(0.5 * (np.sqrt(1.0 + 8.0 * np.maximum(room, 0.0) / (most * dt)) - 1.0))
    return np.asarray((np.maximum(room, 0.0) / dt + 0.5 * most * n * (n + 1.0)) / (n + 1.0))


def box(arm: Any, q: np.ndarray, v: np.ndarray, bounds: Bounds, dt: float) -> Bounds:
    """Least and largest velocities of the next period."""
    room = np.minimum(q - arm.lower, 1e3), np.minimum(arm.upper - q, 1e3)
    low = np.maximum.reduce([-bounds[0], v - bounds[1] * dt, -stopping(room[0], bounds[1], dt)])
    high = np.minimum.reduce([bounds[0], v + bounds[1] * dt, stopping(room[1], bounds[1], dt)])
    return np.minimum(low, high), high


def short_way(arm: Any, way: np.ndarray) -> np.ndarray:
    """Ways of joints, those without an end by the shorter way around."""
    return np.where(np.isinf(arm.upper), (way + np.pi) % (2.0 * np.pi) - np.pi, way)


class Follower:
    """Seven joints, each for itself: to the target's joint angles in the shortest time, by its samples so far.

    What the target itself makes use of a joint's acceleration is not reckoned with for braking.
    """

    def __init__(self, arm: Any, start: Bounds, seen: Bounds, bounds: Bounds, dt: float) -> None:
        self.arm, self.bounds, self.dt = arm, bounds, dt
        self.q, self.v = start[0].copy(), start[1].copy()
        self.target, self.rate = seen[0].copy(), seen[1].copy()
        self.gone = 0

    def step(self, target: np.ndarray | None) -> float:
        """Go on by a period: how far the joint that is farthest off is then, rad."""
        dt, (fastest, hardest) = self.dt, self.bounds
        push = np.zeros(7)
        if target is None:
            self.gone += 1
            aim = self.target + self.gone * dt * self.rate
        else:
            rate = np.clip(short_way(self.arm, target - self.target) / (dt * (self.gone + 1)), -fastest, fastest)
            push = np.minimum(np.abs(rate - self.rate) / (dt * (self.gone + 1)), 0.8 * hardest)
            self.target, self.rate, self.gone = target.copy(), rate, 0
            aim = target
        behind = short_way(self.arm, aim - self.q) - dt * self.rate
        wanted = self.rate + np.sign(behind) * stopping(np.abs(behind), hardest - push, dt)
        self.v = np.clip(wanted, *box(self.arm, self.q, self.v, self.bounds, dt))
        self.q = self.q + dt * self.v
        return float(np.abs(short_way(self.arm, aim - self.q)).max())


class Chaser(Follower):
    """A follower that is told poses alone: it makes for the posture that it meets soonest if the target goes on so."""

    def __init__(self, arm: Any, start: Bounds, before: Any, bounds: Bounds, dt: float) -> None:
        """Begin at joint angles and velocities; before: the target's pose a period ago, None if that is unknown."""
        super().__init__(arm, start, start, bounds, dt)
        self.before, self.ticks = before, 0

    def rate_of(self, q: np.ndarray, T: Any) -> np.ndarray:
        """The least velocities with which a posture of the target moves on with it."""
        if self.before is None:
            return np.zeros(7)
        turn = T.rotation @ pin.log3(self.before.rotation.T @ T.rotation)
        J = self.arm.jacobian(q)
        twist = np.concatenate([T.translation - self.before.translation, turn]) / self.dt
        rate = J.T @ np.linalg.solve(J @ J.T + DAMPING * np.eye(6), twist)
        return np.asarray(np.clip(rate, -self.bounds[0], self.bounds[0]))

    def seconds_to(self, way: np.ndarray, rate: np.ndarray) -> float:
        """The shortest time to a posture that moves on evenly."""
        return float(least_time(way, *self.bounds, self.v - rate).max())

    def choose(self, T: Any, kept: np.ndarray | None) -> np.ndarray:
        """The posture that is met soonest: one that is kept, unless another is met clearly sooner."""
        best, chosen = np.inf, self.q
        if kept is not None:
            chosen = kept
            best = SOONER * self.seconds_to(short_way(self.arm, kept - self.q), self.rate)
        ways = ways_to(self.arm, self.q, T.homogeneous)
        for way in ways[np.argsort(least_time(ways, *self.bounds, self.v).max(axis=1))[:SOONEST:EVERY]]:
            rate = self.rate_of(self.q + way, T)
            seconds = self.seconds_to(way, rate)
            if seconds < best:
                best, chosen, self.rate = seconds, self.q + way, rate
        return chosen

    def chase(self, T: Any | None) -> float:
        """Go on by a period towards a pose: how far the joint that is farthest off is then, rad."""
        if T is None:
            self.before = None
            return self.step(None)
        kept = self.arm.solve(T, seed=self.target).q if self.ticks else None
        if self.ticks % CHOOSE_EVERY == 0:
            chosen = self.choose(T, kept)
            if chosen is not kept:
                # Where that posture was a period ago.
                self.target, self.gone, kept = chosen - self.dt * self.rate, 0, chosen
        self.before = T
        self.ticks += 1
        return self.step(kept)


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
    tracker = arm.tracker(q0, dt, velocities(arm), smoothing=SMOOTHING if known.shaken else 0.0)
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


def seen_before(found: Run, k: int) -> bool:
    """Whether the target a period ago says how it moves: not after a jump or a long time without one."""
    return bool(found.free[k] and k > 1 and not found.known.lost[max(k - LONG, 0) : k].all())


def steps_of(arm: Any, found: Run, k: int, bounds: Bounds, dt: float, told: bool) -> tuple[Follower, Any]:
    """The follower that begins at sample k, where the tracker's joints are, and what takes it on to a sample."""
    known, start, seen = found.known, (found.q[k], found.v[k]), seen_before(found, k)
    if told:
        before = (known.q[k - 1], (known.q[k - 1] - known.q[k - 2]) / dt) if seen else (known.q[k], np.zeros(7))
        follower = Follower(arm, start, before, bounds, dt)
        return follower, lambda m: follower.step(None if known.lost[m] else known.q[m])
    chaser = Chaser(arm, start, found.targets[k - 1] if seen else None, bounds, dt)
    return chaser, lambda m: chaser.chase(None if known.lost[m] else found.targets[m])


def envelope(
    arm: Any, forward: Any, found: Run, span: tuple[int, int], bounds: Bounds, dt: float, told: bool
) -> np.ndarray:
    """(m, 2) bound from a sample on, until the follower has caught up, or up to another one.

    It ends before what cannot be followed.
    """
    k, end = span
    follower, step = steps_of(arm, found, k, bounds, dt, told)
    off = []
    for m in range(k, end):
        if m > k + 2 and not found.free[m]:
            break
        left = step(m)
        off.append(off_by(forward, follower.q, found.targets[m]))
        if left < TOGETHER and not found.known.lost[m]:
            break
    return np.tile(np.max(off, axis=0), (len(off), 1))


def beyond(arm: Any, forward: Any, found: Run, bounds: Bounds, dt: float, told: bool) -> np.ndarray:
    """(n, 2) how far tips are beyond the bound, m and rad, of samples that came and can be followed; others -inf.

    Args:
        arm: the arm.
        forward: Pinocchio's forward kinematics.
        found: what a tracker made of a motion.
        bounds: largest velocities and accelerations.
        dt: period, s.
        told: whether the follower is told the joint angles of the target, and not its poses alone.
    """
    anew = begins_anew(found) | (np.concatenate([[True], found.on[:-1]]) & ~found.on)
    most = np.zeros((len(found.off), 2))
    at = [*np.flatnonzero(anew).tolist(), len(found.off)]
    for k, end in itertools.pairwise(at):
        away = envelope(arm, forward, found, (k, end), bounds, dt, told)
        most[k : k + len(away)] = away
    most = np.maximum(most, np.array(NEAR_TARGET) + found.noise)
    counted = found.free & ~found.known.lost
    return np.where(counted[:, None], found.off - most, -np.inf)


def bound_line(arm: Any, forward: Any, name: str, count: int, seed: int, dt: float) -> str:
    """One line on motions against the bounds."""
    counted, past, past_told, worst, on = 0, 0, 0, np.full(2, -np.inf), 0
    for k in range(seed, seed + count):
        found, bounds = run(arm, forward, known_motion(arm, k, dt), dt)
        here, told = (beyond(arm, forward, found, bounds, dt, each) for each in (False, True))
        samples = np.isfinite(here[:, 0])
        counted += int(samples.sum())
        on += int((found.on & samples).sum())
        past += int((here > 0.0).any(axis=1).sum())
        past_told += int((told > 0.0).any(axis=1).sum())
        worst = np.maximum(worst, here.max(axis=0))
    return (
        f"{name}: seeds {seed} to {seed + count - 1}, {count} motions, {counted} samples that can be followed; "
        f"within the bound {100.0 * (1.0 - past / counted):.2f} % ({past} beyond it, by {1e3 * worst[0]:.0f} mm and "
        f"{1e3 * worst[1]:.0f} mrad at most), on target {100.0 * on / counted:.2f} %, within that of one who "
        f"is told the joint angles {100.0 * (1.0 - past_told / counted):.2f} %"
    )
