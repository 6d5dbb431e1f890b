"""The posture farthest from the joint limits, exactly.

The arm angles at which every joint has more than a given margin are the feasible intervals for limits drawn in by it,
and those are known (`intervals`). So any posture tells where all better ones are, or that there is none: the search
climbs from posture to posture until nothing is left. Limits moved out instead give the least violating posture.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.minimum import propose, start_search, tell
from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.exact.intervals import TURN, find_intervals
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import MAX_PIECES
from srs_ik.kernels.layout.limb import INVERSE_HALF_RANGE, LOWER, MIDDLE, SHOULDER, SIZE, UPPER, WRIST
from srs_ik.kernels.layout.search import STATE
from srs_ik.kernels.limb.branches import NO_BRANCH, side_posture
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE, elbow_part
from srs_ik.kernels.limb.limits import set_joint_limits, set_limit
from srs_ik.kernels.limb.triangle import elbow_side

GAIN = 1e-11
"""Margins closer than this are equal."""

GAIN_OUTSIDE = 1e-9
"""So are violations, rad: beside `OUTSIDE`, their digits end here."""

ROUNDS = 64
"""Most times that the limits are moved; two to four are usual."""

PROBED = 8
"""Arm angles, evenly spaced, at which the largest margin is looked for first."""

FINENESS = 1e-9
"""A climb ends at this part of its interval ..."""

FINEST = 1e-15
"""... and no closer than this, rad."""


@kernel
def draw_in(P, lowest, respect, box):
    """Copy the packed limb to `box` with the limits that postures below a cost keep, and no others.

    Returns False where no posture can keep them.
    """
    for i in range(SIZE):
        box[i] = P[i]
    for j in range(7):
        lower = P[LOWER + j]
        upper = P[UPPER + j]
        if lowest >= OUTSIDE:
            lower -= lowest - OUTSIDE
            upper += lowest - OUTSIDE
        elif P[INVERSE_HALF_RANGE + j] > 0.0:
            half = (1.0 + lowest) / P[INVERSE_HALF_RANGE + j]
            lower = P[MIDDLE + j] - half
            upper = P[MIDDLE + j] + half
        elif not respect:
            lower = -math.inf
            upper = math.inf
        if lower > upper:
            return False
        set_limit(box, j, lower, upper)
    set_joint_limits(box, SHOULDER, 0)
    set_joint_limits(box, WRIST, 4)
    return True


@kernel
def branch_at(P, side, psi, branch, seeded, seed, respect):
    """Posture of one branch at an arm angle on the exact limb: q, cost."""
    q, _, value = side_posture(P, side, psi, (branch >> 1) & 1, branch & 1, seeded, seed, respect)
    return q, value


@kernel
def climb(P, side, branch, lower, middle, upper, seeded, seed, respect, S):
    """Best posture of a branch found between two arm angles, from one between them on: q, cost.

    S is the state of a line search.
    """
    q, value = branch_at(P, side, middle, branch, seeded, seed, respect)
    if upper == lower:
        return q, value
    lower_q, lower_value = branch_at(P, side, lower, branch, seeded, seed, respect)
    upper_q, upper_value = branch_at(P, side, upper, branch, seeded, seed, respect)
    start_search(S, lower, middle, upper, lower_value, value, upper_value, max(FINENESS * (upper - lower), FINEST))
    while True:
        x, wanted = propose(S)
        if not wanted:
            break
        next_q, f = branch_at(P, side, x, branch, seeded, seed, respect)
        if tell(S, f):
            q, value = next_q, f
    if lower_value < value:
        q, value = lower_q, lower_value
    if upper_value < value:
        q, value = upper_q, upper_value
    return q, value


@kernel
def copy_interval(source, i, out, k):
    """Copy row i of some intervals to row k of others: a whole row assigned would take a second to compile."""
    out[k, 0] = source[i, 0]
    out[k, 1] = source[i, 1]
    out[k, 2] = source[i, 2]


@kernel
def keep_within(found, n, window):
    """Cut intervals of one branch to another interval of it; return the number of rows in use."""
    left = n
    for i in range(n):
        for turns in range(-1, 2):
            a = max(found[i, 1] + turns * TURN, window[0])
            b = min(found[i, 2] + turns * TURN, window[1])
            if a <= b and left < found.shape[0]:
                found[left, 0] = found[i, 0]
                found[left, 1] = a
                found[left, 2] = b
                left += 1
    for i in range(n, left):
        copy_interval(found, i, found, i - n)
    return left - n


@kernel
def keep_branch(found, n, branch):
    """Drop the intervals of other branches (-1: of none); return the number of rows in use."""
    left = 0
    for i in range(n):
        if branch < 0 or int(found[i, 0]) == branch:
            copy_interval(found, i, found, left)
            left += 1
    return left


@kernel
def largest_margin(P, place_, found, box):
    """The least cost of all postures inside the limits, `OUTSIDE` or more where none was met.

    Most poses show it at one of a few arm angles: where the elbow is the tightest joint, nothing is better. Else the
    search begins with limits drawn in by the best of these.

    Args:
        P: packed limb.
        place_: the pose, from `triangle.place`.
        found: (8 MAX_PIECES, 3) work space.
        box: (SIZE,) work space.
    """
    sides = (elbow_side(P, place_, 0), elbow_side(P, place_, 1))
    _, first = elbow_part(P, sides[0][0], False, 0.0, True)
    _, second = elbow_part(P, sides[1][0], False, 0.0, True)
    least = (first, second)
    lowest = 4.0 * NO_BRANCH
    for k in range(PROBED):
        psi = TURN * k / PROBED
        for elbow in range(2):
            if least[elbow] < lowest - GAIN:
                _, _, value = side_posture(P, sides[elbow], psi, -1, -1, False, NO_SEED, True)
                lowest = min(lowest, value)
        if lowest <= min(least[0], least[1]) + GAIN:
            return lowest
    if lowest >= OUTSIDE:
        n = find_intervals(P, place_, -1, found)
    elif draw_in(P, lowest - GAIN, True, box):
        n = find_intervals(box, place_, -1, found)
    else:
        n = 0
    if n == 0:
        return lowest
    _, _, value = farthest(P, place_, found, 0, n, -1, True)
    return min(lowest, value)


@kernel
def farthest(P, place_, given, first, last, branch, respect):
    """Posture of the least cost over the intervals in rows first to last - 1 of given: q, branch, cost.

    These are all feasible intervals of a pose, or one of them; or whole circles, where there is none.
    """
    sides = (elbow_side(P, place_, 0), elbow_side(P, place_, 1))
    _, elbow = elbow_part(P, sides[0][0], False, 0.0, True)
    _, other = elbow_part(P, sides[1][0], False, 0.0, True)
    elbow = min(elbow, other)
    found = np.empty((8 * MAX_PIECES, 3))
    boxes = np.empty((1, SIZE))
    box = row(boxes, 0)
    S = np.empty(STATE)
    n = last - first
    for i in range(n):
        copy_interval(given, first + i, found, i)
    n = keep_branch(found, n, branch)
    alone = n == 1
    if alone:
        branch = int(found[0, 0])
    window = (found[0, 1], found[0, 2])
    best_q = NO_SEED
    best = 0
    lowest = 4.0 * NO_BRANCH
    for round_ in range(ROUNDS):
        before = lowest
        # The middle of each interval, then the way up from the highest; from the others only where that gains nothing.
        top = 0
        top_value = 4.0 * NO_BRANCH
        for i in range(n):
            b = int(found[i, 0])
            q, value = branch_at(P, sides[b >> 2], 0.5 * (found[i, 1] + found[i, 2]), b, False, NO_SEED, respect)
            if value < top_value:
                top, top_value = i, value
            if value < lowest:
                best_q, best, lowest = q, b, value
        for i in range(n if round_ > 0 or alone else 0):
            k = (top + i) % n
            b = int(found[k, 0])
            lower, upper = found[k, 1], found[k, 2]
            middle = 0.5 * (lower + upper)
            q, value = climb(P, sides[b >> 2], b, lower, middle, upper, False, NO_SEED, respect, S)
            if value < lowest:
                best_q, best, lowest = q, b, value
            if lowest < before:
                break
        if lowest >= before:
            break
        if respect and lowest < OUTSIDE and lowest <= elbow + GAIN:
            # The elbow is the tightest joint, and no arm angle bends it otherwise.
            break
        gain = GAIN_OUTSIDE if lowest >= OUTSIDE else GAIN
        if not draw_in(P, lowest - gain, respect, box):
            break
        n = find_intervals(box, place_, branch, found)
        if alone:
            n = keep_within(found, n, window)
        if n == 0:
            break
    keep(boxes)
    return best_q, best, lowest
