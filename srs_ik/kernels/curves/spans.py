"""Spans: parts of the runs of a near limb on which the branch stays the same, with the arm angles that they pass."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, short_way
from srs_ik.kernels.algebra.lane_trig import angle_of, turn
from srs_ik.kernels.algebra.lanes import root, scatter
from srs_ik.kernels.algebra.minimum import propose, start_search, tell
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import cross, dot, load3, sub
from srs_ik.kernels.chain.eight import branches_of
from srs_ik.kernels.chain.kinematics import turn_about_line
from srs_ik.kernels.chain.newton import arm_angle
from srs_ik.kernels.curves.changes import CHANGE, CHANGE_AT, CHANGE_MIDDLE, MOST_CHANGES, find_changes
from srs_ik.kernels.curves.ends import on_curve, sample_before
from srs_ik.kernels.curves.follow import tangent_at
from srs_ik.kernels.curves.in_step import SAMPLE, load_sample, take_ways
from srs_ik.kernels.curves.runs import samples_of
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import ELBOW_CENTRE, SHOULDER_CENTRE
from srs_ik.kernels.layout.search import MAX_RUNS, SMOOTH, STATE
from srs_ik.kernels.limb.branches import bit_of

TOLD = 2
TOLD_BRANCH, TOLD_PSI = range(TOLD)
"""What a sample tells: its branch and its arm angle, rad."""

SPAN = 6
"""A span: its run, branch, first and last parameter, least and greatest arm angle on it, rad (not wrapped)."""

MAX_SPANS = 2 * MAX_RUNS

JUST_OUTSIDE = 1e-12
"""Spans on either side of a change of branch end this close to it, in the parameter of the curve."""

SHORT = 1e-9
SHORT_TURN = 1e-7
"""A branch that a curve is in no longer than this, in its parameter and in arm angles, is one of rounding: what lies
there is on the border of those before and behind."""

LITTLE = 1e-6
"""A step that tells whether an arm angle rises, rad."""

WELL_BENT = 0.6
"""Beside a sample where the arm angle turns around, it is less steep than this part of what comes next."""

TURNING = 1e-9
TURNED = 1e-12
"""An arm angle that goes back by more than the first, rad, has turned around. There it is the same up to the second."""


@kernel
def angle_at(P, by, q):
    """The arm angle of a posture for the pose."""
    return arm_angle(P, q, by.target.place[0], by.target.place[1])


@kernel
def arm_angles(P, place_, q):
    """The arm angles of eight postures."""
    t, h0 = place_[0], place_[1]
    turn_1, turn_2, turn_3 = turn(q[0]), turn(q[1]), turn(q[2])
    elbow = turn_about_line(P, 2, turn_3[0], turn_3[1], load3(P, ELBOW_CENTRE))
    elbow = turn_about_line(P, 1, turn_2[0], turn_2[1], elbow)
    elbow = turn_about_line(P, 0, turn_1[0], turn_1[1], elbow)
    upper_arm = sub(elbow, load3(P, SHOULDER_CENTRE))
    c, s = dot(upper_arm, h0), dot(upper_arm, cross(t, h0))
    share = 1.0 / root(c * c + s * s)
    return angle_of(share * c, share * s)


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
def tell_samples(P, by, curve, told):
    """Write branch and arm angle of the samples of a curve, eight at a time."""
    rows, first, last = curve
    for i in range(first, last, 8):
        # The last eight rows there are may begin before.
        k = min(i, rows.shape[0] - 8)
        q = take_ways(row(rows, k), 1, SAMPLE)
        scatter(row(told, k), TOLD_BRANCH, TOLD, branches_of(P, q))
        scatter(row(told, k), TOLD_PSI, TOLD, arm_angles(P, by.target.place, q))


@kernel
def drop_span(spans, i, n):
    """Take a span out of n; their number."""
    for k in range(i, n - 1):
        for c in range(SPAN):
            spans[k, c] = spans[k + 1, c]
    return n - 1


@kernel
def join_span(spans, i, n):
    """Let a span take in the one behind it; the number of spans."""
    spans[i, 3] = spans[i + 1, 3]
    spans[i, 4], spans[i, 5] = min(spans[i, 4], spans[i + 1, 4]), max(spans[i, 5], spans[i + 1, 5])
    return drop_span(spans, i + 1, n)


@kernel
def without_short(spans, first, n):
    """Drop the spans of a run, from row `first` on, that rounding makes, and join what is one then; their number."""
    i = first
    while i < n and n - first > 1:
        span = spans[i]
        if span[3] - span[2] < SHORT and span[5] - span[4] < SHORT_TURN:
            n = drop_span(spans, i, n)
            if first < i < n and spans[i - 1, 1] == spans[i, 1]:
                n = join_span(spans, i - 1, n)
        else:
            i += 1
    return n


@kernel
def spans_of_run(P, by, rows, runs, index, room, n):
    """Append the spans of a run; the number of spans. `room` is for spans, for what samples tell, and for changes."""
    spans, told, changes = room
    curve = samples_of(rows, runs[index])
    _, first, last = curve
    tell_samples(P, by, curve, told)
    start = n
    q = load_sample(rows[first])
    x = rows[first, 0]
    branch = int(told[first, TOLD_BRANCH])
    psi = told[first, TOLD_PSI]
    n = open_span(spans, n, index, branch, x, psi)
    rise = turn_at(P, by, q) if may_turn(P, by, curve, first, 1) else 0.0
    for i in range(first + 1, last):
        before, q = (rows[i - 1, 0], q), load_sample(rows[i])
        for c in range(find_changes(P, by, curve, before, (rows[i, 0], q), changes)):
            inside = max(changes[c, CHANGE_AT] - JUST_OUTSIDE, x)
            outside = max(min(changes[c, CHANGE_AT] + JUST_OUTSIDE, rows[i, 0]), inside)
            there, _ = on_curve(P, by, 0, curve, inside)
            change = short_way(angle_at(P, by, there) - psi)
            behind = turn_at(P, by, there)
            take_turn(P, by, curve, spans[n - 1], Passed(psi, rise), inside, (change, behind))
            psi += change
            extend(spans[n - 1], inside, psi)
            there, _ = on_curve(P, by, 0, curve, outside)
            psi += short_way(angle_at(P, by, there) - psi)
            branch ^= bit_of(int(changes[c, CHANGE_MIDDLE]))
            n = open_span(spans, n, index, branch, outside, psi)
            x = outside
            rise = behind
        change = short_way(told[i, TOLD_PSI] - psi)
        behind = change
        if i == last - 1 and may_turn(P, by, curve, i, -1):
            behind = turn_at(P, by, q)
        take_turn(P, by, curve, spans[n - 1], Passed(psi, rise), rows[i, 0], (change, behind))
        rise = change
        psi += change
        x = rows[i, 0]
        extend(spans[n - 1], x, psi)
    return without_short(spans, start, n)


@kernel
def find_spans(P, by, rows, runs, spans):
    """Cut all runs into spans; return their number."""
    room = spans, np.empty((rows.shape[0], TOLD)), np.empty((MOST_CHANGES, CHANGE))
    n = 0
    for index in range(runs.shape[0]):
        n = spans_of_run(P, by, rows, runs, index, room, n)
    return n
