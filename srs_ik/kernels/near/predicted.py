"""Feasible arm angles of a near limb, predicted by the closed form of its nearest exact limb and corrected.

The directions that shoulder and wrist have to make differ from those of the nearest exact limb by a small multiple of
what the axes miss, a band. Limits drawn in by the band leave arm angles that are feasible for certain, limits drawn out
all that can be. Ends lie in what is between: there Newton's method finds them on the true chain. Next to a singularity
the band says nothing, and the curves of the true chain have to be followed.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import difference
from srs_ik.kernels.algebra.lane_trig import turn
from srs_ik.kernels.algebra.lanes import as_bits, gather, one_of, scatter, whole_number
from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.algebra.vectors import dot, load3
from srs_ik.kernels.chain.eight import put_eight, take_eight
from srs_ik.kernels.chain.kinematics import forward_kinematics
from srs_ik.kernels.chain.limit_ends import to_limits
from srs_ik.kernels.chain.newton import STEPS, arm_angle
from srs_ik.kernels.chain.newton_eight import ALL, close_in_planes, half_planes
from srs_ik.kernels.exact.intervals import PI, TURN, find_intervals, join_touching, write_interval
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import MAX_PIECES
from srs_ik.kernels.layout.limb import (
    A1,
    A1_A2,
    A2_A3,
    BAND,
    BOTTOM_GAP,
    LOWER,
    PHASE,
    SHIFT,
    SHOULDER,
    SIZE,
    STRAIGHT,
    TOP_GAP,
    UPPER,
    WRIST,
)
from srs_ik.kernels.limb.branches import branch_of, side_posture
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.limits import beyond, set_joint_limits, set_limit, turn_to_middle
from srs_ik.kernels.limb.poses import read7
from srs_ik.kernels.limb.triangle import elbow_side, place

WIDEST_BAND = 0.2
"""Wider bands tell too little."""

WELL_BENT = 0.5
"""Sine of a middle angle from which on shifts are measured."""

LEAST_BEND = 1.6
"""The elbow is bent by at least so many bands, or it may be straight on the true chain."""

MARGINS = 1e-9
SPARE = 0.5
"""Ends may be this far, rad, outside the arm angles between which they are expected, and by this part of what is
between these: the band is not for every joint at every posture."""

OBLIQUE = 1e-2
"""Cosine between neighbouring axes of a shoulder or wrist from which on a joint's limit is no circle about its axis."""

ALMOST_NOTHING = 1e-4
"""With a narrower band, rad, as many intervals are expected as the nearest exact limb has ..."""

BARELY = 1e-3
"""... and no end farther from its own, rad."""

END = 12
END_PSI = 7
END_WAY = 8
END_FIRST = 9
END_LAST = 10
END_BRANCH = 11
"""An end that is looked for: joint angles to start from, their arm angle, direction to go, arm angles between which the
end lies, and branch."""

MAX_ENDS = 256

POINT = 17
POINT_PSI = 7
POINT_RATES = 8
POINT_OFF = 15
POINT_BRANCH = 16
"""A point: joint angles, arm angle, the rates of the joints with it, how far it is outside the limits, branch."""

MAX_POINTS = 512
"""Room for the points between two arm angles."""

LARGEST_GAP = 0.3
SMALLEST_GAP = 1e-9
"""Between points farther apart than the first, rad, there may be anything; closer than the second, nothing."""

CLOSER = 0.7
"""Gaps are narrower than this part of how far shoulder and wrist are from singular, rad: there joints turn fast."""

LONGEST_CROSSING = 0.2
"""Where a limit is between two points, no joint moves farther than this, rad."""

FASTER = 1.5
"""Between two points no joint moves faster than at the faster one, but for this factor."""


@kernel
def sines_of_middles(P, q):
    """How far shoulder and wrist are from singular."""
    return abs(math.sin(q[1] - P[SHOULDER + PHASE])), abs(math.sin(q[5] - P[WRIST + PHASE]))


@kernel
def certain_posture(P, side, branch, psi):
    """The posture of the nearest exact limb at an arm angle."""
    q, _, _ = side_posture(P, side, psi, (branch >> 1) & 1, branch & 1, False, NO_SEED, True)
    return q


