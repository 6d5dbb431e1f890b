"""How far a limb reaches with an almost straight or folded elbow, at each turn of it about the line S-W.

At each turn there is a best bend, with which the wrist is farthest out. How far it is past the pose then tells the
bends, to both sides of the best one, with which the pose is reached: their square is the room at that turn. That
differs from turn to turn by what the axes miss, so that close to the farthest it reaches a pose at some turns alone:
about one at which the room is greater than at all others near it.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, difference, dot7, short_way, store7
from srs_ik.kernels.algebra.lane_trig import turn, turns_of
from srs_ik.kernels.algebra.lanes import ALL, as_bits, eight_of, larger, scatter
from srs_ik.kernels.algebra.pointers import copy, read7, row
from srs_ik.kernels.algebra.vectors import along, cross, dot, scale
from srs_ik.kernels.chain.eight import highest, put_eight, sines_of_eight, take_eight
from srs_ik.kernels.chain.newton_eight import largest, reduced, turned_by_all, with_wrist
from srs_ik.kernels.chain.starts import almost_straight
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import FAR, NEAR
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.postures_eight import eight_postures
from srs_ik.kernels.limb.surface import level_place
from srs_ik.kernels.limb.triangle import elbow_side

TURNS = 16
"""Turns, all around, at which reaches are looked at."""

EVERY_PAIR = 0b1111
"""The pairs of signs of shoulder and wrist, as bits."""

REACH = 23
REACH_ROOM, REACH_RISE, REACH_TURNING, REACH_BENDING = 7, 8, 9, 16
"""What is known at a turn: the joint angles of the best bend; the room, rad squared, and its rise with the turn; the
ways of the joints with the turn, which is that of joint 3, and with the bend, which is that of joint 4."""

STEPS = 8
"""Newton's steps to the best bend at a turn, at most ..."""

SETTLED = 1e-5
"""... and the step, rad, that is the last one."""

LEAST_BEND = 5e-5
"""Where the best bend leaves less room than this, rad, to both sides, Newton's method closes no posture for certain:
the greatest reach tells then by itself what there is around it (`rank_five`)."""

CLEAR = 2.0
"""Where the elbow is almost straight, shoulder and wrist are clear of singularities that are so many times its widest
bend at the pose away, and the widest at any pose."""

ALMOST = 1.2
"""A bend wider by this than what may be straight is clear of it."""

SHORTEST = 1e-9
"""A limb that can be folded to less than this, m, has no line S-W there."""

LONGEST_STEP = 0.5
"""A longer step, rad, leads to no posture nearby."""


MOST_ENDS = 8
"""Turns without room that are told, at most: two for each of the signs of shoulder and wrist."""

SHARPEST = 1e-5
"""A curve that turns around on a shorter way, rad, is followed."""

HALVINGS = 16
"""Steps to where cubics tell that room ends, from which Newton's method goes on."""

AWAY = 0.1
"""Where room ends between two turns, it goes the other way at none, but for this part of its change."""


@kernel
def is_almost_straight(P, place_):
    """Whether the elbow at a pose may be straight or folded on the true chain."""
    return place_[3] < ALMOST * almost_straight(P)


@kernel
def may_be_straight(P, place_):
    """Whether it may be that of a limb that cannot be folded to a point, where the line S-W would be lost."""
    return is_almost_straight(P, place_) and P[NEAR] >= SHORTEST


@kernel
def by_two(made, n, size2, rest):
    """The figures of joints 1 and 2 that make up a moment in the plane of theirs."""
    s1, s2, _, _ = made.s
    return dot(cross(rest, s2), n) / size2, dot(cross(s1, rest), n) / size2


@kernel
def reach_step(P, turns, target, curvature):
    """The step of eight postures to their best bends at their turns: it, room, rise, and both ways (`REACH`)."""
    made = reduced(P, turns, target.R, target.p)
    t = target.place[0]
    s1, s2, s3, s4 = made.s
    n = cross(s1, s2)
    size2 = dot(n, n)
    share = 1.0 / dot(n, t)
    past, rise, slope = -share * dot(n, made.rest), share * dot(n, s3), share * dot(n, s4)
    none = 0.0 * past
    a, b = by_two(made, n, size2, along(scale(slope, t), -1.0, s4))
    bending = with_wrist(made, (0.0, 0.0, 0.0), a, b, none, none + 1.0)
    a, b = by_two(made, n, size2, along(scale(rise, t), -1.0, s3))
    turning = with_wrist(made, (0.0, 0.0, 0.0), a, b, none + 1.0, none)
    a, b = by_two(made, n, size2, along(made.rest, past, t))
    step = along7(with_wrist(made, made.angular, a, b, none, none), -slope / curvature, bending)
    per_room = -2.0 / curvature
    return step, per_room * past, per_room * rise, turning, bending


