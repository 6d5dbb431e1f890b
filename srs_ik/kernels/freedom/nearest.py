"""The posture nearest to a seed over all turns that a pose leaves free, all branches and all arm angles.

Local searches on the true chain start from a grid (`starts`), the best of it first; what lies next to a start that was
taken is left out.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.exact.nearest import between_limbs
from srs_ik.kernels.freedom.settle import settle
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import SOLVED
from srs_ik.kernels.layout.freedom import START_COST, Found, Liking
from srs_ik.kernels.layout.limb import IS_CLOSED, PHASE, SHOULDER, STRAIGHT, WRIST
from srs_ik.kernels.limb.poses import read7

APART = 0.5
"""Starts this close to each other, rad in every joint, lead to the same posture."""

CLOSE = 0.15
CLEAR = 2.0
"""A posture this close to a seed, rad, is the nearest one if no joint is singular within so many times its distance."""

NONE_LEFT = 1e300

ATTEMPTS = 32
ATTEMPTS_NEAR = 32
"""Local searches at least, on an exact limb and on a near one, whose starts are not quite on its poses."""

NO_NEARER = 2.0
"""A search does not come so much nearer to the seed than its start, rad."""

MOST_ATTEMPTS = 60
"""The same where none has found a posture yet."""


@kernel
def are_close(starts, i, k):
    """Whether two starts lead to the same posture."""
    most = 0.0
    for j in range(7):
        most = max(most, abs(starts[i, j] - starts[k, j]))
    return most < APART


@kernel
def take_best(starts, n):
    """The start of least cost (-1: none is left) and that cost; drop it and those next to it."""
    best, least = -1, NONE_LEFT
    for i in range(n):
        if starts[i, START_COST] < least:
            best, least = i, starts[i, START_COST]
    if best >= 0:
        for i in range(n):
            if starts[i, START_COST] < NONE_LEFT and are_close(starts, i, best):
                starts[i, START_COST] = NONE_LEFT
    return best, least


@kernel
def beside(P, pose, freedom, liking, desk):
    """The posture that a search from the seed itself leads to; met where it is so close that there is no nearer one."""
    rival = Liking(liking.posture, liking.weights, liking.lower, liking.upper, CLOSE * CLOSE, liking.posture)
    there, cost, error, at_rest = settle(P, liking.posture, pose, freedom, rival, desk)
    q, distance = liking.posture, math.sqrt(cost)
    s2 = abs(math.sin(q[1] - P[SHOULDER + PHASE]))
    s4 = abs(math.sin(q[3] - P[STRAIGHT]))
    s6 = abs(math.sin(q[5] - P[WRIST + PHASE]))
    alone = distance < CLOSE and min(s2, s4, s6) > CLEAR * distance + between_limbs(P)
    return Found(there, cost, at_rest and error < SOLVED and alone)


@kernel
def nearest(P, pose, freedom, liking, count, desk):
    """The nearest posture that searches from the starts in `desk` lead to, `count` of them."""
    found = Found(liking.posture, NONE_LEFT, False)
    attempts = ATTEMPTS if P[IS_CLOSED] == 1.0 else ATTEMPTS_NEAR
    for k in range(MOST_ATTEMPTS):
        if k >= attempts and found.met:
            break
        i, distance = take_best(desk.starts, count)
        if i < 0 or (found.met and math.sqrt(distance) > math.sqrt(found.cost) + NO_NEARER):
            break
        start = read7(row(desk.starts, i))
        rival = Liking(liking.posture, liking.weights, liking.lower, liking.upper, found.cost, found.q)
        there, cost, error, _ = settle(P, start, pose, freedom, rival, desk)
        if error < SOLVED and cost < found.cost:
            found = Found(there, cost, True)
    return found
