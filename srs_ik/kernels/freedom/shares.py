"""A step that brings down the largest of seven *shares*: how far a joint is from mid-range, by half of its range.

The pose is met to first order, which leaves two ways to go (four at most). Along these the largest share is least where
some joints share it, and which ones that are is found one after the other, from those of the step before.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.freedom import system
from srs_ik.kernels.freedom.elimination import RHS
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import INVERSE_HALF_RANGE, MIDDLE

ROUNDS = 24
"""Most changes of the joints that have the largest share, in a step."""

EVEN_SHARES = 1e-13
"""Shares closer than this are equal."""

ON_TOP, HOLDING = 15, 14
"""Rows of the system: the joints that have the largest share (2 j + 1 above the middle, 2 j below); their weights."""

EVENED, BEFORE, BEGIN = 8, 12, 13
"""Columns behind those of the joints that have the largest share: their slopes along evened ways, their shares before
these; the row of where steps begin."""

LIGHT = 1e-12
"""A joint that weighs less, weighs nothing."""


@kernel
def share_of(P, j, angle):
    """How far a joint is from the middle of its range, by half of it."""
    return abs(angle - P[MIDDLE + j]) * P[INVERSE_HALF_RANGE + j]


@kernel
def largest_share(P, q):
    """How far the tightest joint is from the middle of its range, by half of it; 1 on a limit."""
    most = 0.0
    for j in range(7):
        most = max(most, share_of(P, j, q[j]))
    return most


@kernel
def slope_along(P, M, mark, k):
    """How fast a joint's share rises along way k."""
    j = mark // 2
    side = P[INVERSE_HALF_RANGE + j] if mark % 2 == 1 else -P[INVERSE_HALF_RANGE + j]
    return side * M[system.WAYS + k, j]


@kernel
def share_before(P, M, q, mark):
    """A joint's share after the step that meets the pose, before any along the ways."""
    j = mark // 2
    side = P[INVERSE_HALF_RANGE + j] if mark % 2 == 1 else -P[INVERSE_HALF_RANGE + j]
    return side * (q[j] + M[system.STEP_ROW, j] - P[MIDDLE + j])


@kernel
def worst_of(P, K, M, q, n):
    """The joint whose share is the largest after a step along n ways, in column RHS of K: its mark, and the share."""
    worst, most = -1, -math.inf
    for j in range(7):
        if P[INVERSE_HALF_RANGE + j] <= 0.0:
            continue
        away = q[j] + M[system.STEP_ROW, j] - P[MIDDLE + j]
        for k in range(n):
            away += M[system.WAYS + k, j] * K[k, RHS]
        share = P[INVERSE_HALF_RANGE + j] * abs(away)
        if share > most:
            worst, most = 2 * j + (1 if away > 0.0 else 0), share
    return worst, most


@kernel
def even_out(K, M, m, n, i):
    """Take row i of the system, figures along n ways, to ways along which bends are even: by their triangle in M."""
    for k in range(n):
        rest = K[i, EVENED + k]
        for j in range(k):
            rest -= M[m + k, system.ASIDE + j] * K[i, EVENED + j]
        K[i, EVENED + k] = rest / M[m + k, system.ASIDE + k]


@kernel
def put_on_top(P, K, M, q, sizes, i):
    """Write joint i of those that have the largest share: its slopes along evened ways, and its share before these."""
    m, n = sizes
    mark = int(K[ON_TOP, i])
    for k in range(n):
        K[i, EVENED + k] = slope_along(P, M, mark, k)
    K[i, BEFORE] = share_before(P, M, q, mark)
    even_out(K, M, m, n, i)


@kernel
def solve_on_top(K, M, m, n, count):
    """The step along n ways at which `count` joints have the same share, and no other way lowers it: into column RHS.

    Behind it stand the share and what each of the joints weighs, which are solved for alone.
    """
    for i in range(count):
        for j in range(i + 1):
            total = 0.0
            for k in range(n):
                total += K[i, EVENED + k] * K[j, EVENED + k]
            K[i, j] = K[j, i] = total
        total = K[i, BEFORE]
        for k in range(n):
            total += K[i, EVENED + k] * K[BEGIN, EVENED + k]
        K[i, RHS] = total
        K[i, count] = K[count, i] = 1.0
    K[count, count], K[count, RHS] = 0.0, 1.0
    system.eliminate(K, count + 1)
    share = K[count, RHS]
    for i in range(count - 1, -1, -1):
        K[n + 1 + i, RHS] = K[i, RHS]
    K[n, RHS] = share
    for k in range(n - 1, -1, -1):
        rest = K[BEGIN, EVENED + k]
        for i in range(count):
            rest -= K[n + 1 + i, RHS] * K[i, EVENED + k]
        for j in range(k + 1, n):
            rest -= M[m + j, system.ASIDE + k] * K[j, RHS]
        K[k, RHS] = rest / M[m + k, system.ASIDE + k]


