"""Ends of intervals that are looked for on the true chain of a near limb, eight at a time."""

from __future__ import annotations

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import store7
from srs_ik.kernels.algebra.lanes import ALL, as_bits, gather, one_of, scatter, where
from srs_ik.kernels.algebra.pointers import copy, keep, read7, row
from srs_ik.kernels.chain.eight import sines_of_eight, take_eight
from srs_ik.kernels.chain.limit_ends import to_limits
from srs_ik.kernels.chain.newton import STEPS
from srs_ik.kernels.curves.ends import beyond_any_of_eight, beyond_limits
from srs_ik.kernels.exact.events import TURN
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.limb.goal import NO_SEED, turned
from srs_ik.kernels.near.scan import (
    POINT_NEXT,
    POINT_OFF,
    POINT_PSI,
    STRETCH_BRANCH,
    STRETCH_FIRST,
    STRETCH_LAST,
    STRETCH_LOWER,
    STRETCH_SCANNED,
    STRETCH_STATES,
    STRETCH_UPPER,
    certain_eight,
    in_branches,
    inside_between,
)

MARGINS = 1e-9
SPARE = 0.5
JOINT_OUTSIDE = 1e-6
"""Ends may be this far, rad, outside the arm angles between which they are expected, and by this part of what is
between these: the band is not for every joint at every posture. No joint is farther outside its limits there than the
last, rad."""

END = 12
END_PSI = 7
END_WAY = 8
END_FIRST = 9
END_LAST = 10
END_BRANCH = 11
"""An end that is looked for: joint angles to start from, their arm angle, direction to go, arm angles between which the
end lies, and branch."""

UNTOLD = 1e9
BY_CLOSED_FORM = (UNTOLD, UNTOLD, UNTOLD, UNTOLD, UNTOLD, UNTOLD, UNTOLD)
"""Joint angles of an end whose search begins at the closed form's posture: it is asked for eight at a time."""

MAX_ENDS = 256

CUT = 21
CUT_SLACKS = 5
CUT_PARTS = 19
CUT_STRETCHES = 20
"""A row of `arcs.without_arcs`, and behind it how far each joint is outside its limits, as a band counts it, at the
lower end and at the upper one; how many parts of it are feasible for certain, and how many stretches there are up to
it on which ends lie."""


OUTSIDE, INSIDE, ANY = range(3)
"""States at an arm angle: outside the limits, inside, or told by the posture there; then it is an end, if inside."""


