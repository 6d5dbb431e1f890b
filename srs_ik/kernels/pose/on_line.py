"""Poses of an almost exact limb whose elbow lies on the line from shoulder to wrist, as well as floats tell.

What such a limb misses moves the elbow across that line farther than the bend that is left. So its arm angle is that of
its misses, and no curve can be followed: rounding hides its bends. The elbow is at all arm angles at once. Postures are
those of the nearest exact limb, at any bend, closed on the true chain.
"""

from __future__ import annotations

import numpy as np

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.chain.newton import CLOSED, ROUNDING
from srs_ik.kernels.exact.flat import exact_intervals, hidden_bend, is_as_good_as_flat
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import MAX_PIECES
from srs_ik.kernels.layout.asked import Goal
from srs_ik.kernels.layout.limb import FAR, IS_NEAR, LIMITED, MISS
from srs_ik.kernels.limb.branches import NO_BRANCH
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE
from srs_ik.kernels.limb.in_line import ROUNDED
from srs_ik.kernels.near.predicted import write_whole
from srs_ik.kernels.near.second_attempts import is_on_line
from srs_ik.kernels.pose.any_bend import at_any_bend, best_in_interval

SHARE = 0.1
"""Part of what counts as closed that misses may take off the reach of a straight arm, m, without being seen."""

BENDS = 4.0
"""So many times the bend that rounding hides is still told too badly for a curve to be followed."""


@kernel
def is_on_line_throughout(P, place_):
    """Whether the elbow of a limb with rounded figures is on the line S-W at a pose, and its curves are lost."""
    if P[IS_NEAR] == 0.0 or P[MISS] * P[MISS] > SHARE * CLOSED * P[FAR]:
        return False
    return place_[3] < BENDS * hidden_bend(P, place_, ROUNDING)


@kernel
def may_be_on_line(P, place_):
    """Whether postures of a near limb may have their elbow on the line S-W, so that they are at any arm angle."""
    return P[IS_NEAR] != 0.0 and P[MISS] < ROUNDED * P[FAR] and is_as_good_as_flat(place_)


@kernel
def on_line_at(family, target, psi, branch, goal, found):
    """The posture known at an arm angle, or a better one whose elbow is on the line: q, branch, cost.

    That at the same arm angle of the nearest exact limb, or the best of all.
    """
    P = row(family, LIMITED)
    other = at_any_bend(family, target, psi, branch, goal, found)
    if other[2] >= OUTSIDE:
        pieces = np.empty((8 * MAX_PIECES, 3))
        for i in range(exact_intervals(family, target, goal.respect, pieces)):
            own = int(pieces[i, 0])
            if branch < 0 or own == branch:
                other = best_in_interval(family, target, pieces[i : i + 1], own, goal, other)
    return other if other[2] < OUTSIDE and is_on_line(P, other[0], target.place) else found


@kernel
def best_on_line(family, target, branch, respect):
    """The posture farthest from its limits in a branch, the elbow on the line: q, branch, cost."""
    goal = Goal(False, NO_SEED, respect)
    return on_line_at(family, target, 0.0, branch, goal, (NO_SEED, branch, 4.0 * NO_BRANCH))


@kernel
def on_line_intervals(family, target, respect, out):
    """Write a whole circle for each branch that has a posture with its elbow on the line; the number of rows."""
    n = 0
    for branch in range(8):
        if best_on_line(family, target, branch, respect)[2] < OUTSIDE:
            n = write_whole(out, n, branch)
    return n
