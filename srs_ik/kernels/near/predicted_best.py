"""The posture of a near limb farthest from its limits, predicted by its nearest exact limb and corrected.

The posture of the exact limb has one beside it on the true chain, with some margin. Where another has more, limits
drawn in by that margin and out by the band (`predicted`) are kept: so a few short intervals of arm angles are left. On
arcs next to singularities the curves are followed, elsewhere `within` looks at postures.
"""

from __future__ import annotations

import numpy as np

from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.chain.answer import measure_row
from srs_ik.kernels.chain.newton import STEPS, arm_angle, close_at_angle
from srs_ik.kernels.curves.best import best_of_runs, search_followed
from srs_ik.kernels.curves.in_step import LONGEST_STEP
from srs_ik.kernels.exact.farthest import best_glance, copy_interval, draw_in, farthest_of_all
from srs_ik.kernels.exact.intervals import intervals_of
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import MAX_PIECES
from srs_ik.kernels.layout.asked import Best, Goal, Setting
from srs_ik.kernels.layout.limb import INVERSE_HALF_RANGE, SIZE
from srs_ik.kernels.layout.search import MAX_RUNS, RUN
from srs_ik.kernels.limb.branches import NO_BRANCH, branch_of
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE, cost, turned
from srs_ik.kernels.limb.limits import margin
from srs_ik.kernels.near.arcs import (
    ARC,
    ARC_ELBOW,
    MOST_ARCS,
    find_arcs,
    follow_arcs,
    mark_needed,
    put_ends_of_arcs,
    touches,
    without_arcs,
)
from srs_ik.kernels.near.band import may_predict_limits, share_of, sines_of_middles, widen
from srs_ik.kernels.near.intervals import has_none
from srs_ik.kernels.near.predicted import is_surely_out, predicted_intervals
from srs_ik.kernels.near.scan import view_of
from srs_ik.kernels.near.second_attempts import found_again, may_be_on_line
from srs_ik.kernels.near.within import best_within

SINGULAR = 1e-9
"""A sine of shoulder or wrist below this counts as this."""


@kernel
def best_on_arcs(P, box, by, points, count, branch, best):
    """The best posture on some arcs, followed, if it is better than the best so far, and whether all went well.

    `box` is the limb with limits drawn in: postures outside them are not better.
    """
    runs = np.empty((MAX_RUNS, RUN))
    rows, k = follow_arcs(box, by, LONGEST_STEP, (points, count), runs)
    return best_of_runs(P, by, rows, runs[: max(k, 0)], branch, Goal(False, NO_SEED, True), best), k >= 0


@kernel
def expected_cost(P, view, branch):
    """What the best posture costs at most, as the band tells beside the exact limb's best one.

    Where that is not so, none is found that costs less. It is 0 where the exact limb has none inside the limits.
    """
    place_ = view.target.place
    q, _, lowest = best_glance(P, place_, view.sides, branch, True)
    if not lowest < 0.0:
        q, _, lowest = farthest_of_all(P, P, place_, branch, True)
    if not lowest < 0.0:
        return 0.0
    s2, s6 = sines_of_middles(P, q)
    for j in range(7):
        if P[INVERSE_HALF_RANGE + j] > 0.0:
            off = view.band[j] / max(share_of(j, s2, s6), SINGULAR)
            lowest = max(lowest, off * P[INVERSE_HALF_RANGE + j] - margin(P, j, q[j]))
    return min(lowest, 0.0)


@kernel
def closed_best(P, target, best, A):
    """A posture that was looked at, closed, with its cost."""
    R, p, place_ = target
    psi = arm_angle(P, best.q, place_[0], place_[1])
    q, met = close_at_angle(P, best.q, R, p, place_[0], place_[1], psi, STEPS, A)
    q = turned(P, q, False, NO_SEED, True)
    return Best(q, cost(P, q, False, NO_SEED, True) if met else NO_BRANCH)


