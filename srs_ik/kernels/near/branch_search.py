"""One branch of a near limb at an arm angle, next to a singularity, where the closed form starts from the wrong place.

There the closed form fixes angles of which the true chain knows little more than a sum: joints 1 and 3 of a singular
shoulder, 5 and 7 of a singular wrist. So Newton's method starts from turns and bends all over, eight at a time.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.chain.eight import put_eight, take_eight
from srs_ik.kernels.chain.newton_eight import close_eight
from srs_ik.kernels.chain.starts import FIRST, WIDTH
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import FAR, MISS, PHASE, SHOULDER, WRIST
from srs_ik.kernels.limb.branches import NO_BRANCH, branch_of, elbow_starts
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE, cost, turned
from srs_ik.kernels.limb.poses import read7

NEAR = 15.0
"""A middle angle is next to a singularity if its sine is below so many times what axes miss, a part of the reach."""

NEAR_STRAIGHT = 25.0
"""The elbow is almost straight if its bend is below the root of this times what axes miss, a part of the reach."""

WIDEST = 0.7
"""No larger sine is next to a singularity."""

STEPS = 16
"""Steps of Newton's method, which halves the error at best next to a singularity."""

TURNS = 8
"""Turns of joint 1 against 3, or 5 against 7."""

BENDS = (1.0, 0.1, 0.01, 3.0)
"""Middle angles of a singular shoulder or wrist, in parts of what is near."""


@kernel
def turn_and_bend(q, i, phase, side, near):
    """The i-th start of three joints whose middle one is almost singular, on a side of its phase; first as they are."""
    if i == 0:
        return q
    turn = (i % TURNS) * 2.0 * math.pi / TURNS
    x = min(near * BENDS[(i - 1) // TURNS], WIDEST)
    x = x if side == 0 else -x
    if math.cos(q[1] - phase) > 0.0:
        return q[0] + turn, phase + x, q[2] - turn
    return q[0] + turn, phase + math.pi - x, q[2] + turn


@kernel
def put_start(A, i, a, q4, b):
    """Write one of eight starts into A: shoulder, elbow and wrist."""
    for j in range(3):
        A[FIRST + i, j] = a[j]
        A[FIRST + i, 4 + j] = b[j]
    A[FIRST + i, 3] = q4


@kernel
def close_starts(P, place_, R, p, psi, branch, seeded, seed, respect, best_q, lowest, A):
    """Newton's method from eight postures in A: the best one in a branch, if it is better than the best so far."""
    rows = row(A, FIRST)
    q, met = close_eight(P, take_eight(rows, WIDTH), R, p, place_[0], place_[1], psi, STEPS)
    put_eight(rows, WIDTH, met, q)
    for i in range(8):
        if (met >> i) & 1 == 1:
            found = read7(row(A, FIRST + i))
            if branch_of(P, found) == branch:
                found = turned(P, found, seeded, seed, respect)
                value = cost(P, found, seeded, seed, respect)
                if value < lowest:
                    best_q, lowest = found, value
    return best_q, lowest


@kernel
def search_branch(P, place_, R, p, psi, branch, seeded, seed, respect, A):
    """A posture of a branch at an arm angle, next to a singularity: inside the limits if there is one, near a seed.

    Returns the posture, its cost (NO_BRANCH or more where none is found), and whether there cannot well be others. With
    a straight elbow it does not look: postures may lie so close together that only their curves tell them apart.
    """
    miss = P[MISS] / P[FAR]
    elbow_starts(P, place_, psi, branch >> 2, False, NO_SEED, False, A, 0)
    q = read7(row(A, branch & 3))
    lowest = 2.0 * NO_BRANCH
    if place_[3] < min(WIDEST, math.sqrt(NEAR_STRAIGHT * miss)):
        return q, lowest, False
    near = min(WIDEST, NEAR * miss)
    phase_s = P[SHOULDER + PHASE]
    phase_w = P[WRIST + PHASE]
    near_s = abs(math.sin(q[1] - phase_s)) < near
    near_w = abs(math.sin(q[5] - phase_w)) < near
    turns = 1 + TURNS * (len(BENDS) // 2 if near_s and near_w else len(BENDS))
    starts_s = turns if near_s else 1
    total = starts_s * (turns if near_w else 1)
    best_q = q
    for i in range(total):
        a = turn_and_bend((q[0], q[1], q[2]), i % starts_s, phase_s, (branch >> 1) & 1, near)
        b = turn_and_bend((q[4], q[5], q[6]), i // starts_s, phase_w, branch & 1, near)
        put_start(A, i % 8, a, q[3], b)
        if i % 8 == 7 or i == total - 1:
            best_q, lowest = close_starts(P, place_, R, p, psi, branch, seeded, seed, respect, best_q, lowest, A)
            if lowest < OUTSIDE and not seeded:
                break
    return best_q, lowest, near_s or near_w
