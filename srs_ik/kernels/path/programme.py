"""The best way through the strips of a path's poses: fewest breaks, then least sum of squared joint steps.

Dynamic programming over the postures of the strips, which may come from anywhere between two postures of the pose
before, not from these alone: there, joint angles are taken as straight lines and the cost so far as a parabola, so the
best place is known in closed form, and coarse strips make no coarse path. Only distances of joints count, so a path
passes singularities, where branches meet, like any other place.
"""

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, largest
from srs_ik.kernels.algebra.lanes import LANES, as_bits, as_mask, one_of, where
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.chain.eight import highest, postures_of, rows_of
from srs_ik.kernels.curves.in_step import one_of_seven
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import path as at
from srs_ik.kernels.layout.path import Pages
from srs_ik.kernels.path.followed import along_cell
from srs_ik.kernels.path.steps import (
    are_short,
    eight_steps,
    kept,
    least_of_eight,
    product,
    step_cost,
    step_of,
    step_value,
    steps_between,
)

ROUNDING = 1e-9
"""Of a step that is just continuous, rad."""


@kernel
def cheaper_part(va, vb):
    """From where to where on the way between two postures paths may lead, and what they cost at both."""
    if vb > va + 0.5 * at.TOO_FAST:
        # Only one end belongs to the better ways.
        return 0.0, 0.0, va, va
    if va > vb + 0.5 * at.TOO_FAST:
        return 1.0, 1.0, vb, vb
    return 0.0, 1.0, va, vb


@kernel
def try_cell(e, d, ends, rules, found, place):
    """Step from between two postures of a strip, e being that from the first and d its way to the second, if better.

    `ends` are the costs of both, and by how much those between sag; `found` the least cost so far and its place.
    """
    settings = rules.settings
    t0, t1, va, vb = cheaper_part(ends[0], ends[1])
    if largest(e) + largest(d) > settings[7 * at.BY_CONTINUITY]:
        t0, t1 = kept(e, d, t0, t1, settings, at.BY_CONTINUITY)
    if t0 > t1:
        return found
    extra = 0.0
    if rules.limited:
        slow0, slow1 = kept(e, d, t0, t1, settings, at.BY_VELOCITY)
        if slow0 <= slow1:
            t0, t1 = slow0, slow1
        else:
            extra = at.TOO_FAST
    value, t = step_cost(e, d, (va, vb, ends[2]), t0, t1, rules)
    if extra > 0.0:
        over = 0.0
        for j in range(7):
            over = max(over, abs(e[j] - t * d[j]) / settings[7 * at.BY_VELOCITY + j])
        value += extra * over
    return (value, place + t) if value < found[0] else found


@kernel
def reach_of(strip, rules, least):
    """Square of how far postures may be for a step from a strip to be continuous, and cheaper than what is known."""
    longest = rules.settings[7 * at.BY_CONTINUITY]
    room = max(least - strip[at.STRIP_LEAST], 0.0)
    if rules.settings[7 * at.INVERSE_SPEED] != 0.0:
        return min(longest, room / rules.settings[7 * at.LEAST_INVERSE]) ** 2
    return min(room / rules.share, 7.0 * longest * longest)


@kernel
def is_beyond(low, high, strip, most, settings):
    """Whether what is between joint angles low and high is farther, squared, than that from all postures of a strip."""
    together = settings[7 * at.INVERSE_SPEED] == 0.0
    total = 0.0
    for k in range(7):
        j = (3, 1, 5, 0, 2, 4, 6)[k]
        off = abs(step_of(settings, j, 0.5 * (strip[j] + strip[7 + j]), 0.5 * (low[j] + high[j])))
        off -= 0.5 * ((strip[7 + j] - strip[j]) + (high[j] - low[j]))
        if off > 0.0:
            total = total + off * off if together else max(total, off * off)
            if total > most or off > settings[7 * at.BY_CONTINUITY]:
                return True
    return False


