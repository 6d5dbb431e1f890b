"""A chosen joint path made smooth: arm angles moved off their grid so that the squared joint steps become least.

Each posture moves with its own arm angle alone, so the least-squares step is one tridiagonal system for the whole path.
"""

from __future__ import annotations

import math

from srs_ik.kernels.chain.newton import CLOSED, STEPS, close_at_angle, close_free
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import IS_CLOSED
from srs_ik.kernels.limb.branches import side_posture
from srs_ik.kernels.limb.goal import OUTSIDE, turned
from srs_ik.kernels.limb.self_motion import rates
from srs_ik.kernels.limb.triangle import elbow_side
from srs_ik.kernels.path.programme import difference

SWEEPS = 16
"""Most Gauss-Newton steps of a path."""

LONGEST_MOVE = 0.3
"""Longest move of an arm angle in one step, rad."""

SLOW_RATE = 20.0
"""Joint rates above this, rad/rad, belong to a posture next to a singularity: its arm angle stays."""


@kernel
def posture(P, place_, psi, branch, near):
    """Posture of a branch on the nearest exact limb, turned to be near another one: q, cost, S-W from the forearm."""
    side = elbow_side(P, place_, branch >> 2)
    q, _, value = side_posture(P, side, psi, (branch >> 1) & 1, branch & 1, True, near, True)
    return q, value, side[3]


@kernel
def squared_step(P, a, b):
    """Squared distance of two postures, joints without end the shorter way round."""
    total = 0.0
    for j in range(7):
        d = difference(P, j, a[j], b[j])
        total += d * d
    return total


@kernel
def is_linked(P, a, b, longest):
    """Whether a step between two postures is continuous."""
    linked = True
    for j in range(7):
        linked = linked and abs(difference(P, j, a[j], b[j])) <= longest[1, j]
    return linked


@kernel
def close_to(P, place_, R, p, q, psi, respect, J, A):
    """The posture on the true chain: itself, or by Newton's method on a near limb, the arm angle kept if possible."""
    if P[IS_CLOSED] == 1.0:
        return q, True
    closed_q, closed = close_at_angle(P, q, R, p, place_[0], place_[1], psi, STEPS, A)
    if closed:
        closed_q = turned(P, closed_q, True, q, respect)
        if squared_step(P, q, closed_q) < 0.25:
            return closed_q, True
    closed_q, error = close_free(P, q, R, p, respect, 2 * STEPS, J, A)
    return turned(P, closed_q, True, q, respect), error < CLOSED


@kernel
def solve_tridiagonal(diagonal, beside, x, n):
    """Solve a symmetric tridiagonal system in place; x holds the right-hand side, then the solution."""
    for i in range(1, n):
        f = beside[i - 1] / diagonal[i - 1]
        diagonal[i] -= f * beside[i - 1]
        x[i] -= f * x[i - 1]
    x[n - 1] /= diagonal[n - 1]
    for i in range(n - 2, -1, -1):
        x[i] = (x[i] - beside[i] * x[i + 1]) / diagonal[i]


@kernel
def assemble(P, q, rate, linked, seeded, seed, diagonal, beside, move, n):
    """Gauss-Newton system of a run of n postures q (n, 7) with rates (n, 7); `linked` says which steps count."""
    for i in range(n):
        diagonal[i] = 1e-9
        beside[i] = 0.0
        move[i] = 0.0
    for i in range(n):
        for j in range(7):
            r = rate[i, j]
            if i == 0 and seeded:
                diagonal[0] += r * r
                move[0] += r * difference(P, j, q[0, j], seed[j])
            if i + 1 < n and linked[i]:
                d = difference(P, j, q[i, j], q[i + 1, j])
                s = rate[i + 1, j]
                diagonal[i] += r * r
                diagonal[i + 1] += s * s
                beside[i] -= r * s
                move[i] += r * d
                move[i + 1] -= s * d


@kernel
def write_rates(P, place_, q, w, rate):
    """Joint rates with the arm angle, zero where they are too fast to be used."""
    values, good = rates(P, q, place_[0], w)
    fastest = 0.0
    for j in range(7):
        fastest = max(fastest, abs(values[j]))
    for j in range(7):
        rate[j] = values[j] if good and fastest < SLOW_RATE else 0.0


@kernel
def feasible_move(P, place_, psi, move, branch, near):
    """The largest of move, move / 2, ... that keeps the limits."""
    move = min(max(move, -LONGEST_MOVE), LONGEST_MOVE)
    for _ in range(4):
        _, value, _ = posture(P, place_, psi + move, branch, near)
        if value < OUTSIDE:
            return move
        move *= 0.5
    return 0.0


@kernel
def wrapped(angle):
    """The angle in [-pi, pi)."""
    return angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))
