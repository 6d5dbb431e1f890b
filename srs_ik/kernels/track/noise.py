"""The noise of a target, told from its motion, and how long a filter has to be for it.

What moves smoothly has third differences that hardly change from one to the next; those of white noise change their
sign. So minus the product of two in a row is the noise, 15 times its variance in the mean, and less than nothing where
there is none. Its median over a window does not see jumps: they are a few samples. Differences are divided by times:
between targets some may be lost, or be expected at every tenth update alone.
"""

import math

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import load_pose, store_pose
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import track as at
from srs_ik.kernels.layout.limb import FAR
from srs_ik.kernels.track.target import way_to

ENOUGH = 5
"""Targets in a row that make two third differences."""

LONGER = 3.0
"""A target so many times later than the one before was after its own is the first one again."""

PER_VARIANCE = 3.0 * 15.0 * 0.79
"""The median of `WINDOWED` samples, of three axes, over the variance of one: 15 is the mean, and 0.79 the median of as
many over the mean, by 12,500 windows of white noise."""

ARM = 0.5
"""The lever of accelerations of the tip, by the reach."""

NEGLIGIBLE = 0.01
"""Noise that, as it is, asks for less than this share of the acceleration of the slowest joint is followed."""

USUAL = 0.02
ASKS_FOR = 0.125
STEEP = 1.0 / 3.0
"""A filter with the first of these time constants, seconds, is for noise that then asks for this share of that
acceleration. By accelerations alone, it would be longer with the noise to the power of 0.4; with a lag as large as what
is left of the noise, to the power of 2/9. Between them, it is good for noise from 5 um to 2 mm."""


@kernel
def put_in_order(a, old, new):
    """Replace one of WINDOWED sorted figures by another, and keep the order."""
    k = 0
    while a[k] != old and k < at.WINDOWED - 1:
        k += 1
    while k > 0 and a[k - 1] > new:
        a[k] = a[k - 1]
        k -= 1
    while k < at.WINDOWED - 1 and a[k + 1] < new:
        a[k] = a[k + 1]
        k += 1
    a[k] = new


@kernel
def note(S, i, product):
    """Take a sample of the linear (0) or the angular noise (1) into its window."""
    here = at.WINDOW + at.WINDOWED * i + int(S[at.WINDOW_AT])
    put_in_order(row(S, at.SORTED + at.WINDOWED * i), S[here], -product)
    S[here] = -product


@kernel
def skip(S):
    """A target that has jumped: no difference spans it."""
    S[at.IN_A_ROW] = 0.0


@kernel
def common(h1, h2, h3, h4):
    """Minus the covariance of two third divided differences in a row, of white noise, over its variance.

    They have three samples in common; between all five are these times. For times of 1, it is 15 / 36.
    """
    a = h2 + h3
    first = 1.0 / (h1 * (h2 * a) ** 2 * (a + h4))
    second = 1.0 / ((h1 + h2) * (h2 * h3) ** 2 * (h3 + h4))
    return first + second + 1.0 / ((h1 + a) * (a * h3) ** 2 * h4)


@kernel
def measure(S, gap, R, p):
    """Take in a target as it came, so many periods after the one before."""
    linear, angular = way_to(load_pose(S, at.GIVEN), (R, p))
    store_pose(S, at.GIVEN, R, p)
    if gap > LONGER * S[at.SPACING]:
        skip(S)
    h1, h2, h3, h4 = gap, S[at.SPACING], S[at.SPACING + 1], S[at.SPACING + 2]
    S[at.SPACING], S[at.SPACING + 1], S[at.SPACING + 2], S[at.SPACING + 3] = h1, h2, h3, h4
    S[at.IN_A_ROW] = min(S[at.IN_A_ROW] + 1.0, ENOUGH)
    if S[at.IN_A_ROW] == 1.0:
        return
    products = (0.0, 0.0)
    for i in range(6):
        first = (linear[i] if i < 3 else angular[i - 3]) / h1
        second = (first - S[at.CHANGES + i]) / (h1 + h2)
        third = (second - S[at.CHANGES + 6 + i]) / (h1 + h2 + h3)
        product = third * S[at.CHANGES + 12 + i]
        products = (products[0] + product, products[1]) if i < 3 else (products[0], products[1] + product)
        S[at.CHANGES + i], S[at.CHANGES + 6 + i], S[at.CHANGES + 12 + i] = first, second, third
    if S[at.IN_A_ROW] == ENOUGH:
        evenly = 15.0 / common(h1, h2, h3, h4)
        note(S, 0, evenly * products[0])
        note(S, 1, evenly * products[1])
        S[at.EVERY] = 0.25 * (h1 + h2 + h3 + h4)
        S[at.WINDOW_AT] = (S[at.WINDOW_AT] + 1.0) % at.WINDOWED
        S[at.NOISE], S[at.NOISE + 1] = deviation(S, 0), deviation(S, 1)


@kernel
def deviation(S, i):
    """Standard deviation of the linear (0) or the angular noise (1), m or rad an axis."""
    k = at.SORTED + at.WINDOWED * i + at.WINDOWED // 2
    return math.sqrt(max(0.5 * (S[k - 1] + S[k]), 0.0) / PER_VARIANCE)


@kernel
def asked_for(P, S, C):
    """The time constant of the filter that the noise asks for, seconds."""
    most = math.inf
    for j in range(7):
        most = min(most, C[at.ACCELERATION + j], at.SOFT_START * C[at.SPEED + j])
    period = C[at.PERIOD]
    shaken = math.hypot(S[at.NOISE] / (ARM * P[FAR]), S[at.NOISE + 1])
    # A second difference of white noise is sqrt(6) times as large as the noise.
    share = math.sqrt(6.0) * shaken / (period * period * most)
    if share <= NEGLIGIBLE:
        return 0.0
    filtered = shaken * math.sqrt(S[at.EVERY] * period) / (most * USUAL**2.5)
    return USUAL * (filtered / ASKS_FOR) ** STEEP * (1.0 - NEGLIGIBLE / share)
