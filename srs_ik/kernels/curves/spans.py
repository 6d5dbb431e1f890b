"""Spans: parts of the runs of a near limb on which the branch stays the same, with the arm angles that they pass."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import short_way
from srs_ik.kernels.algebra.pointers import copy, row
from srs_ik.kernels.curves.changes import (
    CHANGE,
    CHANGE_AT,
    CHANGE_MIDDLE,
    MOST_BACK,
    MOST_CHANGES,
    find_changes,
    posture_beside,
    turned_back,
)
from srs_ik.kernels.curves.ends import inside_of_blur, on_curve, sample_before
from srs_ik.kernels.curves.follow import BLURRED
from srs_ik.kernels.curves.runs import samples_of
from srs_ik.kernels.curves.told import (
    ARM_ANGLE,
    TOLD,
    TOLD_BRANCH,
    TOLD_PSI,
    TOLD_RATE,
    angle_at,
    rate_at,
    tell_samples,
    turning_between,
)
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.asked import Samples
from srs_ik.kernels.layout.search import MAX_RUNS
from srs_ik.kernels.limb.branches import bit_of

SPAN = 6
"""A span: its run, branch, first and last parameter, least and greatest arm angle on it, rad (not wrapped)."""

MAX_SPANS = 4 * MAX_RUNS
"""Along a free split, rounding may change the branch a thousand times."""

JUST_OUTSIDE = 1e-12
"""Spans on either side of a change of branch end this close to it, in the parameter of the curve."""

SHORT = 1e-9
SHORT_TURN = 1e-7
"""A branch that a curve is in no longer than this, in its parameter and in arm angles, is one of rounding: what lies
there is on the border of those before and behind."""

TURNING = 1e-9
"""An arm angle that goes back by more than this, rad, has turned around."""


@kernel
def turning_angle(P, by, curve, ends, psi, sign):
    """The farthest arm angle, in the direction of a sign, between two parameters; psi is close by."""
    a, _ = on_curve(P, by, 0, curve, ends[0])
    b, _ = on_curve(P, by, 0, curve, ends[1])
    turning = inside_of_blur(P, by, turning_between(P, by, a, b, sign, ARM_ANGLE), BLURRED)
    return psi + short_way(angle_at(P, by, turning) - psi)


@kernel
def open_span(spans, n, index, branch, x, psi):
    """Begin a span; return the number of spans. Without room the last one makes way: it must not go on as this one."""
    n = min(n, spans.shape[0] - 1)
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
        there, _ = on_curve(P, by, 0, curve, span[3])
        rises = rate_at(P, by, there) * sign > 0.0
        ends = (span[3], x) if rises else (max(span[2], curve.rows[before, 0]), span[3])
        extend(span, span[3], turning_angle(P, by, curve, ends, psi, sign))
    elif (change if abs(change) > TURNING else rise) * behind < 0.0:
        sign = math.copysign(1.0, change if abs(change) > TURNING else rise)
        extend(span, x, turning_angle(P, by, curve, (span[3], x), psi, sign))


@kernel
def take_back(P, by, curve, span, passed, a, b):
    """Let a span reach to where the arm angle goes back between two places, if it does; where it has come."""
    for i in range(MOST_BACK):
        a, _, found = turned_back(P, by, curve, a, b, i > 0)
        if not found:
            break
        x, psi, rate = a
        change, behind = short_way(psi - passed.psi), math.copysign(1.0, rate)
        take_turn(P, by, curve, span, passed, x, (change, behind))
        passed = Passed(passed.psi + change, behind)
        extend(span, x, passed.psi)
    return passed


@kernel
def drop_span(spans, i, n):
    """Take a span out of n; their number."""
    for k in range(i, n - 1):
        copy(row(spans, k + 1), row(spans, k), SPAN)
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
    """Append the spans of a run; the number of spans. `room` is for spans, what samples tell, and room for changes."""
    spans, told, changes = room
    curve = samples_of(rows, runs[index])
    _, first, last = curve
    start = n
    x = rows[first, 0]
    branch = int(told[first, TOLD_BRANCH])
    psi = told[first, TOLD_PSI]
    n = open_span(spans, n, index, branch, x, psi)
    last_told = x, psi, told[first, TOLD_RATE]
    rise = math.copysign(1.0, last_told[2])
    for i in range(first + 1, last):
        for c in range(find_changes(P, by, curve, i, told, changes)):
            inside = max(changes[c, CHANGE_AT] - JUST_OUTSIDE, x)
            outside = max(min(changes[c, CHANGE_AT] + JUST_OUTSIDE, rows[i, 0]), inside)
            there = posture_beside(P, by, curve, changes[c], inside)
            to = inside, angle_at(P, by, there), rate_at(P, by, there)
            psi, rise = take_back(P, by, curve, spans[n - 1], Passed(psi, rise), last_told, to)
            change, behind = short_way(to[1] - psi), math.copysign(1.0, to[2])
            take_turn(P, by, curve, spans[n - 1], Passed(psi, rise), inside, (change, behind))
            psi += change
            extend(spans[n - 1], inside, psi)
            there = posture_beside(P, by, curve, changes[c], outside)
            psi += short_way(angle_at(P, by, there) - psi)
            branch ^= bit_of(int(changes[c, CHANGE_MIDDLE]))
            n = open_span(spans, n, index, branch, outside, psi)
            x = outside
            rise, last_told = behind, (outside, psi, to[2])
        to = rows[i, 0], told[i, TOLD_PSI], told[i, TOLD_RATE]
        psi, rise = take_back(P, by, curve, spans[n - 1], Passed(psi, rise), last_told, to)
        change = short_way(to[1] - psi)
        # Two samples with one arm angle have its turn between them, if it rises at one of them alone.
        stays = abs(change) <= TURNING
        rise = last_told[2] if stays else rise
        behind = math.copysign(1.0, to[2]) if stays or i == last - 1 else change
        take_turn(P, by, curve, spans[n - 1], Passed(psi, rise), rows[i, 0], (change, behind))
        rise, last_told = change, to
        psi += change
        x = rows[i, 0]
        extend(spans[n - 1], x, psi)
    return without_short(spans, start, n)


@kernel
def find_spans(P, by, rows, runs, spans):
    """Cut all runs into spans; return their number."""
    told, changes = np.empty((rows.shape[0], TOLD)), np.empty((MOST_CHANGES, CHANGE))
    count = runs.shape[0]
    if count > 0:
        # Runs lie one behind the other.
        tell_samples(P, by, Samples(rows, int(runs[0, 3]), int(runs[count - 1, 4])), told)
    room = spans, told, changes
    n = 0
    for index in range(count):
        n = spans_of_run(P, by, rows, runs, index, room, n)
    return n
