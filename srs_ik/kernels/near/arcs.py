"""Arcs of arm angles next to a singular shoulder or wrist, where the curves of the true chain are followed.

On such an arc the band says nothing about joints 1 and 3, or 5 and 7, and postures of one branch may go over into
another. Outside it, all is predicted. So the curves are followed from one end of the arc to the other alone: four of
them, one from each branch on a side of the elbow, and two arcs in step.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import dot7
from srs_ik.kernels.algebra.lane_trig import turns_of
from srs_ik.kernels.algebra.pointers import copy, read7, row
from srs_ik.kernels.algebra.vectors import dot, load3
from srs_ik.kernels.chain.eight import take_eight
from srs_ik.kernels.chain.newton_eight import curve_ways, reduced
from srs_ik.kernels.curves.follow import CURVE
from srs_ik.kernels.curves.in_step import SAMPLE, one_of_seven
from srs_ik.kernels.curves.marks import MARK, MARK_FIRST, MARK_LAST, MARK_NEXT, follow_marks, put_mark
from srs_ik.kernels.curves.runs import SPARE_ROWS, survey_curves
from srs_ik.kernels.exact.events import TURN
from srs_ik.kernels.exact.intervals import SAME
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.asked import Runs
from srs_ik.kernels.layout.limb import A1, BOTTOM_GAP, SHOULDER, TOP_GAP, WRIST
from srs_ik.kernels.near.band import WIDER, nearness
from srs_ik.kernels.near.scan import POINT, POINT_BRANCH, POINT_PSI, put_points

ARC = 4
ARC_ELBOW = 0
ARC_LOWER = 1
ARC_UPPER = 2
ARC_NEEDED = 3
"""An arc: side of the elbow, first and last arm angle, whether a feasible posture may be on it."""

MOST_ARCS = 8
"""Two of the shoulder and two of the wrist, on either side of the elbow."""

WIDEST = 5.0
"""An arc wider than this, rad, leaves nothing to predict."""

IN_STEP = 2
"""Arcs that are followed in step, four curves each."""

LONGEST_ON_ARCS = 0.45
"""Length of a step, rad, where curves are smooth between samples, and no best posture is looked for."""

ARC_ROWS = 2048
"""Room for the samples of arcs in step."""


@kernel
def put_arc(arcs, first, n, lower, upper):
    """Insert an arc, joined with those that it touches, among the rows first to n - 1; the number of rows."""
    i = first
    while i < n:
        shift = TURN * math.floor((arcs[i, ARC_LOWER] - lower) / TURN + 0.5)
        a, b = lower + shift, upper + shift
        if a <= arcs[i, ARC_UPPER] and arcs[i, ARC_LOWER] <= b:
            lower, upper = min(a, arcs[i, ARC_LOWER]), max(b, arcs[i, ARC_UPPER])
            n -= 1
            copy(row(arcs, n), row(arcs, i), ARC)
            i = first
        else:
            i += 1
    arcs[n, ARC_LOWER], arcs[n, ARC_UPPER] = lower, upper
    return n + 1


@kernel
def put_arcs_of(P, k, circle, band, arcs, first, n):
    """Append the arcs of a spherical joint; the number of rows, -1 where one is a whole circle."""
    a1 = load3(P, k + A1)
    constant = dot(a1, circle[0])
    c, s = dot(a1, circle[1]), dot(a1, circle[2])
    r = math.sqrt(c * c + s * s)
    near = 0.25 * band * band * (2.0 - P[k + TOP_GAP] - P[k + BOTTOM_GAP])
    middle = math.atan2(s, c)
    for end in range(2):
        # How far a1'R a3 may go, at the top and at the bottom.
        most = 1.0 - P[k + TOP_GAP] - constant if end == 0 else 1.0 - P[k + BOTTOM_GAP] + constant
        if r > most - near:
            if most - WIDER * WIDER * near < -r:
                return -1
            half = math.acos(min((most - WIDER * WIDER * near) / r, 1.0))
            centre = middle + end * 0.5 * TURN
            n = put_arc(arcs, first, n, centre - half, centre + half)
    return n


@kernel
def find_arcs(P, view, arcs):
    """Write the arcs of both sides of the elbow into rows of arcs; their number, -1 where they do not tell all.

    That is where one is a whole circle, or where an arc of the shoulder and one of the wrist touch: between the two the
    true chain may have closed curves that come to no end of an arc.
    """
    n = 0
    for elbow in range(2):
        first = n
        n = middle = put_arcs_of(P, SHOULDER, view.sides[elbow][1][0], nearness(SHOULDER, view.band), arcs, first, n)
        if n >= 0:
            n = put_arcs_of(P, WRIST, view.sides[elbow][2][0], nearness(WRIST, view.band), arcs, middle, n)
        if n < 0:
            return -1
        for i in range(first, middle):
            for k in range(middle, n):
                if touches(arcs, i, arcs, k):
                    return -1
        for i in range(first, n):
            arcs[i, ARC_ELBOW] = elbow
            arcs[i, ARC_NEEDED] = 0.0
            if arcs[i, ARC_UPPER] - arcs[i, ARC_LOWER] > WIDEST:
                return -1
    return n


@kernel
def put_ends_of_arcs(P, view, arcs, n, k):
    """Fill in eight points for each of the next arcs that are needed, from row k on, its first end's branches first.

    There are at most two of them. Returns the row to go on from, and how many there are (-1: a point is not met).
    """
    points = view.points
    count = 0
    while k < n and count < IN_STEP:
        if arcs[k, ARC_NEEDED] == 1.0:
            first = 8 * count
            for i in range(8):
                points[first + i, POINT_PSI] = arcs[k, ARC_LOWER] if i < 4 else arcs[k, ARC_UPPER]
                points[first + i, POINT_BRANCH] = 4.0 * arcs[k, ARC_ELBOW] + i % 4
            if not put_points(P, view, points, first):
                return k, -1
            count += 1
        k += 1
    return k, count


@kernel
def rates_of(point):
    """The rates of the joints with the arm angle at a point."""
    return (point[8], point[9], point[10], point[11], point[12], point[13], point[14])


@kernel
def put_marks_of_arcs(P, target, points, count, marks):
    """Marks at the ends of some arcs, those first from which the curves lead into one; how many these are."""
    starts, n = 0, 0
    for into in range(2):
        for first in range(0, 8 * count, 8):
            q = take_eight(row(points, first), POINT)
            t = curve_ways(reduced(P, turns_of(q), target.R, target.p))
            for i in range(8):
                way = one_of_seven(t, i)
                rises = dot7(way, rates_of(points[first + i])) > 0.0
                if (rises == (i < 4)) == (into == 0):
                    n = put_mark(marks, n, n, read7(points[first + i]), way)
        if into == 0:
            starts = n
    return starts


@kernel
def follow_arcs(P, by, longest, ends, runs):
    """Follow the curves between the ends of some arcs: samples, and the number of feasible runs, -1 if it fails.

    In steps no longer than given, rad. `ends` are the points of these arcs, and how many arcs they are.
    """
    points, count = ends
    marks = np.full((8 * IN_STEP, MARK), np.inf)
    pieces = np.empty((ARC_ROWS, SAMPLE))
    line = np.empty((ARC_ROWS, SAMPLE))
    rows = np.empty((ARC_ROWS + SPARE_ROWS, SAMPLE))
    curves = np.empty((4 * IN_STEP, CURVE))
    starts = put_marks_of_arcs(P, by.target, points, count, marks)
    if starts != 4 * count:
        return rows, -1
    follow_marks(P, by.target, longest, marks[: 8 * count], starts, pieces)
    for i in range(starts):
        if marks[i, MARK_NEXT] < 0.0:
            return rows, -1
        curves[i, 0], curves[i, 1], curves[i, 2] = marks[i, MARK_FIRST], marks[i, MARK_LAST], 0.0
    _, k = survey_curves(P, by, pieces, curves[:starts], line, Runs(rows, runs))
    return rows, k


@kernel
def mark_needed(arcs, n, possible, n_possible):
    """Mark the arcs that what may be feasible touches; whether there are any."""
    any_needed = False
    for k in range(n):
        for i in range(n_possible):
            if (int(possible[i, 0]) >> 2) == int(arcs[k, ARC_ELBOW]) and touches(possible, i, arcs, k):
                arcs[k, ARC_NEEDED] = 1.0
                any_needed = True
    return any_needed


@kernel
def mark_around(arcs, n, psi, branches):
    """Mark the arcs of branches (bits) that an arm angle lies on as needed; whether each side of the elbow has one."""
    elbows = (1 if branches & 0b1111 != 0 else 0) | (2 if branches >> 4 != 0 else 0)
    left = elbows
    for k in range(n):
        ahead = psi - arcs[k, ARC_LOWER]
        ahead -= TURN * math.floor(ahead / TURN)
        side = 1 << int(arcs[k, ARC_ELBOW])
        if side & elbows != 0 and ahead <= arcs[k, ARC_UPPER] - arcs[k, ARC_LOWER]:
            arcs[k, ARC_NEEDED] = 1.0
            left &= ~side
    return left == 0


@kernel
def touches(intervals, i, arcs, k):
    """Whether an interval and an arc have an arm angle in common."""
    ahead = intervals[i, 1] - arcs[k, ARC_LOWER]
    ahead -= TURN * math.floor(ahead / TURN)
    return ahead <= arcs[k, ARC_UPPER] - arcs[k, ARC_LOWER] or ahead + intervals[i, 2] - intervals[i, 1] >= TURN


@kernel
def without_arcs(intervals, n, arcs, n_arcs, out):
    """Cut the arcs that are needed out of intervals, into rows of out: branch, ends, the arcs that these are at or -1.

    Returns the number of rows.
    """
    count = 0
    for i in range(n):
        elbow = int(intervals[i, 0]) >> 2
        first = count
        count = put_cut(out, count, intervals[i, 0], intervals[i, 1], intervals[i, 2], -1.0, -1.0)
        for k in range(n_arcs):
            if arcs[k, ARC_NEEDED] == 1.0 and int(arcs[k, ARC_ELBOW]) == elbow:
                count = cut_arc(arcs, k, first, count, out)
    return count


@kernel
def put_cut(out, n, branch, lower, upper, from_arc, to_arc):
    """Append what is left of an interval; the number of rows."""
    if n >= out.shape[0]:
        return n
    out[n, 0], out[n, 1], out[n, 2], out[n, 3], out[n, 4] = branch, lower, upper, from_arc, to_arc
    return n + 1


@kernel
def cut_arc(arcs, k, first, n, out):
    """Cut an arc out of the rows first to n - 1; the number of rows."""
    left = n
    for i in range(first, n):
        branch, lower, upper, from_arc, to_arc = out[i, 0], out[i, 1], out[i, 2], out[i, 3], out[i, 4]
        whole = upper - lower >= TURN - SAME
        # The first end of the arc from the interval's own on.
        a = arcs[k, ARC_LOWER] - TURN * math.floor((arcs[k, ARC_LOWER] - lower) / TURN)
        b = a + arcs[k, ARC_UPPER] - arcs[k, ARC_LOWER]
        if whole and from_arc < 0.0:
            out[i, 1], out[i, 2], out[i, 3], out[i, 4] = b, a + TURN, k, k
            continue
        # It may begin behind, or reach over the interval's beginning.
        out[i, 1], out[i, 2] = 1.0, 0.0
        start, start_arc = lower, from_arc
        for turns in range(-1, 1):
            c, d = a + turns * TURN, b + turns * TURN
            if d < start or c > upper:
                continue
            if c > start:
                left = put_cut(out, left, branch, start, c, start_arc, k)
            start, start_arc = d, k * 1.0
        if start < upper or start_arc == from_arc:
            left = put_cut(out, left, branch, start, upper, start_arc, to_arc)
    return pack_rows(out, first, left)


@kernel
def pack_rows(out, first, n):
    """Drop rows whose ends are in the wrong order; the number of rows."""
    left = first
    for i in range(first, n):
        if out[i, 1] <= out[i, 2]:
            copy(row(out, i), row(out, left), 5)
            left += 1
    return left