@kernel
def best_bends(P, target, q, curvature, to_ends):
    """The best bends at the turns of eight postures, or at turns next to them without room (`to_ends`).

    Returns the postures, the room, its rise, the ways with the turn and with the bend, and which there are, as bits.
    """
    turns = turns_of(q)
    turning = bending = q
    room = rise = 0.0 * q[0]
    met = 0
    for _ in range(STEPS):
        step, room, rise, turning, bending = reach_step(P, turns, target, curvature)
        if to_ends:
            step = along7(step, -room / rise, turning)
        size = largest(step)
        q = along7(q, 1.0, step)
        met = as_bits(size < SETTLED)
        if met == ALL or as_bits(size < LONGEST_STEP) != ALL:
            break
        turns = turned_by_all(turns, step)
    return q, room, rise, turning, bending, met


@kernel
def curvature_of(P, level):
    """How the reach curves with the bend where the elbow is flat, m/rad squared; negative if it is straight."""
    reach = P[FAR] if level[2] > 0.0 else -P[NEAR]
    return (P[NEAR] - P[FAR]) * (P[NEAR] + P[FAR]) / (4.0 * reach)


@kernel
def put_reaches(P, target, which, reaches):
    """Write what is known at all turns (`REACH`), for pairs of signs of shoulder and wrist one turn after another.

    Of those pairs that are named by bits. `reaches` is for that, TURNS rows a pair.
    Returns as bits the pairs for which it is known, and those whose shoulder and wrist are away from singular.
    """
    level = level_place(target.place)
    curvature = curvature_of(P, level)
    sides = elbow_side(P, level, 0), elbow_side(P, level, 1)
    eight = eight_of(0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0)
    known = clear = which
    for signs in range(4):
        most, least = 0.0, 1.0
        for first in range(0, TURNS if (which >> signs) & 1 == 1 else 0, 8):
            c, s = turn(2.0 * math.pi / TURNS * (eight + first))
            q, sure = eight_postures(P, sides, 0.0 * eight + signs, c, s)
            q, room, rise, turning, bending, met = best_bends(P, target, q, curvature, False)
            put_best(row(reaches, TURNS * signs + first), (q, room, rise, turning, bending))
            s2, _, s6 = sines_of_eight(P, q)
            if sure & met != ALL:
                known &= ~(1 << signs)
            most, least = max(most, highest(room)), min(least, -highest(larger(-abs(s2), -abs(s6))))
        # No number is not clear.
        if not least > max(almost_straight(P), CLEAR * math.sqrt(most)):
            clear &= ~(1 << signs)
    return known, known & clear


@kernel
def splits_with_ends(reaches):
    """The splits along which the elbow may become flat, as bits in the order of `put_starts`.

    Along one, the sign of its shoulder or wrist changes. Room is between what it is at all turns with both signs, or
    beside it by no more than these differ.
    """
    which = 0
    for i in range(4):
        a, b = (i, i + 2) if i < 2 else (2 * i - 4, 2 * i - 3)
        least = most = reaches[TURNS * a, REACH_ROOM]
        rest = 0.0
        for k in range(2 * TURNS):
            room = reaches[TURNS * (a if k < TURNS else b) + k % TURNS, REACH_ROOM]
            least, most, rest = min(least, room), max(most, room), rest + 0.0 * room
        # Where a room is no number, nothing is told.
        if not (rest == 0.0 and (2.0 * least > most or 2.0 * most < least)):
            which |= 1 << i
    return which


@kernel
def put_best(rows, found):
    """Write what `best_bends` tells into eight rows."""
    q, room, rise, turning, bending = found
    put_eight(rows, REACH, ALL, q)
    scatter(rows, REACH_ROOM, REACH, room)
    scatter(rows, REACH_RISE, REACH, rise)
    put_eight(row(rows, REACH_TURNING), REACH, ALL, turning)
    put_eight(row(rows, REACH_BENDING), REACH, ALL, bending)


@kernel
def next_turn(i):
    """The row of the turn behind that in row i, of the same pair of signs."""
    return i + 1 if (i + 1) % TURNS != 0 else i + 1 - TURNS


@kernel
def pairs_on_line(P, target):
    """The pairs of signs of shoulder and wrist, as bits, with which the elbow at a pose may lie on the line S-W.

    That is where room ends; next to a singular shoulder or wrist, reaches do not tell.
    """
    if P[NEAR] < SHORTEST:
        return 0b1111
    reaches = np.empty((4 * TURNS, REACH))
    _, told = put_reaches(P, target, EVERY_PAIR, reaches)
    pairs = 0b1111
    for signs in range(4):
        first = TURNS * signs
        away = (told >> signs) & 1 == 1
        for k in range(TURNS):
            kind = room_between(reaches[first + k], reaches[next_turn(first + k)])
            away = away and kind in (0, 1)
        pairs ^= (1 << signs) if away else 0
    return pairs


@kernel
def way_of(reach, first):
    """One of the ways of a row of `REACH`."""
    return read7(row(reach, first))


