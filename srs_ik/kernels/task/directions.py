"""Arm angles at which a wrist can just, or just no longer, point the hand in a direction, whatever its roll.

Seen from the forearm, the directions in which the wrist can point the hand fill a region of the sphere. Its boundary
consists of arcs on which one joint turns alone: two joints are on their limits, or one is and the direction lies in
the plane of the axes of the others, across which they cannot move it, or it lies in the plane of all three. The wanted
direction moves on a circle about the line S-W as the arm angle does. So the arm angles at which it can enter or leave
the region are those at which two circles meet, and they are known.
"""

import math

from srs_ik.kernels.algebra.vectors import across, cross, dot, load3, rotate
from srs_ik.kernels.exact.events import add_event
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import A1, A2, A3, LOWER, PHASE, RANGE_KIND, UPPER, WRIST

MAX_CROSSINGS = 56
"""Two for each of 28 circles."""

POINT = 1e-14
"""A circle of a smaller radius is a point."""


@kernel
def turned_by(axis, angle, v):
    """A vector turned about a unit axis by an angle."""
    return rotate(axis, math.cos(angle), math.sin(angle), v)


@kernel
def meets(axis, v, x, value):
    """The angles, two or none, by which v turned about a unit axis has the product `value` with x; and their number."""
    sweep = across(v, axis)
    c = dot(x, sweep)
    s = dot(x, cross(axis, v))
    rest = value - dot(axis, v) * dot(axis, x)
    r = math.sqrt(c * c + s * s)
    if r < POINT or abs(rest) > r:
        return (0.0, 0.0), 0
    middle = math.atan2(s, c)
    apart = math.atan2(math.sqrt((r - rest) * (r + rest)), rest)
    return (middle + apart, middle - apart), 2


@kernel
def add_crossings(P, line, wanted, q5, q6, axis, v, psis, n):
    """Insert the arm angles at which the wanted direction meets the circle of v about an axis; return their number.

    All is seen from the forearm: the circle after the turns q5 and q6, the wanted direction as in `wrist_crossings`.
    """
    a5 = load3(P, WRIST + A1)
    a6 = load3(P, WRIST + A2)
    angles, count = meets(axis, v, turned_by(a6, -q6, turned_by(a5, -q5, line)), dot(line, wanted))
    sideways = across(wanted, line)
    for i in range(count):
        u = turned_by(a5, q5, turned_by(a6, q6, turned_by(axis, angles[i], v)))
        # The arm turns with the arm angle; seen from the forearm, the direction turns the other way.
        n = add_event(math.atan2(-dot(cross(line, sideways), u), dot(sideways, u)), psis, n)
    return n


@kernel
def bounds(P, joint):
    """Limits of a joint, and how many count: none where the range is a full turn."""
    return (P[LOWER + joint], P[UPPER + joint]), 0 if P[RANGE_KIND + joint] == 0.0 else 2


@kernel
def wrist_crossings(P, line, wanted, hand_axis, psis):
    """Write the arm angles at which the hand can come to point in a direction, or cease to; return their number.

    They are sorted, in [-pi, pi). The direction is told as `wanted` from the forearm at arm angle zero, where it turns
    about `line`, S-W, with the arm angle, and as `hand_axis` in the hand at the zero configuration; `psis` has room for
    MAX_CROSSINGS.
    """
    a5 = load3(P, WRIST + A1)
    a6 = load3(P, WRIST + A2)
    a7 = load3(P, WRIST + A3)
    limits_5, n5 = bounds(P, 4)
    limits_6, n6 = bounds(P, 5)
    limits_7, n7 = bounds(P, 6)
    n = 0
    for i in range(n7):
        v = turned_by(a7, limits_7[i], hand_axis)
        folds, count = meets(a6, v, cross(a5, a6), 0.0)
        for k in range(count):
            n = add_crossings(P, line, wanted, 0.0, 0.0, a5, turned_by(a6, folds[k], v), psis, n)
        for k in range(n6):
            n = add_crossings(P, line, wanted, 0.0, 0.0, a5, turned_by(a6, limits_6[k], v), psis, n)
        for k in range(n5):
            n = add_crossings(P, line, wanted, limits_5[k], 0.0, a6, v, psis, n)
    for i in range(n6):
        folds, count = meets(a7, hand_axis, cross(turned_by(a6, -limits_6[i], a5), a7), 0.0)
        for k in range(count):
            v = turned_by(a6, limits_6[i], turned_by(a7, folds[k], hand_axis))
            n = add_crossings(P, line, wanted, 0.0, 0.0, a5, v, psis, n)
        for k in range(n5):
            n = add_crossings(P, line, wanted, limits_5[k], limits_6[i], a7, hand_axis, psis, n)
    folds, count = meets(a7, hand_axis, cross(a6, a7), 0.0)
    for i in range(count):
        v = turned_by(a7, folds[i], hand_axis)
        for k in range(n5):
            n = add_crossings(P, line, wanted, limits_5[k], 0.0, a6, v, psis, n)
        # Where axes 5, 6 and 7 are in one plane, and the direction with them.
        for turned in (P[WRIST + PHASE], P[WRIST + PHASE] + math.pi):
            n = add_crossings(P, line, wanted, 0.0, 0.0, a5, turned_by(a6, turned, v), psis, n)
    return n
