"""The postures of a pose as strips: runs of postures from end to end of each feasible interval of arm angles.

A posture of a strip is a row of figures (`NODE`): seven joint angles, its arm angle, its way along the strip, and its
branch. Rows are close enough, in joint angles, that what lies between two of them is almost straight: next to a
singularity, where joints 1 and 3 (or 5 and 7) turn by half a turn while the arm angle stands still, there are as many
as the joints need. Where a joint has more than one turn, each combination of turns has strips of its own.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.branches import NO_BRANCH
from srs_ik.kernels.closure import close_at_angle
from srs_ik.kernels.intervals import insert
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import INVERSE_HALF_RANGE, LOWER, RANGE_KIND, SHOULDER, UPPER, WRIST
from srs_ik.kernels.limits import TURN, turn_to_middle
from srs_ik.kernels.memory import row
from srs_ik.kernels.near_branches import evaluate_branch
from srs_ik.kernels.poses import read7
from srs_ik.kernels.samples import add_changes
from srs_ik.kernels.scoring import NO_SEED
from srs_ik.kernels.spherical import angles, default_anchor, middle_angle
from srs_ik.kernels.vectors import swing

NODE = 10
NODE_PSI = 7
NODE_WAY = 8
NODE_BRANCH = 9

STRIP = 16
STRIP_FIRST = 14
STRIP_LAST = 15
"""A strip: least and largest angle of every joint, the rows of its first and last posture."""

SPACING = 0.25
"""Farthest that a joint moves between two postures of a strip, rad."""

WIDEST = 0.7
"""Farthest apart in arm angle, rad."""

CLOSEST = 1e-14
"""Arm angles closer than this, rad, are one: what the joints do between them, a singularity lets them do."""

ROUNDING = 1e-6
"""An end of an interval may be off so far, rad."""

DEEPEST = 60

NEWTON = 8
"""Steps of Newton's method from the posture before."""


@kernel
def turn_on(P, joint, angle, near, followed):
    """The turn of a joint angle: inside the limits if these tell, else the one nearest to the posture before."""
    if not followed or P[RANGE_KIND + joint] != 0.0:
        return turn_to_middle(P, joint, angle)
    return angle + TURN * math.floor((near - angle) / TURN + 0.5)


@kernel
def turn_all(P, q, near, followed):
    """`turn_on` for all joints."""
    return (
        turn_on(P, 0, q[0], near[0], followed),
        turn_on(P, 1, q[1], near[1], followed),
        turn_on(P, 2, q[2], near[2], followed),
        turn_on(P, 3, q[3], near[3], followed),
        turn_on(P, 4, q[4], near[4], followed),
        turn_on(P, 5, q[5], near[5], followed),
        turn_on(P, 6, q[6], near[6], followed),
    )


@kernel
def half_posture(P, k, first, motion, c, s, sign, near, followed):
    """One solution of a spherical joint at cosine and sine of an arm angle, and whether its axes can make it."""
    v0, y0, _ = motion
    v = swing(v0[0], v0[1], v0[2], c, s)
    y = swing(y0[0], y0[1], y0[2], c, s)
    cm, sm, reached = middle_angle(P, k, v)
    anchor = (near[first], near[first + 2], 0.5, first) if followed else default_anchor(P, k)
    return angles(P, k, v, y, cm, sm, sign, anchor), reached


@kernel
def posture_of(P, place_, side, R, p, psi, branch, near, followed, A):
    """The posture of a branch at an arm angle, turned to follow another one, and whether there is one.

    A is None on a limb that the closed form answers; else work space, (16, 9).
    """
    if A is not None:
        if followed:
            q, closed = close_at_angle(P, near, R, p, place_[0], place_[1], psi, NEWTON, A)
            if closed and away(q, near) < 1.0:
                return turn_all(P, q, near, True), True
        q, lowest = evaluate_branch(P, place_, side, R, p, psi, branch, followed, near, False, A)
        return turn_all(P, q, near, followed), lowest < NO_BRANCH
    c = math.cos(psi)
    s = math.sin(psi)
    a, reached_s = half_posture(P, SHOULDER, 0, side[1], c, s, (branch >> 1) & 1, near, followed)
    b, reached_w = half_posture(P, WRIST, 4, side[2], c, s, branch & 1, near, followed)
    return turn_all(P, (a[0], a[1], a[2], side[0], b[0], b[1], b[2]), near, followed), reached_s and reached_w


