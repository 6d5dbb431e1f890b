"""The postures of a pose as strips: runs of postures from end to end of each feasible interval of arm angles.

A posture of a strip is a row of figures (`NODE`): seven joint angles, its arm angle, its branch, and
how far the costs sag towards the next one. Rows are close enough, in joint angles, that what lies between
two of them is almost straight: next to a singularity, where joints 1 and 3 (or 5 and 7) turn by half a turn while the
arm angle stands still, there are as many as the joints need. Where a joint has more than one turn, each combination of
turns has strips of its own.
"""

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import apart, store7
from srs_ik.kernels.algebra.lane_trig import angle_of, turn
from srs_ik.kernels.algebra.lanes import LANES, as_bits, as_mask, eight_of, gather, scatter, where
from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.algebra.vectors import load3
from srs_ik.kernels.chain.eight import put_eight
from srs_ik.kernels.exact.samples import add_changes
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import FIRST_JOINT, INVERSE_HALF_RANGE, LOWER, RANGE_KIND, SHOULDER, UPPER, WRIST
from srs_ik.kernels.layout.path import MEMO, MEMO_CLEAR, MEMO_SHOULDER, MEMO_STAMP, MEMO_WRIST, NODE_BRANCH, NODE_PSI
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.limits import TURN, turn_to_middle
from srs_ik.kernels.limb.postures_eight import eight_postures, in_middle_turn
from srs_ik.kernels.limb.spherical import columns_at, eight_middles, sines
from srs_ik.kernels.path.followed import CLEAR, posture_of, turn_all, turned_away

SPACING = 0.45
"""Farthest that a joint moves between two postures of a strip, rad."""

GRID = 256
"""Arm angles all around at which the postures of all branches are worked out together, when one is asked for."""

WIDEST = 32
"""Farthest apart in arm angle, on that grid: eight of them, which are worked out at once."""

END = 8
"""An end of an interval: arm angle and joint angles."""

FINEST = TURN / GRID
"""Between two angles of the grid, rad."""

CLOSEST = 1e-14
"""Arm angles closer than this, rad, are one: what the joints do between them, a singularity lets them do."""

ROUNDING = 1e-6
"""An end of an interval may be off so far, rad."""

DEEPEST = 60


@kernel
def put_node(nodes, n, q, psi, branch):
    """Write a posture of a strip."""
    store7(row(nodes, n), 0, q)
    nodes[n, NODE_PSI], nodes[n, NODE_BRANCH] = psi, branch


@kernel
def is_wide(P, joint):
    """Whether a joint has limits, and more than one turn inside them somewhere."""
    return P[RANGE_KIND + joint] == 0.0 and P[INVERSE_HALF_RANGE + joint] != 0.0


@kernel
def has_turns(P):
    """Whether a joint may be in one turn or another."""
    some = False
    for joint in range(7):
        some = some or P[RANGE_KIND + joint] == 0.0
    return some


@kernel
def fill_half(P, k, motion, turns, memo, at, stride):
    """Write both solutions of a spherical joint at eight arm angles; as bits, which are clear cut."""
    v, y = columns_at(motion, turns[0], turns[1])
    first = int(P[k + FIRST_JOINT])
    c, s, missed = eight_middles(P, k, v)
    for sign in range(2):
        one, two, three, _ = sines(P, k, v, y, c, s if sign == 0 else -s)
        scatter(memo, at + 3 * sign, stride, in_middle_turn(P, first, angle_of(one[0], one[1])))
        scatter(memo, at + 3 * sign + 1, stride, in_middle_turn(P, first + 1, angle_of(two[0], two[1])))
        scatter(memo, at + 3 * sign + 2, stride, in_middle_turn(P, first + 2, angle_of(three[0], three[1])))
    return as_bits(s > CLEAR) & ~as_bits(missed)


@kernel
def fill_eight(P, side, number, stamp, memo):
    """Write what is known at eight angles of the grid, that of a number among them: `WIDEST` apart, or neighbours."""
    each, first = WIDEST, number % WIDEST
    if number % LANES > 0:
        each, first = 1, number // LANES * LANES
    at, stride = first * MEMO, each * MEMO
    psi = eight_of(0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0) * (each * FINEST) + FINEST * first
    turns = turn(psi)
    clear = fill_half(P, SHOULDER, side[1], turns, memo, at + MEMO_SHOULDER, stride)
    clear &= fill_half(P, WRIST, side[2], turns, memo, at + MEMO_WRIST, stride)
    scatter(memo, at + MEMO_STAMP, stride, 0.0 * psi + stamp)
    scatter(memo, at + MEMO_CLEAR, stride, where(as_mask(clear), 0.0 * psi + 1.0, 0.0 * psi))


@kernel
def grid_posture(P, side, number, branch, q, begun, known):
    """The posture of a branch at an angle of the grid, following another one, and whether there is one."""
    _, stamp, loose, _ = known
    memo = row(known[0], (branch >> 2) * GRID * MEMO)
    at = number % GRID * MEMO
    if memo[at + MEMO_STAMP] != stamp:
        fill_eight(P, side, number % GRID, stamp, memo)
    if memo[at + MEMO_CLEAR] == 0.0:
        return posture_of(P, side, FINEST * number, branch, q, begun)
    a = load3(memo, at + MEMO_SHOULDER + 3 * ((branch >> 1) & 1))
    b = load3(memo, at + MEMO_WRIST + 3 * (branch & 1))
    there = (a[0], a[1], a[2], turn_to_middle(P, 3, side[0]), b[0], b[1], b[2])
    return turn_all(P, there, q, begun) if loose else there, True