@kernel
def shift(P, q):
    """How far the joint directions of a configuration are from those of the closed form at its pose and arm angle.

    Times the sine of the elbow's bend: with that it grows. Zero next to singularities, where it has no bound.
    """
    x, y, z, p = forward_kinematics(P, q)
    place_ = place(P, (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]), p)
    branch = branch_of(P, q)
    s2, s6 = sines_of_middles(P, q)
    if min(s2, s6, place_[3]) < WELL_BENT or abs(math.sin(q[3] - P[STRAIGHT])) < WELL_BENT:
        return 0.0
    psi = arm_angle(P, q, place_[0], place_[1])
    d = difference(q, certain_posture(P, elbow_side(P, place_, branch >> 2), branch, psi))
    outer = max(s2 * max(abs(d[0]), abs(d[2])), s6 * max(abs(d[4]), abs(d[6])))
    return place_[3] * max(outer, abs(d[1]), abs(d[3]), abs(d[5]))


@kernel
def band_of(P, place_):
    """The band of a pose, rad."""
    return P[SHIFT] / place_[3] if place_[3] > 0.0 else math.inf


@kernel
def may_predict(P, place_, band):
    """Whether a band tells enough: not with the elbow almost straight or folded, nor of oblique axes."""
    s, w = SHOULDER, WRIST
    oblique = max(abs(P[s + A1_A2]), abs(P[s + A2_A3]), abs(P[w + A1_A2]), abs(P[w + A2_A3])) > OBLIQUE
    narrow = band < ALMOST_NOTHING
    return band < WIDEST_BAND and place_[3] > LEAST_BEND * band and place_[5] == 0.0 and (narrow or not oblique)


@kernel
def widen(P, band, box):
    """Copy a packed limb to `box`, its limits drawn out by a band, or in by a negative one; whether it has any room."""
    for i in range(SIZE):
        box[i] = P[i]
    box[BAND] = band
    for j in range(1, 7, 2):
        lower, upper = P[LOWER + j] - band, P[UPPER + j] + band
        if lower > upper:
            return False
        set_limit(box, j, lower, upper)
    set_joint_limits(box, SHOULDER, 0)
    set_joint_limits(box, WRIST, 4)
    return True


@kernel
def is_inside_turn(psi, lower, upper):
    """Whether an arm angle, or one whole turns away, is between two."""
    return psi - TURN * math.floor((psi - lower) / TURN) <= upper


@kernel
def passes_singularity(P, k, circle, lower, upper, width):
    """Whether axes 1 and 3 of a spherical joint come closer to parallel than an angle, between two arm angles."""
    a1 = load3(P, k + A1)
    constant = dot(a1, circle[0])
    c = dot(a1, circle[1])
    s = dot(a1, circle[2])
    r = math.sqrt(c * c + s * s)
    top_gap, bottom_gap = P[k + TOP_GAP], P[k + BOTTOM_GAP]
    near = 0.25 * width * width * (2.0 - top_gap - bottom_gap)
    if constant + r < 1.0 - top_gap - near and constant - r > bottom_gap + near - 1.0:
        return False
    at_lower = constant + c * math.cos(lower) + s * math.sin(lower)
    at_upper = constant + c * math.cos(upper) + s * math.sin(upper)
    top = max(at_lower, at_upper)
    bottom = min(at_lower, at_upper)
    middle = math.atan2(s, c)
    if is_inside_turn(middle, lower, upper):
        top = constant + r
    if is_inside_turn(middle + PI, lower, upper):
        bottom = constant - r
    return top > 1.0 - top_gap - near or bottom < bottom_gap + near - 1.0


@kernel
def is_near_singularity(P, side, lower, upper, band):
    """Whether shoulder or wrist come so close to singular between two arm angles that the band tells nothing."""
    return passes_singularity(P, SHOULDER, side[1][0], lower, upper, band) or passes_singularity(
        P, WRIST, side[2][0], lower, upper, band
    )


@kernel
def put_end(q, branch, psi, way, first, last, ends, n):
    """Append an end to be looked for, from a posture at an arm angle on; return how many there are."""
    if n >= MAX_ENDS:
        return n
    for j in range(7):
        ends[n, j] = q[j]
    ends[n, END_PSI] = psi
    ends[n, END_WAY] = way
    ends[n, END_FIRST] = first
    ends[n, END_LAST] = last
    ends[n, END_BRANCH] = branch
    return n + 1


@kernel
def close_points(P, R, p, place_, points, n):
    """Close eight points from row n on at their arm angles, and tell their rates; whether all are met."""
    rows = row(points, n)
    planes = half_planes(place_[0], place_[1], turn(gather(rows, POINT_PSI, POINT)))
    q, rates, met = close_in_planes(P, take_eight(rows, POINT), R, p, planes, STEPS)
    put_eight(rows, POINT, ALL, q)
    for j in range(7):
        scatter(rows, POINT_RATES + j, POINT, rates[j])
    return met == ALL and in_branches(P, q, gather(rows, POINT_BRANCH, POINT)) == ALL


