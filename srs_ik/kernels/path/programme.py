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
from srs_ik.kernels.path.strips import NODE_SAG, NODE_WAY, STRIP_FIRST, STRIP_LAST

BREAK = 1e10
"""Cost of a step that is too long to be continuous."""

TOO_FAST = 1e5
"""Cost of a step above a velocity limit."""

IMPOSSIBLE = 1e15

BY_VELOCITY = 0
BY_CONTINUITY = 1
PERIOD = 2
INVERSE_PERIOD = 3
INVERSE_SPEED = 4
POWER = 5
SETTINGS = 6
"""Rows of the settings of a path, seven figures each: longest steps, a turn for joints without end or zero, 1 / it.

Where the slowest joint counts in place of the squares of all: by what steps are divided, which else is zero, and the
power to which the largest one is raised.
"""

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
def along_cell(a, b):
    """The seven joint steps from one posture of a strip to the next."""
    return (b[0] - a[0], b[1] - a[1], b[2] - a[2], b[3] - a[3], b[4] - a[4], b[5] - a[5], b[6] - a[6])


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
def step_cost(e, d, va, vb, sag, t0, t1, settings, share):
    """Least of va + t (vb - va) - sag t (1 - t) and the value of the step e - t d, t from t0 to t1, and where it is."""
    if settings[INVERSE_SPEED, 0] != 0.0:
        return quickest(e, d, va, vb, t0, t1, settings)
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
def try_cell(e, a, b, ends, settings, limited, share, best, at, place):
    """Step from between two postures a and b of a strip, e being that from a: least cost and its place, if better.

    `ends` are the costs of both, and by how much those between sag.
    """
    va, vb, sag = ends
    d = along_cell(a, b)
    t0, t1 = 0.0, 1.0
    if vb > va + 0.5 * TOO_FAST:
        # Only one end belongs to the better ways.
        t1, vb = 0.0, va
    elif va > vb + 0.5 * TOO_FAST:
        t0, va = 1.0, vb
    t0, t1 = kept(e, d, t0, t1, settings, BY_CONTINUITY)
    if t0 > t1:
        return best, at
    extra = 0.0
    if limited:
        slow0, slow1 = kept(e, d, t0, t1, settings, BY_VELOCITY)
        if slow0 <= slow1:
            t0, t1 = slow0, slow1
        else:
            extra = TOO_FAST
    value, t = step_cost(e, d, va, vb, sag, t0, t1, settings, share)
    if extra > 0.0:
        over = 0.0
        for j in range(7):
            over = max(over, abs(e[j] - t * d[j]) / settings[BY_VELOCITY, j])
        value += extra * over
    if value < best:
        return value, place + t
    return best, at


@kernel
def try_strip(q, nodes, cost, first, last, settings, limited, share, best, at):
    """The cheapest way to a posture q from a strip of the pose before, if better: cost, and place (row and part).

    Postures that are too far away are skipped by their distance: none moves on faster than the strip is long.
    """
    reach = settings[BY_CONTINUITY, 0]
    i = first
    while i <= last:
        following = min(i + 1, last)
        sag = nodes[i, NODE_SAG] if following > i else 0.0
        if min(cost[i], cost[following]) - 0.25 * sag >= best:
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
        best, at = try_cell(e, row(nodes, i), row(nodes, following), ends, settings, limited, share, best, at, i)
        i += 1
    return best, at


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
def leap(q, nodes, cost, first, last, settings, best, at):
    """A break on the way to a posture q: from anywhere among rows first to last - 1, the nearest one if they cost."""
    for i in range(first, last):
        if cost[i] + BREAK < best:
            e = steps_between(settings, row(nodes, i), q)
            value = cost[i] + BREAK + step_value(settings, e, 1.0)
            if value < best:
                best, at = value, float(i)
    return best, at


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
    """Write the settings for a step over so many poses: as many times as fast."""
    for j in range(7):
        scaled[BY_VELOCITY, j] = settings[BY_VELOCITY, j] * between


@kernel
def first_costs(nodes, cost, first, last, seed, settings):
    """Costs of the postures of a first pose: squared joint steps from the seed, if there is one."""
    for i in range(first, last):
        cost[i] = 0.0
        nodes[i, NODE_SAG] = 0.0
        if seed is not None:
            if i + 1 < last and settings[INVERSE_SPEED, 0] == 0.0:
                d = along_cell(row(nodes, i), row(nodes, i + 1))
                nodes[i, NODE_SAG] = product(d, d)
            e = steps_between(settings, seed, row(nodes, i))
            cost[i] = step_value(settings, e, 1.0) + (BREAK if largest(e) > settings[BY_CONTINUITY, 0] else 0.0)


