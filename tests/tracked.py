"""What a tracker does to its limits over many motions, and how fast it meets a target again that jumped or was lost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from motions import KINDS, motion, off_target, within
from scipy.optimize import least_squares

from srs_ik import TrackerStatus

BEYOND = 1e-9
"""What limits may be passed by, rad, rad/s and rad/s^2: rounding."""

NEAR_TARGET = (1e-3, 1e-2)
SECONDS = 10.0
SMOOTHING = 0.02
"""Of every other motion, s; of the others, what their noise asks for."""

PATIENCE = 5.0

STEP_BETWEEN = 0.1
"""How far outside of bounds postures of the grid may be that SciPy brings inside, rad."""

STARTS = 6
ATTEMPTS = 40
EVERY = 5
"""Postures of the grid from which SciPy starts, evaluations from each; one pose in so many is looked at."""

SOONER = 0.05
"""A tip that could be back so many seconds sooner is late."""

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
        tracker = arm.tracker(moving.q0, dt, velocities(arm), smoothing=SMOOTHING if k % 2 else None)
        steps = [tracker.update(T) for T in moving.given]
        q = np.array([step.q for step in steps])
        nan += int((~np.isfinite(q)).any(axis=1).sum())
        mute += sum(1 for step in steps if not (step.status in TrackerStatus and step.message))
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


def least_time(
    way: np.ndarray, fastest: np.ndarray, hardest: np.ndarray, velocity: np.ndarray | float = 0.0
) -> np.ndarray:
    """Seconds over a way to rest, from rest or a velocity, at a largest velocity and acceleration."""
    # A joint that cannot stop before its end comes back to it.
    side = np.where(way - velocity * np.abs(velocity) / (2.0 * hardest) >= 0.0, 1.0, -1.0)
    way, velocity = side * way, side * velocity
    peak = np.sqrt(np.maximum(hardest * way + 0.5 * velocity**2, 0.0))
    even = (way - (fastest**2 - 0.5 * velocity**2) / hardest) / fastest
    return (2.0 * np.minimum(peak, fastest) - velocity) / hardest + np.where(peak > fastest, even, 0.0)


def ways_to(arm: Any, q: np.ndarray, T: np.ndarray) -> np.ndarray:
    """(n, 7) how far joints are from the postures of a pose: over 180 arm angles, all branches."""
    angles = np.linspace(-np.pi, np.pi, 180, endpoint=False)
    found = arm.solve_batch(np.repeat(T[None], len(angles), axis=0), arm_angle=angles, all_branches=True, threads=1)
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


def box_after(
    arm: Any, start: tuple[np.ndarray, np.ndarray], seconds: float, bounds: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """(7,) each: how far down and up joints come in a time from where they are, by their velocities, rad.

    Every joint is for itself, so a posture can be reached in that time just if it is in there.
    """
    q, velocity = start
    low, high = q - farthest(seconds, -velocity, *bounds), q + farthest(seconds, velocity, *bounds)
    return np.maximum(low, arm.lower), np.minimum(high, arm.upper)


def in_box(arm: Any, q: np.ndarray, T: np.ndarray, low: np.ndarray, high: np.ndarray) -> bool:
    """Whether a posture on a pose, to `NEAR_TARGET`, is between bounds: nearest of a grid of arm angles, by SciPy."""
    near = q + ways_to(arm, q, T)
    outside = np.maximum(np.maximum(low - near, near - high), 0.0).max(axis=1, initial=0.0)

    def off(x: np.ndarray) -> np.ndarray:
        tip = arm.forward_kinematics(x)
        turn = pin.log3(tip.rotation.T @ T[:3, :3])
        return np.concatenate([(tip.translation - T[:3, 3]) / NEAR_TARGET[0], turn / NEAR_TARGET[1]])

    def slopes(x: np.ndarray) -> np.ndarray:
        R, J = arm.forward_kinematics(x).rotation, arm.jacobian(x)
        turning = pin.Jlog3(T[:3, :3].T @ R) @ R.T @ J[3:]
        return np.vstack([J[:3] / NEAR_TARGET[0], -turning / NEAR_TARGET[1]])

    for k in np.argsort(outside)[:STARTS]:
        if outside[k] > STEP_BETWEEN:
            break
        wide = np.maximum(high, low + 1e-9)
        ends = low - 1e-12, wide + 1e-12
        found = least_squares(off, np.clip(near[k], low, wide), slopes, bounds=ends, xtol=1e-10, max_nfev=ATTEMPTS)
        if max(np.linalg.norm(found.fun[:3]), np.linalg.norm(found.fun[3:])) < 1.0:
            return True
    return False


def least_return(
    arm: Any, start: tuple[np.ndarray, np.ndarray], ahead: np.ndarray, bounds: tuple[np.ndarray, np.ndarray], dt: float
) -> float:
    """Seconds until any motion within the limits could be on its target, which it knows; endless where none could.

    Each joint is looked at for itself, and one pose in `EVERY`.
    """
    for k in range(0, len(ahead), EVERY):
        if in_box(arm, start[0], ahead[k], *box_after(arm, start, dt * (k + 1), bounds)):
            return dt * k
    return float(np.inf)


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


@dataclass
class Loss:
    """What came of a loss: whether it took a tip off its target, and seconds until the tip was on it again.

    `least` is the time in which a motion within the limits could be there that knows the future; NaN where it was not
    asked for, since the tip was back at once or off its target before.
    """

    on_before: bool
    back: float
    least: float


def losses(arm: Any, count: int, seed: int, dt: float) -> tuple[list[Loss], np.ndarray]:
    """What comes of targets of which 5 % are lost for 10 s, and all for a while; then none, so that all may be met.

    Returns:
        The losses; and the share of updates on target of each motion, in these 10 s.
    """
    out, shares = [], []
    n = round(SECONDS / dt)
    for k in range(seed, seed + count):
        moving = motion(arm, k, SECONDS + PATIENCE, dt, WITHIN_REACH[k % len(WITHIN_REACH)], trouble=False)
        rng = np.random.default_rng(k + 7_000_000)
        lost = np.zeros(len(moving.given), bool)
        lost[:n] = rng.uniform(size=n) < LOST
        gone = int(rng.integers(n // 4, n // 2))
        lost[gone : gone + round(GONE_FOR / dt)] = True
        tracker = arm.tracker(moving.q0, dt, velocities(arm))
        steps = [tracker.update(None if off else T) for off, T in zip(lost, moving.true, strict=True)]
        q = np.array([step.q for step in steps])
        bounds = tracker.velocity_limit, tracker.acceleration_limit
        position, angle = off_target(arm.forward_kinematics, q, moving.true)
        on = (position < NEAR_TARGET[0]) & (angle < NEAR_TARGET[1])
        shares.append(on[:n].mean())
        edges = np.flatnonzero(np.diff(np.concatenate([[False], lost, [False]]).astype(int)))
        for first, end in edges.reshape(-1, 2):
            back = dt * float(np.argmax(on[end:])) if on[end:].any() else np.inf
            before = bool(first == 0 or on[first - 1])
            least = np.nan
            if before and back > 0.0:
                start = steps[end - 1].q, steps[end - 1].velocity
                # What the tracker did can be done.
                until = len(moving.true) if np.isinf(back) else end + round(back / dt)
                least = min(least_return(arm, start, moving.true[end:until], bounds, dt), back)
            out.append(Loss(before, back, least))
    return out, np.array(shares)


def losses_line(arm: Any, name: str, count: int, seed: int, dt: float) -> str:
    """One line on what `losses` measures."""
    found, shares = losses(arm, count, seed, dt)
    taken = np.array([loss.back for loss in found if loss.on_before])
    others = np.array([loss.back for loss in found if not loss.on_before])
    late = [loss for loss in found if loss.on_before and 0.0 < loss.back < np.inf]
    over = np.array([loss.back - loss.least for loss in late]) if late else np.zeros(1)
    never = np.isinf(taken)
    possible = sum(1 for loss in found if loss.on_before and np.isinf(loss.back) and np.isfinite(loss.least))
    kept = np.where(never, SECONDS + PATIENCE, taken)
    return (
        f"{name}: seeds {seed} to {seed + count - 1}, {count} motions; {len(taken)} losses with the tip on its target, "
        f"{int(never.sum())} without a return ({possible} of them possible); on target again at once "
        f"{100.0 * (kept == 0.0).mean():.1f} %, 99 % {np.percentile(kept, 99.0):.2f} s, at most {kept.max():.2f} s; "
        f"{len(late)} later than at once, {int((over > SOONER).sum())} of them {SOONER:g} s later than might be; "
        f"later than limits allow one who knows the future by: "
        f"median {np.median(over):.3f} s, 95 % {np.percentile(over, 95.0):.3f} s, most {over.max():.3f} s; "
        f"{len(others)} losses with the tip off it before, {int(np.isinf(others).sum())} without a return; "
        f"on target {100.0 * shares.mean():.1f} % of all updates"
    )