@kernel
def cell_of(pages, i, last):
    """From row i of a strip to the next: joint angles, steps, and the costs of both and how far they sag between."""
    following = min(i + 1, last)
    a = row(pages.nodes, i * at.NODE)
    sag = a[at.NODE_SAG] if following > i else 0.0
    return a, along_cell(a, row(pages.nodes, following * at.NODE)), (pages.cost[i], pages.cost[following], sag)


@kernel
def lowest(ends):
    """What no posture between two of a strip costs less than."""
    return min(ends[0], ends[1]) - 0.25 * ends[2]


@kernel
def try_strip(q, pages, strip, rules, found):
    """The cheapest way to a posture q from a strip of the pose before, if better: cost, and place (row and part)."""
    box = row(pages.strips, strip * at.STRIP)
    first, last = int(box[at.STRIP_FIRST]), int(box[at.STRIP_LAST])
    if box[at.STRIP_LEAST] < found[0] and not is_beyond(q, q, box, reach_of(box, rules, found[0]), rules.settings):
        for i in range(first, max(last, first + 1)):
            a, d, ends = cell_of(pages, i, last)
            if lowest(ends) < found[0]:
                found = try_cell(steps_between(rules.settings, a, q), d, ends, rules, found, float(i))
    return found


@kernel
def try_eight(q, pages, i, last, rules, found):
    """The cheapest ways to eight postures q from between row i of a strip and the next one, if better.

    A way that costs less where nothing limits it is taken if it is short enough, and else looked at by itself.
    """
    best, place = found
    a, d, ends = cell_of(pages, i, last)
    e = eight_steps(rules.settings, a, q)
    t0, t1, va, vb = cheaper_part(ends[0], ends[1])
    longest = rules.settings[7 * at.BY_CONTINUITY]
    value, t = least_of_eight(e, d, (va, vb, ends[2]), t0, t1, rules)
    better = as_bits(value < best)
    if not better:
        return found
    if rules.settings[7 * at.INVERSE_SPEED] == 0.0:
        good = value < best
        # Squares of steps are at least those of the longest joint's.
        if rules.limited or as_bits(good & (value > lowest(ends) + rules.share * longest * longest)):
            good = good & are_short(along7(e, -t, d), rules.settings, rules.limited, 0.0)
        best, place = where(good, value, best), where(good, t + float(i), place)
        better &= ~as_bits(good)
    if better:
        better &= as_bits(are_short(along7(e, -0.5, d), rules.settings, False, 0.5 * largest(d) + ROUNDING))
    for k in range(LANES):
        if better >> k & 1:
            cost, there = try_cell(one_of_seven(e, k), d, ends, rules, (one_of(best, k), one_of(place, k)), float(i))
            best, place = where(as_mask(1 << k), cost, best), where(as_mask(1 << k), there, place)
    return best, place


@kernel
def pages_of(sheet):
    """Postures, costs and strips of a sheet, which has to be kept, as pointers."""
    return Pages(row(sheet.nodes, 0), row(sheet.cost, 0), row(sheet.strips, 0))


@kernel
def leap(q, sheet, first, last, settings, found):
    """A break on the way to a posture q: from anywhere among rows first to last - 1, the nearest one if they cost."""
    for i in range(first, last):
        if sheet.cost[i] + at.BREAK < found[0]:
            e = steps_between(settings, row(sheet.nodes, i), q)
            value = sheet.cost[i] + at.BREAK + step_value(settings, e, 1.0)
            if value < found[0]:
                found = (value, float(i))
    return found


@kernel
def unbounded(cost, span):
    """Write that the ways to the postures of a pose may cost what they want."""
    for i in range(span.first, span.last):
        cost[i] = at.IMPOSSIBLE


@kernel
def cheapest(cost, first, last):
    """The cheapest of the rows first to last - 1."""
    best = first
    for i in range(first + 1, last):
        if cost[i] < cost[best]:
            best = i
    return best