@kernel
def put_points(P, sides, R, p, place_, points, n):
    """Fill in postures and rates of the eight points from row n on, at their arm angles; whether all are met."""
    for i in range(n, n + 8):
        branch = int(points[i, POINT_BRANCH])
        q = certain_posture(P, sides[branch >> 2], branch, points[i, POINT_PSI])
        for j in range(7):
            points[i, j] = q[j]
    return close_points(P, R, p, place_, points, n)


@kernel
def outside_by(P, point):
    """By how much a point is outside the limits, rad."""
    worst = -PI
    for j in range(7):
        worst = max(worst, beyond(P, j, turn_to_middle(P, j, point[j])))
    return worst


@kernel
def least_sine(P, a, b):
    """How far shoulder and wrist are from singular at two points."""
    s2, s6 = sines_of_middles(P, a)
    t2, t6 = sines_of_middles(P, b)
    return min(s2, s6, t2, t6)


@kernel
def is_narrow(P, a, b):
    """Whether two points are so close together that no joint turns much faster between them."""
    return b[POINT_PSI] - a[POINT_PSI] < CLOSER * least_sine(P, a, b)


@kernel
def is_decided(P, a, b):
    """Whether all postures between two points are inside the limits, or all outside, or one limit is between them."""
    width = b[POINT_PSI] - a[POINT_PSI]
    if width > LARGEST_GAP:
        return False
    if width < SMALLEST_GAP:
        return True
    if not is_narrow(P, a, b):
        return False
    inside_a, inside_b = a[POINT_OFF] <= 0.0, b[POINT_OFF] <= 0.0
    fastest = 0.0
    least = -2.0 * PI
    most = -2.0 * PI
    for j in range(7):
        way = FASTER * max(abs(a[POINT_RATES + j]), abs(b[POINT_RATES + j])) * width
        both = beyond(P, j, turn_to_middle(P, j, a[j])) + beyond(P, j, turn_to_middle(P, j, b[j]))
        fastest = max(fastest, way)
        least = max(least, 0.5 * (both - way))
        most = max(most, 0.5 * (both + way))
    if inside_a != inside_b:
        return fastest < LONGEST_CROSSING
    return most <= 0.0 if inside_a else least > 0.0


@kernel
def scan(P, sides, branch, R, p, place_, lower, upper, points, gaps):
    """Look at the postures of a branch between two arm angles, closely enough to miss no limit; the number of points.

    Gaps between points are halved until each is decided. The points are sorted by their arm angles. Returns -1 where
    this cannot be done.
    """
    for i in range(8):
        points[i, POINT_PSI] = lower + (upper - lower) * i / 7.0
        points[i, POINT_BRANCH] = branch
        gaps[i, 0], gaps[i, 1] = i, i + 1
    left = 7
    n = 0
    while True:
        if not put_points(P, sides, R, p, place_, points, n):
            return -1
        for i in range(n, n + 8):
            points[i, POINT_OFF] = outside_by(P, points[i])
        n += 8
        kept = 0
        for i in range(left):
            if not is_decided(P, points[gaps[i, 0]], points[gaps[i, 1]]):
                gaps[kept, 0], gaps[kept, 1] = gaps[i, 0], gaps[i, 1]
                kept += 1
        if kept == 0:
            break
        if n + 8 > MAX_POINTS:
            return -1
        # Eight gaps at a time; the others wait.
        for i in range(8):
            a, b = gaps[i % kept, 0], gaps[i % kept, 1]
            points[n + i, POINT_PSI] = 0.5 * (points[a, POINT_PSI] + points[b, POINT_PSI])
            points[n + i, POINT_BRANCH] = branch
        left = kept
        for i in range(min(kept, 8)):
            gaps[left, 0], gaps[left, 1] = n + i, gaps[i, 1]
            gaps[i, 1] = n + i
            left += 1
    for i in range(1, n):
        k = i
        while k > 0 and points[k - 1, POINT_PSI] > points[k, POINT_PSI]:
            for c in range(POINT):
                points[k, c], points[k - 1, c] = points[k - 1, c], points[k, c]
            k -= 1
    return n


