"""Samples of a followed curve beside its own, so that nothing between two samples is overlooked where limits count.

Joint limits of almost a turn leave a narrow gap: two samples on either side of it may both keep the limits, so one is
put into the gap. And between two samples that break the limits of different joints there may be postures that keep
them all: so samples are put where each of those joints passes its limit.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.joint_vectors import difference, short_way
from srs_ik.kernels.algebra.roots import has_settled, next_parameter, start_crossing, tell_figure
from srs_ik.kernels.curves.follow import between, put
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import LOWER, MIDDLE, RANGE_KIND, UPPER
from srs_ik.kernels.limb.limits import beyond, turn_to_middle

HALVINGS = 45
CROSSING_STEPS = 60

WELL_INSIDE = 0.5
"""A sample in a gap need not lie closer to its middle than this part of half its width."""


@kernel
def into_gap(P, R, p, a, b, j, way, J, A):
    """The posture between a and b with joint j in the gap of its limits: q, its share of the way, whether it is met."""
    far = P[MIDDLE + j] + math.pi
    tolerance = WELL_INSIDE * (math.pi - 0.5 * (P[UPPER + j] - P[LOWER + j]))
    start = short_way(a[j] - far)
    low = 0.0
    high = 1.0
    share = -start / way
    q = a
    met = False
    for _ in range(HALVINGS):
        q, met = between(P, R, p, a, b, share, J, A)
        off = short_way(q[j] - far)
        if not met or abs(off) < tolerance:
            break
        if off * start > 0.0:
            low = share
        else:
            high = share
        share = 0.5 * (low + high)
    return q, share, met


@kernel
def insert(line, first, n, x, q):
    """Insert a sample among the sorted rows first to n - 1; return the number of rows."""
    count = put(line, n, x, q)
    i = count - 1
    while i > first and line[i - 1, 0] > line[i, 0]:
        for c in range(line.shape[1]):
            line[i, c], line[i - 1, c] = line[i - 1, c], line[i, c]
        i -= 1
    return count


@kernel
def put_gaps(P, R, p, x_a, a, x_b, b, line, n, J, A):
    """Append a sample for every gap between postures a and b of a curve, in their order; return the number of rows."""
    way = difference(a, b)
    first = n
    for j in range(7):
        start = short_way(a[j] - P[MIDDLE + j] - math.pi)
        if P[RANGE_KIND + j] == 0.0 or start * (start + way[j]) > 0.0 or start == 0.0 or abs(start) > abs(way[j]):
            continue
        q, share, met = into_gap(P, R, p, a, b, j, way[j], J, A)
        if met:
            n = insert(line, first, n, x_a + share * (x_b - x_a), q)
    return n


@kernel
def joint_beyond(P, j, q):
    """How far a joint of a posture lies outside its limits in the best turn, rad; negative inside."""
    return beyond(P, j, turn_to_middle(P, j, q[j]))


@kernel
def any_outside(P, q):
    """Whether a posture breaks a limit."""
    outside = False
    for j in range(7):
        outside = outside or joint_beyond(P, j, q) > 0.0
    return outside


@kernel
def put_bounds(P, R, p, x_a, a, x_b, b, line, n, J, A):
    """Append samples where joints pass a limit between two postures of a curve, if both break limits; rows in use."""
    if not any_outside(P, a) or not any_outside(P, b):
        return n
    first = n
    for j in range(7):
        at_a = joint_beyond(P, j, a)
        at_b = joint_beyond(P, j, b)
        if (at_a > 0.0) == (at_b > 0.0):
            continue
        # Shares of the way at which the joint is inside, and outside.
        crossing = start_crossing(0.0, at_a, 1.0, at_b) if at_b > 0.0 else start_crossing(1.0, at_b, 0.0, at_a)
        inside_q = a if at_b > 0.0 else b
        for _ in range(CROSSING_STEPS):
            if has_settled(crossing):
                break
            share = next_parameter(crossing)
            q, met = between(P, R, p, a, b, share, J, A)
            if not met:
                break
            f = joint_beyond(P, j, q)
            crossing = tell_figure(crossing, share, f)
            if f <= 0.0:
                inside_q = q
        inside = crossing[0]
        if 0.0 < inside < 1.0:
            n = insert(line, first, n, x_a + inside * (x_b - x_a), inside_q)
    return n
