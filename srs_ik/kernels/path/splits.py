"""Splits: at a singular posture, two joints turn about one axis, against each other while the pose stands still.

A strip that begins or ends in one has all its turns for neighbours.
"""

import math

from srs_ik.kernels.algebra.joint_vectors import along7
from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import BOTTOM_GAP, IS_CLOSED, LOWER, PHASE, SHOULDER, TOP_GAP, UPPER, WRIST
from srs_ik.kernels.layout.path import NODE_BRANCH, NODE_PSI
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.path.followed import settled
from srs_ik.kernels.path.strips import SPACING, put_node

SPLIT = 1e-7
"""Sine of a middle angle under which joints 1 and 3, or 5 and 7, turn against each other freely."""


@kernel
def in_line(P, k, x):
    """Whether the outer axes of the spherical joint at block k are in line where the middle one is at its end x."""
    return P[k + (TOP_GAP if math.cos(x) > 0.0 else BOTTOM_GAP)] == 0.0


@kernel
def split_of(P, q):
    """How joints turn at a singular posture while the pose stands still: seven rates, and whether there are any.

    Where axes are oblique, the middle joint may be at its end and the outer axes still not in line.
    """
    if P[IS_CLOSED] != 1.0:
        return NO_SEED, False
    s = q[1] - P[SHOULDER + PHASE]
    w = q[5] - P[WRIST + PHASE]
    if abs(math.sin(s)) < SPLIT and in_line(P, SHOULDER, s):
        return (1.0, 0.0, math.copysign(1.0, -math.cos(s)), 0.0, 0.0, 0.0, 0.0), True
    if abs(math.sin(w)) < SPLIT and in_line(P, WRIST, w):
        return (0.0, 0.0, 0.0, 0.0, 1.0, 0.0, math.copysign(1.0, -math.cos(w))), True
    return NO_SEED, False


@kernel
def along_split(P, q, split, x):
    """The posture turned along a split, and whether it is inside its limits."""
    return settled(
        P, (q[0] + x * split[0], q[1], q[2] + x * split[2], q[3], q[4] + x * split[4], q[5], q[6] + x * split[6]), 0.0
    )


@kernel
def split_room(P, q, split):
    """How far a posture may turn along a split inside its limits: back (negative or zero) and forth."""
    back, forth = -math.inf, math.inf
    for j in range(0, 7, 2):
        low, high = P[LOWER + j] - q[j], P[UPPER + j] - q[j]
        if split[j] > 0.0:
            back, forth = max(back, low), min(forth, high)
        elif split[j] < 0.0:
            back, forth = max(back, -high), min(forth, -low)
    return min(back, 0.0), max(forth, 0.0)


@kernel
def put_split(P, sheet, i, spacing, n):
    """Append the split of the posture of row i, if it has one, as a strip of its own; the next free row."""
    q = read7(row(sheet.nodes, i))
    split, is_singular = split_of(P, q)
    if not is_singular:
        return n
    back, forth = split_room(P, q, split)
    back, forth = max(back, -math.pi), min(forth, math.pi)
    parts = max(math.ceil((forth - back) / spacing), 1)
    if n + parts >= sheet.nodes.shape[0]:
        return n
    for k in range(parts + 1):
        turned, _ = settled(P, along7(q, back + (forth - back) * k / parts, split), 0.0)
        put_node(sheet.nodes, n, turned, sheet.nodes[i, NODE_PSI], sheet.nodes[i, NODE_BRANCH])
        sheet.linked[n] = k < parts
        n += 1
    return n


@kernel
def put_splits(P, sheet, first, n, around):
    """Append the splits of the ends of the strips among rows first to n - 1; the next free row."""
    spacing = SPACING if around.radius == 0.0 else around.spacing
    last = n
    for i in range(first, last):
        if i == first or not sheet.linked[i - 1] or not sheet.linked[i]:
            n = put_split(P, sheet, i, spacing, n)
    return n
