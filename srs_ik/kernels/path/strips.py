"""The postures of a pose as strips: runs of postures from end to end of each feasible interval of arm angles.

A posture of a strip is a row of figures (`NODE`): seven joint angles, its arm angle, its way along the strip, its
branch, and how far the costs sag towards the next one. Rows are close enough, in joint angles, that what lies between
two of them is almost straight: next to a singularity, where joints 1 and 3 (or 5 and 7) turn by half a turn while the
arm angle stands still, there are as many as the joints need. Where a joint has more than one turn, each combination of
turns has strips of its own.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.joint_vectors import apart
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import load3, store3, swing
from srs_ik.kernels.exact.samples import add_changes
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import (
    A1_A2,
    A2_A3,
    FIRST_JOINT,
    INVERSE_HALF_RANGE,
    LOWER,
    RANGE_KIND,
    SHOULDER,
    UPPER,
    WRIST,
)
from srs_ik.kernels.layout.path import MEMO, MEMO_CLEAR, MEMO_SHOULDER, MEMO_STAMP, MEMO_WRIST, NODE_BRANCH, NODE_PSI
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.limits import TURN, turn_to_middle
from srs_ik.kernels.limb.poses import read7
from srs_ik.kernels.limb.spherical import angles, middle_anchor, middle_angle, mirrored
from srs_ik.kernels.path.followed import posture_of, turn_all, turned_away

SPACING = 0.45
"""Farthest that a joint moves between two postures of a strip, rad."""

GRID = 288
"""Arm angles all around at which the postures of all branches are worked out together, when one is asked for."""

WIDEST = 32
"""Farthest apart in arm angle, on that grid."""

FINEST = TURN / GRID
"""Between two angles of the grid, rad."""

CLEAR = 1e-4
"""A sine of joints 2 or 6, from their phases, above which a spherical joint has two solutions that are far apart."""

CLOSEST = 1e-14
"""Arm angles closer than this, rad, are one: what the joints do between them, a singularity lets them do."""

ROUNDING = 1e-6
"""An end of an interval may be off so far, rad."""

DEEPEST = 60


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
def has_turns(P):
    """Whether a joint may be in one turn or another."""
    some = False
    for joint in range(7):
        some = some or P[RANGE_KIND + joint] == 0.0
    return some


@kernel
def turned(P, k, q):
    """Three angles of a spherical joint in the turns next to the middles of their ranges."""
    first = int(P[k + FIRST_JOINT])
    return (
        turn_to_middle(P, first, q[0]),
        turn_to_middle(P, first + 1, q[1]),
        turn_to_middle(P, first + 2, q[2]),
    )


@kernel
def fill_half(P, k, motion, turn, memo, at):
    """Write both solutions of a spherical joint at cosine and sine of an arm angle; whether they are clear cut."""
    v0, y0, _ = motion
    v = swing(v0[0], v0[1], v0[2], turn[0], turn[1])
    y = swing(y0[0], y0[1], y0[2], turn[0], turn[1])
    c, s, reached = middle_angle(P, k, v)
    if not reached or s < CLEAR:
        return False
    above = angles(P, k, v, y, c, s, 0, middle_anchor())
    store3(memo, at, turned(P, k, above))
    if P[k + A1_A2] == 0.0 and P[k + A2_A3] == 0.0:
        store3(memo, at + 3, turned(P, k, mirrored(P, k, above)))
    else:
        store3(memo, at + 3, turned(P, k, angles(P, k, v, y, c, s, 1, middle_anchor())))
    return True


@kernel
def grid_posture(P, side, number, branch, q, begun, known):
    """The posture of a branch at an angle of the grid, following another one, and whether there is one."""
    memo, stamp, loose = known
    at = ((branch >> 2) * GRID + number % GRID) * MEMO
    if memo[at + MEMO_STAMP] != stamp:
        memo[at + MEMO_STAMP] = stamp
        turn = (math.cos(FINEST * number), math.sin(FINEST * number))
        clear = fill_half(P, SHOULDER, side[1], turn, memo, at + MEMO_SHOULDER)
        clear = clear and fill_half(P, WRIST, side[2], turn, memo, at + MEMO_WRIST)
        memo[at + MEMO_CLEAR] = 1.0 if clear else 0.0
    if memo[at + MEMO_CLEAR] == 0.0:
        return posture_of(P, side, FINEST * number, branch, q, begun)
    a = load3(memo, at + MEMO_SHOULDER + 3 * ((branch >> 1) & 1))
    b = load3(memo, at + MEMO_WRIST + 3 * (branch & 1))
    there = (a[0], a[1], a[2], turn_to_middle(P, 3, side[0]), b[0], b[1], b[2])
    return turn_all(P, there, q, begun) if loose else there, True


@kernel
def posture_at_angle(P, side, psi, branch, q, begun, known):
    """The posture of a branch at any angle, following another one, and whether there is one."""
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
    """Write the postures of an interval (branch, lower, upper) from row n on, and their links; the next free row.

    Fine strips hold only the postures that are as near as is asked for, close together.
    """
    branch, lower, upper = interval
    nodes, linked = sheet.nodes, sheet.linked
    targets, stack, loose = desk.targets, desk.stack, has_turns(P)
    known = (row(desk.memo, 0), desk.stamp[0], loose)
    count = first_angles(P, side, lower, upper, targets)
    q = NO_SEED
    psi = lower
    begun = False
    written = False
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
