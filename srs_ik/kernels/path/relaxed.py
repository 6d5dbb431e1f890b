"""A bound below what any path costs: the programme over cells, where each step counts its least between two cells.

Of squares, what a cell costs is a parabola along it that lies nowhere above the costs of its postures (`WORTH`). A
posture within r of the pieces of two cells is no closer than their distance u less r, and (u - r)^2 is at least
(1 - g) u^2 - r^2 (1 - g) / g for any g from 0 to 1, a parabola of both places. The least over the first place is convex
in the second one: its values at both ends, less the bound of its bend, are nowhere above it. Of times, what a cell
costs is one figure.
"""

import math

from srs_ik.kernels.algebra.joint_vectors import along7, dot7
from srs_ik.kernels.algebra.pointers import copy, row
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import path as at
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.path.cells import GROUP, cell_chord
from srs_ik.kernels.path.steps import steps_between

FAR = 1.0
"""Cells farther apart, rad, count their distance alone."""

ROOT_7 = math.sqrt(7.0)

TURNS = 6
"""How often the shortest step between two cells is looked for along one and the other."""


@kernel
def lowest(worth, i):
    """Least of the parabola of a cell."""
    a, b, sag = worth[i, at.WORTH_BEGIN], worth[i, at.WORTH_END], worth[i, at.WORTH_SAG]
    if sag <= abs(b - a):
        return min(a, b)
    t = 0.5 * (1.0 - (b - a) / sag)
    return a + t * (b - a) - sag * t * (1.0 - t)


@kernel
def least_along(e, d, worth, i, gain):
    """Least over s from 0 to 1 of the parabola of cell i plus gain |e - s d|^2, and whether it is inside."""
    a, b, sag = worth[i, at.WORTH_BEGIN], worth[i, at.WORTH_END], worth[i, at.WORTH_SAG]
    size = sag + gain * dot7(d, d)
    slope = 0.5 * (sag - (b - a)) + gain * dot7(e, d)
    s = 0.0
    if size > 1e-18:
        s = slope / size
    elif slope > 0.0:
        s = 1.0
    t = min(max(s, 0.0), 1.0)
    off = along7(e, -t, d)
    return a + t * (b - a) - sag * t * (1.0 - t) + gain * dot7(off, off), t == s


@kernel
def step_between(cells, i, worth, here, j, settings):
    """The parabola of what a step from cell i to cell j of `here` costs, with what cell i does: begin, end and sag."""
    d, chord = cell_chord(cells, i), cell_chord(here, j)
    e = steps_between(settings, row(cells, i), row(here, j))
    middle = along7(along7(e, 0.5, chord), -0.5, d)
    apart = math.sqrt(dot7(middle, middle))
    off = cells[i, at.CELL_OFF] + here[j, at.CELL_OFF]
    if apart <= off:
        least = lowest(worth, i)
        return least, least, 0.0
    long = 0.5 * (math.sqrt(dot7(d, d)) + math.sqrt(dot7(chord, chord)))
    if apart - off - long > FAR:
        # The shorter way round, for joints without end.
        middle = steps_between(settings, NO_SEED, middle)
        least = lowest(worth, i) + max(math.sqrt(dot7(middle, middle)) - off - long, 0.0) ** 2
        return least, least, 0.0
    gain = 1.0 - off / apart
    less = off * apart * gain
    begin, inside0 = least_along(e, d, worth, i, gain)
    end, inside1 = least_along(along7(e, 1.0, chord), d, worth, i, gain)
    sag = gain * dot7(chord, chord)
    if inside0 and inside1:
        across = gain * dot7(d, chord)
        size = worth[i, at.WORTH_SAG] + gain * dot7(d, d)
        if size > 1e-18:
            sag = max(sag - across * across / size, 0.0)
    return begin - less, end - less, sag


@kernel
def write_groups(cells, first, last, worth, groups):
    """Write for each group of cells a posture, how far its cells reach from it, and what none costs less than."""
    count = (last - first + GROUP - 1) // GROUP
    for g in range(count):
        begin, end = first + g * GROUP, min(first + (g + 1) * GROUP, last)
        middle = begin + (end - begin) // 2
        reach, least = 0.0, at.IMPOSSIBLE
        for i in range(begin, end):
            size, other = 0.0, 0.0
            for j in range(7):
                a = cells[i, j] - cells[middle, j]
                size += a * a
                other += (a + cells[i, 7 + j]) * (a + cells[i, 7 + j])
            reach = max(reach, math.sqrt(max(size, other)) + cells[i, at.CELL_OFF])
            least = min(least, lowest(worth, i))
        copy(row(cells, middle), row(groups, g), 7)
        groups[g, 7], groups[g, 8] = reach, least
    return count