@kernel
def drop(K, i, count):
    """Take joint i out of those that have the largest share."""
    for k in range(i, count - 1):
        K[ON_TOP, k] = K[ON_TOP, k + 1]
        K[HOLDING, k] = K[HOLDING, k + 1]
        for j in range(EVENED, RHS):
            K[k, j] = K[k + 1, j]


@kernel
def keep_or_drop(K, n, count):
    """Take over what the joints weigh, or drop the first that would come to weigh nothing; how many there are then."""
    light, part = -1, 1.0
    for i in range(count):
        now, then = K[HOLDING, i], K[n + 1 + i, RHS]
        if then < -LIGHT and now < part * (now - then):
            light, part = i, now / (now - then)
    for i in range(count):
        K[HOLDING, i] += part * (K[n + 1 + i, RHS] - K[HOLDING, i])
    if light < 0:
        return count
    drop(K, light, count)
    return count - 1


@kernel
def exchange(P, K, M, n, mark):
    """Put a joint in the place of that one of n + 1 others which thereby comes to weigh nothing first; its number."""
    count = n + 1
    for i in range(count):
        other = int(K[ON_TOP, i])
        for k in range(n):
            K[k, i] = slope_along(P, M, other, k)
        K[n, i] = 1.0
    for k in range(n):
        K[k, RHS] = slope_along(P, M, mark, k)
    K[n, RHS] = 1.0
    system.eliminate(K, count)
    out, far = 0, math.inf
    for i in range(count):
        if K[i, RHS] > LIGHT and K[HOLDING, i] < far * K[i, RHS]:
            out, far = i, K[HOLDING, i] / K[i, RHS]
    if far < math.inf:
        for i in range(count):
            K[HOLDING, i] -= far * K[i, RHS]
        K[HOLDING, out] = far
    K[ON_TOP, out] = mark
    return out


@kernel
def still_on_top(P, K, M, q, m, n, count):
    """Whether the joints of the step before may have the largest share together again: each then weighs something."""
    if count == 0 or count > n + 1:
        return False
    for i in range(count):
        put_on_top(P, K, M, q, (m, n), i)
    solve_on_top(K, M, m, n, count)
    for i in range(count):
        K[HOLDING, i] = K[n + 1 + i, RHS]
        if not K[HOLDING, i] >= 0.0:
            return False
    return True


@kernel
def write_bends(M, m, n):
    """Write how steps along n ways bend, made such that they bend upwards, and where they begin."""
    system.put_bends(M, m, n)
    if n == 2:
        system.turn_down(M, m)
    else:
        system.turn_all_down(M, m, n)
    system.bends_up(M, m, n, 0.0)


@kernel
def press(P, K, M, q, sizes, count):
    """The step that brings the largest share down as far as first order tells: it, its multipliers, the share.

    The joints that had it after the last step, so many, are tried first.
    """
    m, n = sizes
    write_bends(M, m, n)
    for k in range(n):
        K[BEGIN, EVENED + k] = M[m + k, RHS]
    even_out(K, M, m, n, BEGIN)
    fresh = not still_on_top(P, K, M, q, m, n, count)
    if fresh:
        for k in range(n):
            K[k, RHS] = 0.0
        mark, share = worst_of(P, K, M, q, n)
        K[ON_TOP, 0], K[HOLDING, 0] = mark, 1.0
        count = 1
        put_on_top(P, K, M, q, sizes, 0)
    for _ in range(ROUNDS):
        if fresh:
            solve_on_top(K, M, m, n, count)
            left = keep_or_drop(K, n, count)
            if left < count:
                count = left
                continue
        fresh = True
        share = K[n, RHS]
        mark, most = worst_of(P, K, M, q, n)
        if most <= share + EVEN_SHARES:
            break
        at = count
        if count == n + 1:
            at = exchange(P, K, M, n, mark)
        else:
            K[ON_TOP, count], K[HOLDING, count] = mark, 0.0
            count += 1
        put_on_top(P, K, M, q, sizes, at)
    for k in range(n):
        far = K[k, RHS]
        for j in range(7):
            M[system.STEP_ROW, j] += far * M[system.WAYS + k, j]
            M[system.REST_ROW, j] -= far * M[system.WAYS + k, 7 + j]
    for i in range(count):
        mark = int(K[ON_TOP, i])
        j = mark // 2
        side = 1.0 if mark % 2 == 1 else -1.0
        M[system.REST_ROW, j] -= K[n + 1 + i, RHS] * side * P[INVERSE_HALF_RANGE + j]
    return read7(row(M, system.STEP_ROW)), system.multipliers(M, m), (share, count)
