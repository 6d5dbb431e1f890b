"""Feasible arm angles of a near limb, on its true chain.

There the joint angles are no roots of linear forms any more. The curves of all postures are followed instead, cut where
a joint meets a limit or the branch changes, and what is left is told by its arm angles.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.chain.answer import measure_row, measure_row_at
from srs_ik.kernels.chain.newton import arm_angle
from srs_ik.kernels.curves.best import best_on
from srs_ik.kernels.curves.ends import on_curve
from srs_ik.kernels.curves.follow import CURVE, follow_through, tangent_at
from srs_ik.kernels.curves.in_step import SAMPLE
from srs_ik.kernels.curves.outreach import EVERY_PAIR, pairs_on_line
from srs_ik.kernels.curves.runs import CURVE_ROWS, SPARE_ROWS, certain_runs, near_runs, samples_of, survey_curves
from srs_ik.kernels.curves.spans import MAX_SPANS, SPAN, find_spans
from srs_ik.kernels.exact.events import TURN
from srs_ik.kernels.exact.farthest import copy_interval
from srs_ik.kernels.exact.intervals import join_touching, write_interval
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import OK, ROW_STATUS
from srs_ik.kernels.layout.asked import Best, Goal, Runs, Setting
from srs_ik.kernels.layout.limb import SIZE
from srs_ik.kernels.layout.search import MAX_RUNS, RUN
from srs_ik.kernels.limb.branches import NO_BRANCH, branch_of
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE
from srs_ik.kernels.limb.limits import tighten
from srs_ik.kernels.limb.triangle import elbow_side
from srs_ik.kernels.near.at_angle import solve_at_angle
from srs_ik.kernels.near.predicted import write_whole
from srs_ik.kernels.near.second_attempts import stretched

LOOKS = 2
"""So many parts of an interval are looked at the ends of, where nothing else tells a posture of it."""

IN_BLUR = 1e-5
WIDE = 1e-3
"""On no more of a curve than the first, in its parameter, a span of more than the second, rad, may be one of blur: next
to a straight elbow floats may meet two postures, and none between them."""

TRACE = 1e-6
"""Limits farther out by this, rad, tell postures that rounding may have hidden: at a singular limit it is the root."""


@kernel
def is_in_blur(P, by, curve, span):
    """Whether a span is two postures between which its curve has none."""
    if span[3] - span[2] > IN_BLUR or span[5] - span[4] < WIDE:
        return False
    _, off = on_curve(P, by, 0, curve, 0.5 * (span[2] + span[3]))
    return off >= NO_BRANCH


@kernel
def write_spans(P, by, rows, runs, spans, out):
    """Write the arm angles of the spans of runs as intervals, branch after branch and sorted; return their number."""
    n_spans, n = find_spans(P, by, rows, runs, spans), 0
    for branch in range(8):
        first = n
        for i in range(n_spans):
            span = spans[i]
            if int(span[1]) == branch:
                if is_in_blur(P, by, samples_of(rows, runs[int(span[0])]), span):
                    n = write_interval(out, first, n, branch, span[4], span[4])
                    n = write_interval(out, first, n, branch, span[5], span[5])
                else:
                    n = write_interval(out, first, n, branch, span[4], min(span[5], span[4] + TURN))
        if n > first:
            n = join_touching(out, first, n)
    return n


@kernel
def true_intervals(P, target, respect, out, J, A):
    """Write (branch, lower, upper) of a near limb's feasible intervals into the rows of out; return their number."""
    runs = np.empty((MAX_RUNS, RUN))
    by = Setting(target, elbow_side(P, target.place, 0), respect, J, A)
    rows, _, k, _ = near_runs(P, by, runs)
    return write_spans(P, by, rows, runs[:k], np.empty((MAX_SPANS, SPAN)), out)


@kernel
def has_none(P, target, J, A):
    """Whether no posture keeps the limits: no curve does, nor if they are a trace wider, and no other is there.

    For certain: how far an almost straight elbow reaches, all around, tells that these are all curves.
    """
    boxes = np.empty((1, SIZE))
    box = row(boxes, 0)
    tighten(P, NO_SEED, math.inf, TRACE, box)
    runs = np.empty((MAX_RUNS, RUN))
    by = Setting(target, elbow_side(P, target.place, 0), True, J, A)
    (_, _, k, _), certain = certain_runs(box, by, EVERY_PAIR, runs)
    keep(boxes)
    return k == 0 and certain == EVERY_PAIR


