"""The roll of a hand whose direction alone is given: the turn about it that leaves the wrist most room.

With elbow and arm angle fixed, what the wrist has to turn moves on circles with the roll, just as it does with the arm
angle when the hand is fixed. So the rolls at which the wrist keeps its limits are exact intervals too.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.branches import best_half
from srs_ik.kernels.elbow import elbow_at, elbow_side, frame_at, turned_frame
from srs_ik.kernels.intervals import MAX_EVENTS, MAX_PIECES, joint_pieces
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import (
    A1,
    A3,
    ACROSS_3,
    AXES,
    INVERSE_HALF_RANGE,
    MIDDLE,
    SHOULDER,
    WRIST,
)
from srs_ik.kernels.limits import turn_to_middle, violation
from srs_ik.kernels.scoring import NO_SEED, OUTSIDE, elbow_part
from srs_ik.kernels.spherical import angles, default_anchor, middle_angle
from srs_ik.kernels.vectors import across, apply, apply_transposed, cross, dot, load3, rotate, scale, swing

STEP = 2.0 * math.pi / 48.0
"""Widest spacing of the rolls at which an interval is looked at."""

FEWEST = 8
"""Fewest parts into which an interval is cut."""

GOLDEN = 0.6180339887498949
REFINED = 1e-10
"""Width of a bracket, rad, at which its golden section ends."""

EVENNESS = 1e-4
"""Weight of the joints' squared distances from their middles: it decides between rolls of the same margin."""

WALK = math.pi / 180.0
"""Step, rad, at which arm angles are tried where the wanted one has no feasible roll."""

BISECTIONS = 36
"""Halvings that bring a step of WALK down to 3e-13 rad."""

NONE = 1e12
"""Cost of a roll that does not exist."""


@kernel
def on_axis(axis, a):
    """The circle on which a vector moves when it is turned about a unit axis: constant, cosine and sine part."""
    return scale(dot(axis, a), axis), across(a, axis), cross(axis, a)


@kernel
def roll_motion(P, place_, elbow, psi, axis):
    """What the wrist has to make at an arm angle, as circles over the roll of the hand about an axis (base frame)."""
    hand = place_[4]
    c4, s4, arm = elbow_at(P, place_, elbow)
    base = frame_at(place_, math.cos(psi), math.sin(psi))
    a4 = load3(P, AXES + 9)
    v = on_axis(axis, apply(hand, load3(P, WRIST + A3)))
    y = on_axis(axis, apply(hand, load3(P, WRIST + ACROSS_3)))
    r = on_axis(axis, turned_frame(base, arm, rotate(a4, c4, s4, load3(P, WRIST + A1))))
    return (
        in_forearm(base, arm, a4, c4, s4, v),
        in_forearm(base, arm, a4, c4, s4, y),
        (apply_transposed(hand, r[0]), apply_transposed(hand, r[1]), apply_transposed(hand, scale(-1.0, r[2]))),
    )


@kernel
def in_forearm(base, arm, a4, c4, s4, circle):
    """A circle of the base frame seen from the forearm."""
    return (
        rotate(a4, c4, -s4, turned_frame(arm, base, circle[0])),
        rotate(a4, c4, -s4, turned_frame(arm, base, circle[1])),
        rotate(a4, c4, -s4, turned_frame(arm, base, circle[2])),
    )


@kernel
def roll_cost(P, motion, roll, sign):
    """How far the wrist is from the middles of its ranges, 1 on a limit; a joint without limits counts with +-pi."""
    c = math.cos(roll)
    s = math.sin(roll)
    v0, y0, _ = motion
    v = swing(v0[0], v0[1], v0[2], c, s)
    cosine, sine, reached = middle_angle(P, WRIST, v)
    q = angles(P, WRIST, v, swing(y0[0], y0[1], y0[2], c, s), cosine, sine, sign, default_anchor(P, WRIST))
    worst = 0.0
    total = 0.0
    for i in range(3):
        joint = 4 + i
        share = P[INVERSE_HALF_RANGE + joint]
        away = abs(turn_to_middle(P, joint, q[i]) - P[MIDDLE + joint]) * (share if share > 0.0 else 1.0 / math.pi)
        worst = max(worst, away)
        total += away * away
    return worst + EVENNESS * total if reached else NONE


@kernel
def refine_roll(P, motion, sign, lower, upper):
    """Golden-section search for the best roll between two: roll, cost."""
    a = lower
    b = upper
    x = b - GOLDEN * (b - a)
    y = a + GOLDEN * (b - a)
    fx = roll_cost(P, motion, x, sign)
    fy = roll_cost(P, motion, y, sign)
    while b - a > REFINED:
        if fx <= fy:
            b = y
            y = x
            fy = fx
            x = b - GOLDEN * (b - a)
            fx = roll_cost(P, motion, x, sign)
        else:
            a = x
            x = y
            fx = fy
            y = a + GOLDEN * (b - a)
            fy = roll_cost(P, motion, y, sign)
    return (x, fx) if fx <= fy else (y, fy)


@kernel
def search_piece(P, motion, sign, lower, upper):
    """The best roll of an interval: roll, cost. Every dip between neighbouring samples is closed in on."""
    count = max(math.ceil((upper - lower) / STEP), FEWEST) if upper > lower else 0
    best = lower
    lowest = roll_cost(P, motion, lower, sign)
    before = lowest
    here = lowest
    for i in range(1, count + 2):
        behind = here
        if i <= count:
            behind = roll_cost(P, motion, lower + (upper - lower) * i / count, sign)
        if here <= before and here <= behind:
            x = lower + (upper - lower) * max(i - 2, 0) / max(count, 1)
            y = lower + (upper - lower) * min(i, count) / max(count, 1)
            if here < lowest:
                best = lower + (upper - lower) * (i - 1) / max(count, 1)
                lowest = here
            roll, cost = refine_roll(P, motion, sign, x, y)
            if cost < lowest:
                best = roll
                lowest = cost
        before = here
        here = behind
    return best, lowest


