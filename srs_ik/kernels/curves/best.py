"""The best posture of a near limb, over the curves that `follow` follows on its true chain.

A run is a feasible piece of a curve (`survey`); a span is a part of a run on which the branch stays the same.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, difference, short_way
from srs_ik.kernels.algebra.minimum import propose, start_search, tell
from srs_ik.kernels.algebra.roots import has_settled, next_parameter, start_crossing, tell_figure
from srs_ik.kernels.chain.newton import arm_angle
from srs_ik.kernels.curves.ends import meet, on_chord, on_curve, sample_before
from srs_ik.kernels.curves.follow import tangent_at
from srs_ik.kernels.curves.in_step import load_sample
from srs_ik.kernels.curves.runs import near_runs, samples_of
from srs_ik.kernels.exact.free_splits import closed_better
from srs_ik.kernels.exact.nearest import slid
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.asked import Best, Setting
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
"""Steps that find where a branch changes, and the first looks on either side, in the parameter of the curve."""

MOST_CHANGES = 6
"""A branch changes no more often between two samples."""

LITTLE = 1e-6
"""A step that tells whether an arm angle rises, rad."""

WELL_BENT = 0.6
"""Beside a sample where the arm angle turns around, it is less steep than this part of what comes next."""

TURNING = 1e-9
TURNED = 1e-12
"""An arm angle that goes back by more than the first, rad, has turned around. There it is the same up to the second."""

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
def met_change(P, by, curve, branch, x, y):
    """`change_of_branch` by Newton's method: its parameter, and whether that is met."""
    rows = curve.rows
    low = sample_before(curve, 0.5 * (x + y))
    if x < rows[low, 0] or y > rows[low + 1, 0]:
        return x, False
    a, b = on_chord(rows, low, x), on_chord(rows, low, y)
    joint, share, angle = first_change(P, branch, a, b)
    if joint < 0:
        return x, False
    q, found, met = meet(P, by, rows, low, along7(a, share, difference(a, b)), joint, angle)
    return found, met and x < found - JUST_OUTSIDE and found + JUST_OUTSIDE < y and out_of_branch(
        P, q, branch
    ) < JUST_OUTSIDE


@kernel
def change_of_branch(P, by, curve, branch, x, y):
    """Where a curve leaves a branch on the way from parameter x to y: the last one in it, and the first one outside."""
    found, met = met_change(P, by, curve, branch, x, y)
    if met:
        return found - JUST_OUTSIDE, found + JUST_OUTSIDE
    q, _ = on_curve(P, by, 0, curve, x)
    at_x = min(out_of_branch(P, q, branch), 0.0)
    q, _ = on_curve(P, by, 0, curve, y)
    crossing = start_crossing(x, at_x, y, max(out_of_branch(P, q, branch), 0.0))
    for _ in range(CHANGE_STEPS):
        if has_settled(crossing):
            break
        middle = next_parameter(crossing)
        q, _ = on_curve(P, by, 0, curve, middle)
        crossing = tell_figure(crossing, middle, out_of_branch(P, q, branch))
    inside = crossing[0]
    step = JUST_OUTSIDE
    while inside + step < crossing[3]:
        q, _ = on_curve(P, by, 0, curve, inside + step)
        if branch_of(P, q) != branch:
            return inside, inside + step
        step *= 4.0
    return inside, crossing[3]


@kernel
def angle_at(P, by, q):
    """The arm angle of a posture for the pose."""
    return arm_angle(P, q, by.target.place[0], by.target.place[1])


@kernel
def ahead_at(P, by, curve, x, psi, sign):
    """How far, in the direction of a sign, the arm angle at a parameter is from one nearby."""
    q, _ = on_curve(P, by, 0, curve, x)
    return sign * short_way(angle_at(P, by, q) - psi)


@kernel
def turning_angle(P, by, curve, points, psi, sign):
    """The farthest arm angle, in the direction of a sign, between the outer of three parameters; psi at the middle."""
    a, x, b = points
    at_a = ahead_at(P, by, curve, a, psi, sign)
    at_b = ahead_at(P, by, curve, b, psi, sign)
    farthest = max(at_a, at_b, 0.0)
    S = np.empty(STATE)
    start_search(S, a, x, b, -at_a, 0.0, -at_b, SMOOTH)
    while True:
        wanted, more = propose(S)
        if not more:
            break
        ahead = ahead_at(P, by, curve, wanted, psi, sign)
        tell(S, -ahead)
        if abs(ahead - farthest) < TURNED:
            break
        farthest = max(farthest, ahead)
    return psi + sign * farthest


@kernel
def turn_at(P, by, q):
    """Whether the arm angle rises (1.0) or falls (-1.0) along a curve at a posture."""
    way, _ = tangent_at(P, by, q)
    return math.copysign(1.0, short_way(angle_at(P, by, along7(q, LITTLE, way)) - angle_at(P, by, q)))


@kernel
def slope(P, by, a, b):
    """How fast the arm angle changes between two samples."""
    before = angle_at(P, by, load_sample(a))
    return short_way(angle_at(P, by, load_sample(b)) - before) / (b[0] - a[0])


@kernel
def may_turn(P, by, curve, end, way):
    """Whether the arm angle may turn around between the sample at an end of a run and the next one, along `way`."""
    rows, first, last = curve
    third = end + 2 * way
    if not first <= third < last:
        return True
    # On a parabola with its top in the first part, this part is at most half as steep as the second one.
    outer, inner = slope(P, by, rows[end], rows[end + way]), slope(P, by, rows[end + way], rows[third])
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


