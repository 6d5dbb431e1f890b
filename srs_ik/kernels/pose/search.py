"""The whole redundancy of a pose: its feasible intervals, and the best posture over all of them."""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.chain.kinematics import pose_error
from srs_ik.kernels.chain.newton import CLOSED, arm_angle, close_free
from srs_ik.kernels.curves.best import search_followed
from srs_ik.kernels.exact.farthest import branch_at, copy_interval, farthest
from srs_ik.kernels.exact.free_splits import NEARLY_FLAT, SMALLEST_BEND, settled_split, with_splits
from srs_ik.kernels.exact.intervals import find_intervals
from srs_ik.kernels.exact.nearest import (
    CLOSE,
    between_limbs,
    first_guess,
    first_guess_near,
    is_alone,
    look_across,
    look_beside,
    settle_near,
    slid,
    tighten,
)
from srs_ik.kernels.exact.nearest_within import nearest_within, way_between
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import MAX_PIECES
from srs_ik.kernels.layout.limb import FAR, FREE, LIMITED, LOOSE, MISS, SIZE
from srs_ik.kernels.limb.branches import NO_BRANCH, branch_of, is_unsure
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE
from srs_ik.kernels.limb.triangle import elbow_side
from srs_ik.kernels.near.predicted_best import predicted_best
from srs_ik.kernels.near.second_attempts import look_around, rescue

MOST_LEVERAGE = 4.0
"""A seed farther from its nearest posture than so many times the pose error asks for a closer look."""

LAST_STAGE = 15
"""`SMALLEST_BEND` times powers of two up to about `NEARLY_FLAT` are tried before; then limits are given up."""

HARDLY = 1e-5
"""A limb that misses by less than this part of its reach is one with rounded figures."""

HARDLY_FARTHER = 1e-4
FEW_STEPS = 12
"""Its nearest posture is found in a few steps, and no farther from a seed, in squared rad, than this."""

ONE_VALLEY = 0.3
"""An interval shorter than this, rad, whose ends are close to a minimum in it, has no other one."""


@kernel
def is_short(P, place_, q, branch, lower, upper, seed, respect):
    """Whether the postures at both ends of an interval are close to one in it."""
    side = elbow_side(P, place_, branch >> 2)
    a, _ = branch_at(P, side, lower, branch, True, seed, respect)
    b, _ = branch_at(P, side, upper, branch, True, seed, respect)
    return max(way_between(a, q), way_between(q, b)) < ONE_VALLEY


@kernel
def without(P, place_, found, n, q, branch, psi, seed, respect):
    """Drop the short interval around a known minimum; return the number of intervals that are left."""
    left = 0
    for i in range(n):
        ahead = (psi - found[i, 1]) - 2.0 * math.pi * math.floor((psi - found[i, 1]) / (2.0 * math.pi))
        width = found[i, 2] - found[i, 1]
        if int(found[i, 0]) == branch and width < ONE_VALLEY and ahead <= width:
            if is_short(P, place_, q, branch, found[i, 1], found[i, 2], seed, respect):
                continue
        copy_interval(found, i, found, left)
        left += 1
    return left


@kernel
def whole_circles(out):
    """Write every arm angle of every branch as eight intervals."""
    for b in range(8):
        out[b, 0] = b
        out[b, 1] = -math.pi
        out[b, 2] = math.pi


@kernel
def guess(P, place_, R, p, seed, respect, J, A):
    """A posture near a seed by local search: psi, q, branch, cost, and whether it is a local minimum."""
    if J is None:
        psi, q, branch, lowest, minimum = first_guess(P, place_, seed, respect)
        position, orientation = pose_error(P, seed, R, p)
        if lowest > (MOST_LEVERAGE * max(position / P[FAR], orientation)) ** 2:
            # Suspiciously far: next to a singularity, the seed's own neighbourhood may hold a nearer posture.
            other, value, still = settle_near(P, seed, R, p, seed, respect, np.empty((6, 7)), np.empty((16, 9)))
            if value < lowest:
                return arm_angle(P, other, place_[0], place_[1]), other, branch_of(P, other), value, still
        return psi, q, branch, lowest, minimum
    return first_guess_near(P, place_, R, p, seed, respect, J, A)


@kernel
def search_hardly_near(P, place_, R, p, found, n, q, best, lowest, seed, respect, J, A):
    """The nearest posture in intervals of a limb that hardly differs from its nearest exact limb: q, branch, cost.

    That limb's own nearest posture, settled on the true chain; only next to a singularity are the curves followed.
    """
    start, branch, value = nearest_within(P, place_, found, n, -1, seed, respect, 4.0 * NO_BRANCH)
    if value >= OUTSIDE and not is_unsure(P, q):
        return q, best, lowest
    if value < OUTSIDE and not is_unsure(P, start) and not is_unsure(P, q):
        if value >= lowest:
            return q, best, lowest
        start, error = close_free(P, start, R, p, respect, FEW_STEPS, J, A)
        settled, there, _ = slid(P, start, R, p, seed, respect, J, A)
        if error < CLOSED and there < value + HARDLY_FARTHER:
            return (settled, branch_of(P, settled), there) if there < lowest else (q, best, lowest)
    start, branch, value = search_followed(P, place_, R, p, -1, True, seed, respect, respect, J, A)
    if value < lowest:
        return start, branch, value
    return q, best, lowest


