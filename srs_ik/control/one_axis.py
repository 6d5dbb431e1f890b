"""A free mass on one axis under a fractal impedance: what rate and delay do, without the arm around it."""

from __future__ import annotations

import numpy as np

from srs_ik.control.profile import ForceProfile, Law
from srs_ik.errors import InvalidController
from srs_ik.inputs import control as given
from srs_ik.kernels.entries import control as entries
from srs_ik.kernels.layout import control as at
from srs_ik.system.arrays import Array


def free_response(profile: ForceProfile, mass: float, start: float, dt: float, count: int, law: Law = "A") -> Array:
    """Error (count,), m, of a mass let go at rest, every dt, s, under the law in continuous time.

    With law A it is start/2 (1 + cos wt), w^2 = 2 F(start)/(start mass), and at rest on the target after pi/w.

    Raises:
        InvalidController: no profile or law, or a figure is not positive.
    """
    given.thing(profile, ForceProfile, "profile", "ForceProfile.tanh")
    positions = np.empty(given.count(count, "count"))
    figures = given.positive(mass, "mass"), given.positive(start, "start"), given.positive(dt, "time step")
    entries.free_response(profile.row(law), *figures, positions)
    return positions


def sampled_response(
    profile: ForceProfile, mass: float, start: float, period: float, delay: float, duration: float, law: Law = "A"
) -> Array:
    """Position (m), speed (m/s) and force (N), (n, 3), of a mass under a controller that samples and acts late.

    The force of a sample is held for a period (s), and begins `delay` (s) after it; the target is at zero.

    Raises:
        InvalidController: no profile or law, a figure is not positive, or the delay negative.
    """
    given.thing(profile, ForceProfile, "profile", "ForceProfile.tanh")
    period, delay = given.positive(period, "period"), given.not_negative(delay, "delay")
    out = np.empty((max(1, _rows(given.positive(duration, "duration") / period)), 3))
    state = np.zeros(at.STATE)
    state[at.LAST : at.LAST + 3] = -1.0
    setting = np.array([given.positive(mass, "mass"), given.positive(start, "start"), period, delay])
    entries.sampled_response(profile.row(law), state, setting, np.zeros(_rows(delay / period) + 3), out)
    return out


def _rows(number: float) -> int:
    """A number of samples; raises InvalidController where there would be too many."""
    if number > given.MOST:
        raise InvalidController(f"a response has at most {given.MOST:,} samples, not {number:.3g}")
    return round(number)