class Passed(NamedTuple):
    """Where a span has come to along its curve."""

    psi: Any  # arm angle, not wrapped
    rise: Any  # how it has changed on the way there: its sign tells whether it rises


@kernel
def take_turn(P, by, curve, span, passed, x, to):
    """Let a span reach to where the arm angle turns around before parameter x, if it does.

    `to` holds by how much the arm angle changes until x, and how it goes on from there.
    """
    psi, rise = passed
    change, behind = to
    if abs(change) > TURNING and change * rise < 0.0 and abs(rise) > TURNING:
        # Somewhere between the samples before and behind the last one.
        before = max(sample_before(curve, span[3]) - 1, curve.first)
        sign = math.copysign(1.0, rise)
        points = (max(span[2], curve.rows[before, 0]), span[3], x)
        extend(span, span[3], turning_angle(P, by, curve, points, psi, sign))
    elif abs(change) > TURNING and change * behind < 0.0:
        sign = math.copysign(1.0, change)
        extend(span, x, turning_angle(P, by, curve, (span[3], span[3], x), psi, sign))


@kernel
def spans_of_run(P, by, rows, runs, index, spans, n):
    """Append the spans of a run; return the number of spans."""
    curve = samples_of(rows, runs[index])
    _, first, last = curve
    q = load_sample(rows[first])
    x = rows[first, 0]
    branch = branch_of(P, q)
    psi = angle_at(P, by, q)
    n = open_span(spans, n, index, branch, x, psi)
    rise = turn_at(P, by, q) if may_turn(P, by, curve, first, 1) else 0.0
    for i in range(first + 1, last):
        q = load_sample(rows[i])
        for _ in range(MOST_CHANGES):
            if branch_of(P, q) == branch:
                break
            inside, outside = change_of_branch(P, by, curve, branch, x, rows[i, 0])
            there, _ = on_curve(P, by, 0, curve, inside)
            change = short_way(angle_at(P, by, there) - psi)
            behind = turn_at(P, by, there)
            take_turn(P, by, curve, spans[n - 1], Passed(psi, rise), inside, (change, behind))
            psi += change
            extend(spans[n - 1], inside, psi)
            there, _ = on_curve(P, by, 0, curve, outside)
            psi += short_way(angle_at(P, by, there) - psi)
            branch = branch_of(P, there)
            n = open_span(spans, n, index, branch, outside, psi)
            x = outside
            rise = behind
        change = short_way(angle_at(P, by, q) - psi)
        behind = change
        if i == last - 1 and may_turn(P, by, curve, i, -1):
            behind = turn_at(P, by, q)
        take_turn(P, by, curve, spans[n - 1], Passed(psi, rise), rows[i, 0], (change, behind))
        rise = change
        psi += change
        x = rows[i, 0]
        extend(spans[n - 1], x, psi)
    return n


@kernel
def find_spans(P, by, rows, runs, spans):
    """Cut all runs into spans; return their number."""
    n = 0
    for index in range(runs.shape[0]):
        n = spans_of_run(P, by, rows, runs, index, spans, n)
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
def cost_of_turn(P, q, goal):
    """A posture in the turn that suits the goal, and its cost."""
    q = turned(P, q, goal.seeded, goal.seed, goal.respect)
    return q, cost(P, q, goal.seeded, goal.seed, goal.respect)


@kernel
def cost_at(P, by, curve, x, goal):
    """Posture of a run at a parameter, in the turn that suits the goal, and its cost."""
    q, off = on_curve(P, by, 0, curve, x)
    if off >= NO_BRANCH:
        return q, NO_BRANCH
    return cost_of_turn(P, q, goal)


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
        if b < upper:
            q, fb = cost_of_turn(P, load_sample(rows[i]), goal)
        else:
            q, fb = cost_at(P, by, curve, b, goal)
        if fb < best.cost:
            best = Best(q, fb)
        if fx <= fa and fx <= fb and hope(fx, max(x - a, b - x), goal.seeded, rate) < best.cost:
            best = close_in_on(P, by, curve, ((a, fa), (x, fx), (b, fb)), goal, best)
        if b == upper and fb <= fx and hope(fb, b - x, goal.seeded, rate) < best.cost:
            best = close_in_on(P, by, curve, ((x, fx), (b, fb), (b, fb)), goal, best)
        a, fa = x, fx
        x, fx = b, fb
    return best


@kernel
def close_in_on(P, by, curve, bracket, goal, best):
    """Close in on a minimum between the outer of three parameters with their costs: the best posture so far."""
    (a, fa), (x, fx), (b, fb) = bracket
    S = np.empty(STATE)
    start_search(S, a, x, b, fa, fx, fb, SHARP)
    while True:
        wanted, more = propose(S)
        if not more:
            break
        _, f = cost_at(P, by, curve, wanted, goal)
        tell(S, f)
    if S[F_BEST] < best.cost:
        q, f = cost_at(P, by, curve, S[BEST], goal)
        return Best(q, f)
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
    for i in range(find_spans(P, by, rows, runs, spans)):
        if int(spans[i, 1]) == branch:
            curve = samples_of(rows, runs[int(spans[i, 0])])
            best = best_on(P, by, curve, (spans[i, 2], spans[i, 3]), goal, best)
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
        if value < lowest and (branch < 0 or branch_of(P, nearer) == branch):
            q, lowest = nearer, value
    if lowest < OUTSIDE:
        # A joint that was a rounding outside its limits has been put on them; the others make up for it.
        q = closed_better(P, q, target, goal.respect, J, A)
    return q, branch_of(P, q), lowest