@kernel
def origin_step(nodes, settings, i, place):
    """The steps to a posture from its place among those of the pose before."""
    k = math.floor(place)
    e = steps_between(settings, row(nodes, k), row(nodes, i))
    if place == k:
        return e
    return moved_on(e, along_cell(row(nodes, k), row(nodes, k + 1)), place - k)


@kernel
def write_sags(nodes, cost, places, strips, now, settings, share):
    """How far the costs between two postures of a strip lie below their straight line: by the change of their slope.

    The slope at a posture is twice the step to it. Costs that come from a step turn up no faster than its square.
    """
    for b in range(now[2], now[3]):
        first, last = int(strips[b, STRIP_FIRST]), int(strips[b, STRIP_LAST])
        for i in range(first, last + 1):
            nodes[i, NODE_SAG] = 0.0
        if settings[INVERSE_SPEED, 0] != 0.0:
            continue
        for i in range(first, last):
            at, following = places[i - now[0]], places[i + 1 - now[0]]
            if at < 0.0 or following < 0.0 or abs(cost[i + 1] - cost[i]) > 0.5 * TOO_FAST:
                continue
            d = along_cell(row(nodes, i), row(nodes, i + 1))
            turn = product(origin_step(nodes, settings, i + 1, following), d)
            turn -= product(origin_step(nodes, settings, i, at), d)
            nodes[i, NODE_SAG] = share * min(max(turn, 0.0), product(d, d))


@kernel
def advance(nodes, cost, strips, before, now, settings, limited, share, exact):
    """Costs of the postures of a pose from those of the pose before.

    Args:
        nodes: (n, NODE) postures.
        cost: (n,) their costs.
        strips: (m, STRIP) strips.
        before: first row of the pose before in `nodes` and one behind its last, the same in `strips`.
        now: the same of this pose.
        settings: (SETTINGS, 7).
        limited: whether there are velocity limits.
        share: by which squared steps count.
        exact: whether a break may come from every posture of the pose before, or from the cheapest alone.
    """
    places = np.full(now[1] - now[0], -1.0)
    for i in range(now[0], now[1]):
        cost[i] = IMPOSSIBLE
    for b in range(now[2], now[3]):
        for a in range(before[2], before[3]):
            if not boxes_meet(row(strips, a), row(strips, b), settings):
                continue
            first, last = int(strips[a, STRIP_FIRST]), int(strips[a, STRIP_LAST])
            for i in range(int(strips[b, STRIP_FIRST]), int(strips[b, STRIP_LAST]) + 1):
                k = i - now[0]
                cost[i], places[k] = try_strip(
                    row(nodes, i), nodes, cost, first, last, settings, limited, share, cost[i], places[k]
                )
    start = cheapest(cost, before[0], before[1])
    least = cost[start] + BREAK
    if exact or cost[cheapest(cost, now[0], now[1])] > least:
        first, last = (before[0], before[1]) if exact else (start, start + 1)
        for i in range(now[0], now[1]):
            if cost[i] > least:
                before_leap = cost[i]
                cost[i], _ = leap(row(nodes, i), nodes, cost, first, last, settings, cost[i], 0.0)
                if cost[i] < before_leap:
                    places[i - now[0]] = -1.0
    write_sags(nodes, cost, places, strips, now, settings, share)


@kernel
def step_back(q, nodes, cost, strips, before, settings, limited, share):
    """The best place of the pose before on the way to a posture q: cost, row and part of the way to the next row."""
    best, at = IMPOSSIBLE, -1.0
    for a in range(before[2], before[3]):
        first, last = int(strips[a, STRIP_FIRST]), int(strips[a, STRIP_LAST])
        best, at = try_strip(q, nodes, cost, first, last, settings, limited, share, best, at)
    return leap(q, nodes, cost, before[0], before[1], settings, best, at)


@kernel
def path_cost(chain, seed, settings, limited, q):
    """Breaks, steps that are too fast, and the value of all steps of a path."""
    total = 0.0
    for c in range(chain.shape[0]):
        here = row(q, chain[c])
        between = 1
        if c > 0:
            between = chain[c] - chain[c - 1]
            e = steps_between(settings, row(q, chain[c - 1]), here)
        elif seed is not None:
            e = steps_between(settings, seed, here)
        else:
            continue
        total += step_value(settings, e, 1.0 / between)
        if largest(e) > settings[BY_CONTINUITY, 0]:
            total += BREAK
        elif limited:
            if c > 0:
                over = 0.0
                for j in range(7):
                    over = max(over, abs(e[j]) / (between * settings[BY_VELOCITY, j]))
                if over > 1.0 + 1e-9:
                    total += TOO_FAST * over
    return total
