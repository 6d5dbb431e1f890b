"""The equations of a step, some joints held: solved for as many joints as there are equations, and the rest freely.

Where the equations depend on each other, or more joints are held than they leave, joints and multipliers are solved for
together, and equations that contradict each other give way.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.lanes import LANES, as_mask, eight_of, gather, scatter, where
from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.freedom.elimination import BASIC_ROW, GIVES, INVERSE, RHS, ROOM_ROW, solve_equations
from srs_ik.kernels.jit import kernel

STEP_ROW, REST_ROW, WAYS = 8, 9, 10
"""Rows of work space: a step that meets the equations, what is left of the slope there, and up to four ways along the
equations, with what they are bent by behind them."""

ASIDE, UPWARDS = 7, 11
"""Columns behind bends: a triangle or main directions, and how far up these are bent."""

SWEEPS, SPLIT = 4, 1e-4
"""Of Jacobi's method, and what is left between two ways, by the largest bend: enough for what only steps depend on."""

FLAT = 0.01
"""Least bend along a way, by the largest, where steps are turned downhill."""


@kernel
def dot7(A, i, B, k, at):
    """The first seven figures of row i of A times seven of row k of B, in pairs: these do not wait for each other."""
    return (
        (A[i, 0] * B[k, at] + A[i, 1] * B[k, at + 1])
        + (A[i, 2] * B[k, at + 2] + A[i, 3] * B[k, at + 3])
        + (A[i, 4] * B[k, at + 4] + A[i, 5] * B[k, at + 5])
        + A[i, 6] * B[k, at + 6]
    )


@kernel
def halves(M, i):
    """Row i, eight figures each."""
    return gather(row(M, i), 0, 1), gather(row(M, i), LANES, 1)


@kernel
def put_halves(M, i, columns, figures):
    """Write row i in some columns, eight figures each."""
    low, high = halves(M, i)
    scatter(row(M, i), 0, 1, where(columns[0], figures[0], low))
    scatter(row(M, i), LANES, 1, where(columns[1], figures[1], high))


@kernel
def eliminate(M, n):
    """Solve the n x n system in M, right-hand side in column RHS, by elimination with pivoting, in place.

    Returns the sign of the determinant.
    """
    columns = as_mask((1 << n) - 1), as_mask(((1 << n) - 1 >> LANES) | 1 << (RHS - LANES))
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
        low, high = halves(M, pivot)
        if pivot != k:
            sign = -sign
            put_halves(M, pivot, columns, halves(M, k))
            put_halves(M, k, columns, (low, high))
        for i in range(k + 1, n):
            f = M[i, k] / M[k, k]
            if f != 0.0:
                first, last = halves(M, i)
                put_halves(M, i, columns, (first - f * low, last - f * high))
    for k in range(n - 1, -1, -1):
        s = M[k, RHS]
        for j in range(k + 1, n):
            s -= M[k, j] * M[j, RHS]
        M[k, RHS] = s / M[k, k]
    return sign


@kernel
def solve_together(K, M, m, held, d):
    """`solve_held`, joints and multipliers together: the matrix of a step to a saddle has another sign."""
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
            M[7 + r, 7 + i] = -K[ROOM_ROW, GIVES] if i == r else 0.0
        M[7 + r, RHS] = K[7 + r, RHS]
    sign = eliminate(M, 7 + m)
    forces = (M[7, RHS], M[8, RHS], M[9, RHS], M[10, RHS] if m > 3 else 0.0, M[11, RHS] if m > 4 else 0.0)
    return (
        (M[0, RHS], M[1, RHS], M[2, RHS], M[3, RHS], M[4, RHS], M[5, RHS], M[6, RHS]),
        forces,
        (sign < 0.0) == (m % 2 == 1),
    )


@kernel
def multipliers(M, rank):
    """Multipliers of five equations, of which so many count."""
    return (
        multiplier(M, rank, 0),
        multiplier(M, rank, 1),
        multiplier(M, rank, 2),
        multiplier(M, rank, 3),
        multiplier(M, rank, 4),
    )


