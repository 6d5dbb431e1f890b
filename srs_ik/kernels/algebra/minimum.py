"""Minimum of a function of one variable in a bracket, asked for point by point.

The search is turned inside out: `propose` says where the function is wanted next and `tell` takes its value. So one
search serves objectives that are kernels and objectives that are Python functions. The method is Brent's (Algorithms
for Minimization without Derivatives, 1973, chapter 5): parabolas where they behave, golden sections where not. It
starts with the three points of the bracket known.
"""

from __future__ import annotations

import math

from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.search import (
    BEST,
    COUNT,
    F_BEST,
    F_SECOND,
    F_THIRD,
    HIGH,
    LOW,
    RESOLUTION,
    SECOND,
    STEP,
    STEP_BEFORE,
    THIRD,
    WANTED,
)

MOST_STEPS = 80

GOLDEN = 0.6180339887498949
"""A golden section leaves this part of its bracket."""


@kernel
def start_search(S, a, x, b, fa, fx, fb, resolution):
    """Begin with a bracket a <= x <= b whose values are known and lowest at x."""
    S[LOW] = a
    S[HIGH] = b
    S[BEST] = x
    S[F_BEST] = fx
    if fa <= fb:
        S[SECOND], S[F_SECOND], S[THIRD], S[F_THIRD] = a, fa, b, fb
    else:
        S[SECOND], S[F_SECOND], S[THIRD], S[F_THIRD] = b, fb, a, fa
    S[STEP] = b - a
    S[STEP_BEFORE] = b - a
    S[COUNT] = 0.0
    S[RESOLUTION] = resolution


@kernel
def propose(S):
    """Where the function is wanted next, and whether it is wanted at all."""
    finest = S[RESOLUTION]
    x = S[BEST]
    middle = 0.5 * (S[LOW] + S[HIGH])
    if abs(x - middle) <= 2.0 * finest - 0.5 * (S[HIGH] - S[LOW]) or S[COUNT] >= MOST_STEPS:
        return x, False
    before = S[STEP_BEFORE]
    r = (x - S[SECOND]) * (S[F_BEST] - S[F_THIRD])
    q = (x - S[THIRD]) * (S[F_BEST] - S[F_SECOND])
    p = (x - S[THIRD]) * q - (x - S[SECOND]) * r
    q = 2.0 * (q - r)
    if q > 0.0:
        p = -p
    q = abs(q)
    # Values that are not finite make every one of these comparisons false.
    if abs(before) > finest and abs(p) < abs(0.5 * q * before) and q * (S[LOW] - x) < p < q * (S[HIGH] - x):
        S[STEP_BEFORE] = S[STEP]
        step = p / q
        if x + step - S[LOW] < 2.0 * finest or S[HIGH] - x - step < 2.0 * finest:
            step = math.copysign(finest, middle - x)
    else:
        S[STEP_BEFORE] = S[HIGH] - x if x < middle else S[LOW] - x
        step = (1.0 - GOLDEN) * S[STEP_BEFORE]
    S[STEP] = step
    S[WANTED] = x + (step if abs(step) >= finest else math.copysign(finest, step))
    return S[WANTED], True


@kernel
def tell(S, f):
    """Take the value at the point asked for last; return whether it is the best so far."""
    u = S[WANTED]
    x = S[BEST]
    S[COUNT] += 1.0
    if f <= S[F_BEST]:
        if u >= x:
            S[LOW] = x
        else:
            S[HIGH] = x
        S[THIRD], S[F_THIRD] = S[SECOND], S[F_SECOND]
        S[SECOND], S[F_SECOND] = x, S[F_BEST]
        S[BEST], S[F_BEST] = u, f
        return True
    if u < x:
        S[LOW] = u
    else:
        S[HIGH] = u
    if f <= S[F_SECOND] or S[SECOND] == x:
        S[THIRD], S[F_THIRD] = S[SECOND], S[F_SECOND]
        S[SECOND], S[F_SECOND] = u, f
    elif f <= S[F_THIRD] or S[THIRD] == x or S[THIRD] == S[SECOND]:
        S[THIRD], S[F_THIRD] = u, f
    return False


@kernel
def lowest_of_cubic(a, b, from_ends):
    """Where the cubic through two points is lowest, no closer to them than a part of the way, and how low.

    A point is given as its parameter, its figure and the figure's rate, which falls at the first and rises at the last.
    """
    h = b[0] - a[0]
    fall, rise = a[2] * h, b[2] * h
    c2 = 3.0 * (b[1] - a[1]) - 2.0 * fall - rise
    c3 = 2.0 * (a[1] - b[1]) + fall + rise
    share = -fall / (c2 + math.sqrt(max(c2 * c2 - 3.0 * c3 * fall, 0.0)))
    share = min(max(share, from_ends), 1.0 - from_ends)
    return a[0] + share * h, a[1] + share * (fall + share * (c2 + share * c3))
