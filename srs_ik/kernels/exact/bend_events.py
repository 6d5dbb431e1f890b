"""Bends of an elbow as good as flat at which something changes, at one arm angle or over all of them.

A small bend turns the upper arm by a part of it. So at one arm angle every vector that the shoulder or the wrist has to
turn moves with the bend, on a line that is straight but for the square of it, and a joint reaches a limit where one
linear form vanishes. Over all arm angles, there are the bends at which the outer axes of the shoulder or the wrist come
into line.
"""

import math

import numpy as np

from srs_ik.kernels.algebra.vectors import (
    across,
    add,
    angle_between,
    apply,
    apply_transposed,
    dot,
    load3,
    rotate,
    scale,
    sub,
)
from srs_ik.kernels.exact.bends import bent_place
from srs_ik.kernels.exact.events import NEXT_TO_END, end_of_middle, end_of_reach, insert, short_of_end
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import limb as at
from srs_ik.kernels.limb.limits import turn_to_middle
from srs_ik.kernels.limb.triangle import elbow_at, shoulder_columns, side_frames, turned_frame, wrist_columns

MOST_EVENTS = 128
"""Room for bends at which anything changes at an arm angle: 17 each of shoulder and wrist, two of the elbow, two ends,
and some more where oblique axes turn the arm with its bend."""

LIMITS = 6
ENDS = LIMITS + 2
"""Limits of a spherical joint; with them, both ends of the reach of oblique axes."""

TURNED = 0.1
FINE = 1e-2
"""A bend that turns the arm about the line S-W by more than this, rad, is no parabola to limits: then shorter ways are
looked at, and once more as much to both sides of what is found on them, in parts of each."""

SECANTS = 3
"""Steps towards a bend that brings outer axes into line."""


@kernel
def to_be_turned(P, place_, elbow, cos_psi, sin_psi):
    """What limits ask of the rotations R of shoulder and wrist at one arm angle: R a3 and R'a1, of each."""
    base, arm, c4, s4 = side_frames(P, place_, elbow, cos_psi, sin_psi)
    v_s, _ = shoulder_columns(P, base, arm)
    r_s = turned_frame(arm, base, load3(P, at.SHOULDER + at.A1))
    v_w, _ = wrist_columns(P, place_, base, arm, c4, s4)
    before = turned_frame(base, arm, rotate(load3(P, at.AXES + 9), c4, s4, load3(P, at.WRIST + at.A1)))
    return (v_s, r_s), (v_w, apply_transposed(place_[4], before))


@kernel
def add_bend(x, span, bends, n):
    """Insert a bend into the sorted first n, if it lies between both of a span; return how many they are then."""
    # Both ends of the span come behind these.
    return insert(x, bends, n) if span[0] < x < span[1] and n + 2 < bends.shape[0] else n


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
    there = P[at.RANGE_KIND + int(P[k + at.FIRST_JOINT]) + joint] != 0.0
    if joint == 0:
        return load3(P, k + at.BOUND_1_LOWER + 3 * end), P[k + at.A2_A3], False, there
    if joint == 1:
        return load3(P, k + at.A1), P[k + at.BOUND_2_LOWER + end], False, there
    return load3(P, k + at.BOUND_3_LOWER + 3 * end), P[k + at.A1_A2], True, there


@kernel
def beyond_middle_along(P, k, end, curve):
    """`beyond_middle` along a curve of unit vectors: a constant, a linear and a square part."""
    a1, value = load3(P, k + at.A1), P[k + at.BOUND_2_LOWER + end]
    if abs(value) < NEXT_TO_END:
        return dot(a1, curve[0]) - value, dot(a1, curve[1]), dot(a1, curve[2])
    way, gap = end_of_middle(P, k, end)
    rest, slope, square = short_of_end_along(scale(way, a1), gap, curve)
    return way * rest, way * slope, way * square


@kernel
def short_of_end_along(axis, gap, curve):
    """`short_of_end` along a curve of unit vectors: a constant, a linear and a square part, right at three of them."""
    start, slope, square = curve
    last = add(start, add(slope, square))
    first, end = short_of_end(axis, gap, start, 0.0), short_of_end(axis, gap, last, 0.0)
    middle = short_of_end(axis, gap, add(start, add(scale(0.5, slope), scale(0.25, square))), 0.0)
    bow = first + end - 2.0 * middle
    return first, end - first - 2.0 * bow, 2.0 * bow


@kernel
def ease_of_reach(P, gap):
    """By how much a cosine may be out of the reach of oblique axes and count as at its end, with room for rounding."""
    return 0.5 * P[at.SLACK_REACH] * math.sqrt(2.0 * gap)