@kernel
def search_near_seed(P, F, place_, R, p, seed, respect, J, A):
    """The posture nearest to a seed over all branches and arm angles: q, branch, cost (OUTSIDE if none was found)."""
    psi, guessed, branch, lowest, minimum = guess(P, place_, R, p, seed, respect, J, A)
    q, best = guessed, branch
    if lowest >= OUTSIDE:
        return q, best, lowest
    if minimum and is_alone(P, seed, lowest):
        return q, best, lowest
    q, best, lowest = with_splits(P, place_, R, p, -1, seed, respect, q, best, lowest)
    distance = math.sqrt(lowest)
    if J is not None:
        if distance < CLOSE:
            q, best, lowest, sure = look_across(P, R, p, q, best, lowest, minimum, seed, respect, J, A)
            if sure:
                return q, best, lowest
            distance = math.sqrt(lowest)
    boxes = np.empty((1, SIZE))
    box = row(boxes, 0)
    tighten(F, seed, distance * (1.0 + 1e-9), between_limbs(P), box)
    found = np.empty((8 * MAX_PIECES, 3))
    n = find_intervals(box, place_, -1, found)
    keep(boxes)
    # In a box of less than a turn, no joint has two turns to choose from.
    if minimum and distance < 3.0:
        n = without(P, place_, found, n, guessed, branch, psi, seed, respect)
    if n == 0:
        return q, best, lowest
    if J is None:
        nearer_q, nearer, value = nearest_within(P, place_, found, n, -1, seed, respect, lowest)
        if value < lowest:
            nearer_q, nearer, value = settled_split(P, place_, R, p, nearer_q, nearer, value, seed, respect)
    elif P[MISS] < HARDLY * P[FAR]:
        return search_hardly_near(P, place_, R, p, found, n, q, best, lowest, seed, respect, J, A)
    else:
        q, best, lowest, sure = look_beside(P, place_, R, p, found, n, q, best, lowest, seed, respect, J, A)
        if sure:
            return q, best, lowest
        nearer_q, nearer, value = search_followed(P, place_, R, p, -1, True, seed, respect, respect, J, A)
    if value < lowest:
        return nearer_q, nearer, value
    return q, best, lowest


@kernel
def search_exact(family, place_, R, p, branch, seed, respect):
    """Best posture of a closed limb over all arm angles: q, branch, cost; the least violating one if all break limits.

    Rounding may hide a posture from the strict search. So looser tolerances follow, and, with the elbow almost straight
    or folded, all the bends that a pose cannot tell from each other: a bend x changes the length of the arm by x^2 / 8
    of it.
    """
    t, h0, bend_c, bend_s, hand, miss = place_
    strictness = LIMITED if respect else FREE
    found = np.empty((8 * MAX_PIECES, 3))
    best_q = NO_SEED
    best = 0
    lowest = 4.0 * NO_BRANCH
    for stage in range(LAST_STAGE + 1):
        near = place_
        tolerances = LIMITED
        if 0 < stage < LAST_STAGE:
            tolerances = LOOSE
            if stage > 1:
                if bend_s > NEARLY_FLAT:
                    continue
                bend = SMALLEST_BEND * 2.0**stage if stage > 2 else 0.0
                near = (t, h0, math.copysign(math.sqrt(1.0 - bend * bend), bend_c), bend, hand, miss)
        P = row(family, tolerances)
        n = 8
        if stage < LAST_STAGE:
            n = find_intervals(row(family, tolerances + strictness), near, branch, found)
        else:
            whole_circles(found)
        if seed is None:
            q, b, value = farthest(P, near, found, 0, n, branch, respect)
        else:
            q, b, value = nearest_within(P, near, found, n, branch, seed, respect, 4.0 * NO_BRANCH)
        if value < lowest:
            best_q, best, lowest = q, b, value
        if stage == 0:
            best_q, best, lowest = with_splits(P, place_, R, p, branch, seed, respect, best_q, best, lowest)
        if lowest < OUTSIDE:
            break
    return best_q, best, lowest


@kernel
def search_true(P, place_, R, p, branch, seeded, seed, respect, J, A):
    """Best posture of a near limb over all arm angles: q, branch, cost; the least violating one if all break limits."""
    if respect and not seeded:
        q, lowest, certain = predicted_best(P, place_, R, p, branch, J, A)
        if certain:
            return q, branch_of(P, q), lowest
    q, best, lowest = search_followed(P, place_, R, p, branch, seeded, seed, respect, respect, J, A)
    if lowest < OUTSIDE:
        return q, best, lowest
    hidden, b, value = look_around(P, place_, R, p, branch, seeded, seed, respect, J, A)
    if value >= OUTSIDE:
        hidden, b, value = rescue(P, place_, R, p, branch, seeded, seed, respect, J, A)
    if value < lowest:
        q, best, lowest = hidden, b, value
    if lowest < OUTSIDE:
        return q, best, lowest
    outside, b, value = search_followed(P, place_, R, p, branch, seeded, seed, respect, False, J, A)
    if value < lowest:
        return outside, b, value
    return q, best, lowest
