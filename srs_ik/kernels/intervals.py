"""Feasible arm angles of the eight branches, exactly: from the roots of linear forms in cosine and sine of the arm angle.

With the elbow angle fixed, every entry of the arm's rotation is linear in (1, cos psi, sin psi). A joint reaches a limit
where one linear form vanishes (method of Shimizu et al. 2008 and Faria et al. 2018, here for axes in any direction), so
the arm angles at which anything can change are known; between two of them one test decides.
"""

from __future__ import annotations

import math

from srs_ik.kernels.branches import rotations
from srs_ik.kernels.elbow import arm_frame
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import (
    A1,
    A1_A2,
    A2_A3,
    A3,
    AXES,
    BOTTOM_GAP,
    BOUND_1_LOWER,
    BOUND_1_UPPER,
    BOUND_2_LOWER,
    BOUND_2_UPPER,
    BOUND_3_LOWER,
    BOUND_3_UPPER,
    FIRST_JOINT,
    LIMITED_1,
    LIMITED_2,
    LIMITED_3,
    SHOULDER,
    SLACK_JOIN,
    TOP_GAP,
    WRIST,
)
from srs_ik.kernels.limits import turn_to_middle, violation
from srs_ik.kernels.spherical import decompose, default_anchor, middle_angle
from srs_ik.kernels.vectors import apply, cross, dot, load3, rotate

MAX_EVENTS = 18
"""Most arm angles at which one spherical joint can start or stop to be feasible."""

MAX_PIECES = 2 * MAX_EVENTS
"""Most intervals of one branch."""

TOUCH = 1e-12
"""A linear form that misses its value by less than this, relative to its swing, touches it."""

PI = math.pi
TURN = 2.0 * math.pi


@kernel
def linear_form(swing, x, y):
    """Constant, cosine and sine part of x' R(psi) y, R the rotation of the arm; swing = (t, h0, b0, arm t, h, n)."""
    t, h0, b0, arm_t, arm_h, arm_n = swing
    xh = dot(x, h0)
    xb = dot(x, b0)
    yh = dot(arm_h, y)
    yn = dot(arm_n, y)
    return dot(x, t) * dot(arm_t, y), xh * yh - xb * yn, xb * yh + xh * yn


@kernel
def add_event(psi, events, n):
    """Insert an arm angle, wrapped to [-pi, pi), into the sorted first n events."""
    psi -= TURN * math.floor((psi + PI) / TURN)
    if psi >= PI:
        psi -= TURN
    i = n
    while i > 0 and events[i - 1] > psi:
        events[i] = events[i - 1]
        i -= 1
    events[i] = psi
    return n + 1


@kernel
def add_roots(swing, x, y, value, events, n):
    """Insert the arm angles at which x' R(psi) y has a value."""
    constant, c, s = linear_form(swing, x, y)
    r = math.hypot(c, s)
    rest = value - constant
    if r < 1e-15 or abs(rest) > r * (1.0 + TOUCH):
        return n
    middle = math.atan2(s, c)
    apart = math.atan2(math.sqrt(max((r - rest) * (r + rest), 0.0)), rest)
    n = add_event(middle + apart, events, n)
    return add_event(middle - apart, events, n)


@kernel
def form_arguments(is_wrist, x, y, c4, s4, a4, hand):
    """The vectors that turn x' R_joint y into a form of the arm's rotation: R_wrist = (R_arm rot(a4, q4))' hand."""
    if is_wrist:
        return apply(hand, y), rotate(a4, c4, s4, x)
    return x, y