@kernel
def bent(K, M, i):
    """The bends of the Lagrangian along row i of M, for all joints at once."""
    a = M[i, 0] * gather(row(K, 0), 0, 1) + M[i, 1] * gather(row(K, 1), 0, 1)
    b = M[i, 2] * gather(row(K, 2), 0, 1) + M[i, 3] * gather(row(K, 3), 0, 1)
    c = M[i, 4] * gather(row(K, 4), 0, 1) + M[i, 5] * gather(row(K, 5), 0, 1)
    return (a + b) + (c + M[i, 6] * gather(row(K, 6), 0, 1))


@kernel
def write_ways(K, M, m, taken, held, d):
    """Write a step that meets the equations, what is left of the slope, and ways along the equations: how many."""
    for j in range(7):
        M[STEP_ROW, j] = d[j] if (held >> j) & 1 == 1 else 0.0
    for r in range(m):
        M[STEP_ROW, int(M[BASIC_ROW, r])] = M[r, RHS]
    slopes = eight_of(K[0, RHS], K[1, RHS], K[2, RHS], K[3, RHS], K[4, RHS], K[5, RHS], K[6, RHS], 0.0)
    scatter(row(M, REST_ROW), 0, 1, slopes - bent(K, M, STEP_ROW))
    n = 0
    for c in range(7):
        if (taken >> c) & 1 == 1:
            continue
        for j in range(7):
            M[WAYS + n, j] = 1.0 if j == c else 0.0
        for r in range(m):
            M[WAYS + n, int(M[BASIC_ROW, r])] = -M[r, c]
        scatter(row(M, WAYS + n), 7, 1, bent(K, M, WAYS + n))
        n += 1
    return n


@kernel
def turn_down(M, m):
    """Replace the bends along two ways, in rows m and m + 1, by as much upwards: steps then lead down from a saddle."""
    a, b, c = M[m, 0], M[m, 1], M[m + 1, 1]
    middle, half = 0.5 * (a + c), math.sqrt(0.25 * (a - c) ** 2 + b * b)
    high, low = middle + half, middle - half
    least = FLAT * max(abs(high), abs(low))
    if low > least:
        return
    up, down = max(abs(high), least), max(abs(low), least)
    share = (up - down) / (high - low) if high > low else 0.0
    M[m, 0] = down + share * (a - low)
    M[m, 1] = M[m + 1, 0] = share * b
    M[m + 1, 1] = down + share * (c - low)


@kernel
def bends_up(M, m, n, least):
    """Whether bends along n ways are upwards by more than so much: by Cholesky's method, behind them."""
    for k in range(n):
        for i in range(k + 1):
            total = M[m + k, i] - (least if i == k else 0.0)
            for j in range(i):
                total -= M[m + k, ASIDE + j] * M[m + i, ASIDE + j]
            if i < k:
                M[m + k, ASIDE + i] = total / M[m + i, ASIDE + i]
            elif total <= 0.0:
                return False
            else:
                M[m + k, ASIDE + k] = math.sqrt(total)
    return True


@kernel
def split_bends(M, m, n, little):
    """Turn bends along n ways into those along their main directions, which come to stand behind them: by Jacobi.

    What is left between two ways may be little.
    """
    for k in range(n):
        for i in range(n):
            M[m + k, ASIDE + i] = 1.0 if i == k else 0.0
    for _ in range(SWEEPS):
        for i in range(n - 1):
            for k in range(i + 1, n):
                off = M[m + i, k]
                if abs(off) <= little:
                    continue
                ratio = 0.5 * (M[m + k, k] - M[m + i, i]) / off
                t = math.copysign(1.0, ratio) / (abs(ratio) + math.sqrt(1.0 + ratio * ratio))
                c = 1.0 / math.sqrt(1.0 + t * t)
                rotate_ways(M, m, n, (i, k), (c, t * c))


