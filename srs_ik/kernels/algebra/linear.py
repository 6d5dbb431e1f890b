"""Small systems of linear equations, and symmetric ones whose matrix is a narrow band about its diagonal."""

import math

from srs_ik.kernels.algebra.lanes import gather, scatter
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.jit import kernel

NO_CURVE = 1e-9
"""Second derivatives below this count as this."""


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
        if A[pivot, k] < 0.0:
            sign = -sign
        chosen = (1.0 / A[pivot, k]) * gather(row(A, pivot), 0, 1)
        if pivot != k:
            sign = -sign
            scatter(row(A, pivot), 0, 1, gather(row(A, k), 0, 1))
        for i in range(n):
            if i != k:
                scatter(row(A, i), 0, 1, gather(row(A, i), 0, 1) - A[i, k] * chosen)
        scatter(row(A, k), 0, 1, chosen)
    return sign


@kernel
def solve_downhill(A):
    """A step that leads down, from second derivatives in A (7, 9), its upper triangle, and minus slopes in column 7.

    It is Newton's where the function curves upwards. Elsewhere Newton's would lead to a saddle or a top: what is
    negative in D of the factors L D L' changes its sign. The step ends in column 7.

    Returns: whether the function curves upwards.
    """
    upwards = True
    for k in range(7):
        if abs(A[k, k]) < NO_CURVE:
            A[k, k] = NO_CURVE
        upwards = upwards and A[k, k] > 0.0
        for i in range(k + 1, 7):
            part = A[k, i] / A[k, k]
            scatter(row(A, i), 0, 1, gather(row(A, i), 0, 1) - part * gather(row(A, k), 0, 1))
    for n in range(7):
        k = 6 - n
        behind = 0.0
        for i in range(k + 1, 7):
            behind += A[k, i] * A[i, 7]
        A[k, 7] = A[k, 7] / abs(A[k, k]) - behind / A[k, k]
    return upwards


@kernel
def solve_definite(A, least):
    """Solve the 6 x 6 system of a symmetric matrix in A (n, 9), no eigenvalue of which is below `least` > 0.

    The solution ends in column 6; elimination needs no exchange of rows. No pivot is below `least` but by rounding: one
    that is counts as that, so there is always a solution.
    """
    for k in range(6):
        inverse = 1.0 / max(A[k, k], least)
        for i in range(k + 1, 6):
            entry = A[i, k]
            for m in range(k + 1, i):
                A[i, m] -= entry * A[m, k]
            A[i, k] = entry * inverse
            A[i, i] -= entry * A[i, k]
            A[i, 6] -= A[i, k] * A[k, 6]
        A[k, k] = inverse
    for n in range(6):
        k = 5 - n
        A[k, 6] *= A[k, k]
        for i in range(k + 1, 6):
            A[k, 6] -= A[i, k] * A[i, 6]


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
