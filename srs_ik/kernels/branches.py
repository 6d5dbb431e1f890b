"""The eight branches at an arm angle, on the exact limb.

A branch is numbered 4 e + 2 s + w: e = 0 where q4 - STRAIGHT is positive, s = 0 and w = 0 where q2 and q6 lie above their
phase. Two elbow angles give two rotations of the arm; each has two shoulder and two wrist solutions.
"""

from __future__ import annotations

import math

from srs_ik.kernels.elbow import (
    arm_frame,
    arm_rotation,
    elbow_bend,
    hand_rotation,
    shoulder_to_wrist,
    target_frame,
    wrist_rotation,
)
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import SHOULDER, STRAIGHT, WRIST
from srs_ik.kernels.scoring import elbow_part, join, part
from srs_ik.kernels.spherical import decompose, default_anchor, middle_angle

NO_BRANCH = 1e12
"""Cost of a branch that does not exist: oblique axes of a spherical joint cannot make the rotation."""


@kernel
def place(P, R, p):
    """What the branches share: S-W direction and arm-angle zero, elbow bend, hand rotation, distance outside reach."""
    d, t, h0 = target_frame(P, shoulder_to_wrist(P, R, p))
    c, s, miss = elbow_bend(P, d)
    return t, h0, c, s, hand_rotation(P, R), miss


@kernel
def elbow_side(P, bend_c, bend_s, elbow):
    """For elbow branch 0 or 1: directed bend sine, q4, and cosine and sine of q4."""
    s = bend_s if elbow == 0 else -bend_s
    q4 = P[STRAIGHT] + math.atan2(s, bend_c)
    return s, q4, math.cos(q4), math.sin(q4)


@kernel
def rotations(P, place_, elbow, cos_psi, sin_psi):
    """Elbow angle, and the rotations that shoulder and wrist have to make on this side of the elbow."""
    t, h0, bend_c, bend_s, hand, _ = place_
    s, q4, c4, s4 = elbow_side(P, bend_c, bend_s, elbow)
    arm_t, arm_h, arm_n = arm_frame(P, bend_c, s)
    Rs = arm_rotation(t, h0, cos_psi, sin_psi, arm_t, arm_h, arm_n)
    return q4, Rs, wrist_rotation(P, Rs, c4, s4, hand)


@kernel
def anchor(P, k, first, seeded, seed):
    """Where joints 1 and 3 of a spherical joint go when it is singular: half-way to the seed each, or mid-range."""
    if seeded:
        return (seed[first], seed[first + 2], 0.5)
    return default_anchor(P, k)


@kernel
def best_half(P, k, first, R, wanted, seeded, seed, respect):
    """The better of the two solutions of a spherical joint (or the wanted one): angles, sign 0 or 1, cost."""
    c, s, reached = middle_angle(P, k, R)
    here = anchor(P, k, first, seeded, seed)
    seed3 = (seed[first], seed[first + 1], seed[first + 2])
    sign = max(wanted, 0)
    q, cost = part(P, first, decompose(P, k, R, c, s, sign, here), seeded, seed3, respect)
    if wanted < 0:
        other, cost_other = part(P, first, decompose(P, k, R, c, s, 1, here), seeded, seed3, respect)
        if cost_other < cost:
            q = other
            sign = 1
            cost = cost_other
    return q, sign, (cost if reached else NO_BRANCH)


@kernel
def best_branch(P, place_, psi, branch, seeded, seed, respect):
    """The best posture at an arm angle over all branches (or in the wanted one, 0 to 7): q, branch, cost."""
    cos_psi = math.cos(psi)
    sin_psi = math.sin(psi)
    want_s = -1 if branch < 0 else (branch >> 1) & 1
    want_w = -1 if branch < 0 else branch & 1
    first = 0 if branch < 0 else branch >> 2
    last = 1 if branch < 0 else branch >> 2
    best_q = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    best = 0
    lowest = 2.0 * NO_BRANCH
    for elbow in range(first, last + 1):
        q4, Rs, Rw = rotations(P, place_, elbow, cos_psi, sin_psi)
        a, shoulder, cost_s = best_half(P, SHOULDER, 0, Rs, want_s, seeded, seed, respect)
        b, wrist, cost_w = best_half(P, WRIST, 4, Rw, want_w, seeded, seed, respect)
        e, cost_e = elbow_part(P, q4, seeded, seed[3], respect)
        total = join(join(cost_s, cost_w, seeded, respect), cost_e, seeded, respect)
        if max(cost_s, cost_w) >= NO_BRANCH:
            total = NO_BRANCH
        if total < lowest:
            lowest = total
            best = 4 * elbow + 2 * shoulder + wrist
            best_q = (a[0], a[1], a[2], e, b[0], b[1], b[2])
    return best_q, best, lowest


@kernel
def elbow_branches(P, place_, psi, elbow, respect, Q):
    """The four branches on one side of the elbow into rows 0 to 3 of Q (4, 9): seven angles and their cost."""
    q4, Rs, Rw = rotations(P, place_, elbow, math.cos(psi), math.sin(psi))
    none = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    e, cost_e = elbow_part(P, q4, False, 0.0, respect)
    for sign in range(2):
        a, _, cost_s = best_half(P, SHOULDER, 0, Rs, sign, False, none, respect)
        b, _, cost_w = best_half(P, WRIST, 4, Rw, sign, False, none, respect)
        for other in range(2):
            s = 2 * sign + other
            w = 2 * other + sign
            for i in range(3):
                Q[s, i] = a[i]
                Q[w, 4 + i] = b[i]
            Q[s, 3] = e
            Q[s, 7] = join(cost_s, cost_e, False, respect)
            Q[w, 8] = cost_w
    for branch in range(4):
        Q[branch, 7] = join(Q[branch, 7], Q[branch, 8], False, respect)