@kernel
def rotate_ways(M, m, n, pair, turn):
    """Turn two ways into each other."""
    i, k = pair
    c, s = turn
    for j in range(n):
        a, b = M[m + j, i], M[m + j, k]
        M[m + j, i], M[m + j, k] = c * a - s * b, s * a + c * b
    for j in range(n):
        a, b = M[m + i, j], M[m + k, j]
        M[m + i, j], M[m + k, j] = c * a - s * b, s * a + c * b
        a, b = M[m + j, ASIDE + i], M[m + j, ASIDE + k]
        M[m + j, ASIDE + i], M[m + j, ASIDE + k] = c * a - s * b, s * a + c * b


@kernel
def turn_all_down(M, m, n):
    """`turn_down` along n ways, from row m on."""
    most = 0.0
    for k in range(n):
        total = 0.0
        for i in range(n):
            total += abs(M[m + k, i])
        most = max(most, total)
    if bends_up(M, m, n, FLAT * most):
        return
    split_bends(M, m, n, SPLIT * most)
    for k in range(n):
        M[m + k, UPWARDS] = max(abs(M[m + k, k]), FLAT * most)
    for k in range(n):
        for i in range(n):
            total = 0.0
            for j in range(n):
                total += M[m + j, UPWARDS] * M[m + k, ASIDE + j] * M[m + i, ASIDE + j]
            M[m + k, i] = total


@kernel
def put_bends(M, m, n):
    """Write how steps along n ways bend, and where they begin, into rows m on."""
    for k in range(n):
        for i in range(k + 1):
            M[m + k, i] = M[m + i, k] = dot7(M, WAYS + k, M, WAYS + i, 7)
        M[m + k, RHS] = dot7(M, WAYS + k, M, REST_ROW, 0)


@kernel
def go_along(M, m, n):
    """How far to go along each of n ways, into column RHS of rows m on; whether that leads to a minimum."""
    put_bends(M, m, n)
    if n == 2:
        turn_down(M, m)
    elif n == 1:
        M[m, 0] = abs(M[m, 0])
    down = True
    for k in range(n):
        if M[m + k, k] <= 0.0:
            down = False
        if abs(M[m + k, k]) < 1e-300:
            M[m + k, k] = 1e-300
        for i in range(k + 1, n):
            factor = M[m + i, k] / M[m + k, k]
            for j in range(k + 1, n):
                M[m + i, j] -= factor * M[m + k, j]
            M[m + i, RHS] -= factor * M[m + k, RHS]
    for k in range(n - 1, -1, -1):
        rest = M[m + k, RHS]
        for j in range(k + 1, n):
            rest -= M[m + k, j] * M[m + j, RHS]
        M[m + k, RHS] = rest / M[m + k, k]
    return down


@kernel
def multiplier(M, m, r):
    """Multiplier of equation r: what is left of the slope, by the inverse."""
    total = 0.0
    for i in range(m):
        total += M[i, INVERSE + r] * M[REST_ROW, int(M[BASIC_ROW, i])]
    return total


@kernel
def solve_held(K, M, m, held, d):
    """The step with joints in the bit set `held` kept at their steps d; it leads away from a saddle.

    Returns it, the multipliers of the equations, and whether it may lead to a minimum, and not to a saddle.
    """
    basic, rank = solve_equations(K, M, m, held, d) if m > 0 else (-1, 0)
    if basic < 0:
        return solve_together(K, M, m, held, d)
    n = write_ways(K, M, rank, basic | held, held, d)
    down = go_along(M, rank, n)
    for k in range(n):
        far = M[rank + k, RHS]
        for j in range(7):
            M[STEP_ROW, j] += far * M[WAYS + k, j]
            M[REST_ROW, j] -= far * M[WAYS + k, 7 + j]
    return read7(row(M, STEP_ROW)), multipliers(M, rank), down
