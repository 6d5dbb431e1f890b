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
    MET,
    MOST_BACK,
    MOST_CHANGES,
    MOST_MET,
    TURNING,
    Place,
    find_changes,
    goes_on,
    meet_changes,
    place_beside,
    turned_back,
)
from srs_ik.kernels.curves.ends import inside_of_blur, on_curve, sample_before
from srs_ik.kernels.curves.follow import BLURRED
from srs_ik.kernels.curves.in_step import load_sample
from srs_ik.kernels.curves.runs import samples_of
from srs_ik.kernels.curves.told import (
    ARM_ANGLE,
    TOLD,
    TOLD_BRANCH,
    TOLD_PSI,
    TOLD_RATE,
    UNTOLD,
    angle_at,
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
def take_turning(P, by, span, turning, psi):
    """Let a span reach to the arm angle of a posture where that turns around; psi is close by."""
    turning = inside_of_blur(P, by, turning, BLURRED)
    extend(span, span[3], psi + short_way(angle_at(P, by, turning) - psi))


@kernel
def take_turn(P, by, curve, span, passed, here, to):
    """Let a span reach to where the arm angle turns around on the way from one place to another, if it does.

    Behind the other, which is given with its sign, it goes on to rise or to fall.
    """
    psi, rise = passed
    place_, behind = to
    rates = (here.at[2], place_.at[2])
    change = short_way(place_.at[1] - psi)
    if abs(change) > TURNING and change * rise < 0.0 and abs(rise) > TURNING:
        # Somewhere between the samples before and behind this place.
        sign = math.copysign(1.0, rise)
        if here.at[2] * sign > 0.0:
            take_turning(P, by, span, turning_between(P, by, here.q, place_.q, sign, ARM_ANGLE, rates), psi)
        else:
            before = max(sample_before(curve, span[3]) - 1, curve.first)
            x = max(span[2], curve.rows[before, 0])
            q, _ = on_curve(P, by, 0, curve, x)
            take_turning(P, by, span, turning_between(P, by, q, here.q, sign, ARM_ANGLE, UNTOLD), psi)
    elif (change if abs(change) > TURNING else rise) * behind < 0.0:
        sign = math.copysign(1.0, change if abs(change) > TURNING else rise)
        take_turning(P, by, span, turning_between(P, by, here.q, place_.q, sign, ARM_ANGLE, rates), psi)


@kernel
def take_back(P, by, curve, span, passed, here, at):
    """Let a span reach to where the arm angle goes back between two places, if it does; where it has come, twice."""
    for i in range(MOST_BACK):
        there, found = turned_back(P, by, curve, here.at, at, i > 0)
        if not found:
            break
        psi, behind = passed.psi + short_way(there.at[1] - passed.psi), math.copysign(1.0, there.at[2])
        take_turn(P, by, curve, span, passed, here, (there, behind))
        passed, here = Passed(psi, behind), there
        extend(span, there.at[0], psi)
    return passed, here


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
def pass_between(P, by, curve, i, passed, room, n):
    """Go on with n spans from sample i - 1 of a run to the next one: where they have come to, and their number.

    `room` is for spans, what is known of the samples (`find_changes`), and room for changes.
    """
    spans, known, changes = room
    told, _ = known
    rows = curve.rows
    psi, rise = passed
    x = rows[i - 1, 0]
    here = Place((x, told[i - 1, TOLD_PSI], told[i - 1, TOLD_RATE]), load_sample(rows[i - 1]))
    for c in range(find_changes(P, by, curve, i, known, changes)):
        inside = max(changes[c, CHANGE_AT] - JUST_OUTSIDE, x)
        outside = max(min(changes[c, CHANGE_AT] + JUST_OUTSIDE, rows[i, 0]), inside)
        to = place_beside(P, by, curve, changes[c], inside)
        passed, here = take_back(P, by, curve, spans[n - 1], Passed(psi, rise), here, to.at)
        rise = math.copysign(1.0, to.at[2])
        take_turn(P, by, curve, spans[n - 1], passed, here, (to, rise))
        psi = passed.psi + short_way(to.at[1] - passed.psi)
        extend(spans[n - 1], inside, psi)
        here = place_beside(P, by, curve, changes[c], outside)
        psi += short_way(here.at[1] - psi)
        branch = int(spans[n - 1, 1]) ^ bit_of(int(changes[c, CHANGE_MIDDLE]))
        n = open_span(spans, n, spans[n - 1, 0], branch, outside, psi)
        x, here = outside, Place((outside, psi, here.at[2]), here.q)
    to = Place((rows[i, 0], told[i, TOLD_PSI], told[i, TOLD_RATE]), load_sample(rows[i]))
    passed, here = take_back(P, by, curve, spans[n - 1], Passed(psi, rise), here, to.at)
    change = short_way(to.at[1] - passed.psi)
    # Two samples with one arm angle have its turn between them, if it rises at one of them alone.
    stays = abs(change) <= TURNING
    passed = Passed(passed.psi, here.at[2]) if stays else passed
    behind = math.copysign(1.0, to.at[2]) if stays or i == curve.last - 1 else change
    take_turn(P, by, curve, spans[n - 1], passed, here, (to, behind))
    return Passed(passed.psi + change, change), n


@kernel
def spans_of_run(P, by, rows, runs, index, room, n):
    """Append the spans of a run; the number of spans. `room` is as in `pass_between`."""
    spans, (told, _), _ = room
    curve = samples_of(rows, runs[index])
    _, first, last = curve
    start = n
    n = open_span(spans, n, index, told[first, TOLD_BRANCH], rows[first, 0], told[first, TOLD_PSI])
    passed = Passed(told[first, TOLD_PSI], math.copysign(1.0, told[first, TOLD_RATE]))
    for i in range(first + 1, last):
        if goes_on(P, curve, i, told, passed.rise):
            change = short_way(told[i, TOLD_PSI] - passed.psi)
            passed = Passed(passed.psi + change, change)
        else:
            passed, n = pass_between(P, by, curve, i, passed, room, n)
        extend(spans[n - 1], rows[i, 0], passed.psi)
    return without_short(spans, start, n)


@kernel
def find_spans(P, by, rows, runs, spans):
    """Cut all runs into spans; return their number."""
    told, met = np.empty((rows.shape[0], TOLD)), np.empty((MOST_MET, MET))
    count, n_met = runs.shape[0], 0
    if count > 0:
        # Runs lie one behind the other.
        tell_samples(P, by, Samples(rows, int(runs[0, 3]), int(runs[count - 1, 4])), told)
        n_met = meet_changes(P, by, rows, runs, told, met)
    room = spans, (told, met[:n_met]), np.empty((MOST_CHANGES, CHANGE))
    n = 0
    for index in range(count):
        n = spans_of_run(P, by, rows, runs, index, room, n)
    return n
