"""Small closed curves of a pose next to the end of the reach, which arm angles all around pass by.

With the elbow almost straight or folded, how far the true chain reaches differs from one turn of the elbow about the
line S-W to another, by what the axes miss. Close to the farthest it reaches a pose at some of these turns alone: about
a turn at which its reach, with the best bend of the elbow, is greater than at all others near it.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7
from srs_ik.kernels.algebra.lane_trig import turns_of
from srs_ik.kernels.algebra.lanes import as_bits, as_mask, eight_of, gather, one_of, scatter, where
from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.algebra.vectors import cross, dot
from srs_ik.kernels.chain.eight import ALL, put_eight, take_eight, take_ways
from srs_ik.kernels.chain.newton_eight import largest, reduced, turned_by_all, with_wrist
from srs_ik.kernels.chain.starts import almost_straight
from srs_ik.kernels.curves.in_step import one_of_seven
from srs_ik.kernels.curves.surface import level_place
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import FAR, NEAR
from srs_ik.kernels.limb.branches import side_posture
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.poses import read7
from srs_ik.kernels.limb.triangle import elbow_side

TURNS = 16
"""Turns, all around, between which the greatest reaches are looked for."""

STEPS = 8
"""Newton's steps to the best bend at a turn, at most ..."""

SETTLED = 1e-5
"""... and the step, rad, that is the last one."""

CUTS = 12
"""Steps to a greatest reach between two turns, at most."""

LEVEL = 1e-10
"""The rise with a turn, m/rad, that is none."""

NARROWEST = 1e-9
"""Two turns closer than this, rad, are one."""

LEAST_BEND = 5e-5
ROOM = 1e-2
"""Where the best bend leaves less room than this, rad, to both sides, Newton's method closes no posture for certain;
with the second one, it does without the very greatest reach."""

HIGHEST = 2.0
"""Between two turns reaches are no greater than either goes on to rise, so many times, and parts of the reach ..."""

HIGHER = 1e-3
"""... above that."""

LONGEST_STEP = 0.5
"""A longer step, rad, leads to no posture nearby."""

OUTER = 17
OUTER_WAY = 7
OUTER_REACH, OUTER_RISE, OUTER_GOOD = range(14, OUTER)
"""A posture that reaches farthest at its turn: joint angles, their ways with the turn, the reach past the pose, how it
rises with the turn, and whether there is one."""

TOP = 18
TOP_BEGIN, TOP_END, TOP_LOW, TOP_HIGH = range(14, TOP)
"""Two turns with a greatest reach between them: the first posture and the ways of its joints with the turn, both turns
of joint 3, and how the reach rises at each."""


@kernel
def best_bends(P, target, q, curvature):
    """Eight postures, each with the bend that reaches farthest along S-W at its turn, by Newton's method.

    The turn is that of joint 3. Returned are the postures, their reaches past the pose, how these rise with the turn,
    the ways of the joints with the turn and with the bend, and as bits, which there are.
    """
    R, p, place_ = target
    t = place_[0]
    none = 0.0 * q[0]
    still = (none, none, none)
    turns = turns_of(q)
    good = ALL
    past, rise = none, none
    turning, bending = q, q
    for _ in range(STEPS):
        made = reduced(P, turns, R, p)
        # s1 d1 + s2 d2 - t past = rest, with the turns of joints 3 and 4 given.
        s1, s2, s3, s4 = made.s
        across = cross(s1, s2)
        share = 1.0 / dot(t, across)
        to_1, to_2 = cross(s2, t), cross(t, s1)
        past = -share * dot(made.rest, across)
        slope = share * dot(s4, across)
        rise = share * dot(s3, across)
        bent = -slope / curvature
        bending = with_wrist(made, still, -share * dot(s4, to_1), -share * dot(s4, to_2), none, 1.0 + none)
        turning = with_wrist(made, still, -share * dot(s3, to_1), -share * dot(s3, to_2), 1.0 + none, none)
        step = with_wrist(made, made.angular, share * dot(made.rest, to_1), share * dot(made.rest, to_2), none, none)
        step = along7(step, bent, bending)
        size = largest(step)
        good &= as_bits(size < LONGEST_STEP)
        q = along7(q, 1.0, step)
        if good & ~as_bits(size < SETTLED) == 0:
            break
        turns = turned_by_all(turns, step)
    return q, past, rise, turning, bending, good


@kernel
def put_outer(P, target, q, curvature, rows, first):
    """Write the postures that reach farthest at the turns of eight into rows."""
    q, past, rise, turning, _, good = best_bends(P, target, q, curvature)
    out = row(rows, first)
    put_eight(out, OUTER, ALL, q)
    for j in range(7):
        scatter(out, OUTER_WAY + j, OUTER, turning[j])
    scatter(out, OUTER_REACH, OUTER, past)
    scatter(out, OUTER_RISE, OUTER, rise)
    for i in range(8):
        rows[first + i, OUTER_GOOD] = (good >> i) & 1


