"""Shoulder and wrist of the nearest exact limb at eight arm angles at once, well enough for searches to start from.

Angles come from a polynomial that is off by less than 2e-6 rad; where a joint is singular, its turn is anywhere.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.lane_trig import TINY, turn
from srs_ik.kernels.algebra.lanes import LANES, as_bits, eight_of, gather, larger, root, scatter, where, whole_number
from srs_ik.kernels.algebra.vectors import add, dot, load3, sub, swing
from srs_ik.kernels.exact.glance import eight_angles
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import limb
from srs_ik.kernels.layout.freedom import ARM_ANGLES, BRANCH_COST, ELBOW_COST, HALF, HALF_COST
from srs_ik.kernels.limb.branches import NO_BRANCH

STEEP = 30.0
"""Cost of a radian outside the limits."""

ALMOST_ACROSS = 1e-4
"""Axes whose directions have a smaller dot product count as across each other."""

TURN = 2.0 * math.pi
PER_TURN = 1.0 / TURN


@kernel
def middle_eight(P, k, v):
    """`spherical.middle_angle` of eight directions."""
    a1 = load3(P, k + limb.A1)
    up, down = sub(v, a1), add(v, a1)
    top2, bottom2 = dot(up, up), dot(down, down)
    top, bottom = 0.5 * top2 - P[k + limb.TOP_GAP], 0.5 * bottom2 - P[k + limb.BOTTOM_GAP]
    slack = P[limb.SLACK_REACH]
    reached = (top + slack * root(top2) > -TINY) & (bottom + slack * root(bottom2) > -TINY)
    top, bottom = where(top > 0.0, top, 0.0), where(bottom > 0.0, bottom, 0.0)
    share = 1.0 / (top + bottom)
    return (bottom - top) * share, 2.0 * root(top * bottom) * share, reached


@kernel
def outside(P, joint, q):
    """How far eight angles are outside the limits."""
    return larger(larger(P[limb.LOWER + joint] - q, q - P[limb.UPPER + joint]), 0.0)


@kernel
def within(P, joint, q, seeded, wish):
    """The turns of angles that are best to search from, what they cost, and how far they are outside the limits.

    With a seed that is the one nearest to it, inside the limits if there are any, or a little outside where the other
    one is a turn away; its cost is the squared distance. Without one, the wish is the middle between the limits: a turn
    inside them is nearest to it, and costs minus its margin.
    """
    lower, upper = P[limb.LOWER + joint], P[limb.UPPER + joint]
    near = q + TURN * whole_number((wish - q) * PER_TURN)
    if not seeded:
        return near, abs(near - wish) * P[limb.INVERSE_HALF_RANGE + joint] - 1.0, outside(P, joint, near)
    away = near - wish
    cost = away * away
    if lower == -math.inf and upper == math.inf:
        return near, cost, 0.0 * near
    out = outside(P, joint, near)
    if upper - lower > TURN:
        other = near - TURN * whole_number(larger(near - upper, 0.0) * PER_TURN + 0.5)
        other = other + TURN * whole_number(larger(lower - near, 0.0) * PER_TURN + 0.5)
    else:
        # Inside the limits is at most the turn nearest to the middle of the range.
        other = q + TURN * whole_number((P[limb.MIDDLE + joint] - q) * PER_TURN)
    away = other - wish
    others, outs = away * away, outside(P, joint, other)
    worse = cost + STEEP * out > others + STEEP * outs
    return where(worse, other, near), where(worse, others, cost), where(worse, outs, out)


@kernel
def write_eight(P, first, q, reached, goal, table, at):
    """Write three angles and their cost at eight arm angles, from column `at` on; limits are passed at a price."""
    seeded, wish = goal
    a, of_a, out_a = within(P, first, q[0], seeded, wish[0])
    b, of_b, out_b = within(P, first + 1, q[1], seeded, wish[1])
    c, of_c, out_c = within(P, first + 2, q[2], seeded, wish[2])
    out = STEEP * larger(larger(out_a, out_b), out_c)
    if seeded:  # noqa: SIM108
        cost = of_a + of_b + of_c + out
    else:
        cost = where(out > 0.0, out, larger(larger(of_a, of_b), of_c))
    scatter(table, at, 1, a)
    scatter(table, at + ARM_ANGLES, 1, b)
    scatter(table, at + 2 * ARM_ANGLES, 1, c)
    scatter(table, at + HALF_COST * ARM_ANGLES, 1, where(reached, cost, NO_BRANCH))


@kernel
def write_halves(P, k, circles, sought, table):
    """Write both solutions of a spherical joint, and their costs, at arm angles all around."""
    first, half = (0, 0) if k == limb.SHOULDER else (4, 2)
    wish = sought.wish
    here = sought.seeded, (wish[first], wish[first + 1], wish[first + 2])
    loose = sought.loose and k != limb.SHOULDER
    v0, y0, _ = circles
    for i in range(0, ARM_ANGLES, LANES):
        steps = float(i) + eight_of(0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0)
        c, s = turn(sought.shift + steps * (TURN / ARM_ANGLES))
        v, y = swing(v0, c, s), swing(y0, c, s)
        c, s, reached = middle_eight(P, k, v)
        q = eight_angles(P, k, v, y, c, s)
        if loose:
            q = q[0], q[1], where(reached, wish[6], wish[6])
        write_eight(P, first, q, reached, here, table, half * HALF * ARM_ANGLES + i)
        if max(abs(P[k + limb.A1_A2]), abs(P[k + limb.A2_A3])) < ALMOST_ACROSS:
            q = q[0] + math.pi, 2.0 * P[k + limb.PHASE] - q[1], q[2] + math.pi
        else:
            q = eight_angles(P, k, v, y, c, -s)
        if loose:
            q = q[0], q[1], where(reached, wish[6], wish[6])
        write_eight(P, first, q, reached, here, table, (half + 1) * HALF * ARM_ANGLES + i)


@kernel
def write_costs(table, halves, seeded):
    """Write what postures cost at all arm angles, of a half of the shoulder, one of the wrist, and the elbow."""
    for i in range(0, ARM_ANGLES, LANES):
        a = gather(table, (halves[0] * HALF + HALF_COST) * ARM_ANGLES + i, 1)
        b = gather(table, (halves[1] * HALF + HALF_COST) * ARM_ANGLES + i, 1)
        e = table[ELBOW_COST]
        scatter(table, BRANCH_COST + 1 + i, 1, a + b + e if seeded else larger(larger(a, b), e))
    table[BRANCH_COST] = table[BRANCH_COST + ARM_ANGLES]
    table[BRANCH_COST + ARM_ANGLES + 1] = table[BRANCH_COST + 1]


@kernel
def dips(table, i, useless):
    """Which of eight arm angles cost no more than those beside them, as bits, but for useless costs between two."""
    here = gather(table, BRANCH_COST + 1 + i, 1)
    high = (here > gather(table, BRANCH_COST + i, 1)) | (here > gather(table, BRANCH_COST + 2 + i, 1))
    return as_bits(here < NO_BRANCH) & ~as_bits(high | ((here > useless[0]) & (here < useless[1])))
