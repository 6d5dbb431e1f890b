"""Small systems of linear equations."""

from __future__ import annotations

from srs_ik.kernels.jit import kernel


@kernel
def add_row(A, i, f, r):
    """Add a multiple of eight figures to a row."""
    A[i, 0] += f * r[0]
    A[i, 1] += f * r[1]
    A[i, 2] += f * r[2]
    A[i, 3] += f * r[3]
    A[i, 4] += f * r[4]
    A[i, 5] += f * r[5]
    A[i, 6] += f * r[6]
    A[i, 7] += f * r[7]


@kernel
def solve_linear(A, n):
    """Solve the n x n system in A (n, 9), n up to 7, by elimination with pivoting; the solution ends in column n.

    Returns the sign of the determinant, 0 where the system is singular. Every row is worked on in all of its first
    eight columns: a fixed number of them is faster than those that matter.
    """
    sign = 1.0
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(A[i, k]) > abs(A[pivot, k]):
                pivot = i
        if abs(A[pivot, k]) < 1e-18:
            return 0.0
        if pivot != k:
            sign = -sign
            for j in range(8):
                t = A[k, j]
                A[k, j] = A[pivot, j]
                A[pivot, j] = t
        if A[k, k] < 0.0:
            sign = -sign
        f = 1.0 / A[k, k]
        r = (f * A[k, 0], f * A[k, 1], f * A[k, 2], f * A[k, 3], f * A[k, 4], f * A[k, 5], f * A[k, 6], f * A[k, 7])
        for i in range(n):
            f = 0.0 if i == k else A[i, k]
            add_row(A, i, -f, r)
        for j in range(8):
            A[k, j] = r[j]
    return sign