@kernel
def first_costs(sheet, span, start, settings):
    """Costs of the postures of a first pose: squared joint steps from the start, if there is one."""
    nodes, cost = sheet.nodes, sheet.cost
    for i in range(span.first, span.last):
        cost[i] = 0.0
        nodes[i, at.NODE_SAG] = 0.0
        if start.shape[0] > 0:
            if i + 1 < span.last and settings[7 * at.INVERSE_SPEED] == 0.0:
                d = along_cell(row(nodes, i), row(nodes, i + 1))
                nodes[i, at.NODE_SAG] = product(d, d)
            e = steps_between(settings, row(start, 0), row(nodes, i))
            cost[i] = step_value(settings, e, 1.0) + (at.BREAK if largest(e) > settings[7 * at.BY_CONTINUITY] else 0.0)
    write_least(sheet, span)


@kernel
def origin_step(nodes, settings, i, place):
    """The steps to a posture from its place among those of the pose before."""
    k = math.floor(place)
    e = steps_between(settings, row(nodes, k), row(nodes, i))
    if place == k:
        return e
    return along7(e, k - place, along_cell(row(nodes, k), row(nodes, k + 1)))


@kernel
def write_sags(sheet, places, span, rules):
    """How far the costs between two postures of a strip lie below their straight line: by the change of their slope.

    The slope at a posture is twice the step to it. Costs that come from a step turn up no faster than its square.
    """
    nodes, cost, strips, settings = sheet.nodes, sheet.cost, sheet.strips, rules.settings
    for b in range(span.first_strip, span.last_strip):
        first, last = int(strips[b, at.STRIP_FIRST]), int(strips[b, at.STRIP_LAST])
        for i in range(first, last + 1):
            nodes[i, at.NODE_SAG] = 0.0
        if settings[7 * at.INVERSE_SPEED] != 0.0:
            continue
        for i in range(first, last):
            here, following = places[i - span.first], places[i + 1 - span.first]
            if here < 0.0 or following < 0.0 or abs(cost[i + 1] - cost[i]) > 0.5 * at.TOO_FAST:
                continue
            d = along_cell(row(nodes, i), row(nodes, i + 1))
            turn = product(origin_step(nodes, settings, i + 1, following), d)
            turn -= product(origin_step(nodes, settings, i, here), d)
            nodes[i, at.NODE_SAG] = rules.share * min(max(turn, 0.0), product(d, d))


@kernel
def write_least(sheet, span):
    """What no posture of each strip costs less than."""
    for b in range(span.first_strip, span.last_strip):
        least = at.IMPOSSIBLE
        for i in range(int(sheet.strips[b, at.STRIP_FIRST]), int(sheet.strips[b, at.STRIP_LAST]) + 1):
            least = min(least, sheet.cost[i] - 0.25 * sheet.nodes[i, at.NODE_SAG])
        sheet.strips[b, at.STRIP_LEAST] = least


@kernel
def is_beyond_room(sheet, i, span, rooms):
    """Whether ways through a posture of a pose, or next to it in its strip, cost more than they may."""
    sag = sheet.nodes[i, at.NODE_SAG]
    if i > span.first and sheet.linked[i - 1]:
        sag = max(sag, sheet.nodes[i - 1, at.NODE_SAG])
    return sheet.cost[i] - 0.25 * sag > rooms[i]


@kernel
def leave_out(sheet, span, rooms):
    """Take the costs of postures of which no strip leads on to one that may cost as much as its room, `rooms` (N,)."""
    before = True
    for i in range(span.first, span.last):
        beyond = is_beyond_room(sheet, i, span, rooms)
        alone = before or not sheet.linked[i - 1]
        following = i + 1 < span.last and sheet.linked[i]
        if beyond and alone and not (following and not is_beyond_room(sheet, i + 1, span, rooms)):
            sheet.cost[i] = at.IMPOSSIBLE
        before = beyond
    write_least(sheet, span)


