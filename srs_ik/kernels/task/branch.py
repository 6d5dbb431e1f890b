"""The branch of a task's posture: the one farthest from the limits, by a rule that rounding cannot turn over.

Mirrored branches have the same margins but for rounding. Of equal solutions of a joint the first is taken, so that
along a line of tasks the branch changes where another one has more room, and nowhere else.
"""

import math

from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import SHOULDER, WRIST
from srs_ik.kernels.limb.branches import NO_BRANCH, better_half, two_solutions, whole
from srs_ik.kernels.limb.goal import NO_SEED, margin_part
from srs_ik.kernels.limb.triangle import shoulder_columns, side_frames, wrist_columns

TIE = 1e-9
"""Margins, relative to half of a joint's range, that differ by less are equal."""


@kernel
def steady_half(P, k, first, v, y, seeded, seed, respect):
    """The better solution of a spherical joint for R a3 = v and R ACROSS_3 = y: angles, sign 0 or 1, cost."""
    if seeded:
        return better_half(P, k, first, v, y, -1, seeded, seed, respect)
    above, below, reached = two_solutions(P, k, v, y, False, first, NO_SEED, respect)
    q, cost = margin_part(P, first, above, respect)
    other, cost_other = margin_part(P, first, below, respect)
    if not reached:
        return q, 0, NO_BRANCH
    if cost_other < cost - TIE:
        return other, 1, cost_other
    return q, 0, cost


@kernel
def steady_side(P, place_, elbow, c, s, respect):
    """Best posture on one side of the elbow, for cosine and sine of an arm angle: q, branch, cost."""
    base, arm, c4, s4 = side_frames(P, place_, elbow, c, s)
    v, y = shoulder_columns(P, base, arm)
    a, sign_s, cost_s = steady_half(P, SHOULDER, 0, v, y, False, NO_SEED, respect)
    v, y = wrist_columns(P, place_, base, arm, c4, s4)
    b, sign_w, cost_w = steady_half(P, WRIST, 4, v, y, False, NO_SEED, respect)
    q, branch, total = whole(P, math.atan2(s4, c4), a, sign_s, cost_s, b, sign_w, cost_w, False, NO_SEED, respect)
    return q, 4 * elbow + branch, total


@kernel
def steady_branch(P, place_, c, s, respect):
    """Best posture for cosine and sine of an arm angle: q, branch, cost."""
    q, branch, lowest = steady_side(P, place_, 0, c, s, respect)
    other, b, value = steady_side(P, place_, 1, c, s, respect)
    if value < lowest - TIE:
        return other, b, value
    return q, branch, lowest