@kernel
def joint_events(P, k, swing, c4, s4, hand, events):
    """All arm angles at which the spherical joint at block k reaches a limit, the end of its reach, or a singularity."""
    is_wrist = k == WRIST
    a4 = load3(P, AXES + 9)
    a1 = load3(P, k + A1)
    a3 = load3(P, k + A3)
    n = 0
    if P[k + LIMITED_1] == 1.0:
        x, y = form_arguments(is_wrist, load3(P, k + BOUND_1_LOWER), a3, c4, s4, a4, hand)
        n = add_roots(swing, x, y, P[k + A2_A3], events, n)
        x, y = form_arguments(is_wrist, load3(P, k + BOUND_1_UPPER), a3, c4, s4, a4, hand)
        n = add_roots(swing, x, y, P[k + A2_A3], events, n)
    if P[k + LIMITED_3] == 1.0:
        x, y = form_arguments(is_wrist, a1, load3(P, k + BOUND_3_LOWER), c4, s4, a4, hand)
        n = add_roots(swing, x, y, P[k + A1_A2], events, n)
        x, y = form_arguments(is_wrist, a1, load3(P, k + BOUND_3_UPPER), c4, s4, a4, hand)
        n = add_roots(swing, x, y, P[k + A1_A2], events, n)
    x, y = form_arguments(is_wrist, a1, a3, c4, s4, a4, hand)
    if P[k + LIMITED_2] == 1.0:
        n = add_roots(swing, x, y, P[k + BOUND_2_LOWER], events, n)
        n = add_roots(swing, x, y, P[k + BOUND_2_UPPER], events, n)
    if P[k + TOP_GAP] > TOUCH:
        n = add_roots(swing, x, y, 1.0 - P[k + TOP_GAP], events, n)
    if P[k + BOTTOM_GAP] > TOUCH:
        n = add_roots(swing, x, y, P[k + BOTTOM_GAP] - 1.0, events, n)
    # Passing through axes 1 and 3 parallel, joints 1 and 3 jump by half a turn within the branch.
    constant, c, s = linear_form(swing, x, y)
    r = math.hypot(c, s)
    if r > 1e-15:
        if constant + r > 1.0 - TOUCH:
            n = add_event(math.atan2(s, c), events, n)
        if constant - r < TOUCH - 1.0:
            n = add_event(math.atan2(-s, -c), events, n)
    return n


@kernel
def fits(P, k, q):
    """Whether three joint angles of the spherical joint at block k have a turn inside the limits."""
    first = int(P[k + FIRST_JOINT])
    for i in range(3):
        if violation(P, first + i, turn_to_middle(P, first + i, q[i])) > 0.0:
            return False
    return True


@kernel
def feasible_signs(P, k, place_, elbow, psi):
    """Bit set of the solutions (1: first, 2: second) of the spherical joint at block k that keep the limits at psi."""
    _, Rs, Rw = rotations(P, place_, elbow, math.cos(psi), math.sin(psi))
    R = Rw if k == WRIST else Rs
    c, s, reached = middle_angle(P, k, R)
    if not reached:
        return 0
    here = default_anchor(P, k)
    first = 1 if fits(P, k, decompose(P, k, R, c, s, 0, here)) else 0
    return first | (2 if fits(P, k, decompose(P, k, R, c, s, 1, here)) else 0)


@kernel
def add_piece(pieces, sign, n, lower, upper):
    """Append an interval to the pieces of a solution."""
    pieces[sign, n, 0] = lower
    pieces[sign, n, 1] = upper
    return n + 1


