"""Target motions for trackers, with all that goes wrong with them, and the account of what a tracker makes of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

KINDS = ("joints", "limits", "singular", "hand", "reach")


@dataclass
class Motion:
    """Target poses, one a period: where they should be, and what comes of them (None: lost)."""

    q0: np.ndarray
    true: np.ndarray
    given: list[np.ndarray | None]
    kind: str


def within(arm: Any, share: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Joint ranges, those without an end cut to half a turn either way, drawn in to a share of them."""
    lower, upper = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    middle, half = 0.5 * (lower + upper), 0.5 * (upper - lower)
    return middle - share * half, middle + share * half


def minimum_jerk(t: np.ndarray) -> np.ndarray:
    """From 0 to 1 while t goes from 0 to 1."""
    t = np.clip(t, 0.0, 1.0)
    return t**3 * (10.0 - 15.0 * t + 6.0 * t**2)


def joint_motion(
    arm: Any, rng: np.random.Generator, n: int, dt: float, kind: str, speed: float, push: float
) -> np.ndarray:
    """(n, 7) two sines a joint, no faster than a share of the velocity limits and no harder than of the others."""
    lower, upper = within(arm, 0.9)
    half = 0.5 * (upper - lower)
    middle = 0.5 * (lower + upper)
    if kind == "limits":
        lower, upper = within(arm, 1.0)
        half = 0.5 * (upper - lower)
        middle = 0.5 * (lower + upper)
    # From rest.
    t = dt * np.arange(1, n + 1)[:, None]
    t = t - 0.5 * np.tanh(t / 0.5)
    weights = rng.dirichlet((1.0, 1.0), 7).T[:, None]
    rates = rng.uniform(0.3, 2.0, (2, 1, 7))
    phases = rng.uniform(0.0, 2.0 * np.pi, (2, 1, 7))
    amplitude = half * rng.uniform(0.3, 1.0, 7)
    if kind == "limits":
        amplitude = half
    if kind == "singular":
        # About the angles at which shoulder, elbow and wrist are singular, where the limits allow them.
        for j in (1, 3, 5):
            if lower[j] < 0.0 < upper[j]:
                middle[j], amplitude[j] = 0.0, 0.5 * min(-lower[j], upper[j])
    velocity = arm.velocity_limit
    fastest = amplitude * (weights * rates).sum(0)[0]
    hardest = amplitude * (weights * rates**2).sum(0)[0]
    slower = np.minimum(1.0, speed * velocity / fastest)
    slower = np.minimum(slower, np.sqrt(push * 5.0 * velocity / hardest))
    q = middle + amplitude * (weights * np.sin(rates * slower * t + phases)).sum(0)
    return np.clip(q, arm.lower, arm.upper)


def hand_motion(arm: Any, rng: np.random.Generator, q0: np.ndarray, n: int, dt: float, far: float) -> np.ndarray:
    """(n, 4, 4) from one random pose to the next, with a minimum of jerk and pauses between them."""
    lower, upper = within(arm, 0.9)
    poses = np.empty((n, 4, 4))
    here, k = arm.forward_kinematics(q0), 0
    while k < n:
        there = arm.forward_kinematics(np.clip(q0 + rng.normal(0.0, 0.5, 7), lower, upper))
        there = pin.SE3(there.rotation, there.translation + far * rng.normal(0.0, 0.2, 3))
        turn = pin.log3(here.rotation.T @ there.rotation)
        way = max(np.linalg.norm(there.translation - here.translation) / 0.2, np.linalg.norm(turn) / 0.5, 0.4)
        steps, pause = int(way / dt), int(rng.uniform(0.0, 0.5) / dt)
        for s in minimum_jerk(np.arange(1, steps + pause + 1) / steps):
            if k == n:
                break
            poses[k] = np.eye(4)
            poses[k, :3, :3] = here.rotation @ pin.exp3(s * turn)
            poses[k, :3, 3] = (1.0 - s) * here.translation + s * there.translation
            k += 1
        here = pin.SE3(there.rotation, there.translation)
    return poses


def motion(arm: Any, seed: int, seconds: float, dt: float, kind: str, trouble: bool, speed: float = 0.5) -> Motion:
    """One random motion of a kind; with trouble: jitter, jumps, pauses and 5 % lost."""
    rng = np.random.default_rng(seed)
    n = round(seconds / dt)
    q = joint_motion(arm, rng, n, dt, kind, speed, speed)
    if kind in ("hand", "reach"):
        lower, upper = within(arm, 0.6)
        q0 = rng.uniform(lower, upper)
        true = hand_motion(arm, rng, q0, n, dt, 1.0 if kind == "reach" else 0.0)
    else:
        q0 = joint_motion(arm, np.random.default_rng(seed), 1, 1e-9, kind, speed, speed)[0]
        true = np.array([arm.forward_kinematics(each).homogeneous for each in q])
    given: list[np.ndarray | None] = [T.copy() for T in true]
    if trouble:
        for T in given:
            T[:3, 3] += rng.normal(0.0, 5e-4, 3)
            T[:3, :3] = T[:3, :3] @ pin.exp3(rng.normal(0.0, 2e-3, 3))
        at = int(rng.integers(n // 4, n // 2))
        jump = pin.SE3(pin.exp3(rng.normal(0.0, 0.2, 3)), rng.normal(0.0, 0.08, 3)).homogeneous
        for k in range(at, min(at + n // 8, n)):
            given[k] = given[k] @ jump
            true[k] = true[k] @ jump
        for k in np.flatnonzero(rng.uniform(size=n) < 0.05):
            given[k] = None
        gone = int(rng.integers(n // 2, 3 * n // 4))
        given[gone : gone + n // 16] = [None] * len(given[gone : gone + n // 16])
    return Motion(q0, true, given, kind)


def off_target(forward: Any, q: np.ndarray, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distances (m) and angles (rad) of the tip from poses, by forward kinematics of one's own."""
    position, angle = np.empty(len(q)), np.empty(len(q))
    for k, (each, T) in enumerate(zip(q, poses, strict=True)):
        tip = forward(each)
        position[k] = np.linalg.norm(tip.translation - T[:3, 3])
        angle[k] = np.linalg.norm(pin.log3(tip.rotation.T @ T[:3, :3]))
    return position, angle
