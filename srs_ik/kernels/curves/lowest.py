"""Where a cost is lowest along a curve: postures eight at a time, whose costs and rates foretell where to look next."""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, difference, dot7
from srs_ik.kernels.algebra.lanes import gather, one_of
from srs_ik.kernels.algebra.minimum import lowest_of_cubic
from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.curves.ends import dip, on_curve, sample_before
from srs_ik.kernels.curves.follow import between, tangent_at
from srs_ik.kernels.curves.in_step import ARC, between_eight, load_end, load_sample, on_way, one_of_seven
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.asked import Best, Goal
from srs_ik.kernels.layout.limb import INVERSE_HALF_RANGE, MIDDLE
from srs_ik.kernels.layout.search import SHARP, TIE
from srs_ik.kernels.limb.branches import NO_BRANCH
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE, cost, turned
from srs_ik.kernels.limb.limits import violation

LOOKS, LOOK = 8, 3
LOOK_SHARE, LOOK_COST, LOOK_RATE = range(LOOK)
"""Postures that are looked at at once; of each, its share of the way between two samples, its cost, and the rate of
that with the share."""

ROUNDS = 24
AROUND = (-0.05, -0.0025, 0.0, 0.0025, 0.05, -0.02, 0.0, 0.02)
EDGE = 1e-3
"""Rounds of looks, at most; where they are around what is foretold, five at the corner and three at the bottom, and how
far from the ends at least, in parts of the way between two."""

BENT = 16.0
"""A squared distance is above the lines that foretell it but for so many times the square of the way between two."""

UNSURE = 1e-8
"""Looks this far outside the limits, rad, may be inside: postures in step are off by so much at a singular wrist."""


@kernel
def rate_of_cost(P):
    """How fast a cost that is no distance may change with the way along a curve."""
    fastest = 1.0
    for j in range(7):
        fastest = max(fastest, P[INVERSE_HALF_RANGE + j])
    return fastest


@kernel
def hope(value, gap, seeded, rate):
    """A cost below any within a way `gap` of a posture with this cost."""
    if seeded and value < OUTSIDE:
        return max(math.sqrt(value) - ARC * gap, 0.0) ** 2
    return value - rate * ARC * gap


@kernel
def cost_of_turn(P, q, goal):
    """A posture in the turn that suits the goal, and its cost."""
    q = turned(P, q, goal.seeded, goal.seed, goal.respect)
    return q, cost(P, q, goal.seeded, goal.seed, goal.respect)


@kernel
def cost_at(P, by, curve, x, goal):
    """Posture of a run at a parameter, in the turn that suits the goal, and its cost."""
    q, off = on_curve(P, by, 0, curve, x)
    if off >= NO_BRANCH:
        return q, NO_BRANCH
    return cost_of_turn(P, q, goal)


@kernel
def rate_at(P, q, way, goal):
    """How fast the cost of a posture changes along a way from it."""
    worst, highest = 0.0, -math.inf
    rate = outwards = 0.0
    for j in range(7):
        off, outside = q[j] - P[MIDDLE + j], violation(P, j, q[j])
        if outside > worst:
            worst, outwards = outside, way[j] if off > 0.0 else -way[j]
        value = abs(off) * P[INVERSE_HALF_RANGE + j]
        if goal.seeded:
            rate += 2.0 * (q[j] - goal.seed[j]) * way[j]
        elif value > highest:
            highest, rate = value, math.copysign(P[INVERSE_HALF_RANGE + j], off) * way[j]
    return outwards if goal.respect and worst > 0.0 else rate


@kernel
def look_between(P, by, ends, looks, goal, best):
    """Tell costs and rates at eight shares of the way between two samples, in rows of looks: the best one so far.

    `best` is that with its share.
    """
    a = ends[0][0]
    chord = difference(a, ends[1][0])
    q, t, met = between_eight(P, by, on_way(a, chord, gather(row(looks, 0), LOOK_SHARE, LOOK)), chord)
    speed = dot7(chord, chord) / dot7(t, chord)
    for i in range(LOOKS):
        looks[i, LOOK_COST], looks[i, LOOK_RATE] = NO_BRANCH, 0.0
        own, way, there = one_of_seven(q, i), along7(NO_SEED, one_of(speed, i), one_of_seven(t, i)), (met >> i) & 1 == 1
        if not there:
            # In step it divides by what axes 5 to 7 span.
            own, there = between(P, by, ends[0], ends[1], looks[i, LOOK_SHARE])
            way, _ = tangent_at(P, by, own)
            way = along7(NO_SEED, dot7(chord, chord) / dot7(way, chord), way)
        if there:
            own, value = cost_of_turn(P, own, goal)
            looks[i, LOOK_COST], looks[i, LOOK_RATE] = value, rate_at(P, own, way, goal)
            if value < best[0].cost:
                best = Best(own, value), looks[i, LOOK_SHARE]
    return best