@kernel
def turned_away(q, turn, sense):
    """A posture of an arm that is straight, with its elbow turned about S-W: joint 5 takes that back."""
    return q[0], q[1], q[2] + turn, q[3], q[4] + sense * turn, q[5], q[6]


@kernel
def put_around(P, by, level, signs, curvature, rows):
    """Write the postures that reach farthest at turns all around, for signs of shoulder and wrist, into rows."""
    q, _, _ = side_posture(P, elbow_side(P, level, 0), 0.0, signs >> 1, signs & 1, False, NO_SEED, False)
    none = eight_of(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    alike = (none, none, none, none, none, none, none)
    put_outer(P, by.target, along7(alike, 1.0, q), curvature, rows, 0)
    q, sense = along7(alike, 1.0, read7(rows[0])), math.copysign(1.0, rows[0, OUTER_WAY + 4])
    part = 2.0 * math.pi / TURNS
    for first in range(0, TURNS, 8):
        ahead = part * (eight_of(0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0) + first)
        put_outer(P, by.target, turned_away(q, ahead, sense), curvature, rows, first)
    for c in range(OUTER):
        rows[TURNS, c] = rows[0, c]
    rows[TURNS, 2] += 2.0 * math.pi


@kernel
def put_outermost(P, by, which, starts, n):
    """Append postures of the curves about the greatest reaches that are past a pose; their number.

    `which` are, as bits, the signs of shoulder and wrist with which the pose is not reached all around.
    """
    place_ = by.target.place
    if which == 0 or place_[3] >= almost_straight(P) or P[NEAR] < NARROWEST:
        return n
    level = level_place(place_)
    reach = P[FAR] if level[2] > 0.0 else -P[NEAR]
    curvature = (P[NEAR] - P[FAR]) * (P[NEAR] + P[FAR]) / (2.0 * reach)
    away = math.copysign(1.0, reach)
    width = HIGHEST * 2.0 * math.pi / TURNS
    # Half of the turns have a greatest reach behind them, at most.
    rows, tops = np.empty((TURNS + 1, OUTER)), np.zeros((2 * TURNS, TOP))
    count = 0
    for signs in range(4):
        if which >> signs & 1:
            put_around(P, by, level, signs, curvature, rows)
        for i in range(TURNS if which >> signs & 1 else 0):
            a, b = rows[i], rows[i + 1]
            low, high = away * a[OUTER_RISE], away * b[OUTER_RISE]
            top = min(a[OUTER_REACH] * away + width * abs(low), b[OUTER_REACH] * away + width * abs(high))
            good = a[OUTER_GOOD] * b[OUTER_GOOD] != 0.0
            if good and low > 0.0 and high <= 0.0 and top > -HIGHER * P[FAR]:
                for c in range(OUTER_REACH):
                    tops[count, c] = a[c]
                tops[count, TOP_BEGIN], tops[count, TOP_END] = a[2], b[2]
                tops[count, TOP_LOW], tops[count, TOP_HIGH] = low, high
                count += 1
    for i in range(0, count, 8):
        n = put_pairs(P, by, row(tops, i), min(count - i, 8), (curvature, away), starts, n)
    keep(rows)
    keep(tops)
    return n


@kernel
def put_pairs(P, by, tops, count, shape, starts, n):
    """Append both bends of up to eight greatest reaches that are past the pose; how many starts there are.

    `shape` is how the reach bends with the elbow, and the direction in which it is greatest.
    """
    curvature, away = shape
    q, turning = take_eight(tops, TOP), take_ways(tops, OUTER_WAY, TOP)
    begin, end = gather(tops, TOP_BEGIN, TOP), gather(tops, TOP_END, TOP)
    low, high = gather(tops, TOP_LOW, TOP), gather(tops, TOP_HIGH, TOP)
    past, bending = 0.0 * low, turning
    good = going = (1 << count) - 1
    for _ in range(CUTS):
        part = begin + (end - begin) * low / (low - high)
        ahead = where(as_mask(going), part - q[2], 0.0 * part)
        q, past, rise, turning, bending, met = best_bends(P, by.target, along7(q, ahead, turning), curvature)
        good &= met
        enough = past * curvature < -0.5 * (ROOM * curvature) ** 2
        going &= good & ~as_bits(enough | (abs(rise) < LEVEL) | (end - begin < NARROWEST))
        if going == 0:
            break
        rises = away * rise > 0.0
        begin, end = where(rises, part, begin), where(rises, end, part)
        low, high = where(rises, away * rise, 0.5 * low), where(rises, 0.5 * high, away * rise)
    for i in range(8):
        reach = one_of(past, i)
        if (good >> i) & 1 == 1 and reach * curvature < -0.5 * (LEAST_BEND * curvature) ** 2:
            bend = math.sqrt(-2.0 * reach / curvature)
            for sign in range(2):
                there = along7(one_of_seven(q, i), bend if sign == 0 else -bend, one_of_seven(bending, i))
                if n < starts.shape[0]:
                    for j in range(7):
                        starts[n, j] = there[j]
                    n += 1
    return n
