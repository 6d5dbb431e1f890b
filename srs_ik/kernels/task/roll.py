"""The roll of a hand whose direction alone is given: the turn about it that leaves the wrist most room.

With elbow and arm angle fixed, what the wrist has to turn moves on circles with the roll, just as it does with the arm
angle when the hand is fixed. So the rolls at which the wrist keeps its limits are exact intervals too.
"""

import math

import numpy as np

from srs_ik.kernels.algebra.vectors import across, apply, apply_transposed, cross, dot, load3, rotate, scale
from srs_ik.kernels.exact.events import add_event
from srs_ik.kernels.exact.intervals import joint_pieces
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import MAX_EVENTS, MAX_PIECES
from srs_ik.kernels.layout.limb import A1, A3, ACROSS_3, AXES, INVERSE_HALF_RANGE, MIDDLE, SHOULDER, WRIST
from srs_ik.kernels.limb.branches import anchor, better_half
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE, TIE, elbow_part
from srs_ik.kernels.limb.limits import turn_to_middle, turn_to_seed, violation
from srs_ik.kernels.limb.spherical import angles, columns_at, middle_angle
from srs_ik.kernels.limb.triangle import elbow_at, elbow_side, frame_at, shoulder_columns, side_frames, turned_frame
from srs_ik.kernels.pose.elbow import SMALLEST_NUDGE, nearest_angle
from srs_ik.kernels.task.directions import MAX_CROSSINGS, wrist_crossings

STEP = 2.0 * math.pi / 48.0
"""Widest spacing of the rolls at which an interval is looked at."""

FEWEST = 8
"""Fewest parts into which an interval is cut."""

GOLDEN = 0.6180339887498949
REFINED = 1e-10
"""Width of a bracket, rad, at which its golden section ends."""

EVENNESS = 1e-4
"""Weight of the joints' squared distances from their middles: it decides between rolls of the same margin."""

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
def wrist_at(P, motion, roll, sign, seeded, seed, respect):
    """One solution of the wrist at a roll: its angles, and whether it exists."""
    c, s = math.cos(roll), math.sin(roll)
    v, y = columns_at(motion, c, s)
    cosine, sine, reached = middle_angle(P, WRIST, v)
    return angles(P, WRIST, v, y, cosine, sine, sign, anchor(4, seeded, seed, respect)), reached


@kernel
def roll_cost(P, motion, roll, sign):
    """How far the wrist is from the middles of its ranges, 1 on a limit; a joint without limits counts with +-pi."""
    q, reached = wrist_at(P, motion, roll, sign, False, NO_SEED, False)
    worst, total = 0.0, 0.0
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
    a, b = lower, upper
    x, y = b - GOLDEN * (b - a), a + GOLDEN * (b - a)
    fx, fy = roll_cost(P, motion, x, sign), roll_cost(P, motion, y, sign)
    while b - a > REFINED:
        if fx <= fy:
            b, y, fy = y, x, fx
            x = b - GOLDEN * (b - a)
            fx = roll_cost(P, motion, x, sign)
        else:
            a, x, fx = x, y, fy
            y = a + GOLDEN * (b - a)
            fy = roll_cost(P, motion, y, sign)
    return (x, fx) if fx <= fy else (y, fy)


@kernel
def search_piece(P, motion, sign, lower, upper):
    """The best roll of an interval: roll, cost. Every dip between neighbouring samples is closed in on."""
    count = max(math.ceil((upper - lower) / STEP), FEWEST) if upper > lower else 0
    best = lower
    lowest = roll_cost(P, motion, lower, sign)
    before, here = lowest, lowest
    for i in range(1, count + 2):
        behind = here
        if i <= count:
            behind = roll_cost(P, motion, lower + (upper - lower) * i / count, sign)
        if here <= before and here <= behind:
            x = lower + (upper - lower) * max(i - 2, 0) / max(count, 1)
            y = lower + (upper - lower) * min(i, count) / max(count, 1)
            if here < lowest - TIE:
                best = lower + (upper - lower) * (i - 1) / max(count, 1)
                lowest = here
            roll, cost = refine_roll(P, motion, sign, x, y)
            if cost < lowest - TIE:
                best, lowest = roll, cost
        before, here = here, behind
    return best, lowest


@kernel
def keep_roll(P, motion, sign, lower, upper, seed, respect):
    """The roll of an interval nearest to 0, and how far the wrist is from a seed there, rad squared."""
    roll, _ = nearest_angle(0.0, lower, upper)
    q, reached = wrist_at(P, motion, roll, sign, True, seed, respect)
    total = 0.0
    for i in range(3):
        total += (turn_to_seed(P, 4 + i, q[i], seed[4 + i], respect) - seed[4 + i]) ** 2
    return roll, total if reached else NONE


@kernel
def wrist_rolls(P, motion, respect, pieces):
    """Feasible rolls of both wrist solutions into pieces (2, MAX_PIECES, 2); their numbers. Any roll without limits."""
    if respect:
        return joint_pieces(P, WRIST, motion, 3, np.empty(MAX_EVENTS), np.empty(MAX_EVENTS, np.int64), pieces)
    for sign in range(2):
        pieces[sign, 0, 0], pieces[sign, 0, 1] = -math.pi, math.pi
    return 1, 1


