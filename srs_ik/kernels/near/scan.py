"""Stretches of arm angles looked at closely on the true chain: points eight at a time, until no limit can be missed."""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import short_way
from srs_ik.kernels.algebra.lane_trig import turn
from srs_ik.kernels.algebra.lanes import ALL, as_bits, gather, larger, scatter, where, whole_number
from srs_ik.kernels.algebra.pointers import keep, read7, row
from srs_ik.kernels.chain.eight import put_eight, sines_of_eight, take_eight
from srs_ik.kernels.chain.newton import STEPS, close_at_angle
from srs_ik.kernels.chain.newton_eight import NOTHING, PROBED, close_in_planes, half_planes
from srs_ik.kernels.curves.ends import beyond_limits
from srs_ik.kernels.exact.events import PI, TURN
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.asked import View
from srs_ik.kernels.layout.limb import INVERSE_HALF_RANGE, LOWER, MIDDLE, RANGE_KIND, SLACK_LIMIT, UPPER
from srs_ik.kernels.limb.limits import PER_TURN, turn_to_middle
from srs_ik.kernels.limb.postures_eight import eight_postures
from srs_ik.kernels.limb.triangle import elbow_side
from srs_ik.kernels.near.band import ALMOST_NOTHING, band_with, least_bend, widest

POINT = 33
POINT_PSI = 7
POINT_RATES = 8
POINT_OFF = 15
POINT_BRANCH = 16
POINT_BEYOND = 17
POINT_COSTS = 17
POINT_SLOPES = 24
POINT_NEXT = 31
POINT_SINE = 32
"""A point: joint angles, arm angle, the rates of the joints with it, how far it is outside the limits, branch, how far
each joint is outside; where costs count (`within`), cost of each joint and its rate with the arm angle in their place,
and the point's cost; the row of the point that comes next; how far shoulder and wrist are from singular."""

STRETCH = 8
STRETCH_BRANCH, STRETCH_LOWER, STRETCH_UPPER, STRETCH_STATES = range(4)
STRETCH_SCANNED, STRETCH_FIRST, STRETCH_LAST = range(5, 8)
"""A stretch: branch, first and last arm angle, what is expected at either, whether its points are looked at, and the
rows of the first and the last of these."""

MAX_POINTS = 2048
"""Room for the points of a pose."""

FEWEST_PARTS = 3
"""A stretch is divided into so many gaps at least."""

LARGEST_GAP = 0.3
SMALLEST_GAP = 1e-9
"""Between points farther apart than the first, rad, there may be anything; closer than the second, nothing."""

UNSURE = 2.0 * PROBED
"""Points tell no more closely than this, rad, how far a joint is outside its limits."""

BENT = 0.05
"""They do so while the elbow's bend has a sine above this; below it, steps are taken until they are nothing."""

TOUCHING = 5e-13
"""Where joints are outside their limits by less than this, rad, rounding alone keeps them there."""

CLOSER = 0.7
"""Gaps are narrower than this part of how far shoulder and wrist are from singular, rad: there joints turn fast."""

LONGEST_CROSSING = 0.2
"""Where a limit is between two points, no joint moves farther than this, rad."""

BREAKS_LIMITS = 2.0
"""Cost of a posture outside its limits, plus how far it is outside, rad."""

FASTER = 1.5
"""Between two points no joint moves faster than at the faster one, but for this factor."""


@kernel
def view_with(P, target, band):
    """A pose as it is looked at with a band, with work space."""
    sides = (elbow_side(P, target.place, 0), elbow_side(P, target.place, 1))
    return View(target, sides, band, np.empty((MAX_POINTS, POINT)), np.empty((MAX_POINTS, 2), np.int64))


@kernel
def view_of(P, target):
    """A pose as it is looked at, with work space and the band of its least bend."""
    return view_with(P, target, band_with(P, least_bend(P, target.place)))