@kernel
def put_scanned(P, sides, branch, R, p, place_, lower, upper, from_inside, to_inside, ends, n, points, gaps):
    """Append the ends between two arm angles that are inside the limits, or not; their number, -1 where it fails."""
    count = scan(P, sides, branch, R, p, place_, lower, upper, points, gaps)
    if count < 0:
        return -1
    if (points[0, POINT_OFF] <= 0.0) != from_inside or (points[count - 1, POINT_OFF] <= 0.0) != to_inside:
        return -1
    for i in range(1, count):
        inside = points[i, POINT_OFF] <= 0.0
        if inside == (points[i - 1, POINT_OFF] <= 0.0):
            continue
        k = i if inside else i - 1
        way = -1.0 if inside else 1.0
        first, last = points[i - 1, POINT_PSI], points[i, POINT_PSI]
        n = put_end(read7(points[k]), branch, points[k, POINT_PSI], way, first, last, ends, n)
    return n


@kernel
def is_simple(P, q, width, band):
    """Whether one joint alone is on its way out where limits drawn out by a band end, over a width of arm angles.

    No direction turns faster than the arm, so a joint well inside at one end of the width stays inside by the band.
    """
    s2, s6 = sines_of_middles(P, q)
    leaving = 0
    for j in range(7):
        share = s2 if j in (0, 2) else (s6 if j in (4, 6) else 1.0)
        if share * beyond(P, j, turn_to_middle(P, j, q[j])) > -band - width:
            leaving += 1
    return leaving == 1 and width * width < band


@kernel
def put_edge(P, sides, branch, R, p, place_, inside, outside, band, ends, n, points, gaps):
    """Append the ends between arm angles that are feasible for certain and such as cannot be; their number."""
    side = sides[branch >> 2]
    way = 1.0 if outside > inside else -1.0
    first, last = min(inside, outside), max(inside, outside)
    if is_simple(P, certain_posture(P, side, branch, outside), last - first, band):
        return put_end(certain_posture(P, side, branch, inside), branch, inside, way, first, last, ends, n)
    return put_scanned(P, sides, branch, R, p, place_, first, last, way > 0.0, way < 0.0, ends, n, points, gaps)


@kernel
def in_branches(P, q, branches):
    """Which of eight postures, as bits, lie each in its branch."""
    _, s2 = turn(q[1] - P[SHOULDER + PHASE])
    _, s4 = turn(q[3] - P[STRAIGHT])
    _, s6 = turn(q[5] - P[WRIST + PHASE])
    elbow = whole_number((branches - 1.5) * 0.25)
    rest = branches - 4.0 * elbow
    shoulder = whole_number((rest - 0.5) * 0.5)
    wrist = rest - 2.0 * shoulder
    return as_bits(
        ((1.0 - 2.0 * elbow) * s4 > 0.0) & ((1.0 - 2.0 * shoulder) * s2 > 0.0) & ((1.0 - 2.0 * wrist) * s6 > 0.0)
    )