@kernel
def best_roll_at(P, place_, psi, axis, seeded, seed, respect):
    """The best roll at an arm angle: roll, branch in which it is, cost (NONE where there is no roll).

    It is the most comfortable one, or with a seed the nearest to 0 in the branch that is then nearest to the seed.
    """
    pieces = np.empty((2, MAX_PIECES, 2))
    best, branch, lowest = 0.0, -1, NONE
    for elbow in range(2):
        base, arm, c4, s4 = side_frames(P, place_, elbow, math.cos(psi), math.sin(psi))
        _, cost_e = elbow_part(P, math.atan2(s4, c4), seeded, seed[3], respect)
        v, y = shoulder_columns(P, base, arm)
        _, shoulder, cost_s = better_half(P, SHOULDER, 0, v, y, -1, seeded, seed, respect)
        if max(cost_e, cost_s) >= OUTSIDE:
            continue
        motion = roll_motion(P, place_, elbow, psi, axis)
        counts = wrist_rolls(P, motion, respect, pieces)
        for sign in range(2):
            for i in range(counts[sign]):
                lower, upper = pieces[sign, i, 0], pieces[sign, i, 1]
                if seeded:
                    roll, cost = keep_roll(P, motion, sign, lower, upper, seed, respect)
                    total = cost_e + cost_s + cost
                else:
                    roll, cost = search_piece(P, motion, sign, lower, upper)
                    # The arm's own margin decides between the elbow's two sides where it is the smaller one.
                    total = max(cost, 1.0 + max(cost_e, cost_s)) + EVENNESS * cost
                if cost < NONE and total < lowest - TIE:
                    best, branch, lowest = roll, 4 * elbow + 2 * shoulder + sign, total
    return best, branch, lowest


@kernel
def is_within(pieces, counts, psi):
    """Whether an arm angle lies in an interval of either shoulder solution."""
    for sign in range(2):
        for i in range(counts[sign]):
            if nearest_angle(psi, pieces[sign, i, 0], pieces[sign, i, 1])[1] == 0.0:
                return True
    return False


@kernel
def changes(P, place_, elbow, line, room, counts, axis, psis):
    """Write the sorted arm angles at which a roll can come to be feasible, or cease to; return their number."""
    c4, s4, arm = elbow_at(P, place_, elbow)
    wanted = rotate(load3(P, AXES + 9), c4, -s4, turned_frame(arm, frame_at(place_, 1.0, 0.0), axis))
    n = wrist_crossings(P, line, wanted, apply_transposed(place_[4], axis), psis)
    for sign in range(2):
        for i in range(counts[sign]):
            n = add_event(room[sign, i, 0], psis, n)
            n = add_event(room[sign, i, 1], psis, n)
    return n


@kernel
def nearest_gap(P, place_, elbow, psi, axis, farthest):
    """The interval nearest to psi, on one side of the elbow, of arm angles that leave a roll: lower, upper.

    Lower is above upper where none is nearer than `farthest`.
    """
    nothing = (1.0, -1.0)
    q4, motion, _, line = elbow_side(P, place_, elbow)
    if violation(P, 3, turn_to_middle(P, 3, q4)) > 0.0:
        return nothing
    room = np.empty((2, MAX_PIECES, 2))
    counts = joint_pieces(P, SHOULDER, motion, 3, np.empty(MAX_EVENTS), np.empty(MAX_EVENTS, np.int64), room)
    psis = np.empty(MAX_CROSSINGS + 4 * MAX_PIECES)
    n = changes(P, place_, elbow, line, room, counts, axis, psis)
    tried = np.zeros(n, np.bool_)
    pieces = np.empty((2, MAX_PIECES, 2))
    for _ in range(n):
        best, lower, upper, least = -1, 0.0, 0.0, farthest
        for i in range(n):
            end = psis[i + 1] if i + 1 < n else psis[0] + 2.0 * math.pi
            _, away = nearest_angle(psi, psis[i], end)
            if not tried[i] and end > psis[i] and away < least:
                best, lower, upper, least = i, psis[i], end, away
        if best < 0:
            return nothing
        tried[best] = True
        middle = 0.5 * (lower + upper)
        if is_within(room, counts, middle):
            rolls = wrist_rolls(P, roll_motion(P, place_, elbow, middle, axis), True, pieces)
            if rolls[0] + rolls[1] > 0:
                return lower, upper
    return nothing


@kernel
def nearest_roll(P, place_, psi, axis, seeded, seed):
    """The best roll at the arm angle nearest to psi that leaves one inside the limits: roll, branch, cost."""
    lower, upper, least = 1.0, -1.0, 4.0 * math.pi
    for elbow in range(2):
        a, b = nearest_gap(P, place_, elbow, psi, axis, least)
        if a <= b:
            lower, upper = a, b
            least = nearest_angle(psi, a, b)[1]
    nearest, _ = nearest_angle(psi, lower, upper)
    inward = 1.0 if nearest - lower < upper - nearest else -1.0
    nudge = 0.0
    while nudge <= upper - lower:
        roll, branch, cost = best_roll_at(P, place_, nearest + inward * nudge, axis, seeded, seed, True)
        if cost < NONE:
            return roll, branch, cost
        nudge = max(SMALLEST_NUDGE, 8.0 * nudge)
    return 0.0, -1, NONE


@kernel
def best_roll(P, place_, psi, axis, seeded, seed, respect):
    """The best roll at an arm angle, or where limits leave none there, at the nearest arm angle that leaves one.

    Returns:
        The roll, and its branch.
    """
    roll, branch, cost = best_roll_at(P, place_, psi, axis, seeded, seed, respect)
    if respect and cost >= NONE:
        roll, branch, cost = nearest_roll(P, place_, psi, axis, seeded, seed)
        if cost >= NONE:
            roll, branch, _ = best_roll_at(P, place_, psi, axis, seeded, seed, False)
    return roll, branch