@kernel
def add_joint(P, k, v, r, span, bends, n):
    """Insert the bends at which the spherical joint at block k reaches a limit, the end of its reach or a singularity.

    v and r are the curves of R a3 and R'a1 from the smallest bend to the largest.
    """
    a1 = load3(P, k + at.A1)
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
    n = add_bend(way * (P[at.UPPER + 3] + P[at.SLACK_LIMIT] - q4), span, bends, n)
    return add_bend(way * (P[at.LOWER + 3] - P[at.SLACK_LIMIT] - q4), span, bends, n)


@kernel
def curve(start, middle, end):
    """A parabola through three vectors, as a constant, a linear and a square part of 0 to 1."""
    bow = add(add(start, end), scale(-2.0, middle))
    return start, sub(sub(end, start), scale(2.0, bow)), scale(2.0, bow)


@kernel
def add_joints(P, place_, there, span, bends, n):
    """Insert the bends in a span at which shoulder or wrist change at an arm angle, to the first n: their number.

    On the way from the smallest bend to the largest, all that is turned goes along parabolas. `there` holds the side of
    the elbow, cosine and sine of the arm angle.
    """
    elbow, c, s = there
    s_0, w_0 = to_be_turned(P, bent_place(place_, span[0]), elbow, c, s)
    s_1, w_1 = to_be_turned(P, bent_place(place_, along_span(span, 0.5)), elbow, c, s)
    s_2, w_2 = to_be_turned(P, bent_place(place_, span[1]), elbow, c, s)
    n = add_joint(P, at.SHOULDER, curve(s_0[0], s_1[0], s_2[0]), curve(s_0[1], s_1[1], s_2[1]), span, bends, n)
    return add_joint(P, at.WRIST, curve(w_0[0], w_1[0], w_2[0]), curve(w_0[1], w_1[1], w_2[1]), span, bends, n)


@kernel
def turned_by(P, place_, elbow, span):
    """By how much the arm turns about the line S-W from one bend to another, rad."""
    _, _, (_, _, first) = elbow_at(P, bent_place(place_, span[0]), elbow)
    _, _, (_, _, last) = elbow_at(P, bent_place(place_, span[1]), elbow)
    return angle_between(first, last)


@kernel
def around_in(span, low, high, more):
    """What lies between two bends of a span, and some more of it to both sides."""
    return max(low - more, span[0]), min(high + more, span[1])


@kernel
def add_turned(P, place_, there, span, bends):
    """Fill in the bends of `add_joints` where the arm turns far with its bend; their number."""
    coarse = np.empty(MOST_EVENTS)
    n, low = 0, span[0]
    while low < span[1]:
        high = span[1]
        while turned_by(P, place_, there[0], (low, high)) > TURNED:
            high = 0.5 * (low + high)
        around = FINE * (high - low)
        m = add_joints(P, place_, there, around_in(span, low, high, around), coarse, 0)
        for i in range(m):
            n = add_joints(P, place_, there, around_in(span, coarse[i], coarse[i], around), bends, n)
        low = high
    return n


@kernel
def bends_at(P, place_, psi, elbow, span, bends):
    """Fill in the sorted bends at which anything changes at one arm angle, those of the span included; their number.

    The span are sines of the smallest and the largest bend of a pose whose elbow is as good as flat.
    """
    there = (elbow, math.cos(psi), math.sin(psi))
    if P[at.NORMAL_KIND] != 0.0 and turned_by(P, place_, elbow, span) > TURNED:
        n = add_turned(P, place_, there, span, bends)
    else:
        n = add_joints(P, place_, there, span, bends, 0)
    n = add_elbow(P, place_, elbow, span, bends, n)
    return insert(span[1], bends, insert(span[0], bends, n))


@kernel
def apart(P, place_, k, elbow, x):
    """How much farther one outer axis of a spherical joint is from the line S-W than the other, at a bend, rad."""
    t, _, _, _, hand, _ = place_
    c4, s4, (arm_t, _, _) = elbow_at(P, bent_place(place_, x), elbow)
    if k == at.SHOULDER:
        return angle_between(arm_t, load3(P, k + at.A3)), angle_between(t, load3(P, k + at.A1))
    moving = rotate(load3(P, at.AXES + 9), c4, s4, load3(P, k + at.A1))
    return angle_between(arm_t, moving), angle_between(t, apply(hand, load3(P, k + at.A3)))


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
    if P[k + (at.TOP_GAP if end == 0 else at.BOTTOM_GAP)] != 0.0:
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