@kernel
def away(q, near):
    """Largest joint step between two postures."""
    most = 0.0
    for j in range(7):
        most = max(most, abs(q[j] - near[j]))
    return most


@kernel
def settled(P, q, slack):
    """The posture with joints that lie outside their limits by rounding put on them, and whether it is inside then."""
    inside = True
    for j in range(7):
        inside = inside and q[j] <= P[UPPER + j] + slack and q[j] >= P[LOWER + j] - slack
    return (
        min(max(q[0], P[LOWER + 0]), P[UPPER + 0]),
        min(max(q[1], P[LOWER + 1]), P[UPPER + 1]),
        min(max(q[2], P[LOWER + 2]), P[UPPER + 2]),
        min(max(q[3], P[LOWER + 3]), P[UPPER + 3]),
        min(max(q[4], P[LOWER + 4]), P[UPPER + 4]),
        min(max(q[5], P[LOWER + 5]), P[UPPER + 5]),
        min(max(q[6], P[LOWER + 6]), P[UPPER + 6]),
    ), inside


@kernel
def put_node(nodes, n, q, psi, branch):
    """Write a posture of a strip."""
    for j in range(7):
        nodes[n, j] = q[j]
    nodes[n, NODE_PSI] = psi
    nodes[n, NODE_BRANCH] = branch


@kernel
def is_wide(P, joint):
    """Whether a joint has limits, and more than one turn inside them somewhere."""
    return P[RANGE_KIND + joint] == 0.0 and P[INVERSE_HALF_RANGE + joint] != 0.0


@kernel
def first_angles(P, side, lower, upper, targets):
    """Arm angles at which an interval is looked at first, sorted: both ends, some between, turns of wide joints."""
    count = max(int(math.ceil((upper - lower) / WIDEST)), 1)
    n = 0
    for i in range(count + 1):
        targets[n] = lower + (upper - lower) * i / count if i < count else upper
        n += 1
    if upper > lower:
        for joint in range(7):
            if joint != 3 and is_wide(P, joint):
                k = SHOULDER if joint < 3 else WRIST
                motion = side[1] if joint < 3 else side[2]
                n = add_limit(P, k, motion, joint, P[LOWER + joint], lower, upper, targets, n)
                n = add_limit(P, k, motion, joint, P[UPPER + joint], lower, upper, targets, n)
    return n


@kernel
def add_limit(P, k, motion, joint, angle, lower, upper, targets, n):
    """Insert the arm angles at which a joint of a spherical joint passes an angle, on both sides of each."""
    return add_changes(P, k, motion, joint, angle, lower, upper, targets, n)


@kernel
def take_strip(P, place_, side, R, p, branch, lower, upper, nodes, linked, n, work, A):
    """Write the postures of an interval from row n on, and whether each is linked to the next; the next free row."""
    targets, stack = work
    count = first_angles(P, side, lower, upper, targets)
    q = NO_SEED
    psi = lower
    begun = False
    for i in range(count):
        if begun and targets[i] <= psi:
            continue
        top = 0
        wanted, good = posture_of(P, place_, side, R, p, targets[i], branch, q, begun, A)
        if not good:
            continue
        if not begun:
            q, psi, begun = wanted, targets[i], True
            put_node(nodes, n, q, psi, branch)
            linked[n] = False
            n += 1
            continue
        put_node(stack, 0, wanted, targets[i], branch)
        while top >= 0 and n < nodes.shape[0]:
            ahead = stack[top, NODE_PSI]
            wanted = turn_all(P, read7(row(stack, top)), q, True)
            middle = 0.5 * (psi + ahead)
            apart = away(wanted, q)
            if apart > SPACING and ahead - psi > CLOSEST * max(1.0, abs(psi)) and psi < middle < ahead:
                if top + 1 < DEEPEST:
                    between, good = posture_of(P, place_, side, R, p, middle, branch, q, True, A)
                    if good:
                        top += 1
                        put_node(stack, top, between, middle, branch)
                        continue
            linked[n - 1] = apart <= SPACING or is_split(q, wanted)
            q, psi = wanted, ahead
            put_node(nodes, n, q, psi, branch)
            linked[n] = False
            n += 1
            top -= 1
    return n


