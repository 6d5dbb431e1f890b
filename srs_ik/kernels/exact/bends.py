"""The bend of an elbow that is almost straight or folded: a pose tells it no better than it tells the reach.

A bend x takes no more than the square of it off the reach. So a pose whose elbow is almost flat has a range of bends,
and where the outer axes of the shoulder or of the wrist lie along the arm as well, each of them has a curve of
postures of its own: together they are a surface, on which the joints turn far.
"""

import math

import numpy as np

from srs_ik.kernels.algebra.minimum import propose, start_search, tell
from srs_ik.kernels.algebra.pointers import copy, row, scratch
from srs_ik.kernels.exact.farthest import farthest, whole_circles
from srs_ik.kernels.exact.intervals import find_intervals
from srs_ik.kernels.exact.nearest_within import height, nearest_within
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import MAX_PIECES
from srs_ik.kernels.layout.limb import FAR, LOWER, NEAR, SHOULDER, SIZE, UPPER, WRIST
from srs_ik.kernels.layout.search import STATE
from srs_ik.kernels.limb.branches import NO_BRANCH
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.limits import set_joint_limits, set_limit

UNTOLD = 2e-13
"""Reaches that differ by less than this, m, are one."""

WIDE = 1e-7
"""A range of bends that is a smaller part of them is one bend ..."""

SMALLEST = 1e-6
"""... and bends below this part of the largest one are none."""

PACE = 1.5
"""The first bends that are tried are apart by this factor."""

MOST_BENDS = 48
MINIMA = 3
"""Bends that are tried first, and the most of them that are closed in on."""

FINENESS = 1e-9
"""How closely, as a part of the bend."""

FLAT = 1e-9
"""Distances from a seed, rad, and margins that differ by less are equal."""

MARGIN = 0.2
"""Bends are told apart by postures that are farther from a seed than the best so far by up to this, rad, and up to its
distance."""


@kernel
def range_of_bends(P, c, s):
    """The smallest and the largest sine of a bend that a pose with this one may have."""
    reach = P[FAR] if c > 0.0 else P[NEAR]
    spread = 8.0 * UNTOLD * reach / ((P[FAR] - P[NEAR]) * (P[FAR] + P[NEAR]))
    return math.sqrt(max(s * s - spread, 0.0)), math.sqrt(s * s + spread)


@kernel
def bent_place(place_, s):
    """A place with another bend of the elbow on the same side of flat."""
    t, h0, c, _, hand, miss = place_
    return t, h0, math.copysign(math.sqrt(1.0 - s * s), c), s, hand, miss


@kernel
def best_on_circles(P, place_, branch, goal):
    """The best posture over all arm angles: q, branch, cost."""
    found = np.empty((8 * MAX_PIECES, 3))
    n = 0
    if goal.respect:
        n = find_intervals(P, place_, branch, found)
    else:
        whole_circles(found)
        n = 8
    if goal.seeded:
        return nearest_within(P, place_, found[:n], branch, goal, 4.0 * NO_BRANCH)
    return farthest(P, place_, found[:n], branch, goal.respect)


@kernel
def draw_around(P, goal, distance, box):
    """Copy the packed limb to `box`, with limits around a seed and, if they are respected, inside its own."""
    copy(P, box, SIZE)
    for j in range(7):
        lower, upper = goal.seed[j] - distance, goal.seed[j] + distance
        if goal.respect:
            lower, upper = max(lower, P[LOWER + j]), min(upper, P[UPPER + j])
        set_limit(box, j, min(lower, upper), upper)
    set_joint_limits(box, SHOULDER, 0)
    set_joint_limits(box, WRIST, 4)


@kernel
def at_bend(P, box, place_, x, branch, goal, hope):
    """The best posture at the logarithm of a bend: q, branch, cost, and what a search is told.

    Near a seed, of those within the limits of `box` and nearer than `hope`, rad.
    """
    bent = bent_place(place_, math.exp(x))
    if not goal.seeded:
        q, found, value = best_on_circles(P, bent, branch, goal)
        return q, found, value, value
    intervals = np.empty((8 * MAX_PIECES, 3))
    n = find_intervals(box, bent, branch, intervals)
    q, found, value = nearest_within(P, bent, intervals[:n], branch, goal, hope * hope)
    return q, found, value, height(value)


@kernel
def take_bends(lower, upper, logs):
    """Fill in the logarithms of the bends that are tried first; return their number."""
    lower = max(lower, SMALLEST * upper)
    count = min(max(math.ceil(math.log(upper / lower) / math.log(PACE)), 2), MOST_BENDS - 1)
    for i in range(count + 1):
        logs[i] = math.log(lower) + math.log(upper / lower) * i / count
    return count + 1


@kernel
def lowest_left(values, n):
    """The lowest of the minima among sorted values, plateaus and those marked as done left out; -1: none."""
    found = -1
    for i in range(n):
        here = values[i, 0]
        before, behind = values[max(i - 1, 0), 0], values[min(i + 1, n - 1), 0]
        if values[i, 1] != 0.0 or here > min(before, behind) or max(before, behind) < here + FLAT:
            continue
        if found < 0 or here < values[found, 0]:
            found = i
    return found


@kernel
def best_of_bends(P, place_, branch, goal, lowest):
    """The best posture over all arm angles and all bends that a pose may have: q, branch, cost.

    Looks for a cost below `lowest` alone; there may be none.
    """
    lower, upper = range_of_bends(P, place_[2], place_[3])
    best_q, best, least = NO_SEED, 0, 4.0 * NO_BRANCH
    if upper - lower < WIDE * upper:
        return best_q, best, least
    box = row(scratch(1, SIZE), 0)
    hope = 0.0
    if goal.seeded:
        distance = height(lowest)
        if distance < FLAT:
            return best_q, best, least
        hope = distance + min(distance, MARGIN)
        draw_around(P, goal, hope, box)
    logs, values, S = np.empty(MOST_BENDS), np.empty((MOST_BENDS, 2)), np.empty(STATE)
    n = take_bends(lower, upper, logs)
    for i in range(n):
        q, found, value, values[i, 0] = at_bend(P, box, place_, logs[i], branch, goal, hope)
        values[i, 1] = 0.0
        if value < least:
            best_q, best, least = q, found, value
    for _ in range(MINIMA):
        i = lowest_left(values, n)
        if i < 0 or (goal.seeded and values[i, 0] >= NO_BRANCH):
            break
        values[i, 1] = 1.0
        a, b = max(i - 1, 0), min(i + 1, n - 1)
        start_search(S, logs[a], logs[i], logs[b], values[a, 0], values[i, 0], values[b, 0], FINENESS)
        while True:
            x, wanted = propose(S)
            if not wanted:
                break
            q, found, value, here = at_bend(P, box, place_, x, branch, goal, hope)
            tell(S, here)
            if value < least:
                best_q, best, least = q, found, value
    return best_q, best, least
