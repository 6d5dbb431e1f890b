"""The postures of a pose as strips: runs of postures from end to end of each feasible interval of arm angles.

A posture of a strip is a row of figures (`NODE`): seven joint angles, its arm angle, its way along the strip, its
branch, and how far the costs sag towards the next one. Rows are close enough, in joint angles, that what lies between
two of them is almost straight: next to a singularity, where joints 1 and 3 (or 5 and 7) turn by half a turn while the
arm angle stands still, there are as many as the joints need. Where a joint has more than one turn, each combination of
turns has strips of its own.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.exact.samples import add_changes
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import INVERSE_HALF_RANGE, LOWER, RANGE_KIND, SHOULDER, UPPER, WRIST
from srs_ik.kernels.layout.path import NODE_BRANCH, NODE_PSI
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.poses import read7
from srs_ik.kernels.path.followed import away, posture_of, turn_all, turned_away

SPACING = 0.35
"""Farthest that a joint moves between two postures of a strip, rad."""

FINE_SPACING = 0.05
"""The same next to a posture that is nearly the best."""

WIDEST = 0.7
"""Farthest apart in arm angle, rad."""

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
def first_angles(P, side, lower, upper, targets):
    """Arm angles at which an interval is looked at first, sorted: both ends, some between, turns of wide joints."""
    count = max(math.ceil((upper - lower) / WIDEST), 1)
    n = 0
    for i in range(count + 1):
        targets[n] = lower + (upper - lower) * i / count if i < count else upper
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
    """Joint step from a posture to the next above which there are others between, fine about a posture."""
    if around.radius == 0.0:
        return SPACING
    return FINE_SPACING if turned_away(q, around.q) < around.radius + 2.0 * away(ahead, q) else math.inf


@kernel
def take_strip(P, side, interval, around, sheet, n, desk):
    """Write the postures of an interval (branch, lower, upper) from row n on, and their links; the next free row.

    Fine strips hold only the postures that are as near as is asked for, close together.
    """
    branch, lower, upper = interval
    nodes, linked = sheet.nodes, sheet.linked
    targets, stack = desk.targets, desk.stack
    count = first_angles(P, side, lower, upper, targets)
    q = NO_SEED
    psi = lower
    begun = False
    written = False
    for i in range(count):
        if begun and targets[i] <= psi:
            continue
        wanted, good = posture_of(P, side, targets[i], branch, q, begun)
        if not good:
            continue
        put_node(stack, 0, wanted, targets[i], branch)
        top = 0
        while top >= 0 and n < nodes.shape[0]:
            ahead = stack[top, NODE_PSI]
            wanted = turn_all(P, read7(row(stack, top)), q, begun)
            middle = 0.5 * (psi + ahead)
            apart = away(wanted, q)
            if begun and apart > widest_step(q, wanted, around) and psi < middle < ahead:
                if ahead - psi > CLOSEST * max(1.0, abs(psi)) and top + 1 < DEEPEST:
                    between, good = posture_of(P, side, middle, branch, q, True)
                    if good:
                        top += 1
                        put_node(stack, top, between, middle, branch)
                        continue
            if written:
                linked[n - 1] = begun and (apart <= SPACING or is_split(q, wanted))
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
