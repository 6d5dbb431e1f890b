"""The posture farthest from the joint limits, exactly.

The arm angles at which every joint has more than a given margin are the feasible intervals for limits drawn in by it,
and those are known (`intervals`). So any posture tells where all better ones are, or that there is none: the search
climbs from posture to posture until nothing is left. Limits moved out instead give the least violating posture.
"""

import math

import numpy as np

from srs_ik.kernels.algebra.minimum import propose, start_search, tell
from srs_ik.kernels.algebra.pointers import copy, row, scratch
from srs_ik.kernels.exact.events import TURN
from srs_ik.kernels.exact.glance import NEXT_GLANCE, glance
from srs_ik.kernels.exact.intervals import intervals_of
from srs_ik.kernels.exact.summit import summit, turning_axes
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import MAX_PIECES
from srs_ik.kernels.layout.asked import Goal
from srs_ik.kernels.layout.limb import INVERSE_HALF_RANGE, LOWER, MIDDLE, SHOULDER, SIZE, UPPER, WRIST
from srs_ik.kernels.layout.search import CLIMB, STATE
from srs_ik.kernels.limb.branches import NO_BRANCH, side_posture
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE, TIE, elbow_part
from srs_ik.kernels.limb.limits import set_joint_limits, set_limit
from srs_ik.kernels.limb.triangle import elbow_side

GAIN = 1e-11
"""Margins closer than this are equal."""

GAIN_OUTSIDE = 1e-9
"""So are violations, rad: beside `OUTSIDE`, their digits end here."""

ROUNDS = 64
"""Most times that the limits are moved; one or two are usual."""

ROUGHLY = 1e-6
"""What a glance tells is known so well."""

FINENESS = 1e-9
"""A line search ends at this part of its interval ..."""

FINEST = 1e-15
"""... and no closer than this, rad."""

MOST_LEFT = 16 * MAX_PIECES
"""Room for the parts of intervals that may hold a better posture."""


@kernel
def draw_in(P, lowest, respect, box):
    """Copy the packed limb to `box` with the limits that postures below a cost keep, and no others.

    Returns False where no posture can keep them.
    """
    copy(P, box, SIZE)
    for j in range(7):
        lower, upper = P[LOWER + j], P[UPPER + j]
        if lowest >= OUTSIDE:
            lower -= lowest - OUTSIDE
            upper += lowest - OUTSIDE
        elif P[INVERSE_HALF_RANGE + j] > 0.0:
            half = (1.0 + lowest) / P[INVERSE_HALF_RANGE + j]
            lower, upper = P[MIDDLE + j] - half, P[MIDDLE + j] + half
        elif not respect:
            lower, upper = -math.inf, math.inf
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
def climb(P, side, branch, bracket, goal, S):
    """Best posture of a branch that a line search finds between two arm angles, from one between them on: q, cost.

    `bracket` holds the three, the lowest first; S is the state of the search.
    """
    lower, middle, upper = bracket
    seeded, seed, respect = goal
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
    """Copy row i of some intervals to row k of others."""
    copy(row(source, i), row(out, k), 3)


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
        whole = given[k, 2] - given[k, 1] >= TURN
        for i in range(n):
            if found[i, 0] != given[k, 0]:
                continue
            if whole:
                count = put(out, count, found[i, 0], found[i, 1], found[i, 2])
                continue
            for turns in range(-1, 2):
                lower = max(found[i, 1] + turns * TURN, given[k, 1])
                upper = min(found[i, 2] + turns * TURN, given[k, 2])
                if lower <= upper:
                    count = put(out, count, found[i, 0], lower, upper)
    return count


@kernel
def up_from(P, place_, side, branch, span, respect, best):
    """The best posture so far, or a better one on the way up within a span of arm angles, from its middle on."""
    points = np.empty((3, CLIMB))
    outside = respect and best[2] >= OUTSIDE
    psi, sure = summit(P, side, turning_axes(place_, side), branch, span, outside, points)
    q, value = branch_at(P, side, psi, branch, False, NO_SEED, respect)
    # Where the elbow makes both as good, the other joints have more room on the summit.
    if value <= best[2]:
        best = (q, branch, value)
    if not sure:
        q, value = climb(P, side, branch, span, Goal(False, NO_SEED, respect), np.empty(STATE))
        if value < best[2]:
            best = (q, branch, value)
    return best


@kernel
def best_middle(P, sides, left, n, respect, best):
    """The row of n intervals whose middle costs least, and the posture there if it is better than the best so far."""
    top, lowest = 0, 4.0 * NO_BRANCH
    for i in range(n):
        b = int(left[i, 0])
        q, value = branch_at(P, sides[b >> 2], 0.5 * (left[i, 1] + left[i, 2]), b, False, NO_SEED, respect)
        if value < lowest:
            top, lowest = i, value
        if value < best[2]:
            best = (q, b, value)
    return top, best


