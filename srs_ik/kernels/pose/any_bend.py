"""Postures of an elbow as good as flat, at any of the bends that its pose cannot tell from each other.

The feasible arm angles of all bends are known (`exact.flat`). The bend moves joints that are away from singularities by
no more than itself. So the best arm angle is looked for at one bend, with limits that are wider by that, and the bend
then at that arm angle.
"""

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import short_way
from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.chain.newton import arm_angle, clipped
from srs_ik.kernels.exact.bend_events import MOST_EVENTS, bends_at
from srs_ik.kernels.exact.bends import bent_place
from srs_ik.kernels.exact.farthest import farthest
from srs_ik.kernels.exact.flat import NOTABLE, SMALLEST_BEND, exact_intervals, is_almost_flat, span_of_bends
from srs_ik.kernels.exact.free_splits import keep_better, worse_by
from srs_ik.kernels.exact.nearest_within import nearest_within
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import limb as at
from srs_ik.kernels.layout.answer import MAX_PIECES
from srs_ik.kernels.limb.branches import NO_BRANCH, best_branch, is_on_border
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE
from srs_ik.kernels.limb.in_line import NEARLY_IN_LINE, may_split
from srs_ik.kernels.limb.limits import tighten
from srs_ik.kernels.pose.on_limits import meets, put_on_limits

WIDER = 1e-4
"""By so much, rad, limits are wider where one bend stands for all."""

ALONE = 1e-12
"""An interval narrower than this, rad, is a single arm angle."""

BETTER = 1e-8
"""A posture that is better by less than this, rad or of a range, may owe it to missing its pose by rounding."""

INWARDS = 4
FARTHER = 8.0
"""So many arm angles are tried at an end of an interval, each farther from it by this factor."""


@kernel
def hides_some(P, place_):
    """Whether rounding may hide postures on limits of a pose, or take them in another turn: next to a singularity."""
    return is_almost_flat(place_) or may_split(P, place_)


