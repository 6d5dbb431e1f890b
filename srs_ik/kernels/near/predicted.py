"""Feasible arm angles of a near limb, predicted by the closed form of its nearest exact limb and corrected.

The directions that shoulder and wrist have to make differ from those of the nearest exact limb by a small multiple of
what the axes miss, a band. Limits drawn in by the band leave arm angles that are feasible for certain, limits drawn out
all that can be. Ends lie in what is between: there Newton's method finds them on the true chain. Next to a singularity
the band says nothing, and the curves of the true chain have to be followed.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import short_way
from srs_ik.kernels.algebra.pointers import copy, keep, row
from srs_ik.kernels.chain.newton_eight import all_times
from srs_ik.kernels.curves.spans import MAX_SPANS, SPAN, find_spans
from srs_ik.kernels.exact.events import PI, TURN
from srs_ik.kernels.exact.intervals import SAME, intervals_of, join_touching, write_interval
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import MAX_PIECES
from srs_ik.kernels.layout.asked import Setting
from srs_ik.kernels.layout.limb import SIZE, SLACK_JOIN
from srs_ik.kernels.layout.search import MAX_RUNS, RUN
from srs_ik.kernels.limb.limits import beyond, turn_to_middle
from srs_ik.kernels.limb.surface import has_surface
from srs_ik.kernels.limb.triangle import elbow_side
from srs_ik.kernels.near.arcs import (
    ARC,
    LONGEST_ON_ARCS,
    MOST_ARCS,
    find_arcs,
    follow_arcs,
    mark_needed,
    put_ends_of_arcs,
    without_arcs,
)
from srs_ik.kernels.near.band import (
    ALMOST_NOTHING,
    band_of,
    may_meet_limits,
    may_predict_limits,
    may_tell_none,
    may_turn_at_limit,
    widen,
    widest,
)
from srs_ik.kernels.near.ends import (
    ANY,
    BY_CLOSED_FORM,
    CUT,
    CUT_PARTS,
    CUT_SLACKS,
    CUT_STRETCHES,
    END,
    END_BRANCH,
    END_PSI,
    INSIDE,
    MARGINS,
    MAX_ENDS,
    OUTSIDE,
    correct_ends,
    put_end,
    put_ends,
    put_slacks,
    turn_ends,
)
from srs_ik.kernels.near.scan import (
    POINT_BRANCH,
    POINT_PSI,
    STRETCH,
    STRETCH_BRANCH,
    STRETCH_LOWER,
    STRETCH_SCANNED,
    STRETCH_STATES,
    STRETCH_UPPER,
    scan,
    view_of,
)

AT_END = 1e-10
END_SHARE = 1e-3
"""What is followed on an arc begins and ends with it, up to this, rad, of a narrow one to this part of its width."""

BARELY = 1e-3
"""With an almost vanishing band, no end is expected farther from that of the nearest exact limb, rad."""

SAFE = 2.0
"""Limits drawn out by so many bands leave out nothing: bands are measured at many configurations, not at all."""


@kernel
def is_surely_out(P, target):
    """Whether no posture keeps the limits, as the band tells: none does when they are drawn out by more than it."""
    place_ = target.place
    band = all_times(SAFE, band_of(P, place_))
    if not may_tell_none(P, place_, band):
        return False
    boxes = np.empty((1, SIZE))
    possible = np.empty((8 * MAX_PIECES, 3))
    widen(P, band, 1.0, row(boxes, 0))
    n = intervals_of(row(boxes, 0), (elbow_side(P, place_, 0), elbow_side(P, place_, 1)), -1, possible)
    keep(boxes)
    return n == 0


@kernel
def put_stretch(stretches, n, branch, ends, states, scanned):
    """Append a stretch between two arm angles, inside the limits there or outside; the number of stretches."""
    if n >= stretches.shape[0]:
        return n
    stretches[n, STRETCH_BRANCH], stretches[n, STRETCH_SCANNED] = branch, 1.0 if scanned else 0.0
    stretches[n, STRETCH_LOWER], stretches[n, STRETCH_UPPER] = ends
    stretches[n, STRETCH_STATES], stretches[n, STRETCH_STATES + 1] = states
    return n + 1


@kernel
def is_simple(cut, first, width, band):
    """Whether one joint alone is on its way out where limits drawn out by a band end, over a width of arm angles.

    No direction turns faster than the arm, so a joint well inside at one end of the width stays inside by the band.
    `cut` tells from a column on how far the joints are outside at that end.
    """
    leaving = 0
    for j in range(7):
        if cut[first + j] > -band[j] - width:
            leaving += 1 if width * width < band[j] else 2
    return leaving == 1


@kernel
def parts_inside(certain, n, branch, lower, upper, parts):
    """The intervals of a branch that lie between two arm angles, in their order, as rows of parts; their number."""
    count = 0
    for i in range(n):
        if int(certain[i, 0]) != branch:
            continue
        shift = TURN * math.floor((certain[i, 1] - lower + MARGINS) / TURN)
        a, b = certain[i, 1] - shift, certain[i, 2] - shift
        if b > upper + MARGINS and upper - lower < TURN - MARGINS:
            continue
        j = count
        while j > 0 and parts[j - 1, 0] > a:
            parts[j, 0], parts[j, 1] = parts[j - 1, 0], parts[j - 1, 1]
            j -= 1
        parts[j, 0], parts[j, 1] = a, b
        count += 1
    return count


@kernel
def put_outer(view, cut, end, inside, stretches, n):
    """Append the stretch between what is feasible for certain and an outer end (0, 1) of an interval.

    `cut` is a row of `without_arcs`: that end is one of an arc, or of what may be feasible.
    """
    first, last = min(inside, cut[1 + end]), max(inside, cut[1 + end])
    on_arc = cut[3 + end] >= 0.0
    if on_arc and last - first < MARGINS:
        return put_stretch(stretches, n, cut[0], (inside, inside), (INSIDE, INSIDE), False)
    scanned = on_arc or not is_simple(cut, CUT_SLACKS + 7 * end, last - first, view.band)
    state = ANY if on_arc else OUTSIDE
    return put_stretch(stretches, n, cut[0], (first, last), (INSIDE, state) if end == 1 else (state, INSIDE), scanned)


@kernel
def is_circle(cut):
    """Whether an interval, a row of `without_arcs`, is a whole circle."""
    return cut[2] - cut[1] >= TURN - MARGINS and cut[3] < 0.0


@kernel
def put_stretches(view, cut, parts, stretches, n):
    """Append the stretches on which the ends of what is feasible in an interval lie; their number.

    `cut` is a row of `without_arcs`; some parts of it are feasible for certain.
    """
    count, whole = parts.shape[0], is_circle(cut)
    if count == 0:
        states = (ANY if whole or cut[3] >= 0.0 else OUTSIDE, ANY if whole or cut[4] >= 0.0 else OUTSIDE)
        return put_stretch(stretches, n, cut[0], (cut[1], cut[2]), states, True)
    if not whole:
        n = put_outer(view, cut, 0, parts[0, 0], stretches, n)
    for i in range(count if whole else count - 1):
        b = parts[i + 1, 0] if i + 1 < count else parts[0, 0] + TURN
        n = put_stretch(stretches, n, cut[0], (parts[i, 1], b), (INSIDE, INSIDE), True)
    return n if whole else put_outer(view, cut, 1, parts[count - 1, 1], stretches, n)


@kernel
def write_whole(out, n, branch):
    """Append a whole circle."""
    out[n, 0] = branch
    out[n, 1] = -PI
    out[n, 2] = PI
    return n + 1


@kernel
def ends_of_intervals(P, view, possible, certain, ends, out):
    """Write the ends of what is feasible, and as intervals the whole circles; how many ends (-1: not told) and circles.

    Both what may be feasible and what is so for certain are rows of `without_arcs`.
    """
    stretches, parts = np.empty((MAX_ENDS, STRETCH)), np.empty((MAX_PIECES, 2))
    count, used = 0, 0
    for i in range(possible.shape[0]):
        cut = row(possible, i)
        n_parts = parts_inside(certain, certain.shape[0], int(cut[0]), cut[1], cut[2], parts)
        used += n_parts
        if n_parts != 1 or parts[0, 1] - parts[0, 0] < TURN - MARGINS:
            count = put_stretches(view, cut, parts[:n_parts], stretches, count)
        cut[CUT_PARTS], cut[CUT_STRETCHES] = n_parts, count
    if used != certain.shape[0] or count >= MAX_ENDS or not scan(P, view, stretches[:count]):
        return -1, 0
    k, n_ends, n = 0, 0, 0
    for i in range(possible.shape[0]):
        start = n_ends
        while k < possible[i, CUT_STRETCHES]:
            n_ends = put_ends(P, view, row(stretches, k), ends, n_ends)
            if n_ends < 0 or n_ends >= MAX_ENDS:
                return -1, 0
            k += 1
        if possible[i, CUT_PARTS] > 0.0 and n_ends == start:
            n = write_whole(out, n, possible[i, 0])
        elif possible[i, CUT_PARTS] > 0.0 and is_circle(possible[i]):
            turn_ends(ends, start, n_ends)
    return n_ends, n


@kernel
def is_elbow_unsure(P, view):
    """Whether the elbow at a pose is so close to a limit that the band may put it on the other side of it."""
    unsure = False
    for elbow in range(2):
        unsure = unsure or abs(beyond(P, 3, turn_to_middle(P, 3, view.sides[elbow][0]))) < view.band[3] + MARGINS
    return unsure


@kernel
def shifted_intervals(P, view, out):
    """`predicted_intervals` where the band is as good as nothing: the intervals of the nearest exact limb, shifted.

    Their number, or -1 where limits may leave more of them, or fewer, on the true chain.
    """
    if is_elbow_unsure(P, view) or may_turn_at_limit(P, view):
        return -1
    found = np.empty((8 * MAX_PIECES, 3))
    ends = np.empty((MAX_ENDS + 8, END))
    boxes = np.empty((1, SIZE))
    box = row(boxes, 0)
    copy(P, box, SIZE)
    # Joints that come to their limits so closely one behind the other may leave an arm angle between them, or none.
    box[SLACK_JOIN] = BARELY
    n_found = intervals_of(box, view.sides, -1, found)
    keep(boxes)
    arcs = np.empty((MOST_ARCS, ARC))
    n_arcs = find_arcs(P, view, arcs)
    if n_arcs < 0 or mark_needed(arcs, n_arcs, found, n_found):
        return -1
    n_ends = 0
    n = 0
    for i in range(n_found):
        branch = int(found[i, 0])
        lower, upper = found[i, 1], found[i, 2]
        if upper - lower < BARELY:
            if may_meet_limits(P, view, branch, lower) or may_meet_limits(P, view, branch, upper):
                return -1
            continue
        if upper - lower >= TURN - MARGINS:
            n = write_whole(out, n, branch)
            continue
        for k in range(2):
            psi = found[i, 1 + k]
            way = 2.0 * k - 1.0
            n_ends = put_end(ends, n_ends, BY_CLOSED_FORM, branch, (psi, way, psi - BARELY, psi + BARELY))
    if n_ends >= MAX_ENDS or not correct_ends(P, view, ends, n_ends):
        return -1
    return write_ends(ends, n_ends, out, n)


@kernel
def put_arc_ends(P, view, count, ends, n, by):
    """Append both ends of every span of feasible postures on some arcs, followed; the number of ends, -1 if it fails.

    Their own ends are in the first eight points for each.
    """
    runs = np.empty((MAX_RUNS, RUN))
    spans = np.empty((MAX_SPANS, SPAN))
    rows, k = follow_arcs(P, by, LONGEST_ON_ARCS, (view.points, count), runs)
    if k < 0:
        return -1
    n_spans = find_spans(P, by, rows, runs[:k], spans)
    if n + 2 * n_spans > MAX_ENDS:
        return -1
    for i in range(n_spans):
        for end in range(2):
            psi = spans[i, 4 + end]
            for at in range(2 * count):
                point = view.points[4 * at]
                if int(point[POINT_BRANCH]) >> 2 != int(spans[i, 1]) >> 2:
                    continue
                off = short_way(psi - point[POINT_PSI])
                width = view.points[8 * (at // 2) + 4, POINT_PSI] - view.points[8 * (at // 2), POINT_PSI]
                # The arc ends here: exactly there, so that intervals on either side join.
                psi = psi - off if abs(off) < min(AT_END, END_SHARE * width) else psi
            ends[n, END_PSI], ends[n, END_BRANCH] = psi, spans[i, 1]
            n += 1
    return n


@kernel
def predicted_intervals(P, target, out, J, A):
    """Write (branch, lower, upper) of the feasible intervals into the rows of out; their number, or -1: not certain.

    Args:
        P: packed limb, without limits where they are not to count.
        target: the pose.
        out: (n, 3) output.
        J: (6, 7) work space.
        A: (16, 9) work space.
    """
    view = view_of(P, target)
    band, place_ = view.band, target.place
    if not may_predict_limits(P, place_, band) or has_surface(P, place_):
        return -1
    if widest(band) < ALMOST_NOTHING:
        n = shifted_intervals(P, view, out)
        if n >= 0:
            return n
    boxes = np.empty((1, SIZE))
    box = row(boxes, 0)
    certain = np.empty((8 * MAX_PIECES, 3))
    possible = np.empty((8 * MAX_PIECES, 3))
    n_certain = intervals_of(box, view.sides, -1, certain) if widen(P, band, -1.0, box) else 0
    widen(P, band, 1.0, box)
    n_possible = intervals_of(box, view.sides, -1, possible)
    keep(boxes)
    arcs = np.empty((MOST_ARCS, ARC))
    n_arcs = find_arcs(P, view, arcs)
    if n_arcs < 0:
        return -1
    needed = mark_needed(arcs, n_arcs, possible, n_possible)
    cuts = np.empty((16 * MAX_PIECES, CUT))
    certain_cuts = np.empty((16 * MAX_PIECES, 5))
    n_possible = without_arcs(possible, n_possible, arcs, n_arcs, cuts)
    n_certain = without_arcs(certain, n_certain, arcs, n_arcs, certain_cuts)
    put_slacks(P, view, cuts[:n_possible])
    ends = np.empty((MAX_ENDS + 8, END))
    n_ends, n = ends_of_intervals(P, view, cuts[:n_possible], certain_cuts[:n_certain], ends, out)
    if n_ends < 0:
        return -1
    if not correct_ends(P, view, ends, n_ends):
        return -1
    by = Setting(target, view.sides[0], True, J, A)
    k = 0
    while needed and k < n_arcs:
        k, count = put_ends_of_arcs(P, view, arcs, n_arcs, k)
        if count > 0:
            n_ends = put_arc_ends(P, view, count, ends, n_ends, by)
        if count < 0 or n_ends < 0:
            return -1
    return write_ends(ends, n_ends, out, n)


@kernel
def write_ends(ends, n_ends, out, n):
    """Sort the intervals between pairs of ends into those that are whole circles, branch after branch; their number.

    -1 where one ends before it begins: then its ends belong to others.
    """
    for i in range(0, n_ends, 2):
        if ends[i, END_PSI] > ends[i + 1, END_PSI] + SAME:
            return -1
    whole = 0
    for i in range(n):
        whole |= 1 << int(out[i, 0])
    n = 0
    for branch in range(8):
        first = n
        if (whole >> branch) & 1 == 1:
            n = write_whole(out, n, branch)
        for i in range(0, n_ends, 2):
            if int(ends[i, END_BRANCH]) == branch:
                n = write_interval(out, first, n, branch, ends[i, END_PSI], max(ends[i, END_PSI], ends[i + 1, END_PSI]))
        if n > first:
            n = join_touching(out, first, n)
    return n
