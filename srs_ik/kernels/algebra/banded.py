"""Symmetric positive systems of equations whose matrix is a narrow band about its diagonal."""

from __future__ import annotations

import math

from srs_ik.kernels.jit import kernel


@kernel
def factor_band(B, n, width):
    """Factor a matrix with n unknowns in place, by Cholesky; `width` is that of the band, below the diagonal.

    Row i of B (n, width + 2) holds columns i - width to i of the matrix, and the right-hand side last.
    """
    for i in range(n):
        first = max(i - width, 0)
        for j in range(first, i + 1):
            s = B[i, width - i + j]
            for k in range(max(first, j - width), j):
                s -= B[i, width - i + k] * B[j, width - j + k]
            if j < i:
                B[i, width - i + j] = s / B[j, width]
            else:
                B[i, width] = math.sqrt(max(s, 1e-300))


@kernel
def solve_band(B, n, width):
    """Solve the system in B, the solution in its last column: see `factor_band`."""
    factor_band(B, n, width)
    x = width + 1
    for i in range(n):
        s = B[i, x]
        for k in range(max(i - width, 0), i):
            s -= B[i, width - i + k] * B[k, x]
        B[i, x] = s / B[i, width]
    for i in range(n - 1, -1, -1):
        s = B[i, x] / B[i, width]
        B[i, x] = s
        for k in range(max(i - width, 0), i):
            B[k, x] -= B[i, width - i + k] * s
