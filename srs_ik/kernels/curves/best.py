"""The best posture of a near limb, over the curves that `follow` follows on its true chain.

A run is a feasible piece of a curve (`survey`); a span is a part of a run on which the branch stays the same (`spans`).
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import short_way, with_joint
from srs_ik.kernels.algebra.roots import SETTLED
from srs_ik.kernels.chain.descent import slid
from srs_ik.kernels.chain.newton import closed_better
from srs_ik.kernels.chain.starts import width_of_splits
from srs_ik.kernels.curves.ends import on_curve
from srs_ik.kernels.curves.follow import meet
from srs_ik.kernels.curves.gaps import pass_at
from srs_ik.kernels.curves.in_step import load_sample
from srs_ik.kernels.curves.lowest import close_in_on, cost_at, cost_of_turn, hope, rate_of_cost
from srs_ik.kernels.curves.runs import near_runs, samples_of
from srs_ik.kernels.curves.spans import MAX_SPANS, SPAN, find_spans
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.asked import Best, Setting
from srs_ik.kernels.layout.limb import LOWER, RANGE_KIND, UPPER
from srs_ik.kernels.layout.search import MAX_RUNS, RUN
from srs_ik.kernels.limb.branches import NO_BRANCH, branch_of, is_on_border
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE
from srs_ik.kernels.limb.in_line import may_line_up
from srs_ik.kernels.limb.triangle import elbow_side

AT_BOUND = 1e-9
"""A joint this close to a limit in any turn, rad, is on it but for rounding."""


@kernel
def may_jump(P, j, bound):
    """Whether a joint of more than a turn is in another one behind a limit of its range."""
    return P[RANGE_KIND + j] == 0.0 and abs(bound) < math.inf


@kernel
def put_on_bounds(P, q):
    """A posture with joints of more than a turn on limits that rounding alone leaves them beside, in any turn."""
    for k in range(14):
        j = k % 7
        bound = P[(LOWER if k < 7 else UPPER) + j]
        if may_jump(P, j, bound) and abs(short_way(bound - q[j])) < AT_BOUND:
            q = with_joint(q, j, bound)
    return q


@kernel
def where_passed(P, by, ends, j, bound, ahead):
    """The posture between two of a curve where a joint passes an angle on its way, so far ahead of the first of them.

    And whether it is met. A joint that hardly moves along the curve, as the elbow of a limb that is almost exact, is
    moved more by the steps to it: Newton's method for pose and joint at once does not come to such a posture.
    """
    a, b = ends
    q, _, met = meet(P, by, ends, a, j, a[j] + ahead)
    if not met:
        q, _, met = pass_at(P, by, (a, NO_SEED), (b, NO_SEED), j, (bound, SETTLED))
    return q, met


@kernel
def best_at_bounds(P, by, ends, goal, best):
    """The better of the best posture so far and those between two samples where another turn of a joint begins or ends.

    A joint of more than a turn passes a limit there a turn away, and the distance from a seed jumps: where two such
    passes are close together, no sample may be between them, and where they are at one posture, nothing is.
    """
    a, b = ends
    for k in range(14):
        j = k % 7
        bound = P[(LOWER if k < 7 else UPPER) + j]
        if not may_jump(P, j, bound):
            continue
        way, ahead = short_way(b[j] - a[j]), short_way(bound - a[j])
        if ahead * way > 0.0 and abs(ahead) < abs(way):
            q, met = where_passed(P, by, ends, j, bound, ahead)
            if met:
                q, value = cost_of_turn(P, put_on_bounds(P, with_joint(q, j, bound)), goal)
                if value < best.cost:
                    best = Best(q, value)
    return best


@kernel
def best_on(P, by, curve, ends, goal, best):
    """Best posture of a run between two parameters, if it is better than the best so far."""
    rate = rate_of_cost(P)
    rows, i, last = curve
    x, upper = ends
    a = x
    q, fx = cost_at(P, by, curve, x, goal)
    fa = fx
    if fx < best.cost:
        best = Best(q, fx)
    while x < upper:
        while i < last - 1 and rows[i, 0] <= x:
            i += 1
        b = min(rows[i, 0], upper) if rows[i, 0] > x else upper
        before = q
        if b < upper:
            q, fb = cost_of_turn(P, load_sample(rows[i]), goal)
        else:
            q, fb = cost_at(P, by, curve, b, goal)
        if goal.seeded and goal.respect and max(fx, fb) < OUTSIDE:
            best = best_at_bounds(P, by, (before, q), goal, best)
        if fb < best.cost:
            best = Best(q, fb)
        if fx <= fa and fx <= fb and hope(fx, max(x - a, b - x), goal.seeded, rate) < best.cost:
            best, _ = close_in_on(P, by, curve, (a, x, b), goal, best)
        if b == upper and fb <= fx and hope(fb, b - x, goal.seeded, rate) < best.cost:
            best, _ = close_in_on(P, by, curve, (x, b, b), goal, best)
        a, fa = x, fx
        x, fx = b, fb
    return best


@kernel
def best_on_border(P, by, curve, ends, branch, goal, best):
    """The better of the best posture so far and those of a span of another branch that are on the border of a branch.

    Along a free split, rounding tells of which branch postures are.
    """
    rows, first, last = curve
    x, upper = ends
    q, _ = on_curve(P, by, 0, curve, x)
    before = is_on_border(P, q, branch)
    for i in range(first, last):
        if x < min(rows[i, 0], upper):
            after = min(rows[i, 0], upper)
            q, _ = on_curve(P, by, 0, curve, after)
            here = is_on_border(P, q, branch)
            if before and here:
                found = best_on(P, by, curve, (x, after), goal, best)
                best = found if is_on_border(P, found.q, branch) else best
            x, before = after, here
    return best


@kernel
def best_of_runs(P, by, rows, runs, branch, goal, best):
    """Best posture of runs (in one branch, if it is wanted), if it is better than the best so far."""
    if branch < 0:
        for index in range(runs.shape[0]):
            ends = (runs[index, 1], runs[index, 2])
            best = best_on(P, by, samples_of(rows, runs[index]), ends, goal, best)
        return best
    spans = np.empty((MAX_SPANS, SPAN))
    split = may_line_up(P, by.target.place, width_of_splits(P, by.target.place))
    for i in range(find_spans(P, by, rows, runs, spans)):
        curve, ends = samples_of(rows, runs[int(spans[i, 0])]), (spans[i, 2], spans[i, 3])
        if int(spans[i, 1]) == branch:
            best = best_on(P, by, curve, ends, goal, best)
        elif split:
            best = best_on_border(P, by, curve, ends, branch, goal, best)
    return best


@kernel
def search_followed(P, target, branch, goal, inside, J, A):
    """Best posture of a near limb over all its curves (in one branch, if it is wanted): q, branch, cost.

    `inside` says whether to look inside the limits only, where they are respected; else the least violating posture
    is the best.
    """
    runs = np.empty((MAX_RUNS, RUN))
    by = Setting(target, elbow_side(P, target.place, 0), inside, J, A)
    rows, _, k, _ = near_runs(P, by, runs)
    q, lowest = best_of_runs(P, by, rows, runs[:k], branch, goal, Best(goal.seed, 4.0 * NO_BRANCH))
    if goal.seeded and lowest < OUTSIDE:
        nearer, value, _ = slid(P, target, q, goal, J, A)
        if value < lowest and (branch < 0 or is_on_border(P, nearer, branch)):
            q, lowest = nearer, value
    if lowest < OUTSIDE:
        # A joint that was a rounding outside its limits has been put on them; the others make up for it.
        q = closed_better(P, q, target, goal.respect, J, A)
    return q, branch if branch >= 0 else branch_of(P, q), lowest