@kernel
def close_points(P, target, start, points, n):
    """Close eight points from row n on at their arm angles, from a start, and tell their rates; whether all are met."""
    R, p, place_ = target
    rows = row(points, n)
    # A bend this small makes of what a last step leaves more than points may be off.
    short = PROBED if place_[3] > BENT else NOTHING
    planes = half_planes(place_[0], place_[1], turn(gather(rows, POINT_PSI, POINT)))
    q, rates, met = close_in_planes(P, start, R, p, planes, (STEPS, short))
    put_eight(rows, POINT, ALL, q)
    for j in range(7):
        scatter(rows, POINT_RATES + j, POINT, rates[j])
    sines = sines_of_eight(P, q)
    s2, s6 = abs(sines[0]), abs(sines[2])
    scatter(rows, POINT_SINE, POINT, where(s2 < s6, s2, s6))
    return met == ALL and in_branches(sines, gather(rows, POINT_BRANCH, POINT)) == ALL


@kernel
def certain_eight(P, view, rows, width, columns):
    """The closed form's postures at eight rows, in which two columns hold their arm angles and branches."""
    psis, branches = gather(rows, columns[0], width), gather(rows, columns[1], width)
    c, s = turn(psis)
    q, _ = eight_postures(P, view.sides, branches, c, s)
    return q


@kernel
def put_points(P, view, points, n):
    """Fill in postures and rates of the eight points from row n on, at their arm angles; whether all are met."""
    start = certain_eight(P, view, row(points, n), POINT, (POINT_PSI, POINT_BRANCH))
    return close_points(P, view.target, start, points, n)


@kernel
def put_between(P, view, points, pairs, count, n):
    """Put eight points half-way between pairs of points, from row n on; whether all are met.

    The pairs are the first `count` rows of `pairs`; the last of the eight repeat the first. Where joints turn fast, the
    way between two points may lead elsewhere: then the closed form gives the starts, as it does where it is close.
    """
    close = widest(view.band) < ALMOST_NOTHING
    for i in range(8):
        a, b = pairs[i % count, 0], pairs[i % count, 1]
        width = points[b, POINT_PSI] - points[a, POINT_PSI]
        # The cubic through both postures with their rates.
        for j in range(0 if close else 7):
            rates = points[a, POINT_RATES + j] - points[b, POINT_RATES + j]
            half = 0.5 * short_way(points[b, j] - points[a, j])
            points[n + i, j] = points[a, j] + half + 0.125 * width * rates
        points[n + i, POINT_PSI] = points[a, POINT_PSI] + 0.5 * width
        points[n + i, POINT_BRANCH] = points[a, POINT_BRANCH]
    met = not close and close_points(P, view.target, take_eight(row(points, n), POINT), points, n)
    return met or put_points(P, view, points, n)


@kernel
def tell_limits(P, rows):
    """Tell how far eight points and each of their joints are outside the limits, rad; negative inside."""
    worst = 0.0 * gather(rows, 0, POINT) - PI
    for j in range(7):
        off = beyond_limits(P, j, gather(rows, j, POINT))
        scatter(rows, POINT_BEYOND + j, POINT, off)
        worst = larger(worst, off)
    scatter(rows, POINT_OFF, POINT, worst)


@kernel
def is_narrow(a, b):
    """Whether two points are so close together that no joint turns much faster between them."""
    return b[POINT_PSI] - a[POINT_PSI] < CLOSER * min(a[POINT_SINE], b[POINT_SINE])


@kernel
def may_bulge(P, a, b, joint):
    """Whether a joint inside one of its limits at two points may be beyond it between them: goes out, comes back.

    Or comes in at the other limit, through the narrow gap between both.
    """
    at_a, at_b = turn_to_middle(P, joint, a[joint]), turn_to_middle(P, joint, b[joint])
    if P[RANGE_KIND + joint] != 0.0 and abs(at_b - at_a) > PI:
        return True
    width = b[POINT_PSI] - a[POINT_PSI]
    for end in range(2):
        sign, limit = (1.0, P[UPPER + joint]) if end == 1 else (-1.0, P[LOWER + joint])
        f, next_f = sign * (at_a - limit), sign * (at_b - limit)
        out, back = sign * a[POINT_RATES + joint], -sign * b[POINT_RATES + joint]
        # Where the tangents meet.
        if max(f, next_f) <= 0.0 < min(out, back) and f + out * (next_f - f + back * width) / (out + back) > 0.0:
            return True
    return False