@kernel
def predicted_best(P, target, branch, J, A):
    """Posture of the largest margin over all arm angles (in one branch, if it is wanted).

    Returns the posture with its cost, and whether it is certain: inside the limits, and the elbow not almost straight.
    """
    view = view_of(P, target)
    best = Best(NO_SEED, NO_BRANCH)
    if not may_predict_limits(P, target.place, view.band):
        return best, False
    most = expected_cost(P, view, branch)
    best = Best(NO_SEED, most)
    boxes = np.empty((2, SIZE))
    box = row(boxes, 0)
    if not draw_in(P, best.cost, True, box):
        return best, False
    widen(box, view.band, 1.0, row(boxes, 1))
    found = np.empty((8 * MAX_PIECES, 3))
    n = intervals_of(row(boxes, 1), view.sides, branch, found)
    arcs = np.empty((MOST_ARCS, ARC))
    n_arcs = find_arcs(P, view, arcs)
    if n_arcs < 0:
        return best, False
    mark_needed(arcs, n_arcs, found, n)
    cuts = np.empty((16 * MAX_PIECES, 5))
    n = without_arcs(found, n, arcs, n_arcs, cuts)
    best, certain = best_within(P, view, cuts[:n], best)
    by = Setting(target, view.sides[0], True, J, A)
    k = 0
    while certain and k < n_arcs:
        k, count = put_ends_of_arcs(P, view, arcs, n_arcs, k)
        certain = count >= 0
        if count > 0:
            best, certain = best_on_arcs(P, box, by, view.points, count, branch, best)
    keep(boxes)
    if not (certain and best.cost < most):
        return best, False
    best = closed_best(P, target, best, A)
    return best, best.cost < 0.0


@kernel
def predicted_best_of_intervals(P, target, respect, out, J, A):
    """Write the posture with the largest margin of every interval into the rows of out; their number, or -1.

    Args:
        P: packed limb.
        target: the pose.
        respect: whether the joint limits have to be kept.
        out: (n, ROW) output.
        J: (6, 7) work space.
        A: (16, 9) work space.
    """
    if not respect or may_be_on_line(P, target.place):
        return -1
    found = np.empty((8 * MAX_PIECES, 3))
    n = predicted_intervals(P, target, found, J, A)
    view = view_of(P, target)
    one = np.empty((1, 3))
    arcs = np.empty((MOST_ARCS, ARC))
    n_arcs = find_arcs(P, view, arcs)
    for i in range(n):
        for k in range(n_arcs):
            if int(found[i, 0]) >> 2 == int(arcs[k, ARC_ELBOW]) and touches(found, i, arcs, k):
                return -1
        copy_interval(found, i, one, 0)
        best, certain = best_within(P, view, one, Best(NO_SEED, NO_BRANCH))
        if certain and best.cost < 0.0:
            best = closed_best(P, target, best, A)
        if not certain or best.cost >= 0.0:
            return -1
        measure_row(P, target, best.q, int(found[i, 0]), best.cost, respect, row(out, i))
    return n


@kernel
def search_true(P, target, branch, goal, J, A):
    """Best posture of a near limb over all arm angles: q, branch, cost; the least violating one if all break limits."""
    if not goal.seeded:
        # The largest margin of all, if any is inside the limits, whether these have to be kept or not.
        found, certain = predicted_best(P, target, branch, J, A)
        if certain:
            return found.q, branch_of(P, found.q), found.cost
    best = goal.seed, max(branch, 0), 4.0 * NO_BRANCH
    out = goal.respect and is_surely_out(P, target)
    if not out:
        best = search_followed(P, target, branch, goal, goal.respect, J, A)
        if best[2] < OUTSIDE:
            return best
        out = goal.respect and has_none(P, target, J, A)
    outside = search_followed(P, target, branch, goal, False, J, A)
    if out and outside[2] < NO_BRANCH:
        return outside
    hidden = found_again(P, target, branch, goal, J, A)
    if hidden[2] < best[2]:
        best = hidden
    return outside if outside[2] < best[2] else best
