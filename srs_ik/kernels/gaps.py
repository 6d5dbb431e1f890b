"""Samples of a followed curve beside its own, so that nothing between two samples is overlooked where limits count.

Joint limits of almost a turn leave a narrow gap: two samples on either side of it may both keep the limits, so one is
put into the gap. And between two samples that break the limits of different joints there may be postures that keep
them all: so samples are put where each of those joints passes its limit.
"""

from __future__ import annotations

import math

from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import LOWER, MIDDLE, RANGE_KIND, UPPER
from srs_ik.kernels.limits import turn_to_middle, violation
from srs_ik.kernels.trace import between, difference, put, short_way

HALVINGS = 45

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
def joint_outside(P, j, q):
    """Whether a joint of a posture breaks its limits in every turn."""
    return violation(P, j, turn_to_middle(P, j, q[j])) > 0.0


@kernel
def any_outside(P, q):
    """Whether a posture breaks a limit."""
    outside = False
    for j in range(7):
        outside = outside or joint_outside(P, j, q)
    return outside


@kernel
def put_bounds(P, R, p, x_a, a, x_b, b, line, n, J, A):
    """Append samples where joints pass a limit between two postures of a curve, if both break limits; rows in use."""
    if not any_outside(P, a) or not any_outside(P, b):
        return n
    first = n
    for j in range(7):
        leaves = joint_outside(P, j, b)
        if joint_outside(P, j, a) == leaves:
            continue
        # Shares of the way on which the joint is inside, and outside.
        inside = 0.0 if leaves else 1.0
        outside = 1.0 - inside
        inside_q = a if leaves else b
        for _ in range(HALVINGS):
            share = 0.5 * (inside + outside)
            q, met = between(P, R, p, a, b, share, J, A)
            if not met:
                break
            if joint_outside(P, j, q):
                outside = share
            else:
                inside = share
                inside_q = q
        if 0.0 < inside < 1.0:
            n = insert(line, first, n, x_a + inside * (x_b - x_a), inside_q)
    return n
