"""The best posture of a near limb, over the curves that `follow` follows on its true chain.

A run is a feasible piece of a curve (`survey`); a span is a part of a run on which the branch stays the same.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, difference, short_way
from srs_ik.kernels.algebra.minimum import propose, start_search, tell
from srs_ik.kernels.algebra.roots import has_settled, next_parameter, start_crossing, tell_figure
from srs_ik.kernels.chain.newton import STEPS, arm_angle, close_free, pose_step
from srs_ik.kernels.curves.ends import meet, on_chord, on_curve, sample_before
from srs_ik.kernels.curves.follow import FIRST_GUESS, null_vector
from srs_ik.kernels.curves.in_step import load_sample
from srs_ik.kernels.curves.runs import near_runs
from srs_ik.kernels.exact.nearest import slid
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import INVERSE_HALF_RANGE, PHASE, SHOULDER, STRAIGHT, WRIST
from srs_ik.kernels.layout.search import BEST, F_BEST, MAX_RUNS, RUN, SHARP, SMOOTH, STATE
from srs_ik.kernels.limb.branches import NO_BRANCH, branch_of
from srs_ik.kernels.limb.goal import OUTSIDE, cost, turned
from srs_ik.kernels.limb.triangle import elbow_side

SPAN = 6
"""A span: its run, branch, first and last parameter, least and greatest arm angle on it, rad (not wrapped)."""

MAX_SPANS = 2 * MAX_RUNS

CHANGE_STEPS = 60
JUST_OUTSIDE = 1e-12
"""Steps that find where a branch changes, and the first look behind that, in the parameter of the curve."""

BESIDE_IT = 1e-12
"""Newton's method finds where a branch changes up to this, in the parameter of the curve."""

MOST_CHANGES = 6
"""A branch changes no more often between two samples."""

LITTLE = 1e-6
"""A step that tells whether an arm angle rises, rad."""

WELL_BENT = 0.6
"""Beside a sample where the arm angle turns around, it is less steep than this part of what comes next."""

TURNING = 1e-9
"""An arm angle that goes back by more than this, rad, has turned around."""

ARC = 1.1
"""The way along a curve between two samples, at most, for the difference of their parameters."""


@kernel
def out_of_branch(P, q, branch):
    """How far a posture is out of a branch: minus the least sine of a middle angle to its side."""
    shoulder = math.sin(q[1] - P[SHOULDER + PHASE]) * (-1.0 if branch & 2 else 1.0)
    elbow = math.sin(q[3] - P[STRAIGHT]) * (-1.0 if branch & 4 else 1.0)
    wrist = math.sin(q[5] - P[WRIST + PHASE]) * (-1.0 if branch & 1 else 1.0)
    return -min(shoulder, elbow, wrist)


@kernel
def first_change(P, branch, a, b):
    """The middle angle that first changes sides on the straight way from a posture in a branch: joint, share, angle."""
    joint = -1
    phase = 0.0
    least = 2.0
    for k in range(3):
        j = 1 + 2 * k
        at = P[STRAIGHT] if k == 1 else P[(SHOULDER if k == 0 else WRIST) + PHASE]
        bit = 2 if k == 0 else (4 if k == 1 else 1)
        side = -1.0 if branch & bit else 1.0
        sine_a, sine_b = max(side * math.sin(a[j] - at), 0.0), side * math.sin(b[j] - at)
        if sine_b < 0.0 and sine_a < least * (sine_a - sine_b):
            joint, least, phase = j, sine_a / (sine_a - sine_b), at
    middle = a[joint] + least * short_way(b[joint] - a[joint])
    return joint, least, phase + math.pi * math.floor((middle - phase) / math.pi + 0.5)


@kernel
def met_change(P, R, p, rows, run, branch, x, y, J, A):
    """`change_of_branch` by Newton's method: its parameter, and whether that is met."""
    low = sample_before(rows, int(run[3]), int(run[4]), 0.5 * (x + y))
    if x < rows[low, 0] or y > rows[low + 1, 0]:
        return x, False
    a, b = on_chord(rows, low, x), on_chord(rows, low, y)
    joint, share, angle = first_change(P, branch, a, b)
    if joint < 0:
        return x, False
    q, found, met = meet(P, R, p, rows, low, along7(a, share, difference(a, b)), joint, angle, J, A)
    return found, met and x < found - BESIDE_IT and found + BESIDE_IT < y and out_of_branch(P, q, branch) < JUST_OUTSIDE


@kernel
def change_of_branch(P, side, R, p, respect, rows, run, branch, x, y, J, A):
    """Where a curve leaves a branch on the way from parameter x to y: the last one in it, and the first one outside."""
    first = int(run[3])
    last = int(run[4])
    found, met = met_change(P, R, p, rows, run, branch, x, y, J, A)
    if met:
        return found - BESIDE_IT, found + BESIDE_IT
    q, _ = on_curve(P, side, R, p, 0, respect, rows, first, last, x, J, A)
    at_x = min(out_of_branch(P, q, branch), 0.0)
    q, _ = on_curve(P, side, R, p, 0, respect, rows, first, last, y, J, A)
    crossing = start_crossing(x, at_x, y, max(out_of_branch(P, q, branch), 0.0))
    for _ in range(CHANGE_STEPS):
        if has_settled(crossing):
            break
        middle = next_parameter(crossing)
        q, _ = on_curve(P, side, R, p, 0, respect, rows, first, last, middle, J, A)
        crossing = tell_figure(crossing, middle, out_of_branch(P, q, branch))
    inside = crossing[0]
    step = JUST_OUTSIDE
    while inside + step < crossing[3]:
        q, _ = on_curve(P, side, R, p, 0, respect, rows, first, last, inside + step, J, A)
        if branch_of(P, q) != branch:
            return inside, inside + step
        step *= 4.0
    return inside, crossing[3]