@kernel
def at_any_bend(family, target, psi, branch, goal, found):
    """The best posture at an arm angle as known so far, or a better one that looser tolerances find.

    Of an elbow as good as flat, one at any bend.

    Each is given as q, branch, cost.
    """
    best = found
    loose = row(family, at.LOOSE)
    bends = np.empty(MOST_EVENTS)
    span = span_of_bends(loose, target.place)
    for elbow in range(2):
        if branch >= 0 and branch >> 2 != elbow:
            continue
        bends[0], n = target.place[3], 1
        if is_almost_flat(target.place):
            n = bends_at(loose, target.place, psi, elbow, span, bends)
        for i in range(2 * n - 1):
            x = bends[i // 2] if i % 2 == 0 else 0.5 * (bends[i // 2] + bends[i // 2 + 1])
            place_ = bent_place(target.place, x)
            other = best_branch(loose, place_, psi, branch, goal.seeded, goal.seed, goal.respect)
            other = put_on_limits(loose, target, psi, other, goal)
            if other[2] < best[2] and meets(loose, other[0], target):
                best = other
    return best


@kernel
def at_or_inside(family, target, interval, psi, branch, goal):
    """The best posture of a branch at an arm angle of an interval (1, 3), or farther from an end where it has none.

    Next to a singularity, ends are told no better than a few times `NOTABLE`.
    """
    middle, half = 0.5 * (interval[0, 1] + interval[0, 2]), 0.5 * (interval[0, 2] - interval[0, 1])
    found = (NO_SEED, branch, NO_BRANCH)
    inwards = NOTABLE
    for _ in range(INWARDS):
        room = max(half - inwards, 0.0)
        inside = middle + max(min(short_way(psi - middle), room), -room)
        found = at_any_bend(family, target, inside, branch, goal, found)
        if found[2] < OUTSIDE or inwards > half:
            break
        inwards *= FARTHER
    return found


@kernel
def closed_in_branch(P, target, found, wanted, goal, best, work):
    """The better of a posture, closed on the true chain, and the best so far of a branch (-1: of all)."""
    closed = keep_better(P, target, found, -1, goal, best, work)
    if worse_by(closed[2], best[2], goal.seeded) < -BETTER and (wanted < 0 or is_on_border(P, closed[0], wanted)):
        return closed[0], closed[1] if wanted < 0 else wanted, closed[2]
    return best


@kernel
def best_in_interval(family, target, interval, wanted, goal, best):
    """The best posture as known so far, or a better one of an interval (1, 3), at any bend: q, branch, cost.

    Where outer axes are almost in line, no arm angle tells their split: it is closed as it is.
    """
    P = row(family, at.LOOSE + (at.LIMITED if goal.respect else at.FREE))
    # A flat elbow does not tell on which side its arm angle lies.
    place_ = bent_place(target.place, max(target.place[3], SMALLEST_BEND))
    work = (np.empty((6, 7)), np.empty((16, 9)))
    boxes = np.empty((1, at.SIZE))
    box = row(boxes, 0)
    tighten(P, NO_SEED, math.inf, WIDER, box)
    # Rounding may leave less of an interval as narrow as that than any arm angle that is looked at.
    narrow = interval[0, 2] - interval[0, 1] < WIDER
    for in_line in range(2 if may_split(P, place_) else 1):
        if in_line == 1:
            box[at.SLACK_SINGULAR] = NEARLY_IN_LINE
        if goal.seeded:
            q, branch, value = nearest_within(box, place_, interval, -1, goal, best[2])
        else:
            q, branch, value = farthest(box, place_, interval, -1, goal.respect)
        if value >= OUTSIDE and (in_line == 1 or (best[2] < OUTSIDE and not narrow)):
            continue
        # On a limit that rounding may put a joint beyond, which then is taken in another turn at its arm angle.
        found = (clipped(P, q), branch, value)
        best = closed_in_branch(P, target, found, wanted, goal, best, work)
        if max(value, best[2]) < OUTSIDE and worse_by(best[2], value, goal.seeded) < BETTER:
            continue
        psi = arm_angle(P, q, place_[0], place_[1])
        if value >= OUTSIDE:
            psi, branch = 0.5 * (interval[0, 1] + interval[0, 2]), int(interval[0, 0])
        found = at_or_inside(family, target, interval, psi, branch, goal)
        best = closed_in_branch(P, target, found, wanted, goal, best, work)
    keep(boxes)
    return best


@kernel
def nearest_alone(family, target, found, goal, best):
    """The nearest posture as known so far, or a nearer one of those intervals (n, 3) that are single arm angles.

    Where the shoulder's reach begins and the wrist's ends, only loose tolerances find it.
    """
    for i in range(found.shape[0]):
        if found[i, 2] - found[i, 1] < ALONE:
            best = best_in_interval(family, target, found[i : i + 1], int(found[i, 0]), goal, best)
    return best


@kernel
def best_of(family, target, found, branch, goal):
    """The best posture of an exact limb over intervals (n, 3), of a branch (-1: of all), at any bend."""
    P = row(family, at.LIMITED)
    if goal.seeded:
        best = nearest_within(P, target.place, found, branch, goal, 4.0 * NO_BRANCH)
    else:
        best = farthest(P, target.place, found, branch, goal.respect)
    if goal.respect and (best[2] >= OUTSIDE or (goal.seeded and hides_some(P, target.place))):
        for i in range(found.shape[0]):
            own = int(found[i, 0])
            if branch < 0 or own == branch:
                best = best_in_interval(family, target, found[i : i + 1], own, goal, best)
    return best


@kernel
def best_in_intervals(family, target, wanted, goal, best):
    """The best posture as known so far, or a better one of a branch (-1: of all), in the intervals of a pose."""
    found = np.empty((8 * MAX_PIECES, 3))
    n, _ = exact_intervals(family, target, goal.respect, found)
    for i in range(n):
        if wanted < 0 or int(found[i, 0]) == wanted:
            best = best_in_interval(family, target, found[i : i + 1], wanted, goal, best)
    return best


@kernel
def has_turns(P):
    """Whether a joint has limits that are more than a turn apart."""
    several = False
    for j in range(7):
        several = several or (P[at.RANGE_KIND + j] == 0.0 and P[at.UPPER + j] - P[at.LOWER + j] < math.inf)
    return several


@kernel
def best_at_any_bend(family, target, wanted, goal, best):
    """The best posture of a pose as known so far, or a better one of a branch (-1: of all), at any bend."""
    best = best_in_intervals(family, target, wanted, goal, best)
    if not (goal.seeded and best[2] < OUTSIDE and has_turns(row(family, at.LIMITED))):
        return best
    # Nearer to a seed all joints are within a distance of it: of several turns that leaves one, which ends intervals.
    boxes = np.empty((at.FAMILY, at.SIZE))
    for k in range(at.FAMILY):
        tighten(row(family, k), goal.seed, math.sqrt(best[2]), 0.0, row(boxes, k))
    best = best_in_intervals(boxes, target, wanted, goal, best)
    keep(boxes)
    return best