@kernel
def is_decided(P, a, b):
    """Whether all postures between two points are inside the limits, or all outside, or one limit is between them."""
    width = b[POINT_PSI] - a[POINT_PSI]
    if width > LARGEST_GAP:
        return False
    if width < SMALLEST_GAP:
        return True
    if not is_narrow(a, b):
        return False
    inside_a, inside_b = a[POINT_OFF] <= 0.0, b[POINT_OFF] <= 0.0
    fastest, least, most = 0.0, -2.0 * PI, -2.0 * PI
    for j in range(7):
        way = FASTER * max(abs(a[POINT_RATES + j]), abs(b[POINT_RATES + j])) * width
        both = a[POINT_BEYOND + j] + b[POINT_BEYOND + j]
        fastest = max(fastest, way)
        least = max(least, 0.5 * (both - way))
        most = max(most, 0.5 * (both + way))
    if inside_a != inside_b:
        decided = fastest < LONGEST_CROSSING
        for j in range(7 if decided else 0):
            decided = decided and not may_bulge(P, a, b, j)
        return decided
    return most <= -UNSURE if inside_a else least > UNSURE


@kernel
def inside_between(P, target, a, b):
    """First and last arm angle inside the limits between two points outside them that are as close as gaps become.

    The first is larger than the last if there is none. Where joints meet their limits at one arm angle from opposite
    sides, that arm angle is both.
    """
    start, width = a[POINT_PSI], b[POINT_PSI] - a[POINT_PSI]
    if width >= SMALLEST_GAP:
        return 1.0, 0.0
    R, p, place_ = target
    A = np.empty((16, 9))
    q, met = close_at_angle(P, read7(a), R, p, place_[0], place_[1], start, STEPS, A)
    keep(A)
    first, last, touching_first, touching_last = 0.0, width, 0.0, width
    for j in range(7):
        angle, rate = turn_to_middle(P, j, q[j]), a[POINT_RATES + j]
        for end in range(2):
            off, leaving = (angle - P[UPPER + j], rate) if end == 1 else (P[LOWER + j] - angle, -rate)
            if off + max(leaving * width, 0.0) <= 0.0:
                continue
            if leaving > 0.0:
                last, touching_last = min(last, -off / leaving), min(touching_last, (TOUCHING - off) / leaving)
            elif leaving < 0.0:
                first, touching_first = max(first, -off / leaving), max(touching_first, (TOUCHING - off) / leaving)
            elif off > TOUCHING:
                met = False
    if first > last:
        # Not but for rounding.
        first = 0.5 * (max(touching_first, 0.0) + min(touching_last, width))
        last = first
    if not met or touching_first > touching_last:
        return 1.0, 0.0
    return start + first, start + last


@kernel
def spread(stretch, parts, points, gaps, n, left):
    """Append points spread over a stretch, and the gaps between these: the numbers of both."""
    lower, upper = stretch[STRETCH_LOWER], stretch[STRETCH_UPPER]
    for k in range(parts + 1):
        points[n, POINT_PSI] = lower + (upper - lower) * k / parts
        points[n, POINT_BRANCH] = stretch[STRETCH_BRANCH]
        points[n, POINT_NEXT] = n + 1
        if k > 0:
            gaps[left, 0], gaps[left, 1] = n - 1, n
            left += 1
        n += 1
    return n, left


