"""The equations of a step: joints and multipliers together, some joints held."""

from __future__ import annotations

from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.freedom import SYSTEM

RHS = SYSTEM - 1
"""Column of the right-hand side."""

SOFT = 1e-15
"""Weight by which equations that contradict each other give way."""


@kernel
def eliminate(M, n):
    """Solve the n x n system in M, right-hand side in column RHS, by elimination with pivoting, in place.

    Returns the sign of the determinant.
    """
    sign = 1.0
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(M[i, k]) > abs(M[pivot, k]):
                pivot = i
        if abs(M[pivot, k]) < 1e-300:
            M[pivot, k] = 1e-300
        if M[pivot, k] < 0.0:
            sign = -sign
        if pivot != k:
            sign = -sign
            for j in range(k, n):
                M[k, j], M[pivot, j] = M[pivot, j], M[k, j]
            M[k, RHS], M[pivot, RHS] = M[pivot, RHS], M[k, RHS]
        for i in range(k + 1, n):
            f = M[i, k] / M[k, k]
            if f != 0.0:
                for j in range(k + 1, n):
                    M[i, j] -= f * M[k, j]
                M[i, RHS] -= f * M[k, RHS]
    for k in range(n - 1, -1, -1):
        s = M[k, RHS]
        for j in range(k + 1, n):
            s -= M[k, j] * M[j, RHS]
        M[k, RHS] = s / M[k, k]
    return sign


@kernel
def solve_held(K, M, m, held, d):
    """The step with joints in the bit set `held` kept at their steps d.

    Returns it, the multipliers of the equations, and whether it may lead to a minimum: the matrix of a step to a saddle
    has another sign.
    """
    for i in range(7):
        for j in range(7 + m):
            M[i, j] = 0.0
        if (held >> i) & 1 == 1:
            M[i, i] = 1.0
            M[i, RHS] = d[i]
            continue
        for j in range(7):
            M[i, j] = K[i, j]
        for r in range(m):
            M[i, 7 + r] = K[7 + r, i]
        M[i, RHS] = K[i, RHS]
    for r in range(m):
        for j in range(7):
            M[7 + r, j] = K[7 + r, j]
        for i in range(m):
            M[7 + r, 7 + i] = -SOFT if i == r else 0.0
        M[7 + r, RHS] = K[7 + r, RHS]
    sign = eliminate(M, 7 + m)
    forces = (M[7, RHS], M[8, RHS], M[9, RHS], M[10, RHS] if m > 3 else 0.0, M[11, RHS] if m > 4 else 0.0)
    return (
        (M[0, RHS], M[1, RHS], M[2, RHS], M[3, RHS], M[4, RHS], M[5, RHS], M[6, RHS]),
        forces,
        (sign < 0.0) == (m % 2 == 1),
    )
