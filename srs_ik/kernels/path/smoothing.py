"""A path made the best of its kind: all arm angles moved at once, by Newton's method, to the least squared joint steps.

Each posture moves with its own arm angle alone, so a step of Gauss and Newton is one tridiagonal system for the whole
path. Arm angles on an end of their strip that want to go beyond it stay there (projected as by Bertsekas 1982).
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import LIMITED
from srs_ik.kernels.limb.poses import read7, read_pose
from srs_ik.kernels.limb.triangle import elbow_side, place
from srs_ik.kernels.path.corridor import beside, moving_rates, split_of
from srs_ik.kernels.path.programme import largest, path_cost, step_of

SWEEPS = 24
"""Most steps of a path."""

LONGEST_MOVE = 0.25
"""Longest move of a joint in one step, rad."""

ENOUGH = 1e-8
"""A step that gains less, relative to all, is the last one."""

FASTEST = 1e5
"""Joint rates above this, rad/rad, belong to a posture next to a singularity: its arm angle stays."""

ON_END = 1e-9


@kernel
def solve_tridiagonal(diagonal, next_to, x, n):
    """Solve a symmetric tridiagonal system in place; x holds the right-hand side, then the solution."""
    for i in range(1, n):
        f = next_to[i - 1] / diagonal[i - 1]
        diagonal[i] -= f * next_to[i - 1]
        x[i] -= f * x[i - 1]
    x[n - 1] /= diagonal[n - 1]
    for i in range(n - 2, -1, -1):
        x[i] = (x[i] - next_to[i] * x[i + 1]) / diagonal[i]


@kernel
def assemble(chain, seed, settings, damping, q, rate, diagonal, next_to, move):
    """System of a step for the arm angles of a path with postures q (n, 7) and rates (n, 7)."""
    n = chain.shape[0]
    for c in range(n):
        diagonal[c] = 1e-12
        next_to[c] = 0.0
        move[c] = 0.0
    for c in range(n):
        i = chain[c]
        for j in range(7):
            r = rate[i, j]
            if c == 0 and seed is not None:
                diagonal[0] += r * r
                move[0] += r * step_of(settings, j, q[i, j], seed[j])
            if c + 1 < n:
                following = chain[c + 1]
                share = 1.0 / (following - i)
                d = share * step_of(settings, j, q[i, j], q[following, j])
                s = rate[following, j]
                diagonal[c] += share * r * r
                diagonal[c + 1] += share * s * s
                next_to[c] -= share * r * s
                move[c] += r * d
                move[c + 1] -= s * d
    for c in range(n):
        diagonal[c] *= 1.0 + damping


@kernel
def hold(chain, bounds, psi, move, rate):
    """Take the rates of postures that want to pass the ends of their strips; whether there are any."""
    some = False
    for c in range(chain.shape[0]):
        i = chain[c]
        low = psi[i] <= bounds[i, 0] + ON_END and move[c] < 0.0
        high = psi[i] >= bounds[i, 1] - ON_END and move[c] > 0.0
        if low or high:
            some = True
            for j in range(7):
                rate[i, j] = 0.0
    return some


@kernel
def write_rates(P, poses, chain, fixed, branch, q, rate, J, A):
    """Joint rates with the arm angle, zero where they cannot be used."""
    for c in range(chain.shape[0]):
        i = chain[c]
        here = read7(row(q, i))
        _, is_singular = split_of(P, here)
        usable = not fixed[i] and not is_singular
        if usable:
            R, p, _ = read_pose(row(poses, i))
            place_ = place(P, R, p)
            side = elbow_side(P, place_, branch[i] >> 2)
            v, usable = moving_rates(P, place_, side, here, R, p, J, A)
            usable = usable and largest(v) < FASTEST
            for j in range(7):
                rate[i, j] = v[j] if usable else 0.0
        else:
            for j in range(7):
                rate[i, j] = 0.0


@kernel
def move_all(P, poses, chain, bounds, branch, q, psi, rate, move, q_moved, psi_moved, J, A):
    """Write the postures with their arm angles moved on, as far as limits let them."""
    for c in range(chain.shape[0]):
        i = chain[c]
        here = read7(row(q, i))
        there = psi[i]
        fastest = largest(row(rate, i))
        if fastest > 0.0 and move[c] != 0.0:
            size = min(abs(move[c]), LONGEST_MOVE / fastest)
            R, p, _ = read_pose(row(poses, i))
            place_ = place(P, R, p)
            side = elbow_side(P, place_, branch[i] >> 2)
            here, there, _ = beside(
                P,
                side,
                R,
                p,
                psi[i],
                math.copysign(size, move[c]),
                read7(row(rate, i)),
                branch[i],
                here,
                row(bounds, i),
                4.0 * LONGEST_MOVE,
                J,
                A,
            )
        psi_moved[i] = there
        for j in range(7):
            q_moved[i, j] = here[j]


@kernel
def smooth(family, poses, chain, fixed, bounds, seed, settings, q, psi, branch, J, A):
    """Move the postures of a path, in place, so that its squared joint steps become least; see `corridor`."""
    P = row(family, LIMITED)
    n = chain.shape[0]
    rate = np.zeros(q.shape)
    q_moved, psi_moved = q.copy(), psi.copy()
    diagonal, next_to, move = np.empty(n), np.empty(n), np.empty(n)
    lowest = path_cost(chain, seed, settings, False, q)
    damping = 0.0
    fresh = True
    for _ in range(SWEEPS):
        if fresh:
            write_rates(P, poses, chain, fixed, branch, q, rate, J, A)
            assemble(chain, seed, settings, 0.0, q, rate, diagonal, next_to, move)
            hold(chain, bounds, psi, move, rate)
        assemble(chain, seed, settings, damping, q, rate, diagonal, next_to, move)
        solve_tridiagonal(diagonal, next_to, move, n)
        move_all(P, poses, chain, bounds, branch, q, psi, rate, move, q_moved, psi_moved, J, A)
        total = path_cost(chain, seed, settings, False, q_moved)
        fresh = total < lowest
        if fresh:
            gain = lowest - total
            lowest = total
            q[:] = q_moved
            psi[:] = psi_moved
            damping *= 0.1
            if gain < ENOUGH * lowest:
                break
        elif damping > 1e3:
            break
        else:
            damping = max(10.0 * damping, 0.1)
    return lowest
