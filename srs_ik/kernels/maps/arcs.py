"""Arcs of yaw: how far a pose may be turned about axis 1 and still be reached.

Turning the pose by a yaw adds it to joint 1 and leaves all else. So where joints 2 to 7 keep their limits over an
interval of arm angles, and joint 1 runs from a lowest to a highest angle there, the pose is reached at the yaws from
(lower limit - highest angle) to (upper limit - lowest angle). The union over all intervals is the answer.
"""

import math

from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.maps import CELL_ARCS

PI = math.pi
TURN = 2.0 * math.pi

SAME = 1e-12
"""Arcs that miss each other by less than this, rad, touch."""


@kernel
def put_arc(lowest, highest, limits, arcs, n):
    """Append the arc over which joint 1 keeps its limits where it runs from a lowest to a highest angle; their number.

    Returns -1 where that is the whole circle. The arcs (n, 2) are sorted by their starts.
    """
    lower, upper = limits
    width = (upper - lower) + (highest - lowest)
    if width >= TURN - SAME:
        return -1
    if n >= arcs.shape[0]:
        return n
    start = lower - highest
    start -= TURN * math.floor((start + PI) / TURN)
    if start >= PI:
        start -= TURN
    i = n
    while i > 0 and arcs[i - 1, 0] > start:
        arcs[i, 0], arcs[i, 1] = arcs[i - 1, 0], arcs[i - 1, 1]
        i -= 1
    arcs[i, 0], arcs[i, 1] = start, width
    return n + 1


@kernel
def joined(arcs, n):
    """Join n sorted arcs that touch, also around the circle; the first that is left, and one behind the last."""
    last = 0
    for i in range(1, n):
        if arcs[i, 0] <= arcs[last, 0] + arcs[last, 1] + SAME:
            arcs[last, 1] = max(arcs[last, 1], arcs[i, 0] + arcs[i, 1] - arcs[last, 0])
        else:
            last += 1
            arcs[last, 0], arcs[last, 1] = arcs[i, 0], arcs[i, 1]
    # The last one may go on past the start of the first ones.
    first = 0
    while first < last and arcs[first, 0] + TURN <= arcs[last, 0] + arcs[last, 1] + SAME:
        arcs[last, 1] = max(arcs[last, 1], arcs[first, 0] + arcs[first, 1] + TURN - arcs[last, 0])
        first += 1
    return first, last + 1


@kernel
def write_arcs(arcs, n, most, out):
    """Write the union of n sorted arcs (-1: the whole circle) to a cell, at most `most` of them, and none behind."""
    for k in range(CELL_ARCS, CELL_ARCS + 2 * most):
        out[k] = 0.0
    first, end = (0, 0) if n <= 0 else joined(arcs, n)
    if n < 0 or (end - first == 1 and arcs[first, 1] >= TURN - SAME):
        out[CELL_ARCS], out[CELL_ARCS + 1] = -PI, TURN
        return
    for i in range(first, min(end, first + most)):
        k = CELL_ARCS + 2 * (i - first)
        out[k], out[k + 1] = arcs[i, 0], arcs[i, 1]