@kernel
def best_in(P, place_, sides, left, n, respect, best):
    """The best posture so far, or a better one in n intervals.

    The way up from the highest middle; from the others only where that gains nothing.
    """
    before = best[2]
    top, best = best_middle(P, sides, left, n, respect, best)
    for i in range(n):
        k = (top + i) % n
        b, lower, upper = int(left[k, 0]), left[k, 1], left[k, 2]
        best = up_from(P, place_, sides[b >> 2], b, (lower, 0.5 * (lower + upper), upper), respect, best)
        if best[2] < before:
            break
    return best


@kernel
def least_of_elbow(P, side, respect):
    """A cost below which no posture on a side of the elbow is: that of the elbow, which no arm angle bends."""
    _, value = elbow_part(P, side[0], False, 0.0, respect)
    return value


@kernel
def least_of_elbows(P, sides, left, n, respect):
    """The same of n intervals."""
    least = 4.0 * NO_BRANCH
    for i in range(n):
        least = min(least, least_of_elbow(P, sides[int(left[i, 0]) >> 2], respect))
    return least


@kernel
def gain_of(lowest):
    """Costs that differ by less from this one are equal to it."""
    return GAIN_OUTSIDE if lowest >= OUTSIDE else GAIN


@kernel
def farthest_from(P, place_, sides, given, asked, best):
    """The best posture so far, or the best over intervals (n, 3) if it is better: q, branch, cost.

    `asked` holds the branch (-1: all) and whether limits count. A `best` with a cost tells by drawn-in limits what part
    of the intervals may hold better ones.
    """
    branch, respect = asked
    found, left = np.empty((8 * MAX_PIECES, 3)), np.empty((MOST_LEFT, 3))
    box = row(scratch(1, SIZE), 0)
    n = 0
    for k in range(given.shape[0]):
        if branch < 0 or int(given[k, 0]) == branch:
            n = put(left, n, given[k, 0], given[k, 1], given[k, 2])
    least = least_of_elbows(P, sides, left, n, respect)
    known = best[2] < NO_BRANCH
    for _ in range(ROUNDS if n > 0 else 0):
        if not known:
            before = best[2]
            best = best_in(P, place_, sides, left, n, respect, best)
            if best[2] >= before:
                break
        known = False
        lowest = best[2]
        if lowest <= least + gain_of(lowest) or not draw_in(P, lowest - gain_of(lowest), respect, box):
            break
        n = common_parts(found, intervals_of(box, sides, branch, found), given, left)
        if n == 0:
            break
    return best


@kernel
def farthest(P, place_, given, branch, respect):
    """Posture of the least cost over intervals (n, 3) of a branch (-1: of all): q, branch, cost.

    Whole circles stand for all arm angles.
    """
    sides = (elbow_side(P, place_, 0), elbow_side(P, place_, 1))
    return farthest_from(P, place_, sides, given, (branch, respect), (NO_SEED, 0, 4.0 * NO_BRANCH))


@kernel
def best_glance(P, place_, sides, branch, respect):
    """The posture on the summit nearest to the best one of a few arm angles: q, branch, cost.

    Where the elbow is the tightest joint, as it is in half of all poses, it is the best of all.
    """
    signs = ((branch >> 1) & 1, branch & 1) if branch >= 0 else (-1, -1)
    elbow, psi, lowest, others = 0, 0.0, math.inf, math.inf
    for e in range(2):
        if branch >= 0 and branch >> 2 != e:
            continue
        at, value = glance(P, sides[e], signs)
        total = max(value, least_of_elbow(P, sides[e], False))
        # Of two that the elbow makes equal, the one with more room for the other joints.
        if total < lowest - TIE or (total <= lowest + TIE and value < others - ROUGHLY):
            elbow, psi, lowest, others = e, at, total, value
    side = sides[elbow]
    q, b, value = side_posture(P, side, psi, signs[0], signs[1], False, NO_SEED, respect)
    b = branch if branch >= 0 else 4 * elbow + b
    if value >= OUTSIDE:
        return q, b, value
    return up_from(P, place_, side, b, (psi - NEXT_GLANCE, psi, psi + NEXT_GLANCE), respect, (q, b, value))


@kernel
def whole_circles(out):
    """Write every arm angle of every branch as eight intervals."""
    for b in range(8):
        out[b, 0], out[b, 1], out[b, 2] = b, -math.pi, math.pi


@kernel
def farthest_of_all(P, F, place_, branch, respect):
    """Posture of the least cost over all arm angles (in one branch; -1: in all): q, branch, cost.

    `F` is the same limb as P, packed without limits where these do not count. The cost is above `NO_BRANCH` where no
    arm angle is feasible.
    """
    sides = (elbow_side(P, place_, 0), elbow_side(P, place_, 1))
    best = best_glance(P, place_, sides, branch, respect)
    given = np.empty((8 * MAX_PIECES, 3))
    if best[2] < OUTSIDE:
        whole_circles(given)
        return farthest_from(P, place_, sides, given[:8], (branch, respect), best)
    n = intervals_of(F, sides, branch, given)
    return farthest_from(P, place_, sides, given[:n], (branch, respect), (NO_SEED, 0, 4.0 * NO_BRANCH))