@kernel
def is_split(a, b):
    """Whether two postures at one arm angle differ by a turn of joint 1 against 3, and of joint 5 against 7, alone."""
    shoulder = min(abs((b[0] - a[0]) + (b[2] - a[2])), abs((b[0] - a[0]) - (b[2] - a[2])))
    wrist = min(abs((b[4] - a[4]) + (b[6] - a[6])), abs((b[4] - a[4]) - (b[6] - a[6])))
    rest = max(abs(b[1] - a[1]), abs(b[3] - a[3]), abs(b[5] - a[5]))
    return max(shoulder, wrist, rest) < 1e-5


@kernel
def turns_inside(P, joint, nodes, n0, n1):
    """First and last whole turn by which a joint of a run of postures may be turned to be inside its limits."""
    least = nodes[n0, joint]
    most = least
    for i in range(n0 + 1, n1):
        least = min(least, nodes[i, joint])
        most = max(most, nodes[i, joint])
    first = math.ceil((P[LOWER + joint] - most - ROUNDING) / TURN)
    last = math.floor((P[UPPER + joint] - least + ROUNDING) / TURN)
    return int(first), int(last)


@kernel
def put_turned(P, nodes, linked, n0, n1, turns, n):
    """Append a run of postures, joints turned by whole turns, as far as they are inside the limits then."""
    before = False
    for i in range(n0, n1):
        q = read7(row(nodes, i))
        q = (
            q[0] + TURN * turns[0],
            q[1] + TURN * turns[1],
            q[2] + TURN * turns[2],
            q[3] + TURN * turns[3],
            q[4] + TURN * turns[4],
            q[5] + TURN * turns[5],
            q[6] + TURN * turns[6],
        )
        q, inside = settled(P, q, ROUNDING)
        if inside and n < nodes.shape[0]:
            put_node(nodes, n, q, nodes[i, NODE_PSI], nodes[i, NODE_BRANCH])
            linked[n] = False
            if before and linked[i - 1]:
                linked[n - 1] = True
            n += 1
        before = inside
    return n


@kernel
def turn_strips(P, nodes, linked, n0, n1, turns):
    """Replace a run of postures by one run for each combination of turns inside the limits; the next free row."""
    firsts = np.zeros(7, np.int64)
    counts = np.ones(7, np.int64)
    total = 1
    for joint in range(7):
        if is_wide(P, joint):
            first, last = turns_inside(P, joint, nodes, n0, n1)
            firsts[joint] = first
            counts[joint] = max(last - first + 1, 0)
            total *= counts[joint]
    n = n1
    for number in range(total):
        rest = number
        for joint in range(7):
            turns[joint] = firsts[joint] + rest % counts[joint]
            rest //= counts[joint]
        n = put_turned(P, nodes, linked, n0, n1, turns, n)
    for i in range(n1, n):
        for j in range(NODE):
            nodes[n0 + i - n1, j] = nodes[i, j]
        linked[n0 + i - n1] = linked[i]
    return n0 + n - n1


@kernel
def list_strips(nodes, linked, n0, n1, strips, count):
    """Measure the strips among the postures of rows n0 to n1 - 1 and list them; returns how many there are."""
    start = n0
    for i in range(n0, n1):
        if i == start:
            nodes[i, NODE_WAY] = 0.0
        else:
            nodes[i, NODE_WAY] = nodes[i - 1, NODE_WAY] + away(row(nodes, i), row(nodes, i - 1))
        if linked[i] and i + 1 < n1:
            continue
        if count < strips.shape[0]:
            for j in range(7):
                strips[count, j] = nodes[start, j]
                strips[count, 7 + j] = nodes[start, j]
                for k in range(start + 1, i + 1):
                    strips[count, j] = min(strips[count, j], nodes[k, j])
                    strips[count, 7 + j] = max(strips[count, 7 + j], nodes[k, j])
            strips[count, STRIP_FIRST] = start
            strips[count, STRIP_LAST] = i
            count += 1
        start = i + 1
    return count
