"""The posture farthest from the joint limits over all turns that a pose leaves free.

Local searches (`widen`) start from a grid (`starts`), the best of it first.
"""

from __future__ import annotations

import math

from srs_ik.kernels.freedom.nearest import MOST_ATTEMPTS, NONE_LEFT, take_best
from srs_ik.kernels.freedom.settle import onto_pose
from srs_ik.kernels.freedom.widen import largest_share, widen
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import SOLVED
from srs_ik.kernels.layout.freedom import Found
from srs_ik.kernels.layout.limb import INVERSE_HALF_RANGE

ATTEMPTS, ATTEMPTS_IN_CONE = 8, 4
"""Local searches at least: where the axis may lean, they come farther."""

ALMOST = 1e-3
"""A search that ends this close to its pose, m and rad, is brought onto it."""

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
def widest(P, pose, freedom, liking, count, desk):
    """The posture of the widest margin that searches from the starts in `desk` lead to, `count` of them."""
    best, most, attempts = liking.posture, math.inf, 0
    enough = ATTEMPTS if freedom.cone == 0.0 else ATTEMPTS_IN_CONE
    while attempts < MOST_ATTEMPTS and not (most <= 1.0 and attempts >= enough):
        start, least, count = take_best(desk.starts, count)
        if least >= NONE_LEFT:
            break
        attempts += 1
        q, share, error = widen(P, start, pose, freedom, most, desk)
        if SOLVED <= error < ALMOST and share < most:
            q, error = onto_pose(P, q, pose, freedom, liking, desk)
            share = largest_share(P, q)
        if error < SOLVED and share < most:
            best, most = q, share
    if most > 1.0:
        return Found(best, NONE_LEFT, False)
    return Found(best, most - 1.0, True)
