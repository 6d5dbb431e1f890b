"""Where searches for a posture start: on a grid over the turns that a pose leaves free and the arm angle.

On the nearest exact limb shoulder and wrist are each for themselves at a turn and an arm angle, so that one table of
both holds the postures of four branches.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import load9, rotation, swing, times
from srs_ik.kernels.chain.starts import bent_place
from srs_ik.kernels.freedom.turns import elbow_rolls
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.freedom import (
    ARM_ANGLES,
    HALF,
    HALF_COST,
    MOST_STARTS,
    START_COST,
)
from srs_ik.kernels.layout.limb import FAR, IS_CLOSED, SHOULDER, WRIST
from srs_ik.kernels.limb.branches import NO_BRANCH, two_solutions
from srs_ik.kernels.limb.goal import OUTSIDE, elbow_part, join, part
from srs_ik.kernels.limb.triangle import elbow_side, place

OUT_OF_REACH = 0.1
"""Turns that bring the wrist this far out of reach, by the reach, are no starts."""

STEEP = 30.0
"""Cost of a radian outside the limits."""

MOST_OUTSIDE = 0.3
"""An elbow farther outside its limits, rad, is no start."""


@kernel
def write_halves(P, k, circles, turn, seeded, seed, table, at):
    """Both solutions of a spherical joint at an arm angle (cosine, sine), and their costs, from column `at` on."""
    first = 0 if k == SHOULDER else 4
    v0, y0, _ = circles
    v = swing(v0[0], v0[1], v0[2], turn[0], turn[1])
    y = swing(y0[0], y0[1], y0[2], turn[0], turn[1])
    above, below, reached = two_solutions(P, k, v, y, seeded, first, seed, True)
    wish = (seed[first], seed[first + 1], seed[first + 2])
    for sign in range(2):
        a, cost = part(P, first, above if sign == 0 else below, seeded, wish, True)
        if cost >= OUTSIDE:
            cost = softened(a, wish, seeded, cost - OUTSIDE)
        for i in range(3):
            table[at + HALF * sign + i] = a[i]
        table[at + HALF * sign + HALF_COST] = cost if reached else NO_BRANCH


@kernel
def softened(a, wish, seeded, outside):
    """Cost of three joints outside their limits: a search may start from there, but rather from elsewhere."""
    total = STEEP * outside
    if seeded:
        for i in range(3):
            total += (a[i] - wish[i]) ** 2
    return total


@kernel
def fill_table(P, side, seeded, seed, table):
    """Shoulder and wrist at arm angles all around."""
    for i in range(ARM_ANGLES):
        psi = 2.0 * math.pi * i / ARM_ANGLES
        turn = math.cos(psi), math.sin(psi)
        write_halves(P, SHOULDER, side[1], turn, seeded, seed, row(table, i), 0)
        write_halves(P, WRIST, side[2], turn, seeded, seed, row(table, i), 2 * HALF)


@kernel
def write_minima(table, elbow, shoulder, wrist, seeded, starts, n):
    """Write the postures of a branch that cost less than those beside them in arm angle; return how many there are."""
    e, cost_e = elbow
    a, b = HALF * shoulder, HALF * (2 + wrist)
    before = join(table[ARM_ANGLES - 1, a + HALF_COST], table[ARM_ANGLES - 1, b + HALF_COST], seeded, False)
    here = join(table[0, a + HALF_COST], table[0, b + HALF_COST], seeded, False)
    for i in range(ARM_ANGLES):
        k = (i + 1) % ARM_ANGLES
        after = join(table[k, a + HALF_COST], table[k, b + HALF_COST], seeded, False)
        if here <= before and here < after and here < NO_BRANCH and n < MOST_STARTS:
            for j in range(3):
                starts[n, j] = table[i, a + j]
                starts[n, 4 + j] = table[i, b + j]
            starts[n, 3] = e
            starts[n, START_COST] = join(here, cost_e, seeded, False)
            n += 1
        before = here
        here = after
    return n


@kernel
def add_starts(P, R, p, elbow, seeded, seed, desk, n):
    """Write the starts of one side of the elbow at a pose; return how many there are."""
    place_ = place(P, R, p)
    if P[IS_CLOSED] != 1.0:
        place_ = bent_place(P, place_)
    if abs(place_[5]) > OUT_OF_REACH * P[FAR]:
        return n
    side = elbow_side(P, place_, elbow)
    fill_table(P, side, seeded, seed, desk.table)
    e, cost = elbow_part(P, side[0], seeded, seed[3], True)
    if cost >= OUTSIDE:
        outside = cost - OUTSIDE
        if outside > MOST_OUTSIDE:
            return n
        cost = STEEP * outside + ((e - seed[3]) ** 2 if seeded else 0.0)
    for other in range(4):
        n = write_minima(desk.table, (e, cost), other >> 1, other & 1, seeded, desk.starts, n)
    return n


@kernel
def find_starts(P, pose, freedom, turns, seeded, seed, desk):
    """Write a start for every dip of the cost over the arm angle, of all turns and branches; return their number."""
    n = 0
    R, p = pose
    for elbow in range(2):
        if freedom.cone > 0.0:
            for k in range(turns.shape[0]):
                n = add_starts(P, times(R, load9(row(turns, k), 0)), p, elbow, seeded, seed, desk, n)
            continue
        for k in range(elbow_rolls(P, pose, freedom.axis, elbow, desk.rolls)):
            turn = rotation(freedom.axis, math.cos(desk.rolls[k]), math.sin(desk.rolls[k]))
            n = add_starts(P, times(R, turn), p, elbow, seeded, seed, desk, n)
    return n
