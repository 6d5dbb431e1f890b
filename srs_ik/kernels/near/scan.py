"""A stretch of arm angles looked at closely on the true chain: points eight at a time, until no limit can be missed."""

from __future__ import annotations

import numpy as np

from srs_ik.kernels.algebra.eight import ALL, larger
from srs_ik.kernels.algebra.joint_vectors import short_way
from srs_ik.kernels.algebra.lane_trig import turn
from srs_ik.kernels.algebra.lanes import as_bits, gather, scatter, where, whole_number
from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.chain.eight import put_eight, sines_of_eight, take_eight
from srs_ik.kernels.chain.newton import STEPS, close_at_angle
from srs_ik.kernels.chain.newton_eight import PROBED, close_in_planes, half_planes
from srs_ik.kernels.exact.events import PI, TURN
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.asked import View
from srs_ik.kernels.layout.limb import INVERSE_HALF_RANGE, LOWER, MIDDLE, SLACK_LIMIT, UPPER
from srs_ik.kernels.limb.limits import PER_TURN, beyond, turn_to_middle
from srs_ik.kernels.limb.poses import read7
from srs_ik.kernels.limb.postures_eight import eight_postures
from srs_ik.kernels.limb.triangle import elbow_side
from srs_ik.kernels.near.band import ALMOST_NOTHING, band_with, least_bend, widest

POINT = 33
POINT_PSI = 7
POINT_RATES = 8
POINT_OFF = 15
POINT_BRANCH = 16
POINT_COSTS = 17
POINT_SLOPES = 24
POINT_NEXT = 31
POINT_SINE = 32
"""A point: joint angles, arm angle, the rates of the joints with it, how far it is outside the limits, branch; where
costs count (`within`), cost of each joint and its rate with the arm angle, and in the place of the limits the cost;
the row of the point that comes next; how far shoulder and wrist are from singular."""

LAST = 7
"""Of the first eight points of a stretch, the one at its end."""

MAX_POINTS = 1024
"""Room for the points between two arm angles."""

LARGEST_GAP = 0.3
SMALLEST_GAP = 1e-9
"""Between points farther apart than the first, rad, there may be anything; closer than the second, nothing."""

UNSURE = 2.0 * PROBED
"""Points tell no more closely than this, rad, how far a joint is outside its limits."""

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
def close_points(P, target, points, n):
    """Close eight points from row n on at their arm angles, and tell their rates; whether all are met."""
    R, p, place_ = target
    rows = row(points, n)
    planes = half_planes(place_[0], place_[1], turn(gather(rows, POINT_PSI, POINT)))
    q, rates, met = close_in_planes(P, take_eight(rows, POINT), R, p, planes, (STEPS, PROBED))
    put_eight(rows, POINT, ALL, q)
    for j in range(7):
        scatter(rows, POINT_RATES + j, POINT, rates[j])
    sines = sines_of_eight(P, q)
    s2, s6 = abs(sines[0]), abs(sines[2])
    scatter(rows, POINT_SINE, POINT, where(s2 < s6, s2, s6))
    return met == ALL and in_branches(sines, gather(rows, POINT_BRANCH, POINT)) == ALL


@kernel
def put_certain(P, view, rows, width, columns):
    """Write the closed form's postures into eight rows, in which two columns hold their arm angles and branches."""
    psis, branches = gather(rows, columns[0], width), gather(rows, columns[1], width)
    c, s = turn(psis)
    q, _ = eight_postures(P, view.sides, branches, c, s)
    put_eight(rows, width, ALL, q)


@kernel
def put_points(P, view, points, n):
    """Fill in postures and rates of the eight points from row n on, at their arm angles; whether all are met."""
    put_certain(P, view, row(points, n), POINT, (POINT_PSI, POINT_BRANCH))
    return close_points(P, view.target, points, n)


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
        for j in range(7):
            rates = points[a, POINT_RATES + j] - points[b, POINT_RATES + j]
            half = 0.5 * short_way(points[b, j] - points[a, j])
            points[n + i, j] = points[a, j] + half + 0.125 * width * rates
        points[n + i, POINT_PSI] = points[a, POINT_PSI] + 0.5 * width
        points[n + i, POINT_BRANCH] = points[a, POINT_BRANCH]
    return (not close and close_points(P, view.target, points, n)) or put_points(P, view, points, n)


@kernel
def outside_by(P, point):
    """By how much a point is outside the limits, rad."""
    worst = -PI
    for j in range(7):
        worst = max(worst, beyond(P, j, turn_to_middle(P, j, point[j])))
    return worst


@kernel
def is_narrow(a, b):
    """Whether two points are so close together that no joint turns much faster between them."""
    return b[POINT_PSI] - a[POINT_PSI] < CLOSER * min(a[POINT_SINE], b[POINT_SINE])


@kernel
def may_bulge(P, a, b, joint):
    """Whether a joint inside one of its limits at two points may be beyond it between them: goes out, comes back."""
    at_a, at_b = turn_to_middle(P, joint, a[joint]), turn_to_middle(P, joint, b[joint])
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
        both = beyond(P, j, turn_to_middle(P, j, a[j])) + beyond(P, j, turn_to_middle(P, j, b[j]))
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
def scan(P, view, branch, lower, upper):
    """Look at the postures of a branch between two arm angles, closely enough to miss no limit; whether it is done.

    Gaps between points are halved until each is decided. The points are those of the view, and each tells which one
    comes next, from the first to the one in row LAST.
    """
    points, gaps = view.points, view.gaps
    for i in range(8):
        points[i, POINT_PSI] = lower + (upper - lower) * i / LAST
        points[i, POINT_BRANCH] = branch
        points[i, POINT_NEXT] = i + 1
        gaps[i, 0], gaps[i, 1] = i, i + 1
    left = LAST
    n = LAST + 1
    if not put_points(P, view, points, 0):
        return False
    while True:
        for i in range(n - 8, n):
            points[i, POINT_OFF] = outside_by(P, points[i])
        kept = 0
        for i in range(left):
            if not is_decided(P, points[gaps[i, 0]], points[gaps[i, 1]]):
                gaps[kept, 0], gaps[kept, 1] = gaps[i, 0], gaps[i, 1]
                kept += 1
        if kept == 0:
            return True
        # Eight gaps at a time; the others wait.
        if n + 8 > MAX_POINTS or not put_between(P, view, points, gaps, kept, n):
            return False
        left = kept
        for i in range(min(kept, 8)):
            points[n + i, POINT_NEXT], points[gaps[i, 0], POINT_NEXT] = gaps[i, 1], n + i
            gaps[left, 0], gaps[left, 1] = n + i, gaps[i, 1]
            gaps[i, 1] = n + i
            left += 1
        n += 8


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