@kernel
def intervals_through(P, target, q, respect, out, J, A):
    """`true_intervals` of the one curve through a posture that no curve from the closed form led to; at least one."""
    rows, line = np.empty((CURVE_ROWS, SAMPLE)), np.empty((CURVE_ROWS, SAMPLE))
    sampled = np.empty((CURVE_ROWS + SPARE_ROWS, SAMPLE))
    runs, spans, curves = np.empty((MAX_RUNS, RUN)), np.empty((MAX_SPANS, SPAN)), np.empty((1, CURVE))
    by = Setting(target, elbow_side(P, target.place, 0), respect, J, A)
    n = 0
    t, sign = tangent_at(P, by, q)
    if sign != 0.0:
        length, closed = follow_through(P, by, q, t, rows, 0)
        if length > 1:
            curves[0, 0], curves[0, 1], curves[0, 2] = 0.0, length, 1.0 if closed else 0.0
            _, k = survey_curves(P, by, rows, curves, line, Runs(sampled, runs))
            n = write_spans(P, by, sampled, runs[:k], spans, out)
    if n == 0:
        psi = arm_angle(P, q, target.place[0], target.place[1])
        n = write_interval(out, 0, 0, branch_of(P, q), psi, psi)
    return n


@kernel
def with_on_line(P, target, respect, J, A, out, n):
    """Put whole circles for n intervals of branches that have a posture with its elbow on the line S-W; their number.

    It is on either side of the line.
    """
    found = np.empty((out.shape[0], 3))
    for i in range(n):
        copy_interval(out, i, found, i)
    goal = Goal(False, NO_SEED, respect)
    on_line = 0
    pairs = pairs_on_line(P, target)
    for signs in range(4):
        if (pairs >> signs) & 1 == 1 and stretched(P, target, 0.0, signs, goal, J, A)[2] < OUTSIDE:
            on_line |= 0b10001 << signs
    count = 0
    for branch in range(8):
        if (on_line >> branch) & 1 == 1:
            count = write_whole(out, count, branch)
        for i in range(n):
            if (on_line >> branch) & 1 == 0 and int(found[i, 0]) == branch:
                copy_interval(found, i, out, count)
                count += 1
    return count


@kernel
def best_of_true_intervals(P, target, respect, intervals, out, J, A):
    """Write the posture with the largest margin of each of some intervals (n, 3) of a pose into the rows of out."""
    runs = np.empty((MAX_RUNS, RUN))
    by = Setting(target, elbow_side(P, target.place, 0), respect, J, A)
    rows, _, k, _ = near_runs(P, by, runs)
    spans = np.empty((MAX_SPANS, SPAN))
    count = find_spans(P, by, rows, runs[:k], spans)
    goal = Goal(False, NO_SEED, respect)
    for i in range(intervals.shape[0]):
        branch, lower, upper = int(intervals[i, 0]), intervals[i, 1], intervals[i, 2]
        best = Best(NO_SEED, 4.0 * NO_BRANCH)
        for j in range(count):
            middle = 0.5 * (spans[j, 4] + spans[j, 5])
            ahead = middle - lower - TURN * math.floor((middle - lower) / TURN)
            if int(spans[j, 1]) == branch and ahead <= upper - lower:
                curve = samples_of(rows, runs[int(spans[j, 0])])
                best = best_on(P, by, curve, (spans[j, 2], spans[j, 3]), goal, best)
        measure_row(P, target, best.q, branch, best.cost, respect, row(out, i))
        for j in range(LOOKS + 1):
            if out[i, ROW_STATUS] != OK:
                # Its ends came by another way than along these curves.
                psi = lower + (upper - lower) * ((j + LOOKS // 2) % (LOOKS + 1)) / LOOKS
                found = solve_at_angle(P, target, psi, branch, goal, J, A)
                measure_row_at(P, target, psi, found, respect, row(out, i))
