"""One posture for a pose: at an arm angle, or the best over the whole redundancy.

`evaluate` is the one place where a posture is made: closed form on the exact limb, then, on a near limb, Newton's method
on the true chain. The search above it works on arm angles alone.
"""

from __future__ import annotations

import math

from srs_ik.kernels.branches import NO_BRANCH, best_branch
from srs_ik.kernels.closure import CLOSED, clipped, close_at_angle, close_free
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import IS_CLOSED, PHASE, SHOULDER, STRAIGHT, WRIST
from srs_ik.kernels.scoring import OUTSIDE, cost, turn

STEP = 2.0 * math.pi / 24.0
"""Widest spacing of the arm angles at which an interval is first looked at."""

REFINE_STEPS = 40
"""Golden-section steps; each leaves 62 % of the bracket."""

GOLDEN = 0.6180339887498949

STEPS = 12
MORE_STEPS = 80
"""Steps of Newton's method at an arm angle: from the closed form, and where that failed."""

NEAR_SINGULAR = 0.05
"""Sine of a middle angle under which a spherical joint or the elbow is close to singular, for a second attempt."""

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
    q, closed = close_at_angle(P, q, R, p, place_[0], place_[1], psi, STEPS, J, A)
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
def branch_of(P, q):
    """Branch of a configuration, from the sides of its elbow, shoulder and wrist."""
    e = 0 if math.sin(q[3] - P[STRAIGHT]) >= 0.0 else 4
    s = 0 if math.sin(q[1] - P[SHOULDER + PHASE]) >= 0.0 else 2
    w = 0 if math.sin(q[5] - P[WRIST + PHASE]) >= 0.0 else 1
    return e + s + w


@kernel
def bent(q, phase, side):
    """A middle angle, moved away from its phase (or the opposite of it) to its side if it is close."""
    if abs(math.sin(q - phase)) > NEAR_SINGULAR:
        return q
    inwards = 2.0 * NEAR_SINGULAR if math.cos(q - phase) > 0.0 else -2.0 * NEAR_SINGULAR
    return q + inwards if side == 0 else q - inwards


@kernel
def evaluate_again(P, place_, R, p, psi, branch, seeded, seed, respect, J, A):
    """Second attempt at an arm angle on a near limb, where Newton's method did not close: from many postures.

    Near a singular shoulder or wrist the closed form fixes two joint angles of which the true chain knows little more
    than their sum. So the starts turn one against the other, and bend what is straight.
    """
    best_q, best, _ = best_branch(P, place_, psi, branch, seeded, seed, respect)
    lowest = 2.0 * NO_BRANCH
    for b in range(8):
        q0, _, _ = best_branch(P, place_, psi, b, False, seed, False)
        q2 = bent(q0[1], P[SHOULDER + PHASE], (b >> 1) & 1)
        q4 = bent(q0[3], P[STRAIGHT], b >> 2)
        q6 = bent(q0[5], P[WRIST + PHASE], b & 1)
        turns_s = 6 if q2 != q0[1] else 1
        turns_w = 6 if q6 != q0[5] else 1
        against_s = -1.0 if math.cos(q2 - P[SHOULDER + PHASE]) > 0.0 else 1.0
        against_w = -1.0 if math.cos(q6 - P[WRIST + PHASE]) > 0.0 else 1.0
        for i in range(turns_s * turns_w):
            ds = (i % turns_s) * math.pi / 3.0
            dw = (i // turns_s) * math.pi / 3.0
            start = (
                q0[0] + ds,
                q2,
                q0[2] + against_s * ds,
                q4,
                q0[4] + dw,
                q6,
                q0[6] + against_w * dw,
            )
            q, closed = close_at_angle(P, start, R, p, place_[0], place_[1], psi, MORE_STEPS, J, A)
            if closed and (branch < 0 or branch_of(P, q) == branch):
                q = turned(P, q, seeded, seed, respect)
                value = cost(P, q, seeded, seed, respect)
                if value < lowest:
                    best_q = q
                    best = branch_of(P, q)
                    lowest = value
    return best_q, best, lowest


@kernel
def rescue(P, place_, R, p, branch, seeded, seed, respect, J, A):
    """Last resort on a near limb: free steps from postures all around the circle, then from bent ones: q, branch, cost.

    Close to the edge of reach, the nearest exact limb may not reach a pose that the true one does, and a given arm angle
    may have no solution where a neighbouring one has.
    """
    best_q = seed
    best = 0
    lowest = 2.0 * NO_BRANCH
    first = 0 if branch < 0 else branch
    last = 7 if branch < 0 else branch
    for attempt in range(2):
        for i in range(12):
            for b in range(first, last + 1):
                q, _, value = best_branch(P, place_, i * 2.0 * STEP, b, seeded, seed, respect)
                if value >= NO_BRANCH:
                    continue
                if attempt == 1:
                    q2 = bent(q[1], P[SHOULDER + PHASE], (b >> 1) & 1)
                    q4 = bent(q[3], P[STRAIGHT], b >> 2)
                    q6 = bent(q[5], P[WRIST + PHASE], b & 1)
                    if q2 == q[1] and q4 == q[3] and q6 == q[5]:
                        continue
                    q = (q[0], q2, q[2], q4, q[4], q6, q[6])
                if respect:
                    q = clipped(P, q)
                q, error = close_free(P, q, R, p, respect, MORE_STEPS, J, A)
                q = turned(P, q, seeded, seed, respect)
                value = cost(P, q, seeded, seed, respect)
                if error > CLOSED:
                    value = OUTSIDE * (2.0 + error)
                if value < lowest:
                    best_q = q
                    best = b
                    lowest = value
        if lowest < OUTSIDE:
            break
    return best_q, best, lowest
