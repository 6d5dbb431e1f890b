"""Bends of an elbow as good as flat at which limits cross, begin or end, over all arm angles."""

import math

from srs_ik.kernels.algebra.vectors import dot
from srs_ik.kernels.exact.bend_events import ENDS, LIMITS, add_bend, add_elbow, limit_form
from srs_ik.kernels.exact.bends import bent_place
from srs_ik.kernels.exact.events import beyond_middle, end_of_reach, insert, short_of_end
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import SHOULDER, SLACK_LIMIT, WRIST
from srs_ik.kernels.limb.triangle import elbow_side

MOST_CURVES = 64
MOST_CROSSINGS = 512
"""Curves of limits in the plane of bend and arm angle, and bends at which two of them cross, at most."""


@kernel
def beyond_on(P, k, i, form, value, circle):
    """By how much the spherical joint at block k is beyond a limit on a circle of arm angles, in the mean over them."""
    square = dot(circle[1], circle[1])
    if i // 2 == 1:
        return beyond_middle(P, k, i % 2, circle[0], square)
    if i >= LIMITS:
        return short_of_end(form, end_of_reach(P, k, i % 2)[1], circle[0], square)
    return dot(form, circle[0]) - value


@kernel
def put_curve(square, c, s, rest, curves, n):
    """Append a curve square (u^2 + v^2) + c u + s v + rest = 0; how many there are then."""
    curves[n, 0], curves[n, 1], curves[n, 2], curves[n, 3] = square, c, s, rest
    return n + 1


@kernel
def read_curve(curves, i):
    """Row i of some curves as a tuple."""
    return curves[i, 0], curves[i, 1], curves[i, 2], curves[i, 3]


@kernel
def add_curves(P, k, motions, elbow, curves, n):
    """Append the curves on which a spherical joint is on a limit to the first n; how many they are then.

    They are lines and circles in the plane of points (u, v) at the distance of the bend, as a part of the largest, and
    in the direction of the arm angle. `motions` are those with no bend and with the largest.
    """
    for i in range(ENDS):
        form, value, of_r, there = limit_form(P, k, i)
        flat, circle = (motions[0][2], motions[1][2]) if of_r else (motions[0][0], motions[1][0])
        c, s = dot(form, circle[1]), dot(form, circle[2])
        size = math.sqrt(c * c + s * s)
        c_0, s_0 = dot(form, flat[1]), dot(form, flat[2])
        size_0 = math.sqrt(c_0 * c_0 + s_0 * s_0)
        rest = beyond_on(P, k, i, form, value, flat)
        square = beyond_on(P, k, i, form, value, circle) - rest
        if not there or abs(rest) > size + abs(square) + P[SLACK_LIMIT]:
            continue
        if size_0 <= 0.5 * size:
            # The circle of the arm angle shrinks with the bend, the same way on either side of the elbow.
            if elbow == 0:
                n = put_curve(square, c, s, rest, curves, n)
        else:
            # An arm angle of its own, from which the bend leads away in proportion.
            away = math.acos(max(min(-rest / size_0, 1.0), -1.0))
            for side in range(2):
                psi = math.atan2(s_0, c_0) + (away if side == 0 else -away)
                u, v = math.cos(psi), math.sin(psi)
                slope, change = s_0 * u - c_0 * v, rest + square + c * u + s * v
                turn = change / slope if abs(slope) > abs(change) else 0.0
                n = put_curve(turn, -v, u, 0.0, curves, n)
    return n


@kernel
def add_meetings(curve_, line, most, span, bends, n):
    """Insert the bends of the points that a curve shares with a line, each a row of such figures, to the first n."""
    c, s, rest = line
    size = math.sqrt(c * c + s * s)
    # Both ends of the span come behind these.
    if size == 0.0 or n + 4 > bends.shape[0]:
        return n
    c, s, away = c / size, s / size, -rest / size
    # Along the line, from its foot: square x^2 + slope x + start.
    square, slope = curve_[0], curve_[2] * c - curve_[1] * s
    start = square * away * away + (curve_[1] * c + curve_[2] * s) * away + curve_[3]
    under = slope * slope - 4.0 * square * start
    if under < 0.0:
        return n
    sum_ = -0.5 * (slope + math.copysign(math.sqrt(under), slope))
    if sum_ != 0.0:
        n = add_bend(most * math.hypot(away, start / sum_), span, bends, n)
    if square != 0.0:
        n = add_bend(most * math.hypot(away, sum_ / square), span, bends, n)
    return n


@kernel
def bends_of_crossings(P, place_, span, curves, bends):
    """Fill in the sorted bends at which limits cross, begin or end, those of the span included; their number.

    Between two neighbours of them no interval of arm angles appears, parts or goes.
    """
    m, n, most = 0, 0, span[1]
    for elbow in range(2):
        n = add_elbow(P, place_, elbow, span, bends, n)
        flat, bent = elbow_side(P, bent_place(place_, 0.0), elbow), elbow_side(P, bent_place(place_, most), elbow)
        m = add_curves(P, SHOULDER, (flat[1], bent[1]), elbow, curves, m)
        m = add_curves(P, WRIST, (flat[2], bent[2]), elbow, curves, m)
    for i in range(m):
        a = read_curve(curves, i)
        # The points of a curve closest to the origin and farthest from it are on the line through that and its centre.
        n = add_meetings(a, (-a[2], a[1], 0.0), most, span, bends, n)
        for j in range(i + 1, m):
            b = read_curve(curves, j)
            if a[0] == 0.0 and b[0] == 0.0:
                n = add_meetings(a, (b[1], b[2], b[3]), most, span, bends, n)
            else:
                line = b[0] * a[1] - a[0] * b[1], b[0] * a[2] - a[0] * b[2], b[0] * a[3] - a[0] * b[3]
                n = add_meetings(a if a[0] != 0.0 else b, line, most, span, bends, n)
    return insert(span[1], bends, insert(span[0], bends, n))