@kernel
def wrist_rolls(P, motion, respect, pieces):
    """Feasible rolls of both wrist solutions into pieces (2, MAX_PIECES, 2); their numbers. Any roll without limits."""
    if respect:
        return joint_pieces(P, WRIST, motion, 3, np.empty(MAX_EVENTS), np.empty(MAX_EVENTS, np.int64), pieces)
    for sign in range(2):
        pieces[sign, 0, 0] = -math.pi
        pieces[sign, 0, 1] = math.pi
    return 1, 1


@kernel
def best_roll_at(P, place_, psi, axis, respect):
    """The most comfortable roll at an arm angle: roll, branch in which it is, cost (NONE where there is no roll)."""
    pieces = np.empty((2, MAX_PIECES, 2))
    best = 0.0
    branch = -1
    lowest = NONE
    for elbow in range(2):
        q4, motion_s, _, _ = elbow_side(P, place_, elbow)
        _, cost_e = elbow_part(P, q4, False, 0.0, respect)
        cosine = math.cos(psi)
        _, shoulder, cost_s = best_half(P, SHOULDER, 0, motion_s, cosine, math.sin(psi), -1, False, NO_SEED, respect)
        if max(cost_e, cost_s) >= OUTSIDE:
            continue
        motion = roll_motion(P, place_, elbow, psi, axis)
        counts = wrist_rolls(P, motion, respect, pieces)
        for sign in range(2):
            for i in range(counts[sign]):
                roll, cost = search_piece(P, motion, sign, pieces[sign, i, 0], pieces[sign, i, 1])
                # The arm's own margin decides between the elbow's two sides where it is the smaller one.
                total = max(cost, 1.0 + max(cost_e, cost_s)) + EVENNESS * cost if cost < NONE else NONE
                if total < lowest:
                    best = roll
                    branch = 4 * elbow + 2 * shoulder + sign
                    lowest = total
    return best, branch, lowest


@kernel
def shoulder_room(P, place_, room):
    """Arm angles that the shoulder allows on each side of the elbow, intervals (2, 2, MAX_PIECES, 2); their numbers."""
    events = np.empty(MAX_EVENTS)
    marks = np.empty(MAX_EVENTS, np.int64)
    q4, motion, _, _ = elbow_side(P, place_, 0)
    first = (0, 0)
    if violation(P, 3, turn_to_middle(P, 3, q4)) == 0.0:
        first = joint_pieces(P, SHOULDER, motion, 3, events, marks, room[0])
    q4, motion, _, _ = elbow_side(P, place_, 1)
    second = (0, 0)
    if violation(P, 3, turn_to_middle(P, 3, q4)) == 0.0:
        second = joint_pieces(P, SHOULDER, motion, 3, events, marks, room[1])
    return first, second


@kernel
def is_within(pieces, counts, psi):
    """Whether an arm angle lies in an interval of either shoulder solution."""
    turn = 2.0 * math.pi
    for sign in range(2):
        for i in range(counts[sign]):
            ahead = psi - pieces[sign, i, 0]
            if ahead - turn * math.floor(ahead / turn) <= pieces[sign, i, 1] - pieces[sign, i, 0]:
                return True
    return False


@kernel
def some_roll_at(P, place_, room, counts, psi, axis):
    """Whether the limits leave any roll at an arm angle."""
    pieces = np.empty((2, MAX_PIECES, 2))
    for elbow in range(2):
        if is_within(room[elbow], counts[elbow], psi):
            n = wrist_rolls(P, roll_motion(P, place_, elbow, psi, axis), True, pieces)
            if n[0] + n[1] > 0:
                return True
    return False


@kernel
def nearest_with_roll(P, place_, psi, axis):
    """The arm angle nearest to psi that leaves a roll: at steps of WALK on both sides, the first success bisected.

    Where there is none, psi itself.
    """
    room = np.empty((2, 2, MAX_PIECES, 2))
    counts = shoulder_room(P, place_, room)
    if counts[0][0] + counts[0][1] + counts[1][0] + counts[1][1] == 0:
        return psi
    for step in range(1, 181):
        for sign in range(2):
            outward = WALK if sign == 0 else -WALK
            if some_roll_at(P, place_, room, counts, psi + step * outward, axis):
                closed = psi + (step - 1) * outward
                opened = psi + step * outward
                for _ in range(BISECTIONS):
                    middle = 0.5 * (closed + opened)
                    if some_roll_at(P, place_, room, counts, middle, axis):
                        opened = middle
                    else:
                        closed = middle
                return opened
    return psi


@kernel
def best_roll(P, place_, psi, axis, respect):
    """The most comfortable roll at an arm angle, or where limits leave none there, at the nearest that leaves one.

    Returns:
        The roll, and the branch in which it is comfortable.
    """
    roll, branch, cost = best_roll_at(P, place_, psi, axis, respect)
    if respect and cost >= NONE:
        roll, branch, cost = best_roll_at(P, place_, nearest_with_roll(P, place_, psi, axis), axis, True)
        if cost >= NONE:
            roll, branch, cost = best_roll_at(P, place_, psi, axis, False)
    return roll, branch
