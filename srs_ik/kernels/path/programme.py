"""A joint path for a sequence of poses, chosen over the whole sequence at once.

Every pose has a grid of postures: two elbow sides, a set of arm angles, two shoulder and two wrist solutions. Dynamic
programming finds the sequence with the fewest breaks and then the least sum of squared joint steps; shoulder and wrist
steps add up, so the sixteen ways from one arm angle to another cost eight distances. Arm angles are counted from a
direction that is carried along the path, so that the documented zero may be singular on the way without harm.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.vectors import across, cross, norm, swing
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import RANGE_KIND, SHOULDER, SLACK_SINGULAR, WRIST
from srs_ik.kernels.limb.limits import TURN, turn_to_middle, violation
from srs_ik.kernels.limb.spherical import angles, default_anchor, middle_angle
from srs_ik.kernels.limb.triangle import arm_angle_of_direction, elbow_side, target_frame, unit_across

GRID = 24
"""Arm angles that are the same for every pose."""

EXTRA = 8
"""Arm angles of a pose of its own: one for each feasible interval that the grid misses."""

SLOTS = GRID + EXTRA

AGILITY = 3.0
"""The arm angle may change by one grid step, and so many times as much as the pose turns, from one pose to the next."""

NEARLY_STRAIGHT = 0.35
STRAIGHTER = 0.05
"""Sines of the bend under which the elbow may change sides: at most, and between two poses that hardly differ."""

BREAK = 1e6
"""Cost of a step that is too long to be continuous."""

TOO_FAST = 1e3
"""Cost of a step above a velocity limit."""

IMPOSSIBLE = 1e15

NONE = 0.0
FIXED = 1.0
FREE_SUM = 2.0
FREE_DIFFERENCE = 3.0
"""Marks of a half posture: there is none; determined; only q1 + q3, or q3 - q1, is determined."""


@kernel
def carry(t, zero, fresh):
    """The direction of arm angle zero, carried from the pose before to the S-W direction t; fresh if it vanishes."""
    if norm(across(zero, t)) < 1e-6:
        return fresh
    return unit_across(zero, t, fresh)


@kernel
def carried_angle(P, sw, zero):
    """Carried zero direction of a pose, and the arm angle at which it lies."""
    _, t, h0 = target_frame(P, sw)
    z = carry(t, zero, h0)
    return z, arm_angle_of_direction(t, h0, z)


@kernel
def half_states(P, k, first, motion, psi, out):
    """Write both solutions of a spherical joint at an arm angle into out (2, 4): three angles and a mark."""
    c = math.cos(psi)
    s = math.sin(psi)
    v0, y0, _ = motion
    v = swing(v0[0], v0[1], v0[2], c, s)
    y = swing(y0[0], y0[1], y0[2], c, s)
    cm, sm, reached = middle_angle(P, k, v)
    for sign in range(2):
        q = angles(P, k, v, y, cm, sm, sign, default_anchor(P, k))
        mark = FIXED if reached else NONE
        for j in range(3):
            angle = turn_to_middle(P, first + j, q[j])
            out[sign, j] = angle
            if violation(P, first + j, angle) > 0.0:
                mark = NONE
        if mark == FIXED and sm < P[SLACK_SINGULAR]:
            mark = FREE_SUM if cm > 0.0 else FREE_DIFFERENCE
        out[sign, 3] = mark


@kernel
def fill_states(P, place_, zero_angle, slots, count, shoulder, wrist, elbow):
    """Fill in all states of a pose: shoulder and wrist (2, SLOTS, 2, 4), elbow (2, 2) as q4 and a mark."""
    for e in range(2):
        q4, motion_s, motion_w, _ = elbow_side(P, place_, e)
        q4 = turn_to_middle(P, 3, q4)
        elbow[e, 0] = q4
        elbow[e, 1] = NONE if violation(P, 3, q4) > 0.0 else FIXED
        for k in range(count):
            psi = slots[k] + zero_angle
            half_states(P, SHOULDER, 0, motion_s, psi, shoulder[e, k])
            half_states(P, WRIST, 4, motion_w, psi, wrist[e, k])


@kernel
def add_missed(found, n, zero_angle, slots):
    """Append to the grid the middle of each feasible interval that it misses; return the number of slots."""
    count = GRID
    step = TURN / GRID
    for i in range(n):
        lower = found[i, 1] - zero_angle
        upper = found[i, 2] - zero_angle
        if math.ceil((lower + math.pi) / step) * step - math.pi > upper and count < SLOTS:
            middle = 0.5 * (lower + upper)
            slots[count] = middle - TURN * math.floor((middle + math.pi) / TURN)
            count += 1
    return count


@kernel
def difference(P, joint, a, b):
    """Joint step from a to b; the shorter way round for a joint that turns without end."""
    d = b - a
    if P[RANGE_KIND + joint] == 0.0:
        d -= TURN * math.floor(d / TURN + 0.5)
    return d


@kernel
def step_cost(joint, d, longest):
    """Squared step of one joint, with the penalty of a step beyond the longest continuous one or its velocity."""
    size = abs(d)
    value = d * d
    if size > longest[1, joint]:
        value += BREAK
    elif size > longest[0, joint]:
        value += TOO_FAST * (size / longest[0, joint])
    return value


@kernel
def half_distance(P, first, a, b, longest):
    """Cost of a step between two states of a spherical joint."""
    if a[3] == NONE or b[3] == NONE:
        return IMPOSSIBLE
    d1 = difference(P, first, a[0], b[0])
    d2 = difference(P, first + 1, a[1], b[1])
    d3 = difference(P, first + 2, a[2], b[2])
    mark = max(a[3], b[3])
    if mark != FIXED:
        # One of the two can be moved freely along the null direction: only the rest of the step counts.
        toward = 1.0 if mark == FREE_SUM else -1.0
        rest = toward * d1 + d3
        rest = 0.5 * (rest - TURN * math.floor(rest / TURN + 0.5))
        d1 = toward * rest
        d3 = rest
    total = d1 * d1 + d2 * d2 + d3 * d3
    if total < longest[2, 0]:
        return total
    return step_cost(first, d1, longest) + step_cost(first + 1, d2, longest) + step_cost(first + 2, d3, longest)


@kernel
def state_number(e, k, s, w):
    """Number of a state: elbow side, slot, shoulder and wrist solution."""
    return ((e * SLOTS + k) * 2 + s) * 2 + w


@kernel
def pose_change(place0, place1):
    """How much a pose differs from another as the arm sees it, rad: direction S-W, bend, and hand."""
    t0, _, c0, s0, hand0, _ = place0
    t1, _, c1, s1, hand1, _ = place1
    trace = 0.0
    for i in range(9):
        trace += hand0[i] * hand1[i]
    turn = math.acos(min(max(0.5 * (trace - 1.0), -1.0), 1.0))
    return norm(cross(t0, t1)) + abs(c0 * s1 - s0 * c1) + turn


@kernel
def window_of(change):
    """Grid steps that the arm angle may change with a change of the pose."""
    return min(1 + int(AGILITY * change * GRID / TURN), GRID // 2)


@kernel
def half_state(states, e, k, sign):
    """A state of a spherical joint: three angles and a mark."""
    return (states[e, k, sign, 0], states[e, k, sign, 1], states[e, k, sign, 2], states[e, k, sign, 3])


@kernel
def both(states, e, k):
    """The two states of a spherical joint at a slot, and whether any of them is a posture."""
    a = half_state(states, e, k, 0)
    b = half_state(states, e, k, 1)
    return a, b, max(a[3], b[3]) > NONE


@kernel
def relax(P, e0, j, e1, k, base, before, now_s, now_w, longest, cost, best, back):
    """Try the sixteen ways from slot j on elbow side e0 to slot k on side e1, whose elbow step costs `base`.

    now_s and now_w are the pairs of half states of slot k.
    """
    s0, s1, any_s = both(before[0], e0, j)
    w0, w1, any_w = both(before[1], e0, j)
    if not (any_s and any_w):
        return
    first = state_number(e0, j, 0, 0)
    target = state_number(e1, k, 0, 0)
    s00 = base + half_distance(P, 0, s0, now_s[0], longest)
    s01 = base + half_distance(P, 0, s0, now_s[1], longest)
    s10 = base + half_distance(P, 0, s1, now_s[0], longest)
    s11 = base + half_distance(P, 0, s1, now_s[1], longest)
    for w in range(2):
        wrist = w0 if w == 0 else w1
        to_first = half_distance(P, 4, wrist, now_w[0], longest)
        to_second = half_distance(P, 4, wrist, now_w[1], longest)
        for s in range(2):
            # Shoulder and wrist steps add up: the cheaper shoulder before serves both wrists behind.
            number = first + w
            so_far = cost[number] + (s00 if s == 0 else s01)
            other = cost[number + 2] + (s10 if s == 0 else s11)
            if other < so_far:
                number, so_far = number + 2, other
            place = target + 2 * s
            if so_far + to_first < best[place]:
                best[place] = so_far + to_first
                back[place] = number
            if so_far + to_second < best[place + 1]:
                best[place + 1] = so_far + to_second
                back[place + 1] = number


@kernel
def advance(P, before, now, count0, count1, slots0, slots1, window, change_sides, longest, cost, best, back):
    """One step of the dynamic programme: costs `best` and predecessors `back` of the states of the next pose.

    With the elbow nearly straight, it may change sides from any arm angle to any.
    """
    for i in range(best.shape[0]):
        best[i] = IMPOSSIBLE
        back[i] = -1
    step = TURN / GRID
    for e1 in range(2):
        for e0 in range(2):
            if now[2][e1, 1] == NONE or before[2][e0, 1] == NONE or (e0 != e1 and not change_sides):
                continue
            base = step_cost(3, difference(P, 3, before[2][e0, 0], now[2][e1, 0]), longest)
            reach = GRID // 2 if e0 != e1 else window
            for k in range(count1):
                s0, s1, any_s = both(now[0], e1, k)
                w0, w1, any_w = both(now[1], e1, k)
                if not (any_s and any_w):
                    continue
                now_s = (s0, s1)
                now_w = (w0, w1)
                middle = round((slots1[k] + math.pi) / step)
                for i in range(-reach, reach + 1 if 2 * reach < GRID else reach):
                    j = (middle + i) % GRID
                    relax(P, e0, j, e1, k, base, before, now_s, now_w, longest, cost, best, back)
                for j in range(GRID, count0):
                    d = slots0[j] - slots1[k]
                    if abs(d - TURN * math.floor(d / TURN + 0.5)) <= (reach + 1) * step:
                        relax(P, e0, j, e1, k, base, before, now_s, now_w, longest, cost, best, back)


@kernel
def is_possible(now, e, k, s, w):
    """Whether a state is a posture inside the limits."""
    return now[2][e, 1] != NONE and now[0][e, k, s, 3] != NONE and now[1][e, k, w, 3] != NONE


@kernel
def leap(P, before, now, count1, cost, best, back):
    """Where no continuous step leads, break: from the cheapest state of the pose before to every state of this one.

    The squared distance is part of the cost, so of all breaks the shortest is preferred.
    """
    start = 0
    for i in range(cost.shape[0]):
        if cost[i] < cost[start]:
            start = i
    if cost[start] >= IMPOSSIBLE:
        return
    w0 = start % 2
    s0 = (start // 2) % 2
    j = (start // 4) % SLOTS
    e0 = start // (4 * SLOTS)
    for e in range(2):
        for k in range(count1):
            for s in range(2):
                for w in range(2):
                    number = state_number(e, k, s, w)
                    if not is_possible(now, e, k, s, w):
                        continue
                    value = cost[start] + 8.0 * BREAK
                    d = difference(P, 3, before[2][e0, 0], now[2][e, 0])
                    value += d * d
                    for i in range(3):
                        d = difference(P, i, before[0][e0, j, s0, i], now[0][e, k, s, i])
                        value += d * d
                        d = difference(P, 4 + i, before[1][e0, j, w0, i], now[1][e, k, w, i])
                        value += d * d
                    if value < best[number]:
                        best[number] = value
                        back[number] = start


@kernel
def begin(P, now, count, seeded, seed, cost):
    """Costs of the states of a first pose: squared distance from the seed, if there is one."""
    for i in range(cost.shape[0]):
        cost[i] = IMPOSSIBLE
    for e in range(2):
        for k in range(count):
            for s in range(2):
                for w in range(2):
                    if is_possible(now, e, k, s, w):
                        value = 0.0
                        if seeded:
                            d = difference(P, 3, seed[3], now[2][e, 0])
                            value = d * d
                            for i in range(3):
                                d = difference(P, i, seed[i], now[0][e, k, s, i])
                                value += d * d
                                d = difference(P, 4 + i, seed[4 + i], now[1][e, k, w, i])
                                value += d * d
                        cost[state_number(e, k, s, w)] = value


@kernel
def carried_zeros(P, sws, zeros, angles_):
    """Carry the zero direction along the whole path: its arm angle at each pose. sws holds the S-W vectors (n, 3)."""
    zero = (0.0, 0.0, 0.0)
    for i in range(sws.shape[0]):
        sw = (sws[i, 0], sws[i, 1], sws[i, 2])
        zero, angles_[i] = carried_angle(P, sw, zero)
        zeros[i, 0], zeros[i, 1], zeros[i, 2] = zero


@kernel
def may_change_sides(place0, place1, change):
    """Whether the elbow may change sides between two poses that differ by a change: it has to be nearly straight."""
    bend0 = place0[3] if place0[2] > 0.0 else 1.0
    bend1 = place1[3] if place1[2] > 0.0 else 1.0
    return max(bend0, bend1) < min(STRAIGHTER + 2.0 * change, NEARLY_STRAIGHT)