@kernel
def joint_pieces(P, k, place_, elbow, swing, c4, s4, events, marks, pieces):
    """Feasible arm angles of the spherical joint at block k, as circular intervals of its two solutions.

    A full circle is the single piece (-pi, pi). Returns the number of pieces of each solution.
    """
    n = joint_events(P, k, swing, c4, s4, place_[4], events)
    if n == 0:
        signs = feasible_signs(P, k, place_, elbow, 0.0)
        n0 = add_piece(pieces, 0, 0, -PI, PI) if signs & 1 else 0
        n1 = add_piece(pieces, 1, 0, -PI, PI) if signs & 2 else 0
        return n0, n1
    for i in range(n):
        end = events[i + 1] if i + 1 < n else events[0] + TURN
        marks[i] = feasible_signs(P, k, place_, elbow, 0.5 * (events[i] + end)) if end > events[i] else 4
    # A gap of no width takes after its predecessor, so that it neither joins nor parts anything.
    for i in range(n):
        if marks[i] == 4:
            marks[i] = 4 if i == 0 else marks[i - 1]
    for i in range(n):
        if marks[i] == 4:
            marks[i] = marks[n - 1]
    counts0 = 0
    counts1 = 0
    for sign in range(2):
        bit = sign + 1
        count = 0
        start = -1
        for i in range(n):
            if marks[i] & bit and not marks[i - 1 if i > 0 else n - 1] & bit:
                start = i
                break
        if start < 0:
            if marks[0] & bit:
                count = add_piece(pieces, sign, 0, -PI, PI)
        else:
            i = 0
            while i < n:
                first = (start + i) % n
                length = 0
                while i + length < n and marks[(start + i + length) % n] & bit:
                    length += 1
                if length == 0:
                    i += 1
                    continue
                last = first + length
                upper = events[last % n] + TURN * (last // n)
                count = add_piece(pieces, sign, count, events[first], upper)
                i += length
        if count == 0 or pieces[sign, 0, 1] - pieces[sign, 0, 0] < TURN:
            for i in range(n):
                before = marks[i - 1 if i > 0 else n - 1]
                if (before | marks[i]) & bit == 0 and (i == 0 or events[i] > events[i - 1]):
                    if feasible_signs(P, k, place_, elbow, events[i]) & bit:
                        count = add_piece(pieces, sign, count, events[i], events[i])
        if sign == 0:
            counts0 = count
        else:
            counts1 = count
    return counts0, counts1


@kernel
def write_interval(out, n, branch, lower, upper):
    """Append an interval with its lower end brought to [-pi, pi)."""
    shift = TURN * math.floor((lower + PI) / TURN)
    if n < out.shape[0]:
        out[n, 0] = branch
        out[n, 1] = lower - shift
        out[n, 2] = upper - shift
        return n + 1
    return n


@kernel
def intersect(a, na, sign_a, b, nb, sign_b, slack, branch, out, n):
    """Append the arm angles feasible for both a shoulder and a wrist solution."""
    full_a = na == 1 and a[sign_a, 0, 1] - a[sign_a, 0, 0] >= TURN
    full_b = nb == 1 and b[sign_b, 0, 1] - b[sign_b, 0, 0] >= TURN
    if full_a:
        for j in range(nb):
            n = write_interval(out, n, branch, b[sign_b, j, 0], b[sign_b, j, 1])
        return n
    for i in range(na):
        if full_b:
            n = write_interval(out, n, branch, a[sign_a, i, 0], a[sign_a, i, 1])
            continue
        for j in range(nb):
            for turns in range(-1, 2):
                lower = max(a[sign_a, i, 0], b[sign_b, j, 0] + turns * TURN)
                upper = min(a[sign_a, i, 1], b[sign_b, j, 1] + turns * TURN)
                if lower <= upper:
                    n = write_interval(out, n, branch, lower, upper)
                elif lower <= upper + slack:
                    n = write_interval(out, n, branch, 0.5 * (lower + upper), 0.5 * (lower + upper))
    return n


@kernel
def feasible_intervals(P, place_, events, marks, shoulder, wrist, out):
    """Write (branch, lower, upper) of every feasible interval of arm angles into the rows of out; return their number.

    Args:
        P: packed limb; packed without limits where they are not to count (the reach of oblique axes always does).
        place_: the pose, from `branches.place`.
        events: (MAX_EVENTS,) work space.
        marks: (MAX_EVENTS,) integer work space.
        shoulder: (2, MAX_PIECES, 2) work space.
        wrist: (2, MAX_PIECES, 2) work space.
        out: (n, 3) output; 8 x MAX_PIECES rows always suffice.
    """
    t, h0, bend_c, bend_s, _, _ = place_
    n = 0
    for elbow in range(2):
        q4, _, _ = rotations(P, place_, elbow, 1.0, 0.0)
        if violation(P, 3, turn_to_middle(P, 3, q4)) > 0.0:
            continue
        arm_t, arm_h, arm_n = arm_frame(P, bend_c, bend_s if elbow == 0 else -bend_s)
        swing = (t, h0, cross(t, h0), arm_t, arm_h, arm_n)
        c4 = math.cos(q4)
        s4 = math.sin(q4)
        s = joint_pieces(P, SHOULDER, place_, elbow, swing, c4, s4, events, marks, shoulder)
        if s[0] + s[1] == 0:
            continue
        w = joint_pieces(P, WRIST, place_, elbow, swing, c4, s4, events, marks, wrist)
        for i in range(2):
            for j in range(2):
                n = intersect(shoulder, s[i], i, wrist, w[j], j, P[SLACK_JOIN], 4 * elbow + 2 * i + j, out, n)
    return n