@kernel
def quickest_between(cells, i, here, j, settings):
    """Time that a step from cell i to cell j of `here` takes at least, at the velocity limits.

    The slowest of seven joints takes no less than any mean of them with signs: along the squares and the fourth powers
    of the shortest step, and each mean is least at corners of both cells.
    """
    d, chord = cell_chord(cells, i), cell_chord(here, j)
    e = steps_between(settings, row(cells, i), row(here, j))
    off = cells[i, at.CELL_OFF] + here[j, at.CELL_OFF]
    middle = along7(along7(e, 0.5, chord), -0.5, d)
    long = 0.5 * (math.sqrt(dot7(d, d)) + math.sqrt(dot7(chord, chord)))
    if math.sqrt(dot7(middle, middle)) - off - long > FAR:
        middle = steps_between(settings, NO_SEED, middle)
        return max(math.sqrt(dot7(middle, middle)) - off - long, 0.0) * settings[7 * at.LEAST_INVERSE] / ROOT_7
    ed, ec, dd, dc, cc = 0.0, 0.0, 1e-18, 0.0, 1e-18
    for k in range(7):
        square = settings[7 * at.INVERSE_SPEED + k] * settings[7 * at.INVERSE_SPEED + k]
        ed += square * e[k] * d[k]
        ec += square * e[k] * chord[k]
        dd += square * d[k] * d[k]
        dc += square * d[k] * chord[k]
        cc += square * chord[k] * chord[k]
    s, t = 0.5, 0.5
    for _ in range(TURNS):
        s = min(max((ed + t * dc) / dd, 0.0), 1.0)
        t = min(max((s * dc - ec) / cc, 0.0), 1.0)
    least = 0.0
    for power in range(2):
        total, a, b, c, size = 1e-300, 0.0, 0.0, 0.0, 0.0
        for k in range(7):
            inverse = settings[7 * at.INVERSE_SPEED + k]
            w = inverse * (e[k] - s * d[k] + t * chord[k])
            if power == 1:
                w *= w * w
            total += abs(w)
            a += w * inverse * e[k]
            b += w * inverse * d[k]
            c += w * inverse * chord[k]
            size += w * w * inverse * inverse
        least = max(least, (a - max(b, 0.0) + min(c, 0.0) - off * math.sqrt(size)) / total)
    return least


@kernel
def is_too_far(apart, settings):
    """Whether a distance of seven joints, rad, is beyond a continuous step in every case."""
    return apart * apart > 7.0 * settings[7 * at.BY_CONTINUITY] ** 2


@kernel
def reach_groups(groups, total, here, j, settings):
    """Write what a way to cell j costs at least from each group of cells; which group promises most."""
    chord = cell_chord(here, j)
    reach = math.sqrt(dot7(chord, chord)) + here[j, at.CELL_OFF]
    nearest, least = 0, math.inf
    for g in range(total):
        e = steps_between(settings, row(groups, g), row(here, j))
        apart = max(math.sqrt(dot7(e, e)) - reach - groups[g, 7], 0.0)
        value = apart * apart
        if settings[7 * at.INVERSE_SPEED] != 0.0:
            value = apart * settings[7 * at.LEAST_INVERSE] / ROOT_7
        groups[g, 9] = math.inf if is_too_far(apart, settings) else groups[g, 8] + value
        if groups[g, 9] < least:
            nearest, least = g, groups[g, 9]
    return nearest


@kernel
def advance_cell(before, groups, here, j, settings, tried):
    """The parabola of what cell j costs at least, from the cells before; `tried` is work space.

    `before` are cells, first and last row, and what each costs. Settings with an infinite step of continuity let a path
    leap. Where the time counts, the parabola is flat.
    """
    cells, first, last, worth = before
    begin, end, count = at.IMPOSSIBLE, at.IMPOSSIBLE, 0
    total = (last - first + GROUP - 1) // GROUP
    nearest = reach_groups(groups, total, here, j, settings)
    for k in range(total + 1):
        # The most promising ones first.
        g = nearest if k == 0 else k - 1
        if groups[g, 9] >= max(begin, end) or (k > 0 and g == nearest):
            continue
        for i in range(first + g * GROUP, min(first + (g + 1) * GROUP, last)):
            if min(worth[i, at.WORTH_BEGIN], worth[i, at.WORTH_END]) >= at.IMPOSSIBLE:
                continue
            if settings[7 * at.INVERSE_SPEED] != 0.0:
                if worth[i, at.WORTH_BEGIN] < begin:
                    begin = min(begin, worth[i, at.WORTH_BEGIN] + quickest_between(cells, i, here, j, settings))
                    end = begin
                continue
            a, b, sag = step_between(cells, i, worth, here, j, settings)
            if a - 0.25 * sag >= max(begin, end) and b - 0.25 * sag >= max(begin, end):
                continue
            begin, end = min(begin, a), min(end, b)
            tried[count, 0], tried[count, 1], tried[count, 2] = a, b, sag
            count += 1
    sag = 0.0
    for k in range(count):
        above = math.sqrt(max(tried[k, 0] - begin, 0.0)) + math.sqrt(max(tried[k, 1] - end, 0.0))
        sag = max(sag, tried[k, 2] - above * above)
    return begin, end, sag
