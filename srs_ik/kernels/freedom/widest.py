"""The posture farthest from the joint limits over all turns that a pose leaves free.

Local searches (`widen`) start from a grid (`starts`), the best of it first.
"""

from __future__ import annotations

import math

from srs_ik.kernels.chain.freedom import free_error
from srs_ik.kernels.exact.farthest import farthest_of_all
from srs_ik.kernels.freedom.constraints import THIN
from srs_ik.kernels.freedom.settle import onto_pose
from srs_ik.kernels.freedom.shares import largest_share
from srs_ik.kernels.freedom.starts import (
    APART,
    MOST_ATTEMPTS,
    NO_WIDER,
    NONE_LEFT,
    OUT_OF_REACH,
    is_loose,
    line_up,
    starts_of_roll,
    starts_of_turns,
    take_next,
)
from srs_ik.kernels.freedom.widen import widen
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import SOLVED
from srs_ik.kernels.layout.freedom import MOST_STARTS, START_COST, START_LEANS, Found, Freedom, Sought
from srs_ik.kernels.layout.limb import FAR, INVERSE_HALF_RANGE, IS_CLOSED
from srs_ik.kernels.limb.triangle import place

ALMOST = 1e-3
"""A search that ends this close to its pose, m and rad, is brought onto it."""

WIDEST, WIDEST_IN_CONE = 10, 5
"""Local searches at least: with the roll alone free, and with the cone free."""

NARROW = 0.2
"""A cone up to this, rad, hardly widens the margin of its roll, whose searches come first then."""

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
def widened(P, start, pose, freedom, liking, found, desk):
    """The posture that a search from a start leads to, if it keeps a wider margin than the one that is known."""
    q, share, error = widen(P, start, pose, freedom, 1.0 + found.cost if found.met else math.inf, desk)
    if SOLVED <= error < ALMOST and share < 1.0 + found.cost:
        q, error = onto_pose(P, q, pose, freedom, liking, desk)
        share = largest_share(P, q)
    if error < SOLVED and share < 1.0 + found.cost and share <= 1.0:
        return Found(q, share - 1.0, True)
    return found


@kernel
def as_given(P, pose, freedom, liking):
    """The posture of the widest margin at the turn that is given, or that of the nearest exact limb; its margin.

    Searches over the turns start from a grid, and may miss by a little what a single turn has.
    """
    none = Found(liking.posture, NONE_LEFT, False)
    place_ = place(P, pose[0], pose[1])
    if abs(place_[5]) > OUT_OF_REACH * P[FAR]:
        return none
    q, _, cost = farthest_of_all(P, P, place_, -1, True)
    if cost >= 0.0:
        return none
    off, turned = free_error(P, q, pose[0], pose[1], freedom)
    return Found(q, cost, max(off, turned) < SOLVED)


@kernel
def widest(P, pose, freedom, liking, sizes, found, desk):
    """The posture of the widest margin that searches from so many starts in `desk` lead to, or a known one."""
    attempts = 0
    count, enough = sizes
    line_up(desk.starts, count, START_COST)
    while attempts < MOST_ATTEMPTS and not (found.met and attempts >= enough):
        start, least, count = take_next(desk.starts, count, attempts, START_COST, APART)
        if least >= NONE_LEFT or found.cost + NO_WIDER < least < 0.0:
            break
        if freedom.cone == 0.0 and desk.starts[MOST_STARTS - 1 - attempts, START_LEANS] > 0.0:
            continue
        attempts += 1
        found = widened(P, start, pose, freedom, liking, found, desk)
    return found


@kernel
def in_roll(P, pose, given, liking, start, found, desk):
    """The posture of the widest margin with the roll alone free, if it is wider than a known one."""
    roll, count = given
    if start.cost < 0.0:
        found = widened(P, start.q, pose, roll, liking, found, desk)
    return widest(P, pose, roll, liking, (count, WIDEST), found, desk)


@kernel
def widest_of_all(P, pose, given, liking, desk):
    """The posture of the widest margin over all that is free.

    No cone is answered worse than the roll that it contains. In a wide one the roll alone comes last: its searches then
    end as soon as they promise less than what the cone has.
    """
    freedom = given[0]
    roll = Freedom(freedom.axis, 0.0)
    start = as_given(P, pose, roll, liking)
    found = Found(start.q, start.cost if start.met else NONE_LEFT, start.met)
    wide = freedom.cone > NARROW
    if wide and start.cost < 0.0:
        found = widened(P, start.q, pose, freedom, liking, found, desk)
    # Almost exact limbs need more starts.
    loose = P[IS_CLOSED] == 1.0 and is_loose(P, freedom.axis)
    count = starts_of_roll(P, pose, freedom, Sought(False, liking.posture, found, loose, 0.0), desk)
    if not wide:
        found = in_roll(P, pose, (roll, count), liking, start, found, desk)
    if freedom.cone == 0.0:
        return found
    if freedom.cone <= THIN and found.met:
        return widened(P, found.q, pose, freedom, liking, found, desk)
    count = starts_of_turns(P, pose, given, Sought(False, liking.posture, found, loose, 0.0), desk, count)
    if not wide and found.met:
        found = widened(P, found.q, pose, freedom, liking, found, desk)
    found = widest(P, pose, freedom, liking, (count, WIDEST_IN_CONE), found, desk)
    if not wide:
        return found
    best = in_roll(P, pose, (roll, count), liking, start, found, desk)
    if best.cost < found.cost:
        return widened(P, best.q, pose, freedom, liking, best, desk)
    return found
