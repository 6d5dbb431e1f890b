"""The best posture of a near limb, over the curves that `trace` follows on its true chain.

A run is a feasible piece of a curve (`survey`); a span is a part of a run on which the branch stays the same.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import short_way
from srs_ik.kernels.algebra.minimum import GOLDEN, propose, start_search, tell
from srs_ik.kernels.chain.newton import STEPS, arm_angle, close_free
from srs_ik.kernels.curves.follow import load_sample
from srs_ik.kernels.curves.runs import near_runs, on_curve
from srs_ik.kernels.exact.nearest import slid
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import INVERSE_HALF_RANGE
from srs_ik.kernels.layout.search import BEST, F_BEST, MAX_RUNS, RUN, SHARP, STATE
from srs_ik.kernels.limb.branches import NO_BRANCH, branch_of
from srs_ik.kernels.limb.goal import OUTSIDE, cost, turned
from srs_ik.kernels.limb.triangle import elbow_side

SPAN = 6
"""A span: its run, branch, first and last parameter, least and greatest arm angle on it, rad (not wrapped)."""

MAX_SPANS = 2 * MAX_RUNS

BISECTIONS = 44
"""Halvings that find where a branch changes: a step of a curve down to its rounding."""

MOST_CHANGES = 6
"""A branch changes no more often between two samples."""

TURNING = 1e-9
"""An arm angle that goes back by more than this, rad, has turned around."""

ARC = 1.1
"""The way along a curve between two samples, at most, for the difference of their parameters."""


@kernel
def change_of_branch(P, side, R, p, respect, rows, run, branch, x, y, J, A):
    """Where a curve leaves a branch on the way from parameter x to y: the last one in it, and the first one outside."""
    first = int(run[3])
    last = int(run[4])
    for _ in range(BISECTIONS):
        middle = 0.5 * (x + y)
        q, _ = on_curve(P, side, R, p, 0, respect, rows, first, last, middle, J, A)
        if branch_of(P, q) == branch:
            x = middle
        else:
            y = middle
    return x, y


@kernel
def turning_angle(P, place_, side, R, p, respect, rows, run, a, b, psi, sign, J, A):
    """The farthest arm angle, in the direction of a sign, between two parameters; psi is one nearby."""
    first = int(run[3])
    last = int(run[4])
    farthest = psi
    for _ in range(BISECTIONS):
        x = b - GOLDEN * (b - a)
        y = a + GOLDEN * (b - a)
        qx, _ = on_curve(P, side, R, p, 0, respect, rows, first, last, x, J, A)
        qy, _ = on_curve(P, side, R, p, 0, respect, rows, first, last, y, J, A)
        at_x = psi + short_way(arm_angle(P, qx, place_[0], place_[1]) - psi)
        at_y = psi + short_way(arm_angle(P, qy, place_[0], place_[1]) - psi)
        if sign * (at_x - at_y) > 0.0:
            b = y
            farthest = at_x if sign * (at_x - farthest) > 0.0 else farthest
        else:
            a = x
            farthest = at_y if sign * (at_y - farthest) > 0.0 else farthest
    return farthest


@kernel
def open_span(spans, n, index, branch, x, psi):
    """Begin a span; return the number of spans."""
    if n >= spans.shape[0]:
        return n
    spans[n, 0] = index
    spans[n, 1] = branch
    spans[n, 2] = x
    spans[n, 3] = x
    spans[n, 4] = psi
    spans[n, 5] = psi
    return n + 1


@kernel
def extend(span, x, psi):
    """Let a span reach to a parameter with its arm angle."""
    span[3] = x
    span[4] = min(span[4], psi)
    span[5] = max(span[5], psi)


@kernel
def spans_of_run(P, place_, side, R, p, respect, rows, runs, index, spans, n, J, A):
    """Append the spans of a run; return the number of spans."""
    run = runs[index]
    first = int(run[3])
    last = int(run[4])
    t = place_[0]
    h0 = place_[1]
    q = load_sample(rows[first])
    x = rows[first, 0]
    branch = branch_of(P, q)
    psi = arm_angle(P, q, t, h0)
    n = open_span(spans, n, index, branch, x, psi)
    rise = 0.0
    for i in range(first + 1, last):
        q = load_sample(rows[i])
        a = x
        for _ in range(MOST_CHANGES):
            if branch_of(P, q) == branch:
                break
            inside, outside = change_of_branch(P, side, R, p, respect, rows, run, branch, x, rows[i, 0], J, A)
            for end in (inside, outside):
                there, _ = on_curve(P, side, R, p, 0, respect, rows, first, last, end, J, A)
                psi += short_way(arm_angle(P, there, t, h0) - psi)
                if end == inside:
                    extend(spans[n - 1], end, psi)
                else:
                    branch = branch_of(P, there)
                    n = open_span(spans, n, index, branch, end, psi)
            x = outside
            rise = 0.0
        change = short_way(arm_angle(P, q, t, h0) - psi)
        if change * rise < 0.0 and min(abs(change), abs(rise)) > TURNING:
            # It has turned around somewhere between the samples before and behind the last one.
            start = max(spans[n - 1, 2], rows[max(i - 2, first), 0])
            sign = math.copysign(1.0, rise)
            extend(
                spans[n - 1],
                x,
                turning_angle(P, place_, side, R, p, respect, rows, run, start, rows[i, 0], psi, sign, J, A),
            )
        psi += change
        rise = change if x == a else 0.0
        x = rows[i, 0]
        extend(spans[n - 1], x, psi)
    return n


@kernel
def find_spans(P, place_, R, p, respect, rows, runs, k, spans, J, A):
    """Cut all runs into spans; return their number."""
    side = elbow_side(P, place_, 0)
    n = 0
    for index in range(k):
        n = spans_of_run(P, place_, side, R, p, respect, rows, runs, index, spans, n, J, A)
    return n


@kernel
def rate_of_cost(P):
    """How fast a cost that is no distance may change with the way along a curve."""
    fastest = 1.0
    for j in range(7):
        fastest = max(fastest, P[INVERSE_HALF_RANGE + j])
    return fastest


@kernel
def hope(value, gap, seeded, rate):
    """A cost below any within a way `gap` of a posture with this cost."""
    if seeded and value < OUTSIDE:
        return max(math.sqrt(value) - ARC * gap, 0.0) ** 2
    return value - rate * ARC * gap


@kernel
def cost_at(P, side, R, p, rows, run, x, seeded, seed, respect, J, A):
    """Posture of a run at a parameter, in the turn that suits the goal, and its cost."""
    q, off = on_curve(P, side, R, p, 0, respect, rows, int(run[3]), int(run[4]), x, J, A)
    if off >= NO_BRANCH:
        return q, NO_BRANCH
    q = turned(P, q, seeded, seed, respect)
    return q, cost(P, q, seeded, seed, respect)


@kernel
def best_on(P, side, R, p, rows, run, lower, upper, seeded, seed, respect, best_q, lowest, S, J, A):
    """Best posture of a run between two parameters if it is better than the best so far: q, cost."""
    rate = rate_of_cost(P)
    first = int(run[3])
    last = int(run[4])
    a = lower
    x = lower
    q, fx = cost_at(P, side, R, p, rows, run, x, seeded, seed, respect, J, A)
    fa = fx
    if fx < lowest:
        best_q, lowest = q, fx
    i = first
    while x < upper:
        while i < last - 1 and rows[i, 0] <= x:
            i += 1
        b = min(rows[i, 0], upper) if rows[i, 0] > x else upper
        if b < upper:
            q = turned(P, load_sample(rows[i]), seeded, seed, respect)
            fb = cost(P, q, seeded, seed, respect)
        else:
            q, fb = cost_at(P, side, R, p, rows, run, b, seeded, seed, respect, J, A)
        if fb < lowest:
            best_q, lowest = q, fb
        if fx <= fa and fx <= fb and hope(fx, max(x - a, b - x), seeded, rate) < lowest:
            best_q, lowest = close_in_on(
                P, side, R, p, rows, run, a, x, b, fa, fx, fb, seeded, seed, respect, best_q, lowest, S, J, A
            )
        if b == upper and fb <= fx and hope(fb, b - x, seeded, rate) < lowest:
            best_q, lowest = close_in_on(
                P, side, R, p, rows, run, x, b, b, fx, fb, fb, seeded, seed, respect, best_q, lowest, S, J, A
            )
        a, fa = x, fx
        x, fx = b, fb
    return best_q, lowest


@kernel
def close_in_on(P, side, R, p, rows, run, a, x, b, fa, fx, fb, seeded, seed, respect, best_q, lowest, S, J, A):
    """Close in on a minimum between a and b, lowest at x: the best posture so far and its cost."""
    start_search(S, a, x, b, fa, fx, fb, SHARP)
    while True:
        wanted, more = propose(S)
        if not more:
            break
        _, f = cost_at(P, side, R, p, rows, run, wanted, seeded, seed, respect, J, A)
        tell(S, f)
    if S[F_BEST] < lowest:
        return cost_at(P, side, R, p, rows, run, S[BEST], seeded, seed, respect, J, A)
    return best_q, lowest


@kernel
def search_followed(P, place_, R, p, branch, seeded, seed, respect, inside, J, A):
    """Best posture of a near limb over all its curves (in one branch, if it is wanted): q, branch, cost.

    `inside` says whether to look inside the limits only, where they are respected; else the least violating posture
    is the best.
    """
    runs = np.empty((MAX_RUNS, RUN))
    rows, _, k, _ = near_runs(P, place_, R, p, inside, runs, J, A)
    side = elbow_side(P, place_, 0)
    S = np.empty(STATE)
    q = seed
    lowest = 4.0 * NO_BRANCH
    if branch < 0:
        for index in range(k):
            run = runs[index]
            q, lowest = best_on(P, side, R, p, rows, run, run[1], run[2], seeded, seed, respect, q, lowest, S, J, A)
    else:
        spans = np.empty((MAX_SPANS, SPAN))
        n = find_spans(P, place_, R, p, inside, rows, runs, k, spans, J, A)
        for i in range(n):
            if int(spans[i, 1]) == branch:
                run = runs[int(spans[i, 0])]
                q, lowest = best_on(
                    P, side, R, p, rows, run, spans[i, 2], spans[i, 3], seeded, seed, respect, q, lowest, S, J, A
                )
    if seeded and lowest < OUTSIDE:
        nearer, value, _ = slid(P, q, R, p, seed, respect, J, A)
        if value < lowest and (branch < 0 or branch_of(P, nearer) == branch):
            q, lowest = nearer, value
    if lowest < OUTSIDE:
        # A joint that was a rounding outside its limits has been put on them; the others make up for it.
        q, _ = close_free(P, q, R, p, respect, STEPS, J, A)
    return q, branch_of(P, q), lowest
