"""Where joints come to rest that brake as hard as they may, and how they get there."""

from __future__ import annotations

import numpy as np

from srs_ik.system.arrays import Array

BRAKE = 1.0 - 2e-6
"""Share of the largest acceleration that is reckoned with for stopping: that of the kernels, which leaves rounding."""

MOST_LINES = 256
"""A way to rest of more periods is told by so many of its postures."""


def braking(q: Array, v: Array, push: Array, dt: float, limits: tuple[Array, Array]) -> Array:
    """(n, 7) postures at the ends of the periods until all joints rest that brake as hard as they may, after q itself.

    Args:
        q: (7,) rad.
        v: (7,) rad/s.
        push: (7,) largest accelerations, rad/s^2.
        dt: a period, s.
        limits: (7,) least and largest joint angles, rad; braking, no joint leaves them by more than rounding.
    """
    slower, speed = BRAKE * push * dt, np.abs(v)
    count = int(np.ceil((speed / slower).max()))
    # Summed in closed form: with short periods there are many.
    wanted = np.arange(1, count + 1) if count <= MOST_LINES else np.linspace(1, count, MOST_LINES).astype(np.int64)
    full = np.minimum(wanted[:, None], np.floor(speed / slower))
    way = dt * (full * speed - 0.5 * slower * full * (full + 1.0))
    return np.vstack([q, np.clip(q + np.sign(v) * way, *limits)])