@kernel
def ahead_at(P, place_, side, R, p, respect, rows, run, x, psi, sign, J, A):
    """How far, in the direction of a sign, the arm angle at a parameter is from one nearby."""
    q, _ = on_curve(P, side, R, p, 0, respect, rows, int(run[3]), int(run[4]), x, J, A)
    return sign * short_way(arm_angle(P, q, place_[0], place_[1]) - psi)


@kernel
def turning_angle(P, place_, side, R, p, respect, rows, run, a, x, b, psi, sign, J, A):
    """The farthest arm angle, in the direction of a sign, between parameters a and b; at x between them it is psi."""
    at_a = ahead_at(P, place_, side, R, p, respect, rows, run, a, psi, sign, J, A)
    at_b = ahead_at(P, place_, side, R, p, respect, rows, run, b, psi, sign, J, A)
    farthest = max(at_a, at_b, 0.0)
    S = np.empty(STATE)
    start_search(S, a, x, b, -at_a, 0.0, -at_b, SMOOTH)
    while True:
        wanted, more = propose(S)
        if not more:
            break
        ahead = ahead_at(P, place_, side, R, p, respect, rows, run, wanted, psi, sign, J, A)
        tell(S, -ahead)
        farthest = max(farthest, ahead)
    return psi + sign * farthest


@kernel
def turn_at(P, place_, q, R, p, J, A):
    """Whether the arm angle rises (1.0) or falls (-1.0) along a curve at a posture."""
    pose_step(P, q, R, p, J)
    way, sign = null_vector(J, FIRST_GUESS, A)
    t, h0 = place_[0], place_[1]
    change = short_way(arm_angle(P, along7(q, LITTLE, way), t, h0) - arm_angle(P, q, t, h0))
    return math.copysign(1.0, sign * change)


@kernel
def slope(P, place_, a, b):
    """How fast the arm angle changes between two samples."""
    before = arm_angle(P, load_sample(a), place_[0], place_[1])
    return short_way(arm_angle(P, load_sample(b), place_[0], place_[1]) - before) / (b[0] - a[0])


@kernel
def may_turn(P, place_, rows, end, way, run):
    """Whether the arm angle may turn around between the sample at an end of a run and the next one, along `way`."""
    third = end + 2 * way
    if not int(run[3]) <= third < int(run[4]):
        return True
    # On a parabola with its top in the first part, this part is at most half as steep as the second one.
    outer, inner = slope(P, place_, rows[end], rows[end + way]), slope(P, place_, rows[end + way], rows[third])
    return outer * inner < WELL_BENT * inner * inner


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
def take_turn(P, place_, side, R, p, respect, rows, run, span, x, psi, rise, change, behind, J, A):
    """Let a span reach to where the arm angle turns around before parameter x, if it does; how it goes on from there.

    The span so far ends at psi, where the arm angle rises or falls like `rise`; at x it has changed by `change` and
    goes on like `behind`.
    """
    if abs(change) > TURNING and change * rise < 0.0 and abs(rise) > TURNING:
        # Somewhere between the samples before and behind the last one.
        a = max(span[2], rows[max(sample_before(rows, int(run[3]), int(run[4]), span[3]) - 1, int(run[3])), 0])
        sign = math.copysign(1.0, rise)
        extend(span, span[3], turning_angle(P, place_, side, R, p, respect, rows, run, a, span[3], x, psi, sign, J, A))
    elif abs(change) > TURNING and change * behind < 0.0:
        sign = math.copysign(1.0, change)
        extend(span, x, turning_angle(P, place_, side, R, p, respect, rows, run, span[3], span[3], x, psi, sign, J, A))
    return change


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
    rise = turn_at(P, place_, q, R, p, J, A) if may_turn(P, place_, rows, first, 1, run) else 0.0
    for i in range(first + 1, last):
        q = load_sample(rows[i])
        for _ in range(MOST_CHANGES):
            if branch_of(P, q) == branch:
                break
            inside, outside = change_of_branch(P, side, R, p, respect, rows, run, branch, x, rows[i, 0], J, A)
            there, _ = on_curve(P, side, R, p, 0, respect, rows, first, last, inside, J, A)
            change = short_way(arm_angle(P, there, t, h0) - psi)
            behind = turn_at(P, place_, there, R, p, J, A)
            rise = take_turn(
                P, place_, side, R, p, respect, rows, run, spans[n - 1], inside, psi, rise, change, behind, J, A
            )
            psi += change
            extend(spans[n - 1], inside, psi)
            there, _ = on_curve(P, side, R, p, 0, respect, rows, first, last, outside, J, A)
            psi += short_way(arm_angle(P, there, t, h0) - psi)
            branch = branch_of(P, there)
            n = open_span(spans, n, index, branch, outside, psi)
            x = outside
            rise = behind
        change = short_way(arm_angle(P, q, t, h0) - psi)
        behind = change
        if i == last - 1 and may_turn(P, place_, rows, i, -1, run):
            behind = turn_at(P, place_, q, R, p, J, A)
        rise = take_turn(
            P, place_, side, R, p, respect, rows, run, spans[n - 1], rows[i, 0], psi, rise, change, behind, J, A
        )
        psi += change
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
