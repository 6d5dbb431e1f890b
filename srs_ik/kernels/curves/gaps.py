"""Samples of a followed curve beside its own, so that nothing between two samples is overlooked where limits count.

Joint limits of almost a turn leave a narrow gap: two samples on either side of it may both keep the limits, so one is
put into the gap; and one into a range so narrow that it is passed in one step. Between two samples that break the
limits of different joints there may be postures that keep them all: so samples are put where each of those joints
passes its limit.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.joint_vectors import along7, difference, dot7, short_way
from srs_ik.kernels.algebra.roots import has_settled, next_parameter, start_crossing, tell_figure
from srs_ik.kernels.chain.newton import CLOSED
from srs_ik.kernels.curves.ends import closed_inside, joint_beyond
from srs_ik.kernels.curves.follow import between, put, way_at
from srs_ik.kernels.curves.in_step import load_sample, share_of_chord
from srs_ik.kernels.curves.lowest import UNSURE
from srs_ik.kernels.curves.told import UNTOLD, turning_between
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import LOWER, MIDDLE, RANGE_KIND, UPPER
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.limits import turn_to_middle

HALVINGS = 45
CROSSING_STEPS = 60

BULGE = 0.1
"""A joint is off the straight way between two samples by no more than this part of their distance: curves turn by less
than the angle whose cosine is `SMALLEST_COSINE` in a step, however short."""

MOST_TURNS = 42
"""On a way between two samples a joint turns around once, across a limit or two, with a sample on either side."""

WELL_INSIDE = 0.5
"""A sample in a gap need not lie closer to its middle than this part of half its width."""


@kernel
def pass_at(P, by, a, b, j, middle):
    """The posture between two (`between`) at which joint j passes an angle: q, its share of the way, whether it is met.

    `middle` holds that angle, and how far from it, rad, will do.
    """
    angle, tolerance = middle
    start = short_way(a[0][j] - angle)
    low = 0.0
    high = 1.0
    share = start / short_way(a[0][j] - b[0][j])
    q = a[0]
    met = False
    for _ in range(HALVINGS):
        q, met = between(P, by, a, b, share)
        off = short_way(q[j] - angle)
        if not met or abs(off) < tolerance:
            break
        if off * start > 0.0:
            low = share
        else:
            high = share
        share = 0.5 * (low + high)
    return q, share, met


@kernel
def insert(line, first, n, x, q):
    """Insert a sample among the sorted rows first to n - 1; return the number of rows."""
    count = put(line, n, x, q)
    i = count - 1
    while i > first and line[i - 1, 0] > line[i, 0]:
        for c in range(line.shape[1]):
            line[i, c], line[i - 1, c] = line[i - 1, c], line[i, c]
        i -= 1
    return count


@kernel
def put_gaps(P, by, start, end, line, n):
    """Append a sample for every gap and every narrow range between two of a curve, in order; return the number of rows.

    A sample is given as its parameter, its posture, and the way of the curve if it is known.
    """
    x_a, a, way_a = start
    x_b, b, way_b = end
    way = difference(a, b)
    first = n
    for j in range(7):
        if P[RANGE_KIND + j] == 0.0:
            continue
        half = 0.5 * (P[UPPER + j] - P[LOWER + j])
        for opposite in range(2):
            # The middle of the gap, and that of a range which is passed in one step.
            angle = P[MIDDLE + j] + (math.pi if opposite == 0 else 0.0)
            room = math.pi - half if opposite == 0 else half
            off = short_way(a[j] - angle)
            passed = off * (off + way[j]) < 0.0 and abs(off) <= abs(way[j])
            if not passed or (opposite == 1 and min(abs(off), abs(off + way[j])) <= half):
                continue
            q, share, met = pass_at(P, by, (a, way_a), (b, way_b), j, (angle, WELL_INSIDE * room))
            if met:
                n = insert(line, first, n, x_a + share * (x_b - x_a), q)
    return n


@kernel
def any_outside(P, q):
    """Whether a posture breaks a limit."""
    outside = False
    for j in range(7):
        outside = outside or (P[RANGE_KIND + j] != 0.0 and joint_beyond(P, j, q) > 0.0)
    return outside


@kernel
def may_be_inside(P, a, b, bulge):
    """Whether some posture may keep all limits on a way between two that is bent by no more than `bulge`, rad."""
    low = 0.0
    high = 1.0
    for j in range(7):
        if P[RANGE_KIND + j] == 0.0:
            continue
        at_a = joint_beyond(P, j, a) - bulge
        at_b = joint_beyond(P, j, b) - bulge
        if at_a > 0.0 and at_b > 0.0:
            return False
        if at_a > 0.0:
            low = max(low, at_a / (at_a - at_b))
        elif at_b > 0.0:
            high = min(high, at_a / (at_a - at_b))
    return low <= high


@kernel
def may_cross(away, next_away, bulge):
    """Whether a parabola so high may come from a distance to zero and go back to the next one, both positive."""
    drop = next_away - away
    return abs(drop) < 4.0 * bulge and 0.5 * (away + next_away) <= bulge + drop * drop / (16.0 * bulge)


@kernel
def outside_of(P, j, end, angle):
    """How far an angle of joint j, in the best turn, lies outside its lower limit (end 0) or its upper one, rad."""
    return angle - P[UPPER + j] if end == 1 else P[LOWER + j] - angle


@kernel
def may_turn_across(P, j, end, ways, bulge):
    """Whether joint j, at two angles on one side of its lower limit (end 0) or its upper one, may pass it between them.

    Next to a straight elbow a joint may turn around by parts of a micrometre on its way, and limits are as narrow as
    the known postures there are.
    """
    at_a = outside_of(P, j, end, turn_to_middle(P, j, ways[0]))
    at_b = outside_of(P, j, end, turn_to_middle(P, j, ways[1]))
    return (at_a > 0.0) == (at_b > 0.0) and may_cross(abs(at_a), abs(at_b), bulge)


@kernel
def rates_between(P, by, start, end):
    """How fast the joints change along a curve at two of its postures, with the share of the way between these."""
    chord = difference(start[1], end[1])
    length = math.sqrt(dot7(chord, chord))
    t_a, told_a = way_at(P, by, start[1], start[2])
    t_b, told_b = way_at(P, by, end[1], end[2])
    rates_a = along7(NO_SEED, math.copysign(length, dot7(t_a, chord)), t_a)
    return rates_a, along7(NO_SEED, math.copysign(length, dot7(t_b, chord)), t_b), told_a and told_b


@kernel
def stays_on_side(P, j, end, ways, rates):
    """Whether joint j, at two angles on one side of a limit, stays there between them, as its rates at both tell.

    It goes on one way, as the cubic between the two does where no rate is too fast.
    """
    at_a = outside_of(P, j, end, turn_to_middle(P, j, ways[0]))
    at_b = outside_of(P, j, end, turn_to_middle(P, j, ways[1]))
    toward = 1.0 if (end == 1) == (at_a > 0.0) else -1.0
    begins, ends, change = toward * rates[0], toward * rates[1], abs(at_b) - abs(at_a)
    return min(begins * ends, begins * change) > 0.0 and max(abs(begins), abs(ends)) < 3.0 * abs(change)


@kernel
def turn_across(P, by, a, b, joint_end):
    """The posture between two on one side of a limit, of joint j at an end, where that turns around on the other side.

    Or where it comes back to it, up to what rounding makes of postures in step. Returns the posture, and whether there
    is one.
    """
    j, end = joint_end
    outside = outside_of(P, j, end, turn_to_middle(P, j, a[j])) > 0.0
    q = turning_between(P, by, a, b, 1.0 if (end == 1) != outside else -1.0, j, UNTOLD)
    off = outside_of(P, j, end, turn_to_middle(P, j, q[j]))
    if outside and 0.0 < off < UNSURE:
        q, met = closed_inside(P, by, q, CLOSED)
        return q, met and share_of_chord(a, b, q) < 1.0
    return q, (off > 0.0) != outside


@kernel
def put_turns(P, by, start, end, bulge, turns):
    """Write, in their order, samples where joints turn around across a limit on the way between two; their number.

    Where a joint goes on through a narrow range, there and back, samples in the range stand on either side.
    """
    x_a, a, _ = start
    x_b, b, _ = end
    n = 0
    rates_a, rates_b, told = NO_SEED, NO_SEED, False
    for k in range(14):
        j = k // 2
        if P[RANGE_KIND + j] == 0.0 or not may_turn_across(P, j, k % 2, (a[j], b[j]), bulge):
            continue
        if not told:
            rates_a, rates_b, told = rates_between(P, by, start, end)
        if told and stays_on_side(P, j, k % 2, (a[j], b[j]), (rates_a[j], rates_b[j])):
            continue
        q, found = turn_across(P, by, a, b, (j, k % 2))
        if not found:
            continue
        x = x_a + share_of_chord(a, b, q) * (x_b - x_a)
        n = insert(turns, 0, n, x, q)
        inside = P[MIDDLE + j], WELL_INSIDE * 0.5 * (P[UPPER + j] - P[LOWER + j])
        for from_x, from_q, from_way in (start, end):
            if joint_beyond(P, j, from_q) > 0.0 and joint_beyond(P, j, q) > 0.0:
                passing, share, met = pass_at(P, by, (from_q, from_way), (q, NO_SEED), j, inside)
                if met:
                    n = insert(turns, 0, n, from_x + share * (x - from_x), passing)
    return n


@kernel
def put_bounds(P, by, start, end, turns, line, n):
    """Append samples between two postures of a curve, so that nothing hides between them; return the rows in use.

    Where each joint turns around across a limit, and where both of two break limits, where each joint passes a limit.
    Both are given as parameter, posture, and the way of the curve if it is known. `turns` is for `MOST_TURNS` samples.
    """
    a, b = start[1], end[1]
    chord = difference(a, b)
    bulge = BULGE * math.sqrt(dot7(chord, chord))
    outside = any_outside(P, a)
    if outside and any_outside(P, b) and not may_be_inside(P, a, b, bulge):
        return n
    n_turns = put_turns(P, by, start, end, bulge, turns)
    before = start
    for i in range(n_turns + 1):
        behind = (turns[i, 0], load_sample(turns[i]), NO_SEED) if i < n_turns else end
        outside_behind = any_outside(P, behind[1])
        if outside and outside_behind:
            n = put_crossings(P, by, before, behind, bulge, line, n)
        if i < n_turns:
            n = put(line, n, behind[0], behind[1])
        before, outside = behind, outside_behind
    return n


@kernel
def put_crossings(P, by, start, end, bulge, line, n):
    """Append samples where joints pass a limit between two postures that break limits; return the rows in use."""
    x_a, a, way_a = start
    x_b, b, way_b = end
    if not may_be_inside(P, a, b, bulge):
        return n
    first = n
    for j in range(7):
        if P[RANGE_KIND + j] == 0.0:
            continue
        at_a = joint_beyond(P, j, a)
        at_b = joint_beyond(P, j, b)
        if (at_a > 0.0) == (at_b > 0.0):
            continue
        # Shares of the way at which the joint is inside, and outside.
        crossing = start_crossing(0.0, at_a, 1.0, at_b) if at_b > 0.0 else start_crossing(1.0, at_b, 0.0, at_a)
        inside_q = a if at_b > 0.0 else b
        for _ in range(CROSSING_STEPS):
            if has_settled(crossing):
                break
            share = next_parameter(crossing)
            q, met = between(P, by, (a, way_a), (b, way_b), share)
            if not met:
                break
            f = joint_beyond(P, j, q)
            crossing = tell_figure(crossing, share, f)
            if f <= 0.0:
                inside_q = q
        inside = crossing[0]
        if 0.0 < inside < 1.0:
            n = insert(line, first, n, x_a + inside * (x_b - x_a), inside_q)
    return n
