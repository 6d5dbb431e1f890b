"""The posture nearest to a seed over all turns that a pose leaves free, all branches and all arm angles.

Local searches on the true chain start from a grid (`starts`), the best of it first; what lies next to a start that was
taken is left out.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.joint_vectors import between
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import load3, norm
from srs_ik.kernels.chain.freedom import free_error
from srs_ik.kernels.exact.nearest import between_limbs
from srs_ik.kernels.freedom.settle import distance, settle
from srs_ik.kernels.freedom.starts import NARROW
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import SOLVED
from srs_ik.kernels.layout.freedom import START, START_COST, Found, Liking
from srs_ik.kernels.layout.limb import FAR, MISS, PHASE, SHOULDER, STRAIGHT, WRIST, WRIST_IN_TIP
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.poses import read7

APART = 0.5
"""Starts this close to each other, rad in every joint, lead to the same posture."""

CLOSE = 0.15
CLEAR = 2.0
"""A posture this close to a seed, rad, is the nearest one if no joint is singular within so many times its distance."""

SPREAD = math.sqrt(7.0)
"""Seven joints that turn by one together, each by the same, turn the tip by at most so much."""

NONE_LEFT = 1e300

ATTEMPTS, ATTEMPTS_IN_CONE, ATTEMPTS_IN_WIDE_CONE = 32, 20, 12
"""Local searches at least: the farther the axis may lean, the farther they come."""

NO_NEARER = 2.0
"""A search does not come so much nearer to the seed than what its start costs, rad ..."""

NO_SHORTER = 1.0
"""... nor so much nearer than its start is once it is inside the limits."""

MOST_ATTEMPTS = 60
"""Searches at most, where none has found a posture yet."""


@kernel
def are_close(a, b):
    """Whether two starts lead to the same posture."""
    j = 0
    while j < 7 and abs(a[j] - b[j]) < APART:
        j += 1
    return j == 7


@kernel
def copy_start(a, b):
    """Write a start over another one."""
    for j in range(START):
        b[j] = a[j]


@kernel
def take_best(starts, n):
    """Take the start of least cost out of n, and drop those next to it: it, its cost, and how many are left.

    The cost is `NONE_LEFT` where there was none.
    """
    best, least = 0, NONE_LEFT
    for i in range(n):
        if starts[i, START_COST] < least:
            best, least = i, starts[i, START_COST]
    if least >= NONE_LEFT:
        return NO_SEED, least, 0
    q = read7(row(starts, best))
    left = 0
    for i in range(n):
        here = row(starts, i)
        if not are_close(here, q):
            copy_start(here, row(starts, left))
            left += 1
    return q, least, left


@kernel
def beside(P, pose, freedom, liking, desk):
    """The posture that a search from the seed itself leads to; met where it is so close that there is no nearer one."""
    off, turned = free_error(P, liking.posture, pose[0], pose[1], freedom)
    if max(off, turned) < SOLVED and between(liking.posture, liking.lower, liking.upper) == liking.posture:
        return Found(liking.posture, 0.0, True)
    tip = norm(load3(P, WRIST_IN_TIP))
    if turned > SPREAD * CLOSE or off > SPREAD * CLOSE * (P[FAR] + tip + P[MISS]):
        return Found(liking.posture, NONE_LEFT, False)
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
    attempts = 0
    enough = ATTEMPTS
    if freedom.cone > 0.0:
        enough = ATTEMPTS_IN_CONE if freedom.cone < NARROW else ATTEMPTS_IN_WIDE_CONE
    while attempts < MOST_ATTEMPTS and not (found.met and attempts >= enough):
        start, least, count = take_best(desk.starts, count)
        reached = math.sqrt(found.cost)
        if least >= NONE_LEFT or (found.met and math.sqrt(least) > reached + NO_NEARER):
            break
        start = between(start, liking.lower, liking.upper)
        if found.met and math.sqrt(distance(start, liking)) > reached + NO_SHORTER:
            continue
        attempts += 1
        rival = Liking(liking.posture, liking.weights, liking.lower, liking.upper, found.cost, found.q)
        there, cost, error, _ = settle(P, start, pose, freedom, rival, desk)
        if error < SOLVED and cost < found.cost:
            found = Found(there, cost, True)
    return found
