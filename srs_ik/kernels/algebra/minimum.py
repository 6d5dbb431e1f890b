"""Minimum of a function of one variable in a bracket, asked for point by point.

The search is turned inside out: `propose` says where the function is wanted next and `tell` takes its value. So one
search serves objectives that are kernels and objectives that are Python functions. The method is Brent's (Algorithms
for Minimization without Derivatives, 1973, chapter 5): parabolas where they behave, golden sections where not. It
starts with the three points of the bracket known.
"""

import math

from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import search as at

MOST_STEPS = 80

GOLDEN = 0.6180339887498949
"""A golden section leaves this part of its bracket."""


@kernel
def start_search(S, a, x, b, fa, fx, fb, resolution):
    """Begin with a bracket a <= x <= b whose values are known and lowest at x."""
    S[at.LOW] = a
    S[at.HIGH] = b
    S[at.BEST] = x
    S[at.F_BEST] = fx
    if fa <= fb:
        S[at.SECOND], S[at.F_SECOND], S[at.THIRD], S[at.F_THIRD] = a, fa, b, fb
    else:
        S[at.SECOND], S[at.F_SECOND], S[at.THIRD], S[at.F_THIRD] = b, fb, a, fa
    S[at.STEP] = b - a
    S[at.STEP_BEFORE] = b - a
    S[at.COUNT] = 0.0
    S[at.RESOLUTION] = resolution


@kernel
def propose(S):
    """Where the function is wanted next, and whether it is wanted at all."""
    finest = S[at.RESOLUTION]
    x = S[at.BEST]
    middle = 0.5 * (S[at.LOW] + S[at.HIGH])
    if abs(x - middle) <= 2.0 * finest - 0.5 * (S[at.HIGH] - S[at.LOW]) or S[at.COUNT] >= MOST_STEPS:
        return x, False
    before = S[at.STEP_BEFORE]
    r = (x - S[at.SECOND]) * (S[at.F_BEST] - S[at.F_THIRD])
    q = (x - S[at.THIRD]) * (S[at.F_BEST] - S[at.F_SECOND])
    p = (x - S[at.THIRD]) * q - (x - S[at.SECOND]) * r
    q = 2.0 * (q - r)
    if q > 0.0:
        p = -p
    q = abs(q)
    # Values that are not finite make every one of these comparisons false.
    if abs(before) > finest and abs(p) < abs(0.5 * q * before) and q * (S[at.LOW] - x) < p < q * (S[at.HIGH] - x):
        S[at.STEP_BEFORE] = S[at.STEP]
        step = p / q
        if x + step - S[at.LOW] < 2.0 * finest or S[at.HIGH] - x - step < 2.0 * finest:
            step = math.copysign(finest, middle - x)
    else:
        S[at.STEP_BEFORE] = S[at.HIGH] - x if x < middle else S[at.LOW] - x
        step = (1.0 - GOLDEN) * S[at.STEP_BEFORE]
    S[at.STEP] = step
    S[at.WANTED] = x + (step if abs(step) >= finest else math.copysign(finest, step))
    return S[at.WANTED], True


@kernel
def tell(S, f):
    """Take the value at the point asked for last; return whether it is the best so far."""
    u = S[at.WANTED]
    x = S[at.BEST]
    S[at.COUNT] += 1.0
    if f <= S[at.F_BEST]:
        if u >= x:
            S[at.LOW] = x
        else:
            S[at.HIGH] = x
        S[at.THIRD], S[at.F_THIRD] = S[at.SECOND], S[at.F_SECOND]
        S[at.SECOND], S[at.F_SECOND] = x, S[at.F_BEST]
        S[at.BEST], S[at.F_BEST] = u, f
        return True
    if u < x:
        S[at.LOW] = u
    else:
        S[at.HIGH] = u
    if f <= S[at.F_SECOND] or S[at.SECOND] == x:
        S[at.THIRD], S[at.F_THIRD] = S[at.SECOND], S[at.F_SECOND]
        S[at.SECOND], S[at.F_SECOND] = u, f
    elif f <= S[at.F_THIRD] or S[at.THIRD] == x or S[at.THIRD] == S[at.SECOND]:
        S[at.THIRD], S[at.F_THIRD] = u, f
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
