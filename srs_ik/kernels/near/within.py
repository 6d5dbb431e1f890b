"""The posture farthest from the limits within intervals of arm angles, on the true chain of a near limb.

Postures are looked at, eight at a time, until none between them can be better; then the minima are closed in on.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.pointers import copy, read7, row
from srs_ik.kernels.chain.eight import take_eight
from srs_ik.kernels.exact.summit import downhill
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.asked import Best
from srs_ik.kernels.near import scan

GAIN = 1e-12
"""Costs closer than this are equal."""

SPACING = 0.3
"""Widest spacing of the arm angles that are looked at first, rad."""

AT_ONCE = 160
"""Points that are looked at first, at most, but for those of one interval: the best of them shortens what follows."""

COARSE = 1e-3
"""Between points farther apart, rad, every fourth arm angle is half-way."""

CLOSING_STEPS = 24
CLOSED_IN = 1e-7
"""A step of the arm angle this short, rad, is the last: steps shrink like squares."""


@kernel
def joint_between(a, b, joint):
    """Costs of a joint that no posture between two points undercuts, and that none exceeds."""
    cost_a, rate_a = scan.joint_figures(a, joint)
    cost_b, rate_b = scan.joint_figures(b, joint)
    change = scan.FASTER * max(abs(rate_a), abs(rate_b)) * (b[scan.POINT_PSI] - a[scan.POINT_PSI])
    return 0.5 * (cost_a + cost_b - change), 0.5 * (cost_a + cost_b + change)


@kernel
def least_cost(a, b):
    """A cost that no posture between two points undercuts."""
    least = -1.0
    for j in range(7):
        least = max(least, joint_between(a, b, j)[0])
    return least


@kernel
def has_maximum(a, b, joint):
    """Whether the cost of a joint, which turns around once at most between two points, may rise there before it falls.

    It rises behind the middle of the range: of a joint that was on its way there, or is on its way back, or goes there
    and comes back.
    """
    slope_a, slope_b = a[scan.POINT_SLOPES + joint], b[scan.POINT_SLOPES + joint]
    passes = slope_a * a[scan.POINT_RATES + joint] * slope_b * b[scan.POINT_RATES + joint] < 0.0
    if passes or not slope_a < 0.0 < slope_b:
        return slope_a > 0.0 > slope_b or (passes and (slope_a > 0.0 or slope_b < 0.0))
    # Where the tangents meet, behind the middle?
    off_a, off_b, width = (
        1.0 + a[scan.POINT_COSTS + joint],
        1.0 + b[scan.POINT_COSTS + joint],
        b[scan.POINT_PSI] - a[scan.POINT_PSI],
    )
    return off_a + slope_a * (off_a - off_b + slope_b * width) / (slope_b - slope_a) < 0.0


@kernel
def is_valley(a, b, least):
    """Whether the cost between two points that are narrow, no less than a known one, rises nowhere before it falls."""
    valley = True
    for j in range(7):
        valley = valley and not (has_maximum(a, b, j) and joint_between(a, b, j)[1] >= least)
    return valley


@kernel
def measure_points(P, points, first, last, best):
    """Tell the costs of points, in whole eights, of which the rows first to last - 1 count; the best one so far."""
    for i in range(first, last, 8):
        scan.put_costs(P, row(points, i))
    for i in range(first, last):
        if points[i, scan.POINT_OFF] < best.cost:
            best = Best(read7(points[i]), points[i, scan.POINT_OFF])
    return best


@kernel
def spread_points(found, points, gaps):
    """Spread points over the first of some intervals: how many intervals, points, and gaps between these."""
    count, left, taken = 0, 0, 0
    for i in range(found.shape[0]):
        parts = max(math.ceil((found[i, 2] - found[i, 1]) / SPACING), 1)
        if i > 0 and count + parts >= AT_ONCE:
            break
        taken += 1
        count, left = scan.spread(row(found, i), parts, points, gaps, count, left)
    return taken, count, left


@kernel
def sort_gaps(points, gaps, kept, left, lowest):
    """Sort gaps behind those that are kept: valleys to these, what cannot cost less than a known cost out.

    Stops at eight that have to be halved, which come next. Returns how many are kept, are left and have to be halved.
    """
    i = kept
    while i < left and i < kept + 8:
        a, b = points[gaps[i, 0]], points[gaps[i, 1]]
        valley = False
        if scan.is_narrow(a, b):
            least = least_cost(a, b)
            if least > lowest - GAIN:
                left -= 1
                gaps[i, 0], gaps[i, 1] = gaps[left, 0], gaps[left, 1]
                continue
            valley = is_valley(a, b, least)
        if valley:
            first, last = gaps[i, 0], gaps[i, 1]
            gaps[i, 0], gaps[i, 1] = gaps[kept, 0], gaps[kept, 1]
            gaps[kept, 0], gaps[kept, 1] = first, last
            kept += 1
        i += 1
    return kept, left, i - kept


@kernel
def halve_gaps(P, view, n, left, best):
    """Halve gaps of a view that may hide a better point until they are valleys, behind its n points.

    Returns the number of gaps that are left (-1: it fails), and the best configuration so far.
    """
    points, gaps = view.points, view.gaps
    kept, left, long = sort_gaps(points, gaps, 0, left, best.cost)
    while long > 0:
        if n + 8 > scan.MAX_POINTS or not scan.put_between(P, view, points, gaps[kept:], long, n):
            return -1, best
        best = measure_points(P, points, n, n + 8, best)
        for i in range(long):
            gaps[left, 0], gaps[left, 1] = n + i, gaps[kept + i, 1]
            gaps[kept + i, 1] = n + i
            left += 1
        n += 8
        kept, left, long = sort_gaps(points, gaps, kept, left, best.cost)
    return kept, best


@kernel
def copy_point(source, i, target, k):
    """Copy a point."""
    copy(row(source, i), row(target, k), scan.POINT)


@kernel
def next_arm_angle(a, b, latest, step):
    """Where to look for the minimum between two points, from the latest one."""
    lower, upper = a[scan.POINT_PSI], b[scan.POINT_PSI]
    x = latest[scan.POINT_PSI] + downhill(latest, scan.POINT_COSTS, scan.POINT_SLOPES, scan.cost_of(latest)[2])
    if not lower < x < upper:
        cost_a, slope_a, active_a = scan.cost_of(a)
        cost_b, slope_b, active_b = scan.cost_of(b)
        own_a, own_b = a[scan.POINT_SLOPES + active_b], b[scan.POINT_SLOPES + active_a]
        width = upper - lower
        # Where the tangents of two meet, or where the rate of one vanishes before it meets another.
        x = lower + (cost_a - cost_b + slope_b * width) / (slope_b - slope_a)
        if active_a == active_b:
            # The minimum of the cubic through both.
            mean = slope_a + slope_b - 3.0 * (cost_b - cost_a) / width
            far = math.sqrt(max(mean * mean - slope_a * slope_b, 0.0))
            x = upper - width * (slope_b + far - mean) / (slope_b - slope_a + 2.0 * far)
        elif own_a < 0.0:
            x = max(x, lower - own_a * width / (slope_b - own_a))
        elif own_b > 0.0:
            x = min(x, lower - slope_a * width / (own_b - slope_a))
    if (step % 4 == 3 and upper - lower > COARSE) or not lower < x < upper:
        x = 0.5 * (lower + upper)
    return x


@kernel
def close_in(P, view, gaps, work, best):
    """Close in on the minima in up to eight gaps in step: the best configuration, and whether all went well.

    `work` holds the first and the last points of the gaps, the latest ones, and those that are looked at.
    """
    points = view.points
    count = min(gaps.shape[0], 8)
    for i in range(count):
        a, b = gaps[i, 0], gaps[i, 1]
        copy_point(points, a, work, i)
        copy_point(points, b, work, 8 + i)
        copy_point(points, a if points[a, scan.POINT_OFF] < points[b, scan.POINT_OFF] else b, work, 16 + i)
    for i in range(8):
        copy_point(work, 16, work, 24 + i)
    for step in range(CLOSING_STEPS):
        longest = 0.0
        for i in range(count):
            x = next_arm_angle(work[i], work[8 + i], work[16 + i], step)
            way = x - work[16 + i, scan.POINT_PSI]
            _, slope, _ = scan.cost_of(work[16 + i])
            longest = max(longest, abs(way) if abs(way * slope) > GAIN else 0.0)
            for j in range(7):
                work[24 + i, j] = work[16 + i, j] + way * work[16 + i, scan.POINT_RATES + j]
            work[24 + i, scan.POINT_PSI] = x
            work[24 + i, scan.POINT_BRANCH] = work[i, scan.POINT_BRANCH]
        if longest == 0.0:
            break
        if not scan.close_points(P, view.target, take_eight(row(work, 24), scan.POINT), work, 24):
            return best, False
        best = measure_points(P, work, 24, 24 + count, best)
        for i in range(count):
            _, slope, _ = scan.cost_of(work[24 + i])
            copy_point(work, 24 + i, work, 16 + i)
            copy_point(work, 24 + i, work, i if slope < 0.0 else 8 + i)
        if longest < CLOSED_IN:
            break
    return best, True


@kernel
def best_of_some(P, view, found, best):
    """`best_within` of the first of some intervals: also how many these are."""
    points, gaps = view.points, view.gaps
    taken, count, left = spread_points(found, points, gaps)
    if not scan.put_spread(P, view, count):
        return best, taken, False
    best = measure_points(P, points, 0, count, best)
    left, best = halve_gaps(P, view, 8 * ((count + 7) // 8), left, best)
    if left < 0:
        return best, taken, False
    kept = 0
    for i in range(left):
        a, b = points[gaps[i, 0]], points[gaps[i, 1]]
        _, slope_a, _ = scan.cost_of(a)
        _, slope_b, _ = scan.cost_of(b)
        if slope_a < 0.0 < slope_b and not (scan.is_narrow(a, b) and least_cost(a, b) > best.cost - GAIN):
            gaps[kept, 0], gaps[kept, 1] = gaps[i, 0], gaps[i, 1]
            kept += 1
    work = np.empty((32, scan.POINT))
    for i in range(0, kept, 8):
        best, sure = close_in(P, view, gaps[i:kept], work, best)
        if not sure:
            return best, taken, False
    return best, taken, True


@kernel
def best_within(P, view, found, best):
    """The best configuration in intervals, rows of `arcs.without_arcs`, if it is better than the best so far.

    Returns also whether the answer is certain.
    """
    first = 0
    while first < found.shape[0]:
        best, taken, certain = best_of_some(P, view, found[first:], best)
        if not certain:
            return best, False
        first += taken
    return best, True
