"""Bends of an elbow as good as flat at which something changes, at one arm angle or over all of them.

A small bend turns the upper arm by a part of it. So at one arm angle every vector that the shoulder or the wrist has to
turn moves with the bend, on a line that is straight but for the square of it, and a joint reaches a limit where one
linear form vanishes. Over all arm angles, there are the bends at which the outer axes of the shoulder or the wrist come
into line.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.vectors import (
    across,
    add,
    apply,
    apply_transposed,
    cross,
    dot,
    load3,
    norm,
    rotate,
    scale,
    sub,
)
from srs_ik.kernels.exact.bends import bent_place
from srs_ik.kernels.exact.events import NEXT_TO_END, beyond_middle, end_of_middle, end_of_reach, insert, short_of_end
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import (
    A1,
    A1_A2,
    A2_A3,
    A3,
    AXES,
    BOTTOM_GAP,
    BOUND_1_LOWER,
    BOUND_2_LOWER,
    BOUND_3_LOWER,
    FIRST_JOINT,
    LOWER,
    RANGE_KIND,
    SHOULDER,
    SLACK_LIMIT,
    SLACK_REACH,
    TOP_GAP,
    UPPER,
    WRIST,
)
from srs_ik.kernels.limb.limits import turn_to_middle
from srs_ik.kernels.limb.triangle import (
    elbow_at,
    elbow_side,
    shoulder_columns,
    side_frames,
    turned_frame,
    wrist_columns,
)

MOST_EVENTS = 38
"""Most bends at which anything changes at an arm angle: 17 each of shoulder and wrist, two of the elbow, two ends."""

LIMITS = 6
ENDS = LIMITS + 2
"""Limits of a spherical joint; with them, both ends of the reach of oblique axes."""

MOST_CURVES = 64
MOST_CROSSINGS = 512
"""Curves of limits in the plane of bend and arm angle, and bends at which two of them cross, at most."""

SECANTS = 3
"""Steps towards a bend that brings outer axes into line."""


@kernel
def to_be_turned(P, place_, elbow, cos_psi, sin_psi):
    """What limits ask of the rotations R of shoulder and wrist at one arm angle: R a3 and R'a1, of each."""
    base, arm, c4, s4 = side_frames(P, place_, elbow, cos_psi, sin_psi)
    v_s, _ = shoulder_columns(P, base, arm)
    r_s = turned_frame(arm, base, load3(P, SHOULDER + A1))
    v_w, _ = wrist_columns(P, place_, base, arm, c4, s4)
    before = turned_frame(base, arm, rotate(load3(P, AXES + 9), c4, s4, load3(P, WRIST + A1)))
    return (v_s, r_s), (v_w, apply_transposed(place_[4], before))


@kernel
def add_bend(x, span, bends, n):
    """Insert a bend into the sorted first n, if it lies between both of a span; return how many they are then."""
    return insert(x, bends, n) if span[0] < x < span[1] else n


@kernel
def along_span(span, part):
    """The bend at a part of the way from the smallest to the largest."""
    return span[0] + part * (span[1] - span[0])


@kernel
def add_crossing(form, value, curve, span, bends, n):
    """Insert the bends at which a vector on a curve has the product `value` with a form."""
    return add_roots_of_bend(dot(form, curve[0]) - value, dot(form, curve[1]), dot(form, curve[2]), span, bends, n)


@kernel
def add_roots_of_bend(rest, slope, square, span, bends, n):
    """Insert the bends, as a part of the way along their span, at which rest + slope x + square x^2 = 0."""
    under = slope * slope - 4.0 * square * rest
    if under < 0.0:
        return n
    sum_ = -0.5 * (slope + math.copysign(math.sqrt(under), slope))
    if sum_ != 0.0:
        n = add_bend(along_span(span, rest / sum_), span, bends, n)
    return add_bend(along_span(span, sum_ / square), span, bends, n) if square != 0.0 else n


@kernel
def limit_form(P, k, i):
    """A limit of the spherical joint at block k, lower and upper of each of its joints in turn, as a linear form.

    The last two are the ends of the reach of oblique axes. Returns the form, its value on the limit, whether it is one
    of R'a1 and not of R a3, and whether there is a limit.
    """
    joint, end = i // 2, i % 2
    if i >= LIMITS:
        axis, gap = end_of_reach(P, k, end)
        return axis, 1.0 - gap, False, gap > 0.0
    there = P[RANGE_KIND + int(P[k + FIRST_JOINT]) + joint] != 0.0
    if joint == 0:
        return load3(P, k + BOUND_1_LOWER + 3 * end), P[k + A2_A3], False, there
    if joint == 1:
        return load3(P, k + A1), P[k + BOUND_2_LOWER + end], False, there
    return load3(P, k + BOUND_3_LOWER + 3 * end), P[k + A1_A2], True, there


@kernel
def beyond_middle_along(P, k, end, curve):
    """`beyond_middle` along a curve of unit vectors: a constant, a linear and a square part."""
    a1, value = load3(P, k + A1), P[k + BOUND_2_LOWER + end]
    if abs(value) < NEXT_TO_END:
        return dot(a1, curve[0]) - value, dot(a1, curve[1]), dot(a1, curve[2])
    way, gap = end_of_middle(P, k, end)
    rest, slope, square = short_of_end_along(scale(way, a1), gap, curve)
    return way * rest, way * slope, way * square


@kernel
def short_of_end_along(axis, gap, curve):
    """`short_of_end` along a curve of unit vectors: a constant, a linear and a square part."""
    off = sub(axis, curve[0])
    return (
        short_of_end(axis, gap, curve[0], 0.0),
        dot(off, curve[1]),
        dot(off, curve[2]) - 0.5 * dot(curve[1], curve[1]),
    )


