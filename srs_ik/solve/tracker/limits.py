"""Limits of a tracker: the period, and how fast joints may be."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.errors import InvalidConfiguration, MissingLimits, warn_caller
from srs_ik.inputs.numbers import as_positive, per_joint
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.packed import PackedArm

SHORTEST_PERIOD, LONGEST_PERIOD = 1e-6, 100.0
MOST = {"velocity": 1e6, "acceleration": 1e9, "jerk": 1e12}
"""Updates so far apart at least and at most, s, and joints so fast, rad/s, rad/s^2, rad/s^3: beyond that, figures
overflow."""

FULL_SPEED_IN = 0.1
"""Where no accelerations are given, each joint may come to its largest velocity in so many seconds."""

SOON = 0.05
"""A joint without a limit of acceleration comes to its largest velocity in so many seconds at the least: more than that
brings targets back no sooner, and shakes the arm."""


def as_period(dt: float) -> float:
    """The time between two updates, s; raises InvalidConfiguration for one that is none, too short or too long."""
    period = as_positive(dt, "dt", "seconds")
    if not SHORTEST_PERIOD <= period <= LONGEST_PERIOD:
        raise InvalidConfiguration(
            f"dt is the time between two updates, {SHORTEST_PERIOD:g} s at least and {LONGEST_PERIOD:g} s at most, "
            f"not {period:g}"
        )
    return period


def usual_accelerations(packed: PackedArm, velocity: Array) -> Array:
    """(7,) limits of acceleration where none are given, rad/s^2: the arm's own, or by the limits of velocity."""
    known = packed.acceleration_limit
    return np.where(np.isfinite(known), known, velocity / FULL_SPEED_IN)


def pushes(acceleration: Array, velocity: Array, dt: float) -> Array:
    """(7,) accelerations that are reckoned with, rad/s^2: the limits, finite ones where there is none."""
    return np.where(np.isinf(acceleration), np.minimum(velocity / SOON, velocity / dt), acceleration)


def limits_of(given: ArrayLike | None, packed: PackedArm, what: str, default: Array, endless: bool = False) -> Array:
    """(7,) positive figures: those given, one for all or one a joint, or the arm's own; finite ones but where told."""
    if given is None:
        missing = ~(np.isfinite(default) & (default > 0.0))
        if missing.any():
            names = [packed.joint_names[j] for j in np.flatnonzero(missing)]
            raise MissingLimits("velocity", names, packed.name)
        return kept(np.minimum(default, MOST[what]))
    figures = per_joint(given, what, MOST[what], endless)
    own = np.where(default > 0.0, default, np.inf)
    if what == "velocity" and (figures > own * (1.0 + 1e-9)).any():
        j = int((figures / own).argmax())
        warn_caller(
            f"joint {packed.joint_names[j]!r} may go at {figures[j]:.4g} rad/s, its own limit is {default[j]:.4g}"
        )
    return kept(figures)


def kept(figures: Array) -> Array:
    """Figures that nobody can change."""
    figures.setflags(write=False)
    return figures