@kernel
def put_spread(P, view, n):
    """Fill up n points that are spread to whole eights, by copies, and look at them; whether all are met."""
    points = view.points
    for i in range(n, 8 * ((n + 7) // 8)):
        points[i, POINT_PSI], points[i, POINT_BRANCH] = points[n - 1, POINT_PSI], points[n - 1, POINT_BRANCH]
    met = True
    for i in range(0, n, 8):
        met = met and put_points(P, view, points, i)
    return met


@kernel
def take_undecided(P, points, gaps, left, pairs):
    """Take gaps from the end of those that are left, until eight are undecided: how many are left, and become pairs."""
    count = 0
    while left > 0 and count < 8:
        left -= 1
        a, b = gaps[left, 0], gaps[left, 1]
        if not is_decided(P, points[a], points[b]):
            pairs[count, 0], pairs[count, 1] = a, b
            count += 1
    return left, count


@kernel
def scan(P, view, stretches):
    """Look at the postures of stretches closely enough to miss no limit; whether it is done.

    Gaps between points are halved until each is decided. The points are those of the view, and each tells which one
    comes next, from the first of a stretch to its last.
    """
    points, gaps = view.points, view.gaps
    n, left = 0, 0
    for i in range(stretches.shape[0]):
        stretch = row(stretches, i)
        parts = max(math.ceil((stretch[STRETCH_UPPER] - stretch[STRETCH_LOWER]) / LARGEST_GAP), FEWEST_PARTS)
        if stretch[STRETCH_SCANNED] == 0.0:
            continue
        if n + parts + 8 > MAX_POINTS:
            return False
        stretch[STRETCH_FIRST], stretch[STRETCH_LAST] = n, n + parts
        n, left = spread(stretch, parts, points, gaps, n, left)
    if not put_spread(P, view, n):
        return False
    for i in range(0, n, 8):
        tell_limits(P, row(points, i))
    pairs = np.empty((8, 2), np.int64)
    left, count = take_undecided(P, points, gaps, left, pairs)
    while count > 0:
        if n + 8 > MAX_POINTS or not put_between(P, view, points, pairs, count, n):
            return False
        tell_limits(P, row(points, n))
        for i in range(count):
            points[n, POINT_NEXT], points[pairs[i, 0], POINT_NEXT] = pairs[i, 1], n
            gaps[left, 0], gaps[left, 1] = pairs[i, 0], n
            gaps[left + 1, 0], gaps[left + 1, 1] = n, pairs[i, 1]
            left += 2
            n += 1
        left, count = take_undecided(P, points, gaps, left, pairs)
    return True


@kernel
def in_branches(sines, branches):
    """Which of eight postures, as bits, lie each in its branch, told by `sines_of_eight`."""
    s2, s4, s6 = sines
    elbow = whole_number((branches - 1.5) * 0.25)
    rest = branches - 4.0 * elbow
    shoulder = whole_number((rest - 0.5) * 0.5)
    wrist = rest - 2.0 * shoulder
    return as_bits(
        ((1.0 - 2.0 * elbow) * s4 > 0.0) & ((1.0 - 2.0 * shoulder) * s2 > 0.0) & ((1.0 - 2.0 * wrist) * s6 > 0.0)
    )


@kernel
def joint_figures(point, joint):
    """Cost of a joint at a point, and its rate with the arm angle."""
    return point[POINT_COSTS + joint], point[POINT_SLOPES + joint]


@kernel
def put_costs(P, rows):
    """Tell the cost of each joint at eight points, its rate with the arm angle, and the points' costs."""
    highest = 0.0 * gather(rows, 0, POINT) - 1.0
    worst = 0.0 * highest
    for joint in range(7):
        q = gather(rows, joint, POINT)
        q = q + TURN * whole_number((P[MIDDLE + joint] - q) * PER_TURN)
        off, inverse = q - P[MIDDLE + joint], P[INVERSE_HALF_RANGE + joint]
        cost = abs(off) * inverse - 1.0
        slope = inverse * gather(rows, POINT_RATES + joint, POINT)
        scatter(rows, POINT_COSTS + joint, POINT, cost)
        scatter(rows, POINT_SLOPES + joint, POINT, where(off < 0.0, -slope, slope))
        beyond = larger(P[LOWER + joint] - q, q - P[UPPER + joint])
        worst = larger(worst, where(beyond > P[SLACK_LIMIT], beyond, 0.0))
        highest = larger(highest, cost)
    scatter(rows, POINT_OFF, POINT, where(worst > 0.0, BREAKS_LIMITS + worst, highest))


@kernel
def cost_of(point):
    """Cost of a point, its rate with the arm angle, and the joint that makes it."""
    highest, rate, active = -1.0, 0.0, -1
    for joint in range(7):
        cost, slope = joint_figures(point, joint)
        if cost > highest:
            highest, rate, active = cost, slope, joint
    return point[POINT_OFF], rate, active