@kernel
def ease_of_reach(P, gap):
    """By how much a cosine may be out of the reach of oblique axes and count as at its end, with room for rounding."""
    return 0.5 * P[SLACK_REACH] * math.sqrt(2.0 * gap)


@kernel
def add_joint(P, k, v, r, span, bends, n):
    """Insert the bends at which the spherical joint at block k reaches a limit, the end of its reach or a singularity.

    v and r are the curves of R a3 and R'a1 from the smallest bend to the largest.
    """
    a1 = load3(P, k + A1)
    for i in range(LIMITS):
        form, value, of_r, there = limit_form(P, k, i)
        if there and i // 2 == 1:
            rest, slope, square = beyond_middle_along(P, k, i % 2, v)
            n = add_roots_of_bend(rest, slope, square, span, bends, n)
        elif there:
            n = add_crossing(form, value, r if of_r else v, span, bends, n)
    for end in range(2):
        axis, gap = end_of_reach(P, k, end)
        rest, slope, square = short_of_end_along(axis, gap - ease_of_reach(P, gap), v)
        n = add_roots_of_bend(rest, slope, square, span, bends, n)
    beside, way = across(v[0], a1), across(v[1], a1)
    square = dot(way, way)
    return add_bend(along_span(span, -dot(beside, way) / square), span, bends, n) if square > 0.0 else n


@kernel
def add_elbow(P, place_, elbow, span, bends, n):
    """Insert the bends beyond which the elbow itself leaves its limits."""
    c4, s4, _ = elbow_at(P, bent_place(place_, 0.0), elbow)
    q4 = turn_to_middle(P, 3, math.atan2(s4, c4))
    way = 1.0 if (elbow == 0) == (place_[2] > 0.0) else -1.0
    n = add_bend(way * (P[UPPER + 3] + P[SLACK_LIMIT] - q4), span, bends, n)
    return add_bend(way * (P[LOWER + 3] - P[SLACK_LIMIT] - q4), span, bends, n)


@kernel
def curve(start, middle, end):
    """A parabola through three vectors, as a constant, a linear and a square part of 0 to 1."""
    bow = add(add(start, end), scale(-2.0, middle))
    return start, sub(sub(end, start), scale(2.0, bow)), scale(2.0, bow)


@kernel
def bends_at(P, place_, psi, elbow, span, bends):
    """Fill in the sorted bends at which anything changes at one arm angle, those of the span included; their number.

    Args:
        P: packed limb.
        place_: a pose whose elbow is as good as flat.
        psi: the arm angle, rad.
        elbow: side of the elbow, 0 or 1.
        span: sines of the smallest and the largest bend.
        bends: (MOST_EVENTS,) output.
    """
    c, s = math.cos(psi), math.sin(psi)
    s_0, w_0 = to_be_turned(P, bent_place(place_, span[0]), elbow, c, s)
    s_1, w_1 = to_be_turned(P, bent_place(place_, along_span(span, 0.5)), elbow, c, s)
    s_2, w_2 = to_be_turned(P, bent_place(place_, span[1]), elbow, c, s)
    n = add_joint(P, SHOULDER, curve(s_0[0], s_1[0], s_2[0]), curve(s_0[1], s_1[1], s_2[1]), span, bends, 0)
    n = add_joint(P, WRIST, curve(w_0[0], w_1[0], w_2[0]), curve(w_0[1], w_1[1], w_2[1]), span, bends, n)
    n = add_elbow(P, place_, elbow, span, bends, n)
    return insert(span[1], bends, insert(span[0], bends, n))


@kernel
def angle_between(a, b):
    """Angle between two vectors, rad, with all digits where it is small."""
    return math.atan2(norm(cross(a, b)), dot(a, b))


@kernel
def apart(P, place_, k, elbow, x):
    """How much farther one outer axis of a spherical joint is from the line S-W than the other, at a bend, rad."""
    t, _, _, _, hand, _ = place_
    c4, s4, (arm_t, _, _) = elbow_at(P, bent_place(place_, x), elbow)
    if k == SHOULDER:
        return angle_between(arm_t, load3(P, k + A3)), angle_between(t, load3(P, k + A1))
    moving = rotate(load3(P, AXES + 9), c4, s4, load3(P, k + A1))
    return angle_between(arm_t, moving), angle_between(t, apply(hand, load3(P, k + A3)))


@kernel
def off_line(P, place_, k, elbow, end, x):
    """By how much outer axes miss one line at the best arm angle, at a bend: same way (end 0) or opposite ways (1)."""
    moving, still = apart(P, place_, k, elbow, x)
    return moving - (still if end == 0 else math.pi - still)


@kernel
def bend_in_line(P, place_, k, elbow, end, span):
    """The bend in a span at which outer axes of a spherical joint come closest to one line; -1 where none is.

    The end says whether they point the same way there (0) or opposite ways (1).
    """
    if P[k + (TOP_GAP if end == 0 else BOTTOM_GAP)] != 0.0:
        return -1.0
    x0, x1 = span
    y0, y1 = off_line(P, place_, k, elbow, end, x0), off_line(P, place_, k, elbow, end, x1)
    if y0 * y1 > 0.0 and min(abs(y0), abs(y1)) > 4.0 * span[1]:
        return -1.0
    best, least = (x0, abs(y0)) if abs(y0) < abs(y1) else (x1, abs(y1))
    for _ in range(SECANTS):
        if y1 == y0:
            break
        x0, x1 = x1, min(max(x1 - y1 * (x1 - x0) / (y1 - y0), span[0]), span[1])
        y0, y1 = y1, off_line(P, place_, k, elbow, end, x1)
        if abs(y1) < least:
            best, least = x1, abs(y1)
    return best


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
