"""A free mass on one axis under a fractal impedance: what rate and delay do, without the arm around it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from srs_ik.control.profile import ForceProfile, Law, positive
from srs_ik.errors import InvalidController
from srs_ik.kernels.entries import control as entries
from srs_ik.kernels.layout import control as at

Array = NDArray[np.float64]


def free_response(profile: ForceProfile, mass: float, start: float, dt: float, count: int, law: Law = "A") -> Array:
    """Error (count,), m, of a mass let go at rest, every dt, s, under the law in continuous time.

    With law A it is start/2 (1 + cos wt), w^2 = 2 F(start)/(start mass), and at rest on the target after pi/w.

    Raises:
        InvalidController: a figure is not positive.
    """
    positions = np.empty(count)
    entries.free_response(
        profile.row(law), positive(mass, "mass"), positive(start, "start"), positive(dt, "time step"), positions
    )
    return positions


def sampled_response(
    profile: ForceProfile,
    mass: float,
    start: float,
    period: float,
    delay: float,
    duration: float,
    law: Law = "A",
) -> Array:
    """Position (m), speed (m/s) and force (N), (n, 3), of a mass under a controller that samples and acts late.

    The force of a sample is held for a period (s), and begins `delay` (s) after it; the target is at zero.

    Raises:
        InvalidController: a figure is not positive, or the delay negative.
    """
    period = positive(period, "period")
    if not 0.0 <= delay < math.inf:
        raise InvalidController(f"the delay is a time, s, not {delay!r}")
    out = np.empty((max(1, round(positive(duration, "duration") / period)), 3))
    state = np.zeros(at.STATE)
    state[at.LAST : at.LAST + 3] = -1.0
    setting = np.array([positive(mass, "mass"), positive(start, "start"), period, delay])
    entries.sampled_response(profile.row(law), state, setting, np.zeros(int(delay / period) + 3), out)
    return out
