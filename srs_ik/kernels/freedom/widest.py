"""The posture farthest from the joint limits over all turns that a pose leaves free.

A margin is kept by a posture inside limits that are drawn in by it. So the widest margin is closed in on: limits are
drawn in, and the posture nearest to the middle of the ranges is asked for inside of them.
"""

from __future__ import annotations

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.freedom.nearest import MOST_ATTEMPTS, NONE_LEFT, take_best
from srs_ik.kernels.freedom.settle import settle
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import SOLVED
from srs_ik.kernels.layout.freedom import Found, Liking
from srs_ik.kernels.layout.limb import INVERSE_HALF_RANGE, IS_CLOSED, LOWER, MIDDLE, UPPER
from srs_ik.kernels.limb.goal import cost
from srs_ik.kernels.limb.limits import middles
from srs_ik.kernels.limb.poses import read7

ATTEMPTS = 6
ATTEMPTS_NEAR = 20
"""Local searches at least, on an exact limb and on a near one."""

LEAST_WEIGHT = 1e-6
"""Weight of a joint without limits, which may be anywhere."""

FINENESS = 1e-7
"""Margins closer than this are equal."""


@kernel
def weight(P, j):
    """Weight of a joint's squared distance from the middle of its range."""
    return max(P[INVERSE_HALF_RANGE + j] ** 2, LEAST_WEIGHT)


@kernel
def end(P, j, margin, side):
    """A limit of a joint, drawn in by a margin."""
    share = P[INVERSE_HALF_RANGE + j]
    if share > 0.0:
        drawn = P[MIDDLE + j] + side * (1.0 - margin) / share
        return min(max(drawn, P[LOWER + j]), P[UPPER + j])
    return P[UPPER + j] if side > 0.0 else P[LOWER + j]


@kernel
def ends(P, margin, side):
    """Seven limits, drawn in."""
    return (
        end(P, 0, margin, side),
        end(P, 1, margin, side),
        end(P, 2, margin, side),
        end(P, 3, margin, side),
        end(P, 4, margin, side),
        end(P, 5, margin, side),
        end(P, 6, margin, side),
    )


@kernel
def comfort(P, margin):
    """Closeness to the middle of all ranges, inside limits that are drawn in."""
    weights = (weight(P, 0), weight(P, 1), weight(P, 2), weight(P, 3), weight(P, 4), weight(P, 5), weight(P, 6))
    return Liking(middles(P), weights, ends(P, margin, -1.0), ends(P, margin, 1.0), NONE_LEFT, middles(P))


@kernel
def climb(P, q, pose, freedom, margin, desk):
    """From a posture to one whose margin is the widest around, and wider than a given one: it, and its margin."""
    most = 1.0
    best, found, better = q, margin, False
    while most - found > FINENESS:
        # The first step asks whether there is any that is better.
        ask = 0.5 * (found + most) if better else found + FINENESS
        there, _, error, _ = settle(P, best, pose, freedom, comfort(P, ask), desk)
        reached = -cost(P, there, False, there, False)
        if error < SOLVED and reached > found:
            best, found, better = there, reached, True
        elif better:
            most = ask
        else:
            break
    return best, found


@kernel
def widest(P, pose, freedom, count, desk):
    """The posture of the widest margin that searches from the starts in `desk` lead to, `count` of them."""
    found = Found(middles(P), NONE_LEFT, False)
    margin = -FINENESS
    attempts = ATTEMPTS if P[IS_CLOSED] == 1.0 else ATTEMPTS_NEAR
    for k in range(MOST_ATTEMPTS):
        if k >= attempts and found.met:
            break
        i, _ = take_best(desk.starts, count)
        if i < 0:
            break
        q, reached = climb(P, read7(row(desk.starts, i)), pose, freedom, margin, desk)
        if reached > margin:
            margin = reached
            found = Found(q, -reached, True)
    return found
