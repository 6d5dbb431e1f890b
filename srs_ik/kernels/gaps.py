"""Where a followed curve jumps over a gap between the limits of a joint.

Joint limits of almost a turn leave a narrow gap. Two samples on either side of it both keep the limits; so that the
gap between them is not overlooked, a sample is put into it.
"""

from __future__ import annotations

import math

from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import LOWER, MIDDLE, RANGE_KIND, UPPER
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
    # Between the gaps of two joints there may be room.
    i = first
    while i < n - 1:
        x = 0.5 * (line[i, 0] + line[i + 1, 0])
        q, met = between(P, R, p, a, b, (x - x_a) / (x_b - x_a), J, A)
        if met:
            n = insert(line, first, n, x, q)
            i += 1
        i += 1
    return n
