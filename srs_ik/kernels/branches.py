"""The eight branches at an arm angle, on the exact limb.

A branch is numbered 4 e + 2 s + w: e = 0 where q4 - STRAIGHT is positive, s = 0 and w = 0 where q2 and q6 lie above
their phase. Two elbow angles give two rotations of the arm; each has two shoulder and two wrist solutions.
"""

from __future__ import annotations

import math

from srs_ik.kernels.elbow import elbow_side
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import FAR, MISS, PHASE, SHOULDER, STRAIGHT, WRIST
from srs_ik.kernels.scoring import elbow_part, join, part
from srs_ik.kernels.spherical import angles, default_anchor, middle_angle
from srs_ik.kernels.vectors import swing

NO_BRANCH = 1e12
"""Cost of a branch that does not exist: oblique axes of a spherical joint cannot make the rotation."""

UNSURE = 60.0
WIDEST_UNSURE = 0.5
"""Sine of a middle angle, for each part of its reach by which a limb misses, under which branches are unsure."""


@kernel
def branch_of(P, q):
    """Branch of a configuration, from the sides of its elbow, shoulder and wrist."""
    e = 0 if math.sin(q[3] - P[STRAIGHT]) >= 0.0 else 4
    s = 0 if math.sin(q[1] - P[SHOULDER + PHASE]) >= 0.0 else 2
    w = 0 if math.sin(q[5] - P[WRIST + PHASE]) >= 0.0 else 1
    return e + s + w


@kernel
def is_unsure(P, q):
    """Whether a posture of a near limb is so close to a singularity that there may be others at its arm angle."""
    width = min(WIDEST_UNSURE, UNSURE * P[MISS] / P[FAR])
    s2 = abs(math.sin(q[1] - P[SHOULDER + PHASE]))
    s4 = abs(math.sin(q[3] - P[STRAIGHT]))
    s6 = abs(math.sin(q[5] - P[WRIST + PHASE]))
    return min(s2, s4, s6) < width


@kernel
def anchor(P, k, first, seeded, seed):
    """Where joints 1 and 3 of a spherical joint go when it is singular: half-way to the seed each, or mid-range."""
    if seeded:
        return (seed[first], seed[first + 2], 0.5)
    return default_anchor(P, k)


@kernel
def best_half(P, k, first, motion, cos_psi, sin_psi, wanted, seeded, seed, respect):
    """The better of the two solutions of a spherical joint (or the wanted one): angles, sign 0 or 1, cost."""
    v0, y0, _ = motion
    v = swing(v0[0], v0[1], v0[2], cos_psi, sin_psi)
    y = swing(y0[0], y0[1], y0[2], cos_psi, sin_psi)
    c, s, reached = middle_angle(P, k, v)
    here = anchor(P, k, first, seeded, seed)
    seed3 = (seed[first], seed[first + 1], seed[first + 2])
    sign = max(wanted, 0)
    q, cost = part(P, first, angles(P, k, v, y, c, s, sign, here), seeded, seed3, respect)
    if wanted < 0:
        other, cost_other = part(P, first, angles(P, k, v, y, c, s, 1, here), seeded, seed3, respect)
        if cost_other < cost:
            q = other
            sign = 1
            cost = cost_other
    return q, sign, (cost if reached else NO_BRANCH)


@kernel
def side_posture(P, side, psi, shoulder, wrist, seeded, seed, respect):
    """Best posture on one side of the elbow at an arm angle (signs -1: any): q, branch without its elbow bit, cost."""
    q4, motion_s, motion_w, _ = side
    c = math.cos(psi)
    s = math.sin(psi)
    a, sign_s, cost_s = best_half(P, SHOULDER, 0, motion_s, c, s, shoulder, seeded, seed, respect)
    b, sign_w, cost_w = best_half(P, WRIST, 4, motion_w, c, s, wrist, seeded, seed, respect)
    e, cost_e = elbow_part(P, q4, seeded, seed[3], respect)
    total = join(join(cost_s, cost_w, seeded, respect), cost_e, seeded, respect)
    if max(cost_s, cost_w) >= NO_BRANCH:
        total = NO_BRANCH
    return (a[0], a[1], a[2], e, b[0], b[1], b[2]), 2 * sign_s + sign_w, total


@kernel
def best_branch(P, place_, psi, branch, seeded, seed, respect):
    """The best posture at an arm angle over all branches (or in the wanted one, 0 to 7): q, branch, cost."""
    if branch >= 0:
        side = elbow_side(P, place_, branch >> 2)
        q, _, lowest = side_posture(P, side, psi, (branch >> 1) & 1, branch & 1, seeded, seed, respect)
        return q, branch, lowest
    side = elbow_side(P, place_, 0)
    q, best, lowest = side_posture(P, side, psi, -1, -1, seeded, seed, respect)
    side = elbow_side(P, place_, 1)
    other, b, value = side_posture(P, side, psi, -1, -1, seeded, seed, respect)
    if value < lowest:
        return other, 4 + b, value
    return q, best, lowest


@kernel
def elbow_branches(P, place_, psi, elbow, respect, Q):
    """The four branches on one side of the elbow into rows 0 to 3 of Q (4, 9): seven angles, their cost, work space."""
    q4, motion_s, motion_w, _ = elbow_side(P, place_, elbow)
    c = math.cos(psi)
    s = math.sin(psi)
    none = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    e, cost_e = elbow_part(P, q4, False, 0.0, respect)
    for sign in range(2):
        a, _, cost_s = best_half(P, SHOULDER, 0, motion_s, c, s, sign, False, none, respect)
        b, _, cost_w = best_half(P, WRIST, 4, motion_w, c, s, sign, False, none, respect)
        for other in range(2):
            with_s = 2 * sign + other
            with_w = 2 * other + sign
            for i in range(3):
                Q[with_s, i] = a[i]
                Q[with_w, 4 + i] = b[i]
            Q[with_s, 3] = e
            Q[with_s, 7] = join(cost_s, cost_e, False, respect)
            Q[with_w, 8] = cost_w
    for row in range(4):
        Q[row, 7] = max(Q[row, 7], Q[row, 8])