@kernel
def length2_of(reach, first):
    """The square of the length of one of the ways of a row of `REACH`."""
    way = way_of(reach, first)
    return dot7(way, way)


@kernel
def across2_of(reach):
    """The square of the way with the bend, as far as it is across that with the turn."""
    along_turning = dot7(way_of(reach, REACH_TURNING), way_of(reach, REACH_BENDING))
    return length2_of(reach, REACH_BENDING) - along_turning * along_turning / length2_of(reach, REACH_TURNING)


@kernel
def room_between(a, b):
    """Whether there is room between two turns (1), none (0), an end of it (2), or what cannot be told (-1)."""
    width = short_way(b[2] - a[2])
    at_a, at_b = a[REACH_ROOM], b[REACH_ROOM]
    rise_a, rise_b = width * a[REACH_RISE], width * b[REACH_RISE]
    if min(abs(at_a), abs(at_b)) < LEAST_BEND**2:
        return -1
    if (at_a > 0.0) != (at_b > 0.0):
        change = at_b - at_a
        return 2 if min(rise_a * change, rise_b * change) > -AWAY * change * change else -1
    side = math.copysign(1.0, at_a)
    fall, back = -side * rise_a, side * rise_b
    # Where the tangents meet.
    if min(fall, back) > 0.0 and side * at_a <= fall * (side * (at_a - at_b) + back) / (fall + back):
        return -1
    return 1 if side > 0.0 else 0


@kernel
def shares_of(share, width):
    """What counts of the way to the second of two turns, and of the rates at both, on a cubic at a share of the way."""
    rest = 1.0 - share
    return share * share * (3.0 - 2.0 * share), width * share * rest * rest, -width * share * share * rest


@kernel
def room_at(a, b, share):
    """The room between two turns, by the cubic through both."""
    to_b, from_a, from_b = shares_of(share, short_way(b[2] - a[2]))
    change = b[REACH_ROOM] - a[REACH_ROOM]
    return a[REACH_ROOM] + to_b * change + from_a * a[REACH_RISE] + from_b * b[REACH_RISE]


@kernel
def best_at(a, b, share):
    """The best bend between two turns, by the cubic through both: posture, way with the bend."""
    to_b, from_a, from_b = shares_of(share, short_way(b[2] - a[2]))
    q = along7(along7(read7(a), to_b, difference(read7(a), read7(b))), from_a, way_of(a, REACH_TURNING))
    q = along7(q, from_b, way_of(b, REACH_TURNING))
    return q, along7(along7(NO_SEED, 1.0 - share, way_of(a, REACH_BENDING)), share, way_of(b, REACH_BENDING))


@kernel
def share_of_end(a, b):
    """The share of the way between two turns at which room ends."""
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        share = 0.5 * (low + high)
        if (room_at(a, b, share) > 0.0) == (a[REACH_ROOM] > 0.0):
            low = share
        else:
            high = share
    return 0.5 * (low + high)


@kernel
def copy_reach(source, i, target, k):
    """Copy a row of `REACH`."""
    copy(row(source, i), row(target, k), REACH)


@kernel
def put_bests_at_ends(P, by, rows, n):
    """Write what is known at ends of the room next to the turns of up to eight postures; whether all are met."""
    for i in range(n, 8):
        store7(row(rows, i), 0, read7(rows[n - 1]))
    curvature = curvature_of(P, level_place(by.target.place))
    q, room, rise, turning, bending, met = best_bends(P, by.target, take_eight(row(rows, 0), REACH), curvature, True)
    put_best(row(rows, 0), (q, 0.0 * room, rise, turning, bending))
    return met == ALL


@kernel
def find_ends(P, by, which, reaches, ends, gaps):
    """Write the turns at which room ends (`REACH`), and behind which turns these are; their number, -1: not told."""
    n = 0
    for i in range(4 * TURNS):
        if (which >> (i // TURNS)) & 1 == 0:
            continue
        a, b = reaches[i], reaches[next_turn(i)]
        kind = room_between(a, b)
        if kind < 0 or (kind == 2 and n >= MOST_ENDS):
            return -1
        if kind == 2:
            q, _ = best_at(a, b, share_of_end(a, b))
            store7(row(ends, n), 0, q)
            gaps[n] = i
            n += 1
    if n > 0 and not put_bests_at_ends(P, by, ends, n):
        return -1
    for i in range(n):
        a, b = reaches[int(gaps[i])], reaches[next_turn(int(gaps[i]))]
        sharp2 = ends[i, REACH_RISE] ** 2 * across2_of(ends[i]) / length2_of(ends[i], REACH_TURNING)
        share = short_way(ends[i, 2] - a[2]) / short_way(b[2] - a[2])
        if sharp2 < (2.0 * SHARPEST) ** 2 or not 0.0 < share < 1.0:
            return -1
    return n
