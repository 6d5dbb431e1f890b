"""One posture for a pose, at an arm angle.

`evaluate` is the one place where a posture is made: closed form on the exact limb, then, on a near limb, Newton's
method on the true chain. What looks for the best arm angle is in `margin`, `nearest_within` and `followed`.

Where a kernel takes the work spaces J (6, 7) and A (7, 9), None stands for them on a limb that the closed form answers:
what a near limb needs is then not compiled at all.
"""

from __future__ import annotations

import math

from srs_ik.kernels.branches import NO_BRANCH, best_branch, branch_of, side_posture
from srs_ik.kernels.closure import close_at_angle
from srs_ik.kernels.elbow import elbow_side
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import FAR, MISS
from srs_ik.kernels.scoring import cost, turn

MOST_BENT = 0.3
"""Widest bend of the elbow, rad, that counts as almost straight."""

STEPS = 12
"""Steps of Newton's method at an arm angle, from the closed form."""


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
def bent_place(P, place_):
    """A place whose elbow is not almost straight: there the bend depends on the square root of what the limb misses.

    The bends of the true chain at a pose are so different that Newton's method starts better from a wider one.
    """
    t, h0, c, s, hand, miss = place_
    bend = min(MOST_BENT, math.sqrt(8.0 * P[MISS] / P[FAR]))
    if s >= bend:
        return place_
    return t, h0, math.copysign(math.sqrt(1.0 - bend * bend), c), bend, hand, miss


@kernel
def evaluate_branch(P, place_, side, R, p, psi, branch, seeded, seed, respect, A):
    """Posture of one branch at an arm angle on the true chain: q, cost (NO_BRANCH where there is none)."""
    q, _, lowest = side_posture(P, side, psi, (branch >> 1) & 1, branch & 1, seeded, seed, respect)
    if lowest >= NO_BRANCH:
        return q, lowest
    closed_q, closed = close_at_angle(P, q, R, p, place_[0], place_[1], psi, STEPS, A)
    if not closed or branch_of(P, closed_q) != branch:
        # Newton's method may have met the pose, but elsewhere: that is no answer.
        return q, NO_BRANCH
    q = turned(P, closed_q, seeded, seed, respect)
    return q, cost(P, q, seeded, seed, respect)


@kernel
def evaluate(P, place_, R, p, psi, branch, seeded, seed, respect, J, A):
    """Best posture at an arm angle over all branches, or in one (0 to 7): q, branch, cost."""
    if J is None:
        return best_branch(P, place_, psi, branch, seeded, seed, respect)
    bent = bent_place(P, place_)
    best_q = seed
    best = 0
    lowest = 4.0 * NO_BRANCH
    for elbow in range(2):
        if branch >= 0 and branch >> 2 != elbow:
            continue
        side = elbow_side(P, bent, elbow)
        for b in range(4 * elbow, 4 * elbow + 4):
            if branch >= 0 and b != branch:
                continue
            q, value = evaluate_branch(P, place_, side, R, p, psi, b, seeded, seed, respect, A)
            if value >= NO_BRANCH and bent[3] != place_[3]:
                straight = elbow_side(P, place_, elbow)
                q, value = evaluate_branch(P, place_, straight, R, p, psi, b, seeded, seed, respect, A)
            if value < lowest:
                best_q = q
                best = b
                lowest = value
    return best_q, best, lowest
