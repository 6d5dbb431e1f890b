"""What a drive makes of joint angles that are sent to it, within its limits of velocity and acceleration.

Trackers that know no limits of acceleration send what no joint can do. What a tip is on, then, is what comes of that.
"""

from __future__ import annotations

from typing import Any

import numpy as np

SHARE = 0.8
"""Of its largest acceleration, what a drive reckons with for stopping at a command; the rest is for that one's own."""


def stopping_speed(room: np.ndarray, hardest: np.ndarray, dt: float) -> np.ndarray:
    """(7,) the largest velocities for the next period after which joints can stop within these distances, rad/s.

    With velocities v, v - a T, v - 2 a T, ... the way is (n + 1) v T - a T^2 n (n + 1) / 2, where n periods follow.
    """
    n = np.floor(0.5 * (np.sqrt(1.0 + 8.0 * room / (hardest * dt**2)) - 1.0))
    return np.asarray((room / dt + 0.5 * hardest * dt * n * (n + 1.0)) / (n + 1.0))


def driven(
    arm: Any, q0: np.ndarray, commands: np.ndarray, bounds: tuple[np.ndarray, np.ndarray], dt: float
) -> np.ndarray:
    """(n, 7) joint angles of a drive, from rest, by the commands for the ends of its periods.

    Each joint comes to its command in the shortest time, relative to the velocity of that, and stops there. A drive
    that is on a command within its limits stays on it, so what keeps the limits comes through as it is. Ranges are not
    looked at: what the drive passes an end by counts for nothing.
    """
    fastest, hardest = bounds
    turns = np.isinf(arm.upper)
    q, v, last = np.array(q0, float), np.zeros(7), np.array(q0, float)
    out = np.empty_like(commands)
    for k, command in enumerate(commands):
        step = command - last
        step[turns] = (step[turns] + np.pi) % (2.0 * np.pi) - np.pi
        last = last + step
        rate = np.clip(step / dt, -fastest, fastest)
        behind = last - q - dt * rate
        wanted = rate + np.sign(behind) * stopping_speed(np.abs(behind), SHARE * hardest, dt)
        v = np.clip(np.clip(wanted, v - dt * hardest, v + dt * hardest), -fastest, fastest)
        q = q + dt * v
        out[k] = q
    return out
