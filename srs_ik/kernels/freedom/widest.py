"""The posture farthest from the joint limits over all turns that a pose leaves free.

Local searches (`widen`) start from a grid (`starts`), the best of it first.
"""

from __future__ import annotations

import math

from srs_ik.kernels.freedom.nearest import MOST_ATTEMPTS, NONE_LEFT, take_best
from srs_ik.kernels.freedom.settle import NO_RIVAL
from srs_ik.kernels.freedom.widen import widen
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import SOLVED
from srs_ik.kernels.layout.freedom import Found
from srs_ik.kernels.layout.limb import INVERSE_HALF_RANGE
from srs_ik.kernels.limb.limits import middles

ATTEMPTS = 8
"""Local searches at least."""

LEAST_WEIGHT = 1e-6
"""Weight of a joint without limits, which may be anywhere."""


@kernel
def weight(P, j):
    """Weight of a joint's squared distance from the middle of its range."""
    return max(P[INVERSE_HALF_RANGE + j] ** 2, LEAST_WEIGHT)


@kernel
def any_limited(P):
    """Whether any joint has limits."""
    most = 0.0
    for j in range(7):
        most = max(most, P[INVERSE_HALF_RANGE + j])
    return most > 0.0


@kernel
def weights(P):
    """Weights of the squared distances from the middles of all ranges."""
    return (weight(P, 0), weight(P, 1), weight(P, 2), weight(P, 3), weight(P, 4), weight(P, 5), weight(P, 6))


@kernel
def widest(P, pose, freedom, known, count, desk):
    """The posture of the widest margin that searches from the starts in `desk` lead to, `count` of them.

    One that is known, if it is met, is where another search starts, and what the others have to beat.
    """
    best, most, attempts = middles(P), math.inf, 0
    if known.met:
        best, most = known.q, known.cost + 1.0
        q, share, error = widen(P, best, pose, freedom, NO_RIVAL, desk)
        if error < SOLVED and share < most:
            best, most = q, share
    while attempts < MOST_ATTEMPTS and not (most <= 1.0 and attempts >= ATTEMPTS):
        start, least, count = take_best(desk.starts, count)
        if least >= NONE_LEFT:
            break
        attempts += 1
        q, share, error = widen(P, start, pose, freedom, most, desk)
        if error < SOLVED and share < most:
            best, most = q, share
    if most > 1.0:
        return Found(best, NONE_LEFT, False)
    return Found(best, most - 1.0, True)
