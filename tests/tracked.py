"""What a tracker does to its limits over many motions, and how fast it meets a target again that jumped or was lost."""

from __future__ import annotations

from typing import Any

import numpy as np
from motions import KINDS, motion, off_target, within

BEYOND = 1e-9
"""What limits may be passed by, rad, rad/s and rad/s^2: rounding."""

NEAR_TARGET = (1e-3, 1e-2)
SECONDS = 10.0
SMOOTHING = 0.02
"""Of every other motion, s."""

PATIENCE = 5.0

STEP_BETWEEN = 0.02
"""What lies between two postures or two poses that are looked at, rad."""

WITHIN_REACH = tuple(kind for kind in KINDS if kind != "reach")
"""Motions that can be followed."""

LOST = 0.05
GONE_FOR = 0.2
"""Share of targets that are lost, and seconds in which all are."""


def velocities(arm: Any) -> np.ndarray:
    """The arm's velocity limits, 2 rad/s where a file has none."""
    known = np.isfinite(arm.velocity_limit) & (arm.velocity_limit > 0.0)
    return np.where(known, arm.velocity_limit, 2.0)


def passed(arm: Any, q0: np.ndarray, q: np.ndarray, bounds: tuple[np.ndarray, np.ndarray], dt: float) -> np.ndarray:
    """By how much joint angles, velocities and accelerations pass their limits, at most."""
    from_rest = np.vstack([q0, q0, q])
    velocity = np.diff(from_rest, axis=0) / dt
    acceleration = np.diff(velocity, axis=0) / dt
    return np.array(
        [
            np.maximum(arm.lower - q, q - arm.upper).max(),
            (np.abs(velocity) - bounds[0]).max(),
            (np.abs(acceleration) - bounds[1]).max(),
        ]
    )


def limits_line(arm: Any, name: str, count: int, seed: int, dt: float) -> str:
    """One line on random motions of 10 s with jitter, pauses, jumps and lost targets."""
    worst, nan, mute, updates, on = np.full(3, -np.inf), 0, 0, 0, 0.0
    for k in range(seed, seed + count):
        moving = motion(arm, k, SECONDS, dt, KINDS[k % len(KINDS)], trouble=True)
        tracker = arm.tracker(moving.q0, dt, velocities(arm), smoothing=SMOOTHING * (k % 2))
        steps = [tracker.update(T) for T in moving.given]
        q = np.array([step.q for step in steps])
        nan += int((~np.isfinite(q)).any(axis=1).sum())
        mute += sum(1 for step in steps if not (step.status and step.message))
        worst = np.maximum(worst, passed(arm, moving.q0, q, (tracker.velocity_limit, tracker.acceleration_limit), dt))
        position, angle = off_target(arm.forward_kinematics, q, moving.true)
        on += float(((position < NEAR_TARGET[0]) & (angle < NEAR_TARGET[1])).sum())
        updates += len(q)
    broken = int((worst > BEYOND).sum())
    return (
        f"{name}: seeds {seed} to {seed + count - 1}, {count} motions, {updates} updates; "
        f"kinds of limits passed {broken} (position {worst[0]:.1e} rad, velocity {worst[1]:.1e} rad/s, "
        f"acceleration {worst[2]:.1e} rad/s^2), "
        f"not finite {nan}, without a status {mute}, on target {100.0 * on / updates:.1f} %"
    )


def least_time(way: np.ndarray, fastest: np.ndarray, hardest: np.ndarray) -> np.ndarray:
    """Seconds from rest to rest over a way, at a largest velocity and acceleration."""
    way = np.abs(way)
    short = way <= fastest**2 / hardest
    return np.where(short, 2.0 * np.sqrt(way / hardest), way / fastest + fastest / hardest)


def ways_to(arm: Any, q: np.ndarray, T: np.ndarray) -> np.ndarray:
    """(n, 7) how far joints are from the postures of a pose: over 180 arm angles, all branches."""
    angles = np.linspace(-np.pi, np.pi, 180, endpoint=False)
    found = arm.solve_batch(np.repeat(T[None], len(angles), axis=0), arm_angle=angles, all_branches=True)
    way: np.ndarray = found.q.reshape(-1, 7)[np.asarray(found.ok).ravel()] - q
    endless = np.isinf(arm.upper)
    way[:, endless] = (way[:, endless] + np.pi) % (2.0 * np.pi) - np.pi
    return way


def least_time_to(arm: Any, q: np.ndarray, T: np.ndarray, bounds: tuple[np.ndarray, np.ndarray]) -> float:
    """The shortest time in which joints at rest come to rest at a posture of a pose.

    Every joint alone needs that long, whatever the others do.
    """
    return float(least_time(ways_to(arm, q, T), *bounds).max(axis=1).min(initial=np.inf))


def farthest(seconds: float, velocity: np.ndarray, fastest: np.ndarray, hardest: np.ndarray) -> np.ndarray:
    """(7,) how far up joints come in a time, from their velocities."""
    rising = np.minimum((fastest - velocity) / hardest, seconds)
    return velocity * rising + 0.5 * hardest * rising**2 + fastest * (seconds - rising)


