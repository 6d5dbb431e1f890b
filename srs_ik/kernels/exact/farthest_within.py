"""The posture farthest from the joint limits within given intervals of an exact limb, all of them in one search.

As in `farthest`, a posture tells by drawn-in limits where all better ones are; here they are sought in the part of the
given intervals that is left then. So an interval that holds no better posture is never searched.
"""

from __future__ import annotations

import numpy as np

from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.exact.farthest import GAIN, GAIN_OUTSIDE, ROUNDS, branch_at, climb, draw_in
from srs_ik.kernels.exact.intervals import TURN, find_intervals
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import MAX_PIECES
from srs_ik.kernels.layout.limb import SIZE
from srs_ik.kernels.layout.search import STATE
from srs_ik.kernels.limb.branches import NO_BRANCH
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE, elbow_part
from srs_ik.kernels.limb.triangle import elbow_side

MOST_LEFT = 16 * MAX_PIECES
"""Room for the parts of intervals that may hold a better posture."""


@kernel
def put(out, n, branch, lower, upper):
    """Append an interval, if there is room; return the number of rows in use."""
    if n == out.shape[0]:
        return n
    out[n, 0], out[n, 1], out[n, 2] = branch, lower, upper
    return n + 1


@kernel
def common_parts(found, n, given, out):
    """Write what the first n intervals of found share with given ones of their branches; return the number of rows."""
    count = 0
    for k in range(given.shape[0]):
        for i in range(n):
            if found[i, 0] != given[k, 0]:
                continue
            for turns in range(-1, 2):
                lower = max(found[i, 1] + turns * TURN, given[k, 1])
                upper = min(found[i, 2] + turns * TURN, given[k, 2])
                if lower <= upper:
                    count = put(out, count, found[i, 0], lower, upper)
    return count


@kernel
def best_middle(P, sides, left, n, respect):
    """The best of the postures in the middle of n intervals: its row, the posture, its cost."""
    top, best_q, lowest = 0, NO_SEED, 4.0 * NO_BRANCH
    for i in range(n):
        b = int(left[i, 0])
        q, value = branch_at(P, sides[b >> 2], 0.5 * (left[i, 1] + left[i, 2]), b, False, NO_SEED, respect)
        if value < lowest:
            top, best_q, lowest = i, q, value
    return top, best_q, lowest


@kernel
def least_of_elbows(P, sides, left, n, respect):
    """A cost below which no posture in n intervals is: that of its elbow, which no arm angle bends otherwise."""
    least = 4.0 * NO_BRANCH
    for i in range(n):
        _, value = elbow_part(P, sides[int(left[i, 0]) >> 2][0], False, 0.0, respect)
        least = min(least, value)
    return least


@kernel
def farthest_within(P, place_, given, branch, respect):
    """Posture of the least cost over intervals (n, 3) of a branch (-1: of all): q, branch, cost."""
    sides = (elbow_side(P, place_, 0), elbow_side(P, place_, 1))
    found, left = np.empty((8 * MAX_PIECES, 3)), np.empty((MOST_LEFT, 3))
    boxes = np.empty((1, SIZE))
    box = row(boxes, 0)
    S = np.empty(STATE)
    n = 0
    for k in range(given.shape[0]):
        if branch < 0 or int(given[k, 0]) == branch:
            n = put(left, n, given[k, 0], given[k, 1], given[k, 2])
    best_q, best, lowest = NO_SEED, 0, 4.0 * NO_BRANCH
    least = least_of_elbows(P, sides, left, n, respect)
    for round_ in range(ROUNDS):
        before = lowest
        top, q, value = best_middle(P, sides, left, n, respect)
        if value < lowest:
            best_q, best, lowest = q, int(left[top, 0]), value
        if lowest < OUTSIDE and lowest <= least + GAIN:
            # The elbow is the tightest joint.
            break
        # The way up from the highest, once limits have left little; from the others only where that gains nothing.
        for i in range(n if round_ > 0 or n == 1 else 0):
            k = (top + i) % n
            b, lower, upper = int(left[k, 0]), left[k, 1], left[k, 2]
            q, value = climb(P, sides[b >> 2], b, lower, 0.5 * (lower + upper), upper, False, NO_SEED, respect, S)
            if value < lowest:
                best_q, best, lowest = q, b, value
            if lowest < before:
                break
        if lowest >= before:
            break
        gain = GAIN_OUTSIDE if lowest >= OUTSIDE else GAIN
        if not draw_in(P, lowest - gain, respect, box):
            break
        n = common_parts(found, find_intervals(box, place_, branch, found), given, left)
        if n == 0:
            break
    keep(boxes)
    return best_q, best, lowest