@kernel
def correct_ends(P, R, p, place_, ends, n):
    """Bring the arm angles of n ends to their limits on the true chain; whether all are where they are expected."""
    for i in range(n, 8 * ((n + 7) // 8)):
        for j in range(END):
            ends[i, j] = ends[n - 1, j]
    for first in range(0, n, 8):
        rows = row(ends, first)
        way = gather(rows, END_WAY, END)
        q, psi, met = to_limits(
            P, take_eight(rows, END), gather(rows, END_PSI, END), way, R, p, place_[0], place_[1], STEPS
        )
        met &= in_branches(P, q, gather(rows, END_BRANCH, END))
        first_psi, last_psi = gather(rows, END_FIRST, END), gather(rows, END_LAST, END)
        more = SPARE * (last_psi - first_psi) + MARGINS
        met &= as_bits((psi > first_psi - more) & (psi < last_psi + more))
        if met != ALL:
            return False
        for i in range(8):
            ends[first + i, END_PSI] = one_of(psi, i)
    return True


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
def put_ends(P, sides, branch, R, p, place_, lower, upper, parts, count, band, ends, n, points, gaps):
    """Append the ends of what is feasible between two arm angles, of which some parts are for certain; their number.

    Returns -1 where it cannot be told.
    """
    if count == 0:
        return put_scanned(P, sides, branch, R, p, place_, lower, upper, False, False, ends, n, points, gaps)
    whole = upper - lower >= TURN - MARGINS
    start = n
    if not whole:
        n = put_edge(P, sides, branch, R, p, place_, parts[0, 0], lower, band, ends, n, points, gaps)
    for i in range(count if whole else count - 1):
        if n < 0:
            return n
        a = parts[i, 1]
        b = parts[i + 1, 0] if i + 1 < count else parts[0, 0] + TURN
        n = put_scanned(P, sides, branch, R, p, place_, a, b, True, True, ends, n, points, gaps)
    if n < 0 or n >= MAX_ENDS:
        return -1
    if not whole:
        return put_edge(P, sides, branch, R, p, place_, parts[count - 1, 1], upper, band, ends, n, points, gaps)
    if n > start:
        # On a circle, the first of the ends is an upper one: it comes last, a turn later.
        for j in range(END):
            ends[n, j] = ends[start, j]
        for i in range(start, n):
            for j in range(END):
                ends[i, j] = ends[i + 1, j]
        ends[n - 1, END_PSI] += TURN
        ends[n - 1, END_FIRST] += TURN
        ends[n - 1, END_LAST] += TURN
    return n


@kernel
def write_whole(out, n, branch):
    """Append a whole circle."""
    out[n, 0] = branch
    out[n, 1] = -PI
    out[n, 2] = PI
    return n + 1


@kernel
def shifted_intervals(P, place_, sides, R, p, band, out):
    """`predicted_intervals` where the band is as good as nothing: the intervals of the nearest exact limb, shifted."""
    found = np.empty((8 * MAX_PIECES, 3))
    ends = np.empty((MAX_ENDS + 8, END))
    n_found = find_intervals(P, place_, -1, found)
    n_ends = 0
    n = 0
    for i in range(n_found):
        branch = int(found[i, 0])
        lower, upper = found[i, 1], found[i, 2]
        side = sides[branch >> 2]
        if is_near_singularity(P, side, lower, upper, band) or upper - lower < BARELY:
            return -1
        if upper - lower >= TURN - MARGINS:
            n = write_whole(out, n, branch)
            continue
        for k in range(2):
            psi = found[i, 1 + k]
            way = 2.0 * k - 1.0
            q = certain_posture(P, side, branch, psi)
            n_ends = put_end(q, branch, psi, way, psi - BARELY, psi + BARELY, ends, n_ends)
    if n_ends >= MAX_ENDS or not correct_ends(P, R, p, place_, ends, n_ends):
        return -1
    return write_ends(ends, n_ends, out, n)


@kernel
def predicted_intervals(P, place_, R, p, out):
    """Write (branch, lower, upper) of the feasible intervals into the rows of out; their number, or -1: not certain.

    Args:
        P: packed limb, without limits where they are not to count.
        place_: the pose, from `elbow.place`.
        R: rotation of the pose.
        p: position of the pose.
        out: (n, 3) output.
    """
    band = band_of(P, place_)
    if not may_predict(P, place_, band):
        return -1
    sides = (elbow_side(P, place_, 0), elbow_side(P, place_, 1))
    for elbow in range(2):
        if abs(beyond(P, 3, turn_to_middle(P, 3, sides[elbow][0]))) < band:
            return -1
    if band < ALMOST_NOTHING:
        n = shifted_intervals(P, place_, sides, R, p, band, out)
        if n >= 0:
            return n
    boxes = np.empty((1, SIZE))
    box = row(boxes, 0)
    certain = np.empty((8 * MAX_PIECES, 3))
    possible = np.empty((8 * MAX_PIECES, 3))
    n_certain = find_intervals(box, place_, -1, certain) if widen(P, -band, box) else 0
    widen(P, band, box)
    n_possible = find_intervals(box, place_, -1, possible)
    keep(boxes)
    ends = np.empty((MAX_ENDS + 8, END))
    points = np.empty((MAX_POINTS, POINT))
    gaps = np.empty((MAX_POINTS, 2), np.int64)
    parts = np.empty((MAX_PIECES, 2))
    n_ends = 0
    n = 0
    used = 0
    for i in range(n_possible):
        branch = int(possible[i, 0])
        lower, upper = possible[i, 1], possible[i, 2]
        side = sides[branch >> 2]
        if is_near_singularity(P, side, lower, upper, band):
            return -1
        count = parts_inside(certain, n_certain, branch, lower, upper, parts)
        used += count
        start = n_ends
        if count != 1 or parts[0, 1] - parts[0, 0] < TURN - MARGINS:
            n_ends = put_ends(
                P, sides, branch, R, p, place_, lower, upper, parts, count, band, ends, n_ends, points, gaps
            )
        if n_ends < 0 or n_ends >= MAX_ENDS:
            return -1
        if count > 0 and n_ends == start:
            n = write_whole(out, n, branch)
    if used != n_certain:
        return -1
    if not correct_ends(P, R, p, place_, ends, n_ends):
        return -1
    return write_ends(ends, n_ends, out, n)


@kernel
def write_ends(ends, n_ends, out, n):
    """Sort the intervals between pairs of ends into those that are whole circles, branch after branch; their number."""
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
