"""One branch of a near limb at an arm angle, next to several singularities at once, where no curve is led to it.

There the closed form fixes angles of which the true chain knows little more than a sum: joints 1 and 3 of a singular
shoulder, 5 and 7 of a singular wrist, the arm angle and the bend of a straight elbow. So Newton's method starts from
turns and bends all over, eight at a time.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.lanes import ALL, one_of
from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.chain.eight import put_eight, take_eight, tip_errors
from srs_ik.kernels.chain.newton import CLOSED, close_at_angle
from srs_ik.kernels.chain.newton_eight import close_eight
from srs_ik.kernels.chain.starts import FIRST, WIDTH
from srs_ik.kernels.curves.lowest import cost_of_turn
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.asked import Best
from srs_ik.kernels.layout.limb import COSINE_OFF, FAR, MISS, PHASE, SHOULDER, STRAIGHT, WRIST
from srs_ik.kernels.limb.branches import NO_BRANCH, branch_of, elbow_starts
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE

NEAR = 15.0
"""A middle angle is next to a singularity if its sine is below so many times what axes miss, a part of the reach."""

NEAR_STRAIGHT = 2.5
"""The elbow is if its sine is below so many times the bend that is hidden in what its cosine may be off, and so are
then the others, which depend on it."""

WIDEST = 0.7
"""No larger sine is next to a singularity."""

STEPS = 16
"""Steps of Newton's method, which halves the error at best next to a singularity."""

ALMOST_CLOSED = 1e-4
"""What steps in eight leave of an error, m or rad, where the posture may be there."""

TURNS = 8
"""Turns of joint 1 against 3, or 5 against 7."""

BENDS = (1.0, 0.1, 0.01, 3.0)
"""Middle angles of a singular shoulder or wrist, in parts of what is near."""

ARM_ANGLES = 4
ELBOW_BENDS = (0.0025, 0.01, 0.04, 0.15, 0.5)
ELBOW_STARTS = 40
"""Starts of a straight elbow: its bends, in parts of what is near, each to both sides and at arm angles all around."""


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
def elbow_start(P, place_, psi, branch, k, near, A):
    """The k-th start with a straight elbow: the closed form with another bend, at another arm angle."""
    t, h0, c, _, hand, miss = place_
    bend = near * ELBOW_BENDS[k // (2 * ARM_ANGLES)]
    bent = (t, h0, math.copysign(math.sqrt(1.0 - bend * bend), c), bend, hand, miss)
    from_psi = psi + ((k >> 1) % ARM_ANGLES) * 2.0 * math.pi / ARM_ANGLES
    # Axes may miss by more than the elbow is bent: then it lies where the other branch of the closed form has it.
    elbow_starts(P, bent, from_psi, (branch >> 2) ^ (k & 1), False, NO_SEED, False, A, 0)
    q = read7(row(A, branch & 3))
    return q if k & 1 == 0 else (q[0], q[1], q[2], 2.0 * P[STRAIGHT] - q[3], q[4], q[5], q[6])


@kernel
def put_start(A, i, a, q4, b):
    """Write one of eight starts into A: shoulder, elbow and wrist."""
    for j in range(3):
        A[FIRST + i, j] = a[j]
        A[FIRST + i, 4 + j] = b[j]
    A[FIRST + i, 3] = q4


@kernel
def close_starts(P, target, psi, branch, goal, best, steps, A):
    """Newton's method from eight postures in A: the best one in a branch (-1: any), if it is better than one so far.

    Steps in eight divide by almost nothing next to a singularity: what comes almost there goes on alone, with pivots.
    """
    R, p, place_ = target
    rows = row(A, FIRST)
    q, met = close_eight(P, take_eight(rows, WIDTH), R, p, place_[0], place_[1], psi, steps)
    position, orientation, _ = tip_errors(P, q, R, p)
    put_eight(rows, WIDTH, ALL, q)
    for i in range(8):
        error = max(one_of(position, i), one_of(orientation, i))
        found = read7(row(A, FIRST + i))
        closed = (met >> i) & 1 == 1
        if not closed and 0.1 * CLOSED < error < ALMOST_CLOSED:
            found, closed = close_at_angle(P, found, R, p, place_[0], place_[1], psi, steps, A)
        if closed and (branch < 0 or branch_of(P, found) == branch):
            found, value = cost_of_turn(P, found, goal)
            if value < best.cost:
                best = Best(found, value)
    return best


@kernel
def search_branch(P, target, psi, branch, goal, A):
    """A posture of a branch at an arm angle, next to a singularity: inside the limits if there is one, near a seed.

    Returns the posture and its cost (NO_BRANCH or more where none is found, or one part alone is singular).
    """
    place_ = target.place
    near = min(WIDEST, NEAR_STRAIGHT * math.sqrt(2.0 * P[COSINE_OFF]))
    straight = place_[3] < near
    if not straight:
        near = min(WIDEST, NEAR * P[MISS] / P[FAR])
    elbow_starts(P, place_, psi, branch >> 2, False, NO_SEED, False, A, 0)
    start = read7(row(A, branch & 3))
    phase_s = P[SHOULDER + PHASE]
    phase_w = P[WRIST + PHASE]
    near_s = abs(math.sin(start[1] - phase_s)) < near
    near_w = abs(math.sin(start[5] - phase_w)) < near
    count = int(straight) + int(near_s) + int(near_w)
    best = Best(start, 2.0 * NO_BRANCH)
    if count < 2:
        return best
    turns = 1 + TURNS * (len(BENDS) >> (count - 1))
    starts_s = turns if near_s else 1
    starts = starts_s * (turns if near_w else 1)
    total = starts * (ELBOW_STARTS if straight else 1)
    q = start
    for i in range(total):
        if straight and i % starts == 0:
            q = elbow_start(P, place_, psi, branch, i // starts, near, A)
        a = turn_and_bend((q[0], q[1], q[2]), i % starts_s, phase_s, (branch >> 1) & 1, near)
        b = turn_and_bend((q[4], q[5], q[6]), i % starts // starts_s, phase_w, branch & 1, near)
        put_start(A, i % 8, a, q[3], b)
        if i % 8 == 7 or i == total - 1:
            best = close_starts(P, target, psi, branch, goal, best, STEPS, A)
            if best.cost < OUTSIDE and not goal.seeded:
                break
    return best
