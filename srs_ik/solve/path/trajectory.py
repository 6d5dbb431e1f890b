"""A motion through all postures of a joint path that a driver can play: from rest to rest, inside the limits."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, CubicSpline, PchipInterpolator, PPoly

from srs_ik.errors import InvalidConfiguration
from srs_ik.inputs.numbers import as_positive
from srs_ik.solve.path.timing import passing_times
from srs_ik.system.arrays import Array, equal_to_itself

ROUNDING = 1e-9
"""Joint angles outside the limits by this are there by rounding, rad; times by this part of the whole."""

MOST_SAMPLES = 10**7
"""Samples of a motion; with angles, velocities and accelerations they are 1.8 GB."""

APART = 1e-9
"""Passing times that are closer than this part of the whole are one: the path stands still there."""

ROUNDS = 100
LONGER = 1.05
CLOSE = 1e-3
"""Where limits do not hold, a motion is slowed down in so many rounds, each piece by no more than this in one, until
they hold but for this part."""


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
        passes: (N,) when it passes the postures of the path, s: as far apart as the path's own times are, and farther
            about where limits of velocity, or of acceleration where there are any, would not hold between them.
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
        # What is added to times, so that those of parts that are not slowed down stay as they are to the last bit.
        late = np.concatenate([np.diff(part.x) for part in parts]) - np.diff(own)
        x = own + np.append(0.0, np.cumsum(late))
        curve = PPoly(np.concatenate([part.c for part in parts], axis=1), x)
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


def _from_rest_to_rest(times: Array, q: Array, limits: tuple[Array, Array], most: tuple[Array, Array]) -> PPoly:
    """A curve through postures, at rest at both ends, that keeps the limits: at their times, or slowed down.

    The quickest of all of it slowed down by one factor, and of what is slowed down where that is needed, from its own
    times and from the least ones between which limits hold from posture to posture.
    """
    curve = _through(times, q, limits)
    found = _slowed(curve, _use(curve, most))
    if found is curve:
        return curve
    own, least = np.diff(times), np.diff(passing_times(np.diff(q, axis=0), *most))
    for gaps in (own, np.maximum(own, least)):
        found = _slowed_in_part(gaps, q, limits, most, found)
    return found


def _slowed_in_part(
    gaps: Array, q: Array, limits: tuple[Array, Array], most: tuple[Array, Array], best: PPoly
) -> PPoly:
    """A curve through postures that are some times apart, or more where limits would not hold; `best`, if no quicker.

    Pieces that are too fast are made longer, and those beside them as far as that lets them be too fast in turn. What
    is missing then slows down the whole.
    """
    for _ in range(ROUNDS):
        curve = _through(best.x[0] + np.append(0.0, np.cumsum(gaps)), q, limits)
        use = _use(curve, most)
        slowed = _slowed(curve, use)
        best = slowed if slowed.x[-1] < best.x[-1] else best
        if use.max() <= 1.0 + CLOSE or curve.x[-1] >= best.x[-1]:
            break
        gaps = gaps * np.clip(use, 1.0, LONGER)
    return best


def _through(times: Array, q: Array, limits: tuple[Array, Array]) -> PPoly:
    """A curve through postures at their times, at rest at both ends, inside the limits of joint angles."""
    curve: PPoly = CubicSpline(times, q, bc_type="clamped")
    if _leaves(curve, *limits):
        slopes = PchipInterpolator(times, q).derivative()(times)
        slopes[[0, -1]] = 0.0
        curve = CubicHermiteSpline(times, q, slopes)
    return curve


def _use(curve: PPoly, most: tuple[Array, Array]) -> Array:
    """(pieces,) how many times slower each piece of a curve would keep limits of velocity and acceleration."""
    velocity, acceleration = most
    turns = _at(curve.derivative(), *_turning_points(curve.derivative()))
    speed = np.maximum(np.abs(_ends(curve, 1)).max(axis=0), np.abs(turns).max(axis=0))
    hard = np.abs(_ends(curve, 2)).max(axis=0)
    found: Array = np.maximum((speed / velocity).max(axis=1), np.sqrt((hard / acceleration).max(axis=1)))
    return found


def _slowed(curve: PPoly, use: Array) -> PPoly:
    """A cubic curve as many times slower as its most used piece asks for; itself where none does."""
    factor = max(1.0, float(use.max()))
    if factor == 1.0:
        return curve
    return PPoly(
        curve.c / factor ** np.arange(3.0, -1.0, -1.0)[:, None, None], curve.x[0] + factor * (curve.x - curve.x[0])
    )


def _ends(curve: PPoly, order: int) -> Array:
    """(2, pieces, 7) a derivative at the beginning and at the end of every piece."""
    h = np.diff(curve.x)[:, None]
    c = curve.derivative(order).c
    return np.array([c[-1], sum(part * h ** (len(c) - 1 - k) for k, part in enumerate(c))])


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
