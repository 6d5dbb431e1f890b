"""Arcs of yaw: how far a pose may be turned about axis 1 and still be reached.

Turning the pose by a yaw adds it to joint 1 and leaves all else. So where joints 2 to 7 keep their limits over an
interval of arm angles, and joint 1 runs from a lowest to a highest angle there, the pose is reached at the yaws from
(lower limit - highest angle) to (upper limit - lowest angle). The union over all intervals is the answer.
"""

from __future__ import annotations

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
def write_arcs(arcs, n, most, out):
    """Write the union of n sorted arcs (-1: the whole circle) to a cell, at most `most` of them, and none behind."""
    count = 0
    if n < 0:
        out[CELL_ARCS], out[CELL_ARCS + 1] = -PI, TURN
        count = 1
    for i in range(max(n, 0)):
        last = CELL_ARCS + 2 * (count - 1)
        if count > 0 and arcs[i, 0] <= out[last] + out[last + 1] + SAME:
            out[last + 1] = max(out[last + 1], arcs[i, 0] + arcs[i, 1] - out[last])
        elif count < most:
            out[last + 2], out[last + 3] = arcs[i, 0], arcs[i, 1]
            count += 1
    # The last arcs may go on past the start of the first ones.
    while count > 1:
        last = CELL_ARCS + 2 * (count - 1)
        end = out[last] + out[last + 1] - TURN
        if out[CELL_ARCS] > end + SAME:
            break
        out[last + 1] = max(out[last + 1], out[CELL_ARCS] + out[CELL_ARCS + 1] + TURN - out[last])
        for k in range(CELL_ARCS, last):
            out[k] = out[k + 2]
        count -= 1
    if count == 1 and out[CELL_ARCS + 1] >= TURN - SAME:
        out[CELL_ARCS], out[CELL_ARCS + 1] = -PI, TURN
    for k in range(CELL_ARCS + 2 * count, CELL_ARCS + 2 * most):
        out[k] = 0.0