@kernel
def try_all(pages, before, own, first, last, places, rules, most):
    """Costs of up to eight postures of a strip of a pose, by way of all strips of the pose before that cost less.

    Those of the same branch are the likely ones: they come first, and others are left out by what these cost.
    """
    nodes, strips, cost = pages.nodes, pages.strips, pages.cost
    q = postures_of(nodes, first, last, at.NODE)
    best, place = rows_of(cost, first, last, 1), 0.0 * q[0] - 1.0
    dearest = min(most, highest(best))
    branch = nodes[first * at.NODE + at.NODE_BRANCH]
    for turn in range(2):
        for a in range(before.first_strip, before.last_strip):
            box = row(strips, a * at.STRIP)
            begin, end = int(box[at.STRIP_FIRST]), int(box[at.STRIP_LAST])
            if (nodes[begin * at.NODE + at.NODE_BRANCH] == branch) == (turn == 0) and box[at.STRIP_LEAST] < dearest:
                if not is_beyond(own, row(own, 7), box, reach_of(box, rules, dearest), rules.settings):
                    for i in range(begin, max(end, begin + 1)):
                        best, place = try_eight(q, pages, i, end, rules, (best, place))
                    dearest = min(most, highest(best))
    for i in range(first, last + 1):
        cost[i], places[i - first] = one_of(best, i - first), one_of(place, i - first)


@kernel
def try_beside(pages, before, now, places, rules):
    """Costs of postures that are reached for more than they may cost, next to others: ways lead between both.

    Those that are reached nowhere, or not for what they may cost, become impossible.
    """
    cost, strips = pages.cost, pages.strips
    for b in range(now.first_strip, now.last_strip):
        first, last = int(strips[b * at.STRIP + at.STRIP_FIRST]), int(strips[b * at.STRIP + at.STRIP_LAST])
        follows = False
        for i in range(first, last + 1):
            k = i - now.first
            reached = places[k] >= 0.0
            if not reached:
                found = (at.IMPOSSIBLE, -1.0)
                if (follows or (i < last and places[k + 1] >= 0.0)) and cost[i] < at.IMPOSSIBLE:
                    for a in range(before.first_strip, before.last_strip):
                        found = try_strip(row(pages.nodes, i * at.NODE), pages, a, rules, found)
                cost[i], places[k] = found
            follows = reached


@kernel
def advance(sheet, before, now, rules, exact):
    """Costs of the postures of a pose, span `now`, from those of the pose before.

    What ways to them may cost at most is there already. Unless `exact`, breaks come from the cheapest posture alone,
    and strips that need one more break than it go on nowhere: a break there is as good.
    """
    nodes, cost = sheet.nodes, sheet.cost
    pages, places = pages_of(sheet), np.full(now.last - now.first, -1.0)
    start = cheapest(cost, before.first, before.last)
    least = cost[start] + at.BREAK
    most = at.IMPOSSIBLE if exact else least
    for b in range(now.first_strip, now.last_strip):
        own, last = row(pages.strips, b * at.STRIP), int(sheet.strips[b, at.STRIP_LAST])
        for i in range(int(sheet.strips[b, at.STRIP_FIRST]), last + 1, LANES):
            try_all(pages, before, own, i, min(i + LANES - 1, last), row(places, i - now.first), rules, most)
    try_beside(pages, before, now, row(places, 0), rules)
    if exact or cost[cheapest(cost, now.first, now.last)] > least:
        begin, end = (before.first, before.last) if exact else (start, start + 1)
        for i in range(now.first, now.last):
            if cost[i] > least:
                before_leap = cost[i]
                cost[i], _ = leap(row(nodes, i), sheet, begin, end, rules.settings, (cost[i], 0.0))
                if cost[i] < before_leap:
                    places[i - now.first] = -1.0
    write_sags(sheet, places, now, rules)
    write_least(sheet, now)


@kernel
def step_back(q, sheet, before, rules):
    """The best place of the pose before on the way to a posture q: cost, row and part of the way to the next row."""
    found, pages = (at.IMPOSSIBLE, -1.0), pages_of(sheet)
    for a in range(before.first_strip, before.last_strip):
        found = try_strip(q, pages, a, rules, found)
    return leap(q, sheet, before.first, before.last, rules.settings, found)