@kernel
def read_look(looks, i):
    """A look: its share of the way, its cost and the rate of that."""
    return looks[i, LOOK_SHARE], looks[i, LOOK_COST], looks[i, LOOK_RATE]


@kernel
def closer(looks, first, last):
    """The two of eight looks, in their order, and of two looks around them between which the cost is lowest."""
    lowest = 0
    for i in range(1, LOOKS):
        if looks[i, LOOK_COST] < looks[lowest, LOOK_COST]:
            lowest = i
    if min(first[1], last[1]) < looks[lowest, LOOK_COST]:
        return (first, read_look(looks, 0)) if first[1] < last[1] else (read_look(looks, LOOKS - 1), last)
    falls = looks[lowest, LOOK_RATE] < 0.0
    here = read_look(looks, lowest)
    i = lowest
    while 0 <= i < LOOKS and looks[i, LOOK_SHARE] == here[0]:
        i += 1 if falls else -1
    if falls:
        return here, (read_look(looks, i) if i < LOOKS else last)
    return (read_look(looks, i) if i >= 0 else first), here


@kernel
def spread_looks(looks, first, last, corner):
    """Spread eight looks between two, closer around the corner and the bottom that these foretell, if they do."""
    low, high = first[0], last[0]
    width = high - low
    bottom = corner
    if low < corner < high:
        bottom, _ = lowest_of_cubic(first, last, 0.0)
    for i in range(LOOKS):
        share = low + width * (i + 1.0) / (LOOKS + 1.0)
        if low < corner < high:
            share = (corner if i < 5 else bottom) + width * AROUND[i]
        share = min(max(share, low + EDGE * width), high - EDGE * width)
        k = i
        while k > 0 and looks[k - 1, LOOK_SHARE] > share:
            looks[k, LOOK_SHARE] = looks[k - 1, LOOK_SHARE]
            k -= 1
        looks[k, LOOK_SHARE] = share


@kernel
def close_in_on(P, by, curve, bracket, goal, best):
    """Close in on a minimum between the outer of three parameters: the best posture so far, and if it is new, where.

    Eight postures at a time tell the cost and its rate. Where the lines through the two around the lowest meet, or the
    cubic through them is lowest, tells where to look next.
    """
    a, x, b = bracket
    rows = curve.rows
    q, value = cost_at(P, by, curve, x, goal)
    t, _ = tangent_at(P, by, q)
    low = min(sample_before(curve, x), curve.last - 2)
    forward = dot7(t, difference(load_sample(rows[low]), load_sample(rows[low + 1]))) > 0.0
    rate = rate_at(P, q, t if forward else along7(NO_SEED, -1.0, t), goal)
    lower, upper = (x, b) if rate < 0.0 else (a, x)
    if lower == upper:
        return best, x
    low = sample_before(curve, 0.5 * (lower + upper))
    ends = load_end(rows[low]), load_end(rows[low + 1])
    way = rows[low + 1, 0] - rows[low, 0]
    # Where the cost jumps to another turn next to the middle one, no look may be as low.
    known = (x - rows[low, 0]) / way, value, rate * way
    first = known if rate < 0.0 else ((lower - rows[low, 0]) / way, math.inf, 0.0)
    last = known if rate >= 0.0 else ((upper - rows[low, 0]) / way, math.inf, 0.0)
    looks = np.empty((LOOKS, LOOK))
    corner = first[0]
    bent_by = BENT if goal.seeded else rate_of_cost(P)
    found = best, first[0]
    for _ in range(ROUNDS):
        spread_looks(looks, first, last, corner)
        found = look_between(P, by, ends, looks, goal, found)
        first, last = closer(looks, first, last)
        width = last[0] - first[0]
        corner, lowest = first[0], hope(min(first[1], last[1]), way * width, goal.seeded, rate_of_cost(P))
        rise = last[1] - first[1]
        # A cost that jumps to another turn between the two is foretold by no lines.
        if first[2] < 0.0 < last[2] and first[2] * width < rise + TIE and rise - TIE < last[2] * width:
            corner += (last[2] * width - rise) / (last[2] - first[2])
            lowest = first[1] + first[2] * (corner - first[0]) - bent_by * (way * width) ** 2
        if width * way < SHARP or lowest > found[0].cost - TIE:
            break
    keep(looks)
    return found[0], rows[low, 0] + found[1] * way


@kernel
def dip_near(P, by, curve, bracket):
    """Any feasible parameter between the outer of three that are not, on a near limb: it, and its infeasibility.

    Where another curve crosses this one, a look may be on that: what counts is the posture of the curve itself.
    """
    best, x = close_in_on(P, by, curve, bracket, Goal(False, NO_SEED, True), Best(NO_SEED, OUTSIDE + UNSURE))
    if best.cost >= OUTSIDE + UNSURE:
        return x, 1.0
    _, off = on_curve(P, by, 0, curve, x)
    return (x, off) if off <= 0.0 else dip(P, by, 0, curve, bracket[0], bracket[2])