def could_return(
    arm: Any, start: tuple[np.ndarray, np.ndarray], ahead: np.ndarray, bounds: tuple[np.ndarray, np.ndarray], dt: float
) -> bool:
    """Whether joints could be on one of the poses ahead, each by its own limits alone; one pose in ten is looked at.

    None could return where this is false; where it is true, perhaps none that does not know the future.
    """
    q, velocity = start
    for k in range(0, len(ahead), 10):
        seconds, way = dt * (k + 1), ways_to(arm, q, ahead[k])
        up, down = farthest(seconds, velocity, *bounds), farthest(seconds, -velocity, *bounds)
        if ((way <= up + STEP_BETWEEN) & (way >= -down - STEP_BETWEEN)).all(axis=1).any():
            return True
    return False


def recoveries(arm: Any, count: int, seed: int, dt: float) -> list[tuple[float, float]]:
    """Seconds until the tip of a resting arm is on a target that has jumped, and the least time for it.

    The target jumps to a pose that a posture meets whose joints differ by 0.25 rad (standard deviation) each.
    """
    lower, upper = within(arm, 0.8)
    fastest = velocities(arm)
    out = []
    for k in range(seed, seed + count):
        rng = np.random.default_rng(k)
        q0 = rng.uniform(lower, upper)
        T = arm.forward_kinematics(np.clip(q0 + rng.normal(0.0, 0.25, 7), lower, upper)).homogeneous
        tracker = arm.tracker(q0, dt, fastest)
        seconds = np.inf
        for n in range(round(PATIENCE / dt)):
            step = tracker.update(T)
            if step.position_error < NEAR_TARGET[0] and step.orientation_error < NEAR_TARGET[1]:
                seconds = dt * (n + 1)
                break
        out.append((seconds, least_time_to(arm, q0, T, (fastest, tracker.acceleration_limit))))
    return out


def recovery_line(arm: Any, name: str, count: int, seed: int, dt: float) -> str:
    """One line on the times that `recoveries` measures."""
    times = np.array(recoveries(arm, count, seed, dt))
    back = np.isfinite(times[:, 0])
    ratio = times[back, 0] / times[back, 1]
    return (
        f"{name}: seeds {seed} to {seed + count - 1}, {count} jumps, "
        f"{int((~back).sum())} not met within {PATIENCE:g} s; "
        f"time over the least time: median {np.median(ratio):.2f}, 95 % {np.percentile(ratio, 95.0):.2f}, "
        f"most {ratio.max():.2f}"
    )


def losses(arm: Any, count: int, seed: int, dt: float) -> tuple[np.ndarray, np.ndarray, int]:
    """What comes of targets of which 5 % are lost, and all for a while.

    Returns:
        Seconds from the first target after each loss until the tip is on it, endless where it never is; the share
        of updates on target of each motion; and after how many of the losses without a return one was possible.
    """
    back, shares, possible = [], [], 0
    for k in range(seed, seed + count):
        moving = motion(arm, k, SECONDS, dt, WITHIN_REACH[k % len(WITHIN_REACH)], trouble=False)
        rng = np.random.default_rng(k + 7_000_000)
        lost = rng.uniform(size=len(moving.given)) < LOST
        gone = int(rng.integers(len(lost) // 4, len(lost) // 2))
        lost[gone : gone + round(GONE_FOR / dt)] = True
        tracker = arm.tracker(moving.q0, dt, velocities(arm))
        steps = [tracker.update(None if off else T) for off, T in zip(lost, moving.true, strict=True)]
        q = np.array([step.q for step in steps])
        bounds = tracker.velocity_limit, tracker.acceleration_limit
        position, angle = off_target(arm.forward_kinematics, q, moving.true)
        on = (position < NEAR_TARGET[0]) & (angle < NEAR_TARGET[1])
        shares.append(on.mean())
        for end in np.flatnonzero(lost[:-1] & ~lost[1:]) + 1:
            back.append(dt * float(np.argmax(on[end:])) if on[end:].any() else np.inf)
            if np.isinf(back[-1]):
                start = steps[end - 1].q, steps[end - 1].velocity
                possible += could_return(arm, start, moving.true[end:], bounds, dt)
    return np.array(back), np.array(shares), possible


def losses_line(arm: Any, name: str, count: int, seed: int, dt: float) -> str:
    """One line on what `losses` measures."""
    back, shares, possible = losses(arm, count, seed, dt)
    never = np.isinf(back)
    back = np.where(never, SECONDS, back)
    return (
        f"{name}: seeds {seed} to {seed + count - 1}, {count} motions, {len(back)} losses, "
        f"{int(never.sum())} without a return ({possible} of them possible by the limits of each joint alone); "
        f"on target again after: "
        f"median {np.median(back):.3f} s, 95 % {np.percentile(back, 95.0):.3f} s, "
        f"99 % {np.percentile(back, 99.0):.3f} s; at once {100.0 * (back == 0.0).mean():.1f} %; "
        f"on target {100.0 * shares.mean():.1f} % of all updates"
    )
