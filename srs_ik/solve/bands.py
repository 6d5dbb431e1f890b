"""How far the true chain of a near limb is from its nearest exact one: measured over random configurations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.entries.pose import measure_shifts
from srs_ik.kernels.layout import limb as at

Array = NDArray[np.float64]

SAMPLES = 512
"""Random configurations; for as many more the elbow is almost straight."""

ALMOST_STRAIGHT = 0.3
"""Largest bend of the latter, rad."""

STRAIGHT = 0.05
"""Below this sine of its bend, the elbow is as good as straight, or folded."""

WELL_BENT = 0.8
"""From this sine on, the elbow is well bent."""


def put_bands(P: Array) -> None:
    """Write shift and bands of a near limb, (SIZE,), that is being packed.

    At a well-bent elbow, joint angles are off by about what axes miss, over the arm's lengths. Towards a straight one
    that grows with one over the sine of the bend. So each band is the most of the former, and what the latter adds to
    it, over those configurations where the closed form tells the side of the elbow. For that, the cosine of the bend
    counts: it is off by so much at a straight elbow, and by so much more for each part of the sine.
    """
    configurations = _configurations(P)
    shifts = np.zeros((len(configurations), at.SHIFTS))
    measure_shifts(P, configurations, shifts)
    true = np.abs(np.sin(configurations[:, 3] - P[at.STRAIGHT]))
    off = np.abs(shifts[:, at.SHIFT_COSINE])
    at_straight, slope = _above(off, true)

    sine, closed = shifts[:, at.SHIFT_BEND], np.abs(shifts[:, at.SHIFT_CLOSED])
    told = (sine > 0.0) & (1.0 - closed > at.WELL_CLEAR * (slope * sine + at_straight))
    well = told & (sine >= WELL_BENT)
    for joint in range(7):
        usual = shifts[well, joint].max(initial=0.0)
        growth = ((shifts[told, joint] - usual) * sine[told]).max(initial=0.0)
        P[at.BANDS + 2 * joint : at.BANDS + 2 * joint + 2] = usual, growth
    P[at.BANDS + 6 : at.BANDS + 8] = slope, at_straight
    well &= true >= WELL_BENT
    P[at.SHIFT] = (sine * shifts[:, :7].max(axis=1))[well].max(initial=0.0)


def _above(off: Array, true: Array) -> tuple[float, float]:
    """The line above all points (true, off), lowest where the elbow is almost straight: its value at 0, its slope."""
    least = off[true < STRAIGHT].max(initial=0.0)
    starts = least * np.linspace(1.0, 3.0, 9)
    slopes = ((off - starts[:, None]) / np.maximum(true, STRAIGHT)).max(axis=1, initial=0.0)
    best = int((starts + slopes * ALMOST_STRAIGHT).argmin())
    return float(starts[best]), float(slopes[best])


def _configurations(P: Array) -> Array:
    """Random configurations, (n, 7), whose elbow keeps its limits."""
    rng = np.random.default_rng(0)
    q = rng.uniform(-np.pi, np.pi, (2 * SAMPLES, 7))
    lower, upper = P[at.LOWER + 3], P[at.UPPER + 3]
    if np.isfinite(upper - lower):
        q[:SAMPLES, 3] = rng.uniform(lower, upper, SAMPLES)
    q[SAMPLES:, 3] = P[at.STRAIGHT] + ALMOST_STRAIGHT * q[SAMPLES:, 3] / np.pi
    turns = q[:, 3] - 2.0 * np.pi * np.floor((q[:, 3] - lower) / (2.0 * np.pi)) if np.isfinite(lower) else q[:, 3]
    kept: Array = q[turns <= upper]
    return kept
