"""The best way through the strips of a path's poses: fewest breaks, then least sum of squared joint steps.

Dynamic programming over the postures of the strips, which may come from anywhere between two postures of the pose
before, not from these alone: there, joint angles are taken as straight lines and the cost so far as a parabola, so the
best place is known in closed form, and coarse strips make no coarse path. Only distances of joints count, so a path
passes singularities, where branches meet, like any other place.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.path import (
    BREAK,
    BY_CONTINUITY,
    BY_VELOCITY,
    IMPOSSIBLE,
    INVERSE_PERIOD,
    INVERSE_SPEED,
    NODE_SAG,
    NODE_WAY,
    PERIOD,
    POWER,
    STRIP_FIRST,
    STRIP_LAST,
    STRIP_LEAST,
    TOO_FAST,
    Rules,
)
from srs_ik.kernels.path.followed import along_cell

CUTS = 24
"""Steps of the search for the least time between two postures."""


@kernel
def step_of(settings, j, a, b):
    """Joint step from a to b; the shorter way round for a joint that turns without end."""
    d = b - a
    return d - settings[PERIOD, j] * math.floor(d * settings[INVERSE_PERIOD, j] + 0.5)


@kernel
def steps_between(settings, a, b):
    """The seven joint steps from a to b."""
    return (
        step_of(settings, 0, a[0], b[0]),
        step_of(settings, 1, a[1], b[1]),
        step_of(settings, 2, a[2], b[2]),
        step_of(settings, 3, a[3], b[3]),
        step_of(settings, 4, a[4], b[4]),
        step_of(settings, 5, a[5], b[5]),
        step_of(settings, 6, a[6], b[6]),
    )


@kernel
def largest(e):
    """Largest joint step."""
    return max(max(max(abs(e[0]), abs(e[1])), max(abs(e[2]), abs(e[3]))), max(max(abs(e[4]), abs(e[5])), abs(e[6])))


@kernel
def product(a, b):
    """Scalar product of joint steps."""
    return ((a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])) + ((a[4] * b[4] + a[5] * b[5]) + a[6] * b[6])


@kernel
def kept(e, d, t0, t1, settings, kind):
    """The part of t0 to t1 in which no step of e - t d is too long; empty if its end is below its begin."""
    for j in range(7):
        longest = settings[kind, j]
        x, y = e[j], d[j]
        if abs(x) <= longest and abs(x - y) <= longest:
            continue
        if abs(y) < 1e-12:
            if abs(x) > longest * (1.0 + 1e-9):
                return 1.0, 0.0
            continue
        one, other = (x - longest) / y, (x + longest) / y
        t0 = max(t0, min(one, other))
        t1 = min(t1, max(one, other))
    return t0, t1


@kernel
def step_value(settings, e, share):
    """What a step counts: its squares, for all joints together, or a power of the time that the slowest joint takes."""
    if settings[INVERSE_SPEED, 0] == 0.0:
        return share * product(e, e)
    longest = 0.0
    for j in range(7):
        longest = max(longest, abs(e[j]) * settings[INVERSE_SPEED, j])
    return longest if settings[POWER, 0] == 1.0 else longest ** settings[POWER, 0]


@kernel
def step_cost(e, d, ends, t0, t1, rules):
    """Least of va + t (vb - va) - sag t (1 - t) and the value of the step e - t d, t from t0 to t1, and where it is."""
    va, vb, sag = ends
    if rules.settings[INVERSE_SPEED, 0] != 0.0:
        return quickest(e, d, va, vb, t0, t1, rules.settings)
    share = rules.share
    size = product(d, d) * share
    across = product(e, d) * share
    slope = across + 0.5 * (sag - (vb - va))
    t = t0
    if size + sag > 1e-18:
        t = min(max(slope / (size + sag), t0), t1)
    elif slope > 0.0:
        t = t1
    return va + t * (vb - va) - sag * t * (1.0 - t) + share * product(e, e) - t * (2.0 * across - t * size), t


@kernel
def quickest(e, d, va, vb, t0, t1, settings):
    """`step_cost` for the time, which is convex in t: by cutting off a third each time."""
    for _ in range(CUTS):
        left, right = t0 + (t1 - t0) / 3.0, t1 - (t1 - t0) / 3.0
        at_left = left * (vb - va) + step_value(settings, moved_on(e, d, left), 1.0)
        if at_left <= right * (vb - va) + step_value(settings, moved_on(e, d, right), 1.0):
            t1 = right
        else:
            t0 = left
    t = 0.5 * (t0 + t1)
    return va + t * (vb - va) + step_value(settings, moved_on(e, d, t), 1.0), t


@kernel
def moved_on(e, d, t):
    """The steps e - t d."""
    return (
        e[0] - t * d[0],
        e[1] - t * d[1],
        e[2] - t * d[2],
        e[3] - t * d[3],
        e[4] - t * d[4],
        e[5] - t * d[5],
        e[6] - t * d[6],
    )


@kernel
def try_cell(e, a, b, ends, rules, found, place):
    """Step from between two postures a and b of a strip, e being that from a: least cost and its place, if better.

    `ends` are the costs of both, and by how much those between sag; `found` the least cost so far and its place.
    """
    va, vb, sag = ends
    settings = rules.settings
    d = along_cell(a, b)
    t0, t1 = 0.0, 1.0
    if vb > va + 0.5 * TOO_FAST:
        # Only one end belongs to the better ways.
        t1, vb = 0.0, va
    elif va > vb + 0.5 * TOO_FAST:
        t0, va = 1.0, vb
    t0, t1 = kept(e, d, t0, t1, settings, BY_CONTINUITY)
    if t0 > t1:
        return found
    extra = 0.0
    if rules.limited:
        slow0, slow1 = kept(e, d, t0, t1, settings, BY_VELOCITY)
        if slow0 <= slow1:
            t0, t1 = slow0, slow1
        else:
            extra = TOO_FAST
    value, t = step_cost(e, d, (va, vb, sag), t0, t1, rules)
    if extra > 0.0:
        over = 0.0
        for j in range(7):
            over = max(over, abs(e[j] - t * d[j]) / settings[BY_VELOCITY, j])
        value += extra * over
    return (value, place + t) if value < found[0] else found


@kernel
def reach_of(strips, strip, rules, least):
    """How far apart joints may be, rad, for a step from a strip to be continuous, and cheaper than what is known."""
    reach = rules.settings[BY_CONTINUITY, 0]
    if rules.settings[INVERSE_SPEED, 0] != 0.0:
        return reach
    room = least - strips[strip, STRIP_LEAST]
    return math.sqrt(max(room, 0.0) / rules.share) if room < rules.share * reach * reach else reach


@kernel
def is_beyond(q, strip, reach, settings):
    """Whether a posture is farther than that from all postures of a strip."""
    for k in range(7):
        j = (3, 1, 5, 0, 2, 4, 6)[k]
        off = abs(step_of(settings, j, 0.5 * (strip[j] + strip[7 + j]), q[j]))
        if off > reach + 0.5 * (strip[7 + j] - strip[j]):
            return True
    return False


@kernel
def try_strip(q, sheet, strip, rules, found):
    """The cheapest way to a posture q from a strip of the pose before, if better: cost, and place (row and part).

    Postures that are too far away are skipped by their distance: none moves on faster than the strip is long.
    """
    nodes, cost, settings = sheet.nodes, sheet.cost, rules.settings
    first, last = int(sheet.strips[strip, STRIP_FIRST]), int(sheet.strips[strip, STRIP_LAST])
    if sheet.strips[strip, STRIP_LEAST] >= found[0]:
        return found
    reach = reach_of(sheet.strips, strip, rules, found[0])
    if is_beyond(q, row(sheet.strips, strip), reach, settings):
        return found
    i = first
    while i <= last:
        following = min(i + 1, last)
        sag = nodes[i, NODE_SAG] if following > i else 0.0
        if min(cost[i], cost[following]) - 0.25 * sag >= found[0]:
            i += 1
            continue
        e = steps_between(settings, row(nodes, i), q)
        distance = largest(e)
        if distance > reach:
            way = nodes[i, NODE_WAY] + (distance - reach)
            if nodes[last, NODE_WAY] < way:
                break
            if nodes[following, NODE_WAY] <= way and following > i:
                i = following
                while i < last and nodes[i + 1, NODE_WAY] <= way:
                    i += 1
                continue
        ends = (cost[i], cost[following], sag)
        better = try_cell(e, row(nodes, i), row(nodes, following), ends, rules, found, float(i))
        if better[0] < found[0]:
            found = better
            reach = reach_of(sheet.strips, strip, rules, found[0])
        i += 1
    return found


@kernel
def boxes_meet(a, b, settings):
    """Whether two strips may have postures no farther apart than a continuous step."""
    reach = settings[BY_CONTINUITY, 0]
    for k in range(7):
        j = (3, 1, 5, 0, 2, 4, 6)[k]
        middle = step_of(settings, j, 0.5 * (a[j] + a[7 + j]), 0.5 * (b[j] + b[7 + j]))
        if abs(middle) > reach + 0.5 * ((a[7 + j] - a[j]) + (b[7 + j] - b[j])):
            return False
    return True


@kernel
def leap(q, sheet, first, last, settings, found):
    """A break on the way to a posture q: from anywhere among rows first to last - 1, the nearest one if they cost."""
    for i in range(first, last):
        if sheet.cost[i] + BREAK < found[0]:
            e = steps_between(settings, row(sheet.nodes, i), q)
            value = sheet.cost[i] + BREAK + step_value(settings, e, 1.0)
            if value < found[0]:
                found = (value, float(i))
    return found


@kernel
def cheapest(cost, first, last):
    """The cheapest of the rows first to last - 1."""
    best = first
    for i in range(first + 1, last):
        if cost[i] < cost[best]:
            best = i
    return best


@kernel
def scale_settings(settings, between, scaled):
    """Write the settings for a step over so many poses: as many times as fast, and twice as far at most."""
    for j in range(7):
        scaled[BY_VELOCITY, j] = settings[BY_VELOCITY, j] * between
        scaled[BY_CONTINUITY, j] = settings[BY_CONTINUITY, j] * min(between, 2)


@kernel
def rules_for(settings, scaled, between, limited):
    """What a step over so many poses counts; `scaled` are the settings with room for its speeds."""
    scale_settings(settings, between, scaled)
    return Rules(scaled, limited, 1.0 / between)


@kernel
def first_costs(sheet, span, seed, settings):
    """Costs of the postures of a first pose: squared joint steps from the seed, if there is one."""
    nodes, cost = sheet.nodes, sheet.cost
    for i in range(span.first, span.last):
        cost[i] = 0.0
        nodes[i, NODE_SAG] = 0.0
        if seed is not None:
            if i + 1 < span.last and settings[INVERSE_SPEED, 0] == 0.0:
                d = along_cell(row(nodes, i), row(nodes, i + 1))
                nodes[i, NODE_SAG] = product(d, d)
            e = steps_between(settings, seed, row(nodes, i))
            cost[i] = step_value(settings, e, 1.0) + (BREAK if largest(e) > settings[BY_CONTINUITY, 0] else 0.0)
    write_least(sheet, span)


@kernel
def origin_step(nodes, settings, i, place):
    """The steps to a posture from its place among those of the pose before."""
    k = math.floor(place)
    e = steps_between(settings, row(nodes, k), row(nodes, i))
    if place == k:
        return e
    return moved_on(e, along_cell(row(nodes, k), row(nodes, k + 1)), place - k)


@kernel
def write_sags(sheet, places, span, rules):
    """How far the costs between two postures of a strip lie below their straight line: by the change of their slope.

    The slope at a posture is twice the step to it. Costs that come from a step turn up no faster than its square.
    """
    nodes, cost, strips, settings = sheet.nodes, sheet.cost, sheet.strips, rules.settings
    for b in range(span.first_strip, span.last_strip):
        first, last = int(strips[b, STRIP_FIRST]), int(strips[b, STRIP_LAST])
        for i in range(first, last + 1):
            nodes[i, NODE_SAG] = 0.0
        if settings[INVERSE_SPEED, 0] != 0.0:
            continue
        for i in range(first, last):
            at, following = places[i - span.first], places[i + 1 - span.first]
            if at < 0.0 or following < 0.0 or abs(cost[i + 1] - cost[i]) > 0.5 * TOO_FAST:
                continue
            d = along_cell(row(nodes, i), row(nodes, i + 1))
            turn = product(origin_step(nodes, settings, i + 1, following), d)
            turn -= product(origin_step(nodes, settings, i, at), d)
            nodes[i, NODE_SAG] = rules.share * min(max(turn, 0.0), product(d, d))


@kernel
def write_least(sheet, span):
    """What no posture of each strip costs less than."""
    for b in range(span.first_strip, span.last_strip):
        least = IMPOSSIBLE
        for i in range(int(sheet.strips[b, STRIP_FIRST]), int(sheet.strips[b, STRIP_LAST]) + 1):
            least = min(least, sheet.cost[i] - 0.25 * sheet.nodes[i, NODE_SAG])
        sheet.strips[b, STRIP_LEAST] = least


@kernel
def advance(sheet, before, now, rules, exact):
    """Costs of the postures of a pose, span `now`, from those of the pose before.

    Unless `exact`, breaks come from the cheapest posture alone, and strips that need one more break than it go on
    nowhere: a break there is as good.
    """
    nodes, cost, strips = sheet.nodes, sheet.cost, sheet.strips
    places = np.full(now.last - now.first, -1.0)
    for i in range(now.first, now.last):
        cost[i] = IMPOSSIBLE
    start = cheapest(cost, before.first, before.last)
    least = cost[start] + BREAK
    for b in range(now.first_strip, now.last_strip):
        for a in range(before.first_strip, before.last_strip):
            if strips[a, STRIP_LEAST] >= (IMPOSSIBLE if exact else least):
                continue
            if not boxes_meet(row(strips, a), row(strips, b), rules.settings):
                continue
            for i in range(int(strips[b, STRIP_FIRST]), int(strips[b, STRIP_LAST]) + 1):
                k = i - now.first
                cost[i], places[k] = try_strip(row(nodes, i), sheet, a, rules, (cost[i], places[k]))
    if exact or cost[cheapest(cost, now.first, now.last)] > least:
        first, last = (before.first, before.last) if exact else (start, start + 1)
        for i in range(now.first, now.last):
            if cost[i] > least:
                before_leap = cost[i]
                cost[i], _ = leap(row(nodes, i), sheet, first, last, rules.settings, (cost[i], 0.0))
                if cost[i] < before_leap:
                    places[i - now.first] = -1.0
    write_sags(sheet, places, now, rules)
    write_least(sheet, now)


@kernel
def step_back(q, sheet, before, rules):
    """The best place of the pose before on the way to a posture q: cost, row and part of the way to the next row."""
    found = (IMPOSSIBLE, -1.0)
    for a in range(before.first_strip, before.last_strip):
        found = try_strip(q, sheet, a, rules, found)
    return leap(q, sheet, before.first, before.last, rules.settings, found)
