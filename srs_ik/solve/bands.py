"""How far the true chain of a near limb is from its nearest exact one: measured over random configurations."""

from __future__ import annotations

import numpy as np

from srs_ik.kernels.entries.pose import measure_shifts
from srs_ik.kernels.layout import limb as at
from srs_ik.system.arrays import Array

SAMPLES = 1024
"""Random configurations; for as many more the elbow is almost straight."""

ALMOST_STRAIGHT = 0.3
"""Largest bend of the latter, rad."""

STRAIGHT = 0.05
"""Below this sine of its bend, the elbow is as good as straight, or folded."""

WELL_BENT = 0.8
"""From this sine on, the elbow is well bent."""


MARGIN = 1.5
"""Bands are wider by this factor than what is seen: some 10 of 100,000 other configurations are outside."""


def put_bands(P: Array) -> None:
    """Write shift and bands of a near limb, (SIZE,), that is being packed.

    At a well-bent elbow, joint angles are off by about what axes miss, over the arm's lengths. Towards a straight one
    that grows with one over the sine of the bend. So each band is the most of the former, and what the latter adds to
    it, over those configurations where the closed form tells the side of the elbow. For that, the cosine of the bend
    counts: the elbow is never straight where the cosine is farther from 1 than it is off at a straight elbow.
    """
    configurations = _configurations(P)
    shifts = np.zeros((len(configurations), at.SHIFTS))
    measure_shifts(P, configurations, shifts)
    true = np.abs(np.sin(configurations[:, 3] - P[at.STRAIGHT]))
    off = np.abs(shifts[:, at.SHIFT_COSINE])
    at_straight = float(off[true < STRAIGHT].max(initial=0.0))
    start, slope = _above(off, true, at_straight)

    sine, closed = shifts[:, at.SHIFT_BEND], np.abs(shifts[:, at.SHIFT_CLOSED])
    told = (sine > 0.0) & (1.0 - closed > at.WELL_CLEAR * at_straight)
    well = told & (sine >= WELL_BENT)
    for joint in range(7):
        usual = shifts[well, joint].max(initial=0.0)
        growth = ((shifts[told, joint] - usual) * sine[told]).max(initial=0.0)
        P[at.BANDS + 2 * joint : at.BANDS + 2 * joint + 2] = MARGIN * usual, MARGIN * growth
    P[at.BANDS + 6 : at.BANDS + 8], P[at.COSINE_OFF] = (MARGIN * slope, MARGIN * start), at_straight
    well &= true >= WELL_BENT
    P[at.SHIFT] = (sine * shifts[:, :7].max(axis=1))[well].max(initial=0.0)


def _above(off: Array, true: Array, least: float) -> tuple[float, float]:
    """The line above all points (true, off), lowest where the elbow is almost straight: its value at 0, its slope.

    At 0 it has some least value. Without end where some point has none.
    """
    if not np.isfinite(off).all():
        # The elbow is so close to another axis that nothing is foretold.
        return np.inf, 0.0
    starts = least * np.linspace(1.0, 3.0, 9)
    slopes = ((off - starts[:, None]) / np.maximum(true, STRAIGHT)).max(axis=1, initial=0.0)
    best = int((starts + slopes * ALMOST_STRAIGHT).argmin())
    return float(starts[best]), float(slopes[best])


def _configurations(P: Array) -> Array:
    """Random configurations, (n, 7), limits or not."""
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (2 * SAMPLES, 7))
    q[SAMPLES:, 3] = P[at.STRAIGHT] + ALMOST_STRAIGHT * q[SAMPLES:, 3] / np.pi
    return q