@kernel
def put_slacks(P, view, cuts):
    """Tell how far the joints are outside their limits at both ends of some intervals, eight at a time."""
    n = cuts.shape[0]
    rows = np.empty((8, 9))
    for i in range(0, 2 * n, 8):
        for k in range(8):
            m = min(i + k, 2 * n - 1)
            rows[k, 7], rows[k, 8] = cuts[m // 2, 1 + m % 2], cuts[m // 2, 0]
        eight = row(rows, 0)
        q = certain_eight(P, view, eight, 9, (7, 8))
        s2, _, s6 = sines_of_eight(P, q)
        for j in range(7):
            off = beyond_limits(P, j, q[j])
            scatter(eight, j, 9, off if j % 2 == 1 else off * abs(s2 if j < 3 else s6))
        for k in range(min(8, 2 * n - i)):
            m = i + k
            for j in range(7):
                cuts[m // 2, CUT_SLACKS + 7 * (m % 2) + j] = rows[k, j]
    keep(rows)


@kernel
def put_end(ends, n, q, branch, at):
    """Append an end to be looked for; return how many there are.

    `at` holds the arm angle of the posture to start from, the way to go, and between which arm angles the end lies.
    """
    if n >= MAX_ENDS:
        return n
    store7(row(ends, n), 0, q)
    ends[n, END_PSI], ends[n, END_WAY], ends[n, END_FIRST], ends[n, END_LAST] = at
    ends[n, END_BRANCH] = branch
    return n + 1


@kernel
def put_fixed_at(point, psi, branch, ends, n):
    """Append an end at an arm angle that is inside the limits, that of a point or one next to it."""
    return put_end(ends, n, read7(point), branch, (psi, 0.0, psi, psi))


@kernel
def put_scanned(P, view, stretch, ends, n):
    """Append the ends on a stretch that is scanned; their number, -1 where what is expected at its own is not there."""
    points, branch = view.points, stretch[STRETCH_BRANCH]
    first, last = int(stretch[STRETCH_FIRST]), int(stretch[STRETCH_LAST])
    at_first, at_last = stretch[STRETCH_STATES], stretch[STRETCH_STATES + 1]
    starts_inside, ends_inside = points[first, POINT_OFF] <= 0.0, points[last, POINT_OFF] <= 0.0
    if at_first != ANY and starts_inside != (at_first == INSIDE):
        return -1
    if at_last != ANY and ends_inside != (at_last == INSIDE):
        return -1
    if at_first == ANY and starts_inside:
        n = put_fixed_at(points[first], points[first, POINT_PSI], branch, ends, n)
    a = first
    while a != last:
        b = int(points[a, POINT_NEXT])
        inside = points[b, POINT_OFF] <= 0.0
        if inside != (points[a, POINT_OFF] <= 0.0):
            k = b if inside else a
            at = (points[k, POINT_PSI], -1.0 if inside else 1.0, points[a, POINT_PSI], points[b, POINT_PSI])
            # In another turn a joint would be on no limit on its way.
            n = put_end(ends, n, turned(P, read7(points[k]), False, NO_SEED, True), branch, at)
        elif not inside:
            lower, upper = inside_between(P, view.target, points[a], points[b])
            if lower <= upper:
                n = put_fixed_at(points[a], lower, branch, ends, n)
                n = put_fixed_at(points[a], upper, branch, ends, n)
        a = b
    if at_last == ANY and ends_inside:
        n = put_fixed_at(points[last], points[last, POINT_PSI], branch, ends, n)
    return n


@kernel
def put_ends(P, view, stretch, ends, n):
    """Append the ends on a stretch; their number, -1 where it cannot be told."""
    if stretch[STRETCH_SCANNED] == 1.0:
        return put_scanned(P, view, stretch, ends, n)
    lower, upper = stretch[STRETCH_LOWER], stretch[STRETCH_UPPER]
    way = stretch[STRETCH_STATES] - stretch[STRETCH_STATES + 1]
    return put_end(ends, n, BY_CLOSED_FORM, stretch[STRETCH_BRANCH], (upper if way < 0.0 else lower, way, lower, upper))


@kernel
def turn_ends(ends, first, n):
    """Put the first of the ends of a circle, an upper one, behind the others, a turn later."""
    copy(row(ends, first), row(ends, n), END)
    for i in range(first, n):
        copy(row(ends, i + 1), row(ends, i), END)
    ends[n - 1, END_PSI] += TURN
    ends[n - 1, END_FIRST] += TURN
    ends[n - 1, END_LAST] += TURN


@kernel
def starts_of(P, view, rows):
    """The postures from which eight ends are looked for: the closed form's, where they are not told."""
    told = take_eight(rows, END)
    is_told = told[0] < UNTOLD
    if as_bits(is_told) == ALL:
        return told
    q = certain_eight(P, view, rows, END, (END_PSI, END_BRANCH))
    return (
        where(is_told, told[0], q[0]),
        where(is_told, told[1], q[1]),
        where(is_told, told[2], q[2]),
        where(is_told, told[3], q[3]),
        where(is_told, told[4], q[4]),
        where(is_told, told[5], q[5]),
        where(is_told, told[6], q[6]),
    )


@kernel
def correct_ends(P, view, ends, n):
    """Bring the arm angles of n ends to their limits on the true chain; whether all are where they are expected."""
    for i in range(n, 8 * ((n + 7) // 8)):
        for j in range(END):
            ends[i, j] = ends[n - 1, j]
    for first in range(0, n, 8):
        rows = row(ends, first)
        way = gather(rows, END_WAY, END)
        q, psi, met = to_limits(P, starts_of(P, view, rows), gather(rows, END_PSI, END), way, view.target, STEPS)
        met &= in_branches(sines_of_eight(P, q), gather(rows, END_BRANCH, END))
        # Next to a singularity another joint, on its way back inside, may still be outside there.
        met &= as_bits(beyond_any_of_eight(P, q) < JOINT_OUTSIDE)
        first_psi, last_psi = gather(rows, END_FIRST, END), gather(rows, END_LAST, END)
        more = SPARE * (last_psi - first_psi) + MARGINS
        met &= as_bits((psi > first_psi - more) & (psi < last_psi + more))
        if met != ALL:
            return False
        for i in range(8):
            ends[first + i, END_PSI] = one_of(psi, i)
    return True