@kernel
def room_for_ends(found):
    """Where `fill_ends` writes the ends of as many intervals."""
    return np.empty((2 * found.shape[0] + LANES, END))


@kernel
def fill_ends(P, sides, found, count, ends):
    """Write the postures at both ends of intervals: arm angle, infinite where they are unsure, and joint angles."""
    last = 2 * count - 1
    for k in range(last // LANES * LANES + LANES):
        i = min(k, last) // 2
        ends[k, 0], ends[k, 1] = found[i, 1 + min(k, last) % 2], found[i, 0]
    for first in range(0, last, LANES):
        rows = row(ends, first)
        c, s = turn(gather(rows, 0, END))
        q, sure = eight_postures(P, sides, gather(rows, 1, END), c, s)
        put_eight(row(rows, 1), END, sure, q)
        for k in range(LANES):
            if not sure >> k & 1:
                ends[first + k, 0] = math.inf


@kernel
def posture_at_angle(P, side, psi, branch, q, begun, known):
    """The posture of a branch at any angle, following another one, and whether there is one."""
    _, _, loose, ends = known
    for end in range(2):
        if psi == ends[END * end]:
            there = read7(row(ends, END * end + 1))
            return turn_all(P, there, q, begun) if loose else there, True
    number = math.floor(psi / FINEST + 0.5)
    if psi == FINEST * number:
        return grid_posture(P, side, int(number), branch, q, begun, known)
    return posture_of(P, side, psi, branch, q, begun)


@kernel
def between_angles(psi, ahead):
    """An arm angle about the middle of two, on the grid if one is there: the roundest number."""
    middle = 0.5 * (psi + ahead)
    room = 0.25 * (ahead - psi)
    step = WIDEST
    while step >= 1:
        angle = FINEST * (step * math.floor(middle / (FINEST * step) + 0.5))
        if abs(angle - middle) < room:
            return angle
        step //= 2
    return middle


@kernel
def first_angles(P, side, lower, upper, targets):
    """Arm angles at which an interval is looked at first, sorted: both ends, some between, turns of wide joints."""
    wide = FINEST * WIDEST
    targets[0] = lower
    n = 1
    number = math.floor(lower / wide) + 1.0
    while wide * number < upper:
        targets[n] = FINEST * (WIDEST * number)
        number += 1.0
        n += 1
    targets[n] = upper
    n += 1
    if upper > lower:
        for joint in range(7):
            if joint != 3 and is_wide(P, joint):
                k = SHOULDER if joint < 3 else WRIST
                motion = side[1] if joint < 3 else side[2]
                n = add_changes(P, k, motion, joint, P[LOWER + joint], lower, upper, targets, n)
                n = add_changes(P, k, motion, joint, P[UPPER + joint], lower, upper, targets, n)
    return n


@kernel
def widest_step(q, ahead, around):
    """Joint step from a posture to the next above which there are others between, about a posture if one is given."""
    if around.radius == 0.0:
        return SPACING
    return around.spacing if turned_away(q, around.q) < around.radius + 2.0 * apart(ahead, q) else math.inf


@kernel
def take_strip(P, side, interval, around, sheet, n, desk):
    """Write the postures of an interval (branch, lower, upper, ends) from row n on, and their links; the next free row.

    Fine strips hold only the postures that are as near as is asked for, close together.
    """
    branch, lower, upper, ends = interval
    nodes, linked = sheet.nodes, sheet.linked
    targets, stack, loose = desk.targets, desk.stack, has_turns(P)
    known = (row(desk.memo, 0), desk.stamp[0], loose, ends)
    count = first_angles(P, side, lower, upper, targets)
    q, psi, begun, written = NO_SEED, lower, False, False
    for i in range(count):
        if begun and targets[i] <= psi:
            continue
        wanted, good = posture_at_angle(P, side, targets[i], branch, q, begun, known)
        if not good:
            continue
        put_node(stack, 0, wanted, targets[i], branch)
        top = 0
        while top >= 0 and n < nodes.shape[0]:
            ahead = stack[top, NODE_PSI]
            wanted = read7(row(stack, top))
            if loose:
                wanted = turn_all(P, wanted, q, begun)
            moved = apart(wanted, q)
            if begun and moved > widest_step(q, wanted, around):
                middle = between_angles(psi, ahead)
                if ahead - psi > CLOSEST * max(1.0, abs(psi)) and top + 1 < DEEPEST and psi < middle < ahead:
                    between, good = posture_at_angle(P, side, middle, branch, q, True, known)
                    if good:
                        top += 1
                        put_node(stack, top, between, middle, branch)
                        continue
            if written:
                linked[n - 1] = begun and (moved <= SPACING or is_split(q, wanted))
            if around.radius == 0.0 or turned_away(wanted, around.q) < around.radius:
                put_node(nodes, n, wanted, ahead, branch)
                linked[n] = False
                written = True
                n += 1
            else:
                if written:
                    linked[n - 1] = False
                written = False
            q, psi, begun = wanted, ahead, True
            top -= 1
    return n


@kernel
def is_split(a, b):
    """Whether two postures at one arm angle differ by a turn of joint 1 against 3, and of joint 5 against 7, alone."""
    shoulder = min(abs((b[0] - a[0]) + (b[2] - a[2])), abs((b[0] - a[0]) - (b[2] - a[2])))
    wrist = min(abs((b[4] - a[4]) + (b[6] - a[6])), abs((b[4] - a[4]) - (b[6] - a[6])))
    rest = max(abs(b[1] - a[1]), abs(b[3] - a[3]), abs(b[5] - a[5]))
    return max(shoulder, wrist, rest) < 1e-5
