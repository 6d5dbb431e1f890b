"""One posture for a pose: at an arm angle, or the best over the whole redundancy.

`evaluate` is the one place where a posture is made: closed form on the exact limb, then, on a near limb, Newton's method
on the true chain. The search above it works on arm angles alone.
"""

from __future__ import annotations

import math

from srs_ik.kernels.branches import NO_BRANCH, best_branch
from srs_ik.kernels.closure import CLOSED, clipped, close_at_angle, close_free
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import IS_CLOSED
from srs_ik.kernels.scoring import OUTSIDE, cost, turn

STEP = 2.0 * math.pi / 24.0
"""Widest spacing of the arm angles at which an interval is first looked at."""

REFINE_STEPS = 40
"""Golden-section steps; each leaves 62 % of the bracket."""

GOLDEN = 0.6180339887498949

@kernel
def turned(P, q, seeded, seed, respect):
    """Every joint in the turn that suits the goal."""
    return (
        turn(P, 0, q[0], seeded, seed[0], respect),
        turn(P, 1, q[1], seeded, seed[1], respect),
        turn(P, 2, q[2], seeded, seed[2], respect),
        turn(P, 3, q[3], seeded, seed[3], respect),
        turn(P, 4, q[4], seeded, seed[4], respect),
        turn(P, 5, q[5], seeded, seed[5], respect),
        turn(P, 6, q[6], seeded, seed[6], respect),
    )


@kernel
def evaluate_branch(P, place_, R, p, psi, branch, seeded, seed, respect, J, A):
    """Posture of one branch at an arm angle on the true chain: q, cost (NO_BRANCH where there is none)."""
    q, _, lowest = best_branch(P, place_, psi, branch, seeded, seed, respect)
    if P[IS_CLOSED] == 1.0 or lowest >= NO_BRANCH:
        return q, lowest
    q, closed = close_at_angle(P, q, R, p, place_[0], place_[1], psi, J, A)
    if not closed:
        return q, NO_BRANCH
    q = turned(P, q, seeded, seed, respect)
    return q, cost(P, q, seeded, seed, respect)


@kernel
def evaluate(P, place_, R, p, psi, branch, seeded, seed, respect, J, A):
    """Best posture at an arm angle over all branches, or in one (0 to 7): q, branch, cost."""
    if P[IS_CLOSED] == 1.0:
        return best_branch(P, place_, psi, branch, seeded, seed, respect)
    if branch >= 0:
        q, lowest = evaluate_branch(P, place_, R, p, psi, branch, seeded, seed, respect, J, A)
        return q, branch, lowest
    best_q, lowest = evaluate_branch(P, place_, R, p, psi, 0, seeded, seed, respect, J, A)
    best = 0
    for b in range(1, 8):
        q, value = evaluate_branch(P, place_, R, p, psi, b, seeded, seed, respect, J, A)
        if value < lowest:
            best_q = q
            best = b
            lowest = value
    return best_q, best, lowest


@kernel
def refine(P, place_, R, p, branch, lower, upper, seeded, seed, respect, J, A):
    """Golden-section search for the best arm angle of a branch between two arm angles: psi, q, cost."""
    a = lower
    b = upper
    x = b - GOLDEN * (b - a)
    y = a + GOLDEN * (b - a)
    qx, _, fx = evaluate(P, place_, R, p, x, branch, seeded, seed, respect, J, A)
    qy, _, fy = evaluate(P, place_, R, p, y, branch, seeded, seed, respect, J, A)
    for _ in range(REFINE_STEPS):
        if b - a < 1e-9:
            break
        if fx <= fy:
            b = y
            y = x
            qy = qx
            fy = fx
            x = b - GOLDEN * (b - a)
            qx, _, fx = evaluate(P, place_, R, p, x, branch, seeded, seed, respect, J, A)
        else:
            a = x
            x = y
            qx = qy
            fx = fy
            y = a + GOLDEN * (b - a)
            qy, _, fy = evaluate(P, place_, R, p, y, branch, seeded, seed, respect, J, A)
    if fx <= fy:
        return x, qx, fx
    return y, qy, fy


@kernel
def search_interval(P, place_, R, p, branch, lower, upper, seeded, seed, respect, J, A):
    """Best arm angle of a branch in an interval: psi, q, cost."""
    psi = lower
    q, _, lowest = evaluate(P, place_, R, p, lower, branch, seeded, seed, respect, J, A)
    count = int(math.ceil((upper - lower) / STEP)) + 1
    step = (upper - lower) / count
    best = 0
    for i in range(1, count + 1):
        x = lower + i * step if i < count else upper
        qx, _, value = evaluate(P, place_, R, p, x, branch, seeded, seed, respect, J, A)
        if value < lowest:
            psi = x
            q = qx
            lowest = value
            best = i
    if step > 0.0:
        a = lower + max(best - 1, 0) * step
        b = lower + min(best + 1, count) * step
        x, qx, value = refine(P, place_, R, p, branch, a, b, seeded, seed, respect, J, A)
        if value < lowest:
            return x, qx, value
    return psi, q, lowest


@kernel
def rescue(P, place_, R, p, branch, seeded, seed, respect, J, A):
    """Last resort on a near limb: free steps from postures all around the circle. Returns psi-free q, branch and cost.

    Close to the edge of reach, the nearest exact limb may not reach a pose that the true one does, and a given arm angle
    may have no solution where a neighbouring one has.
    """
    best_q = seed
    best = 0
    lowest = 2.0 * NO_BRANCH
    first = 0 if branch < 0 else branch
    last = 7 if branch < 0 else branch
    for i in range(12):
        for b in range(first, last + 1):
            q, _, value = best_branch(P, place_, 12.0 * STEP - 2.0 * i * STEP, b, seeded, seed, respect)
            if value >= NO_BRANCH:
                continue
            if respect:
                q = clipped(P, q)
            q, error = close_free(P, q, R, p, respect, 40, J, A)
            q = turned(P, q, seeded, seed, respect)
            value = cost(P, q, seeded, seed, respect)
            if error > CLOSED:
                value = OUTSIDE * (2.0 + error)
            if value < lowest:
                best_q = q
                best = b
                lowest = value
    return best_q, best, lowest
