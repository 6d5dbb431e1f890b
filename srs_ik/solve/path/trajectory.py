"""A motion through all postures of a joint path that a driver can play: from rest to rest, inside the limits."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, CubicSpline, PchipInterpolator, PPoly

from srs_ik.errors import InvalidConfiguration
from srs_ik.inputs.numbers import as_positive
from srs_ik.system.arrays import Array, equal_to_itself

ROUNDING = 1e-9
"""Joint angles outside the limits by this are there by rounding, rad; times by this part of the whole."""

MOST_SAMPLES = 10**7
"""Samples of a motion; with angles, velocities and accelerations they are 1.8 GB."""

APART = 1e-9
"""Passing times that are closer than this part of the whole are one: the path stands still there."""


@equal_to_itself
class Samples(NamedTuple):
    """A motion at evenly spaced times."""

    times: Array  # (M,) s, from 0 on
    q: Array  # (M, 7) rad
    velocity: Array  # (M, 7) rad/s
    acceleration: Array  # (M, 7) rad/s^2; that of the start is what sets it in motion, that of the end is 0


class Trajectory:
    """A motion through all postures of a path, from rest to rest.

    Joint angles are cubic polynomials of the time between two postures. Velocities are continuous, and so are
    accelerations between two rests, unless a joint would swing over its limit: then they jump at postures, and all
    joints stay between their angles at two neighbours. Joints without end go on over pi. At the beginning, at the end,
    and where the path has the same pose twice in a row, such as at a grip, all joints are at rest.

    Attributes:
        passes: (N,) when it passes the postures of the path, s. From rest to rest these are the times that the path
            had, multiplied by one factor, so that limits of velocity, and of acceleration where there are any, hold at
            all times and not only from posture to posture.
        stretch: by what factor it is slower than the path's own times, from beginning to end.
        duration: when it comes to rest, s.
    """

    def __init__(
        self,
        q: Array,
        times: Array,
        stands: NDArray[np.bool_],
        limits: tuple[Array, Array],
        most: tuple[Array, Array],
    ) -> None:
        moves = np.append(True, np.diff(times) > APART * times[-1])
        place = np.cumsum(moves) - 1
        own, angles = times[moves], q[moves]
        self._at_rest: Array | None = None
        if len(own) == 1:
            self._at_rest, self.stretch, self.passes, self.duration = q[0], 1.0, np.zeros(len(q)), 0.0
            return
        rests = np.unique(place[np.append(stands, True) | np.append(True, stands)])
        pieces = [slice(first, last + 1) for first, last in pairwise(rests)]
        parts = [_from_rest_to_rest(own[piece], angles[piece], limits, most) for piece in pieces]
        # What is added to times, so that those of parts that are not stretched stay as they are to the last bit.
        late = np.concatenate([(factor - 1.0) * np.diff(curve.x) for curve, factor in parts])
        x = own + np.append(0.0, np.cumsum(late))
        curve = PPoly(np.concatenate([_slowed(*part) for part in parts], axis=1), x)
        self.passes = x[place]
        self.duration = float(x[-1])
        self.stretch = self.duration / float(own[-1])
        self._curves = [curve, curve.derivative(), curve.derivative(2)]

    def sample(self, period: float) -> Samples:
        """The motion once in every period, until it is at rest.

        Args:
            period: seconds from one sample to the next.

        Raises:
            InvalidConfiguration: no positive period.
        """
        step = as_positive(period, "period", "seconds")
        count = int(np.ceil(self.duration * (1.0 - ROUNDING) / step)) + 1
        if count > MOST_SAMPLES:
            raise InvalidConfiguration(
                f"a period of {step:g} s makes {count:g} samples; at most {MOST_SAMPLES:g} are made"
            )
        times: Array = step * np.arange(count, dtype=float)
        if self._at_rest is not None:
            return Samples(times, self._at_rest[None].copy(), np.zeros((1, 7)), np.zeros((1, 7)))
        q, v, a = (curve(np.minimum(times, self.duration)) for curve in self._curves)
        rest = times >= self.duration
        v[rest] = a[rest] = 0.0
        return Samples(times, q, v, a)

    def __repr__(self) -> str:
        return f"Trajectory({len(self.passes)} postures in {self.duration:.4g} s)"


def _from_rest_to_rest(
    times: Array, q: Array, limits: tuple[Array, Array], most: tuple[Array, Array]
) -> tuple[PPoly, float]:
    """A curve through postures at their times, at rest at both ends, and how many times slower it keeps the limits."""
    curve: PPoly = CubicSpline(times, q, bc_type="clamped")
    if _leaves(curve, *limits):
        slopes = PchipInterpolator(times, q).derivative()(times)
        slopes[[0, -1]] = 0.0
        curve = CubicHermiteSpline(times, q, slopes)
    velocity, acceleration = most
    fast = (_largest_speed(curve) / velocity).max()
    hard = (np.abs(_ends(curve, 2)).max(axis=(0, 1)) / acceleration).max()
    return curve, max(1.0, float(fast), float(np.sqrt(hard)))


def _slowed(curve: PPoly, factor: float) -> Array:
    """Coefficients (4, pieces, 7) of a cubic curve that takes so many times as long."""
    return np.asarray(curve.c / factor ** np.arange(3.0, -1.0, -1.0)[:, None, None])


def _ends(curve: PPoly, order: int) -> Array:
    """(2, pieces, 7) a derivative at the beginning and at the end of every piece."""
    h = np.diff(curve.x)[:, None]
    c = curve.derivative(order).c
    return np.array([c[-1], sum(part * h ** (len(c) - 1 - k) for k, part in enumerate(c))])


def _largest_speed(curve: PPoly) -> Array:
    """(7,) the largest speed of each joint."""
    speed = np.abs(_ends(curve, 1)).max(axis=(0, 1))
    inside = _at(curve.derivative(), *_turning_points(curve.derivative()))
    return np.maximum(speed, np.abs(inside).max(axis=(0, 1)))


def _leaves(curve: PPoly, lower: Array, upper: Array) -> bool:
    """Whether a joint is outside its limits between postures that are inside."""
    extremes = _at(curve, *_turning_points(curve))
    return bool((extremes < lower - ROUNDING).any() or (extremes > upper + ROUNDING).any())


def _turning_points(curve: PPoly) -> tuple[Array, ...]:
    """Where in its piece (k, pieces, 7) a quadratic or cubic turns, from its beginning; that where it does not."""
    h = np.diff(curve.x)[:, None]
    c = curve.derivative().c
    with np.errstate(divide="ignore", invalid="ignore"):
        if len(c) == 2:
            found = [-c[1] / c[0]]
        else:
            root = np.sqrt(c[1] ** 2 - 4.0 * c[0] * c[2])
            half = -0.5 * (c[1] + np.where(c[1] < 0.0, -root, root))
            found = [half / c[0], c[2] / half]
    return tuple(np.where((u > 0.0) & (u < h), u, 0.0) for u in found)


def _at(curve: PPoly, *places: Array) -> Array:
    """(k, pieces, 7) values at places within their pieces."""
    return np.array([sum(part * u ** (len(curve.c) - 1 - k) for k, part in enumerate(curve.c)) for u in places])
