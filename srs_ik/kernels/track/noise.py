"""The noise of a target, told from its motion, and how long a filter has to be for it.

What moves smoothly has third differences that hardly change from one to the next; those of white noise change their
sign. So minus the product of two in a row is the noise, 15 times its variance in the mean, and less than nothing where
there is none. Its median over a window does not see jumps: they are a few samples. Lost targets are none.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import FAR
from srs_ik.kernels.layout.track import (
    ACCELERATION,
    CHANGES,
    GIVEN,
    IN_A_ROW,
    PERIOD,
    SORTED,
    WINDOW,
    WINDOW_AT,
    WINDOWED,
)
from srs_ik.kernels.track.target import load_pose, store_pose, way_to

ENOUGH = 5
"""Targets in a row that make two third differences."""

PER_VARIANCE = 3.0 * 15.0 * 0.79
"""The median of 32 products of third differences of three axes, over the variance of one: 15 is the mean of the product, and
0.79 the median over the mean, by 10,000 windows of white noise."""

ARM = 0.5
"""The lever of accelerations of the tip, by the reach."""

SHARE = 0.05
"""Noise may ask for so much of the acceleration of the slowest joint, without a filter."""

POWER = 0.4
"""Accelerations of a filtered pose fall with the time constant to the power of 2.5."""


@kernel
def put_in_order(a, old, new):
    """Replace one of WINDOWED sorted figures by another, and keep the order."""
    k = 0
    while a[k] != old and k < WINDOWED - 1:
        k += 1
    while k > 0 and a[k - 1] > new:
        a[k] = a[k - 1]
        k -= 1
    while k < WINDOWED - 1 and a[k + 1] < new:
        a[k] = a[k + 1]
        k += 1
    a[k] = new


@kernel
def note(S, i, product):
    """Take a sample of the linear (0) or the angular noise (1) into its window."""
    here = WINDOW + WINDOWED * i + int(S[WINDOW_AT])
    put_in_order(row(S, SORTED + WINDOWED * i), S[here], -product)
    S[here] = -product


@kernel
def skip(S):
    """A target that was lost, or has jumped: no difference spans it."""
    S[IN_A_ROW] = 0.0


@kernel
def measure(S, R, p):
    """Take in a target as it came."""
    linear, angular = way_to(load_pose(S, GIVEN), (R, p))
    store_pose(S, GIVEN, R, p)
    S[IN_A_ROW] = min(S[IN_A_ROW] + 1.0, ENOUGH)
    if S[IN_A_ROW] == 1.0:
        return
    products = (0.0, 0.0)
    for i in range(6):
        first = linear[i] if i < 3 else angular[i - 3]
        second = first - S[CHANGES + i]
        third = second - S[CHANGES + 6 + i]
        product = third * S[CHANGES + 12 + i]
        products = (products[0] + product, products[1]) if i < 3 else (products[0], products[1] + product)
        S[CHANGES + i], S[CHANGES + 6 + i], S[CHANGES + 12 + i] = first, second, third
    if S[IN_A_ROW] == ENOUGH:
        note(S, 0, products[0])
        note(S, 1, products[1])
        S[WINDOW_AT] = (S[WINDOW_AT] + 1.0) % WINDOWED


@kernel
def noise(S, i):
    """Standard deviation of the linear (0) or the angular noise (1), m or rad an axis."""
    k = SORTED + WINDOWED * i + WINDOWED // 2
    return math.sqrt(max(0.5 * (S[k - 1] + S[k]), 0.0) / PER_VARIANCE)


@kernel
def asked_for(P, S, C):
    """The time constant with which the noise asks for no more acceleration than it may, seconds."""
    most = C[ACCELERATION]
    for j in range(7):
        most = min(most, C[ACCELERATION + j])
    period = C[PERIOD]
    shaken = math.hypot(noise(S, 0) / (ARM * P[FAR]), noise(S, 1))
    # A second difference of white noise is sqrt(6) times as large as the noise.
    over = math.sqrt(6.0) * shaken / (period * period * SHARE * most)
    return period * (over**POWER - 1.0) if over > 1.0 else 0.0
