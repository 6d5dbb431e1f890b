"""From a posture to the one around it that is farthest from the joint limits, on a pose up to what that leaves free.

What is brought down is the largest of seven *shares*: how far each joint is from the middle of its range, by half of
that range. The pose is met to first order, which leaves two ways to go (four at most); along these the largest share is
least where some joints share it, and which ones that are is found one after the other. The bends of the pose count as
in `settle`, so that it converges quadratically.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.joint_vectors import along7
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.freedom.settle import (
    ALMOST,
    CLOSE_BY,
    EVEN,
    MAX_STEP,
    MET,
    NO_FORCE,
    SETTLED,
    SHORTER,
    bends,
    equations,
    fill,
    leaves_cone,
    on_edge,
    part_way,
    price,
)
from srs_ik.kernels.freedom.system import (
    ASIDE,
    BASIC_ROW,
    INVERSE,
    REST_ROW,
    RHS,
    STEP_ROW,
    WAYS,
    bends_up,
    eliminate,
    multipliers,
    put_bends,
    solve_equations,
    turn_all_down,
    turn_down,
    write_ways,
)
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.freedom import Liking
from srs_ik.kernels.layout.limb import INVERSE_HALF_RANGE, MIDDLE
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.poses import read7

STEPS = 30
STIFF = 1e-3
STIFFER = 0.1
"""Weight of the length of a step, in shares squared: where bends are known, and where not."""

GAINED = 1e-8
"""A share that falls by less is the least one."""

LITTLE, ALMOST_ON = 1e-6, 1e-5
"""A share that falls by so little, at a posture so close to its pose, m and rad, falls no more to speak of: where no
joint with limits feels a motion, it would go on for long."""

NO_WIDER, BENT = 1.0, 4.0
"""Once bends are known, the largest share falls below what a step promises by no more than so much of it, rad, or of
its square if that is less."""

NO_GAIN = 1e-7
"""A share that is lower than a known one by less is not worth a search."""

NEARLY = 0.02
"""A step that leaves the pose no worse than so, m and rad, is taken if the largest share falls."""

ROUNDS = 24
"""Most changes of the joints that have the largest share, in a step."""

EVEN_SHARES = 1e-13
"""Shares closer than this are equal."""

ON_TOP, HOLDING = 15, 14
"""Rows of the system: the joints that have the largest share (2 j + 1 above the middle, 2 j below); their weights."""

EVENED = 8
"""Columns of the system behind those of the joints that have the largest share: their slopes along evened ways."""

LIGHT = 1e-12
"""A joint that weighs less, weighs nothing."""


@kernel
def largest_share(P, q):
    """How far the tightest joint is from the middle of its range, by half of it; 1 on a limit."""
    most = 0.0
    for j in range(7):
        most = max(most, abs(q[j] - P[MIDDLE + j]) * P[INVERSE_HALF_RANGE + j])
    return most


@kernel
def slope_along(P, M, mark, k):
    """How fast a joint's share rises along way k."""
    j = mark // 2
    side = P[INVERSE_HALF_RANGE + j] if mark % 2 == 1 else -P[INVERSE_HALF_RANGE + j]
    return side * M[WAYS + k, j]


@kernel
def share_before(P, M, q, mark):
    """A joint's share after the step that meets the pose, before any along the ways."""
    j = mark // 2
    side = P[INVERSE_HALF_RANGE + j] if mark % 2 == 1 else -P[INVERSE_HALF_RANGE + j]
    return side * (q[j] + M[STEP_ROW, j] - P[MIDDLE + j])


@kernel
def worst_of(P, K, M, q, n):
    """The joint whose share is the largest after a step along n ways, in column RHS of K: its mark, and the share."""
    worst, most = -1, -math.inf
    for j in range(7):
        if P[INVERSE_HALF_RANGE + j] <= 0.0:
            continue
        away = q[j] + M[STEP_ROW, j] - P[MIDDLE + j]
        for k in range(n):
            away += M[WAYS + k, j] * K[k, RHS]
        share = P[INVERSE_HALF_RANGE + j] * abs(away)
        if share > most:
            worst, most = 2 * j + (1 if away > 0.0 else 0), share
    return worst, most


@kernel
def solve_on_top(P, K, M, q, m, n, count):
    """The step along n ways at which `count` joints have the same share, and no other way lowers it: into column RHS.

    Behind it stand the share and what each of the joints weighs. These are solved for alone, with what the joints'
    slopes and the step without any of them are where bends are even (by their triangle, behind them in M).
    """
    for i in range(count + 1):
        for k in range(n):
            rest = slope_along(P, M, int(K[ON_TOP, i]), k) if i < count else M[m + k, RHS]
            for j in range(k):
                rest -= M[m + k, ASIDE + j] * K[i, EVENED + j]
            K[i, EVENED + k] = rest / M[m + k, ASIDE + k]
    for i in range(count + 1):
        for j in range(i + 1):
            total = 0.0
            for k in range(n):
                total += K[i, EVENED + k] * K[j, EVENED + k]
            if i < count:
                K[i, j] = K[j, i] = total
            elif j < count:
                K[i, j] = K[j, i] = 1.0
                K[j, RHS] = total + share_before(P, M, q, int(K[ON_TOP, j]))
    K[count, count], K[count, RHS] = 0.0, 1.0
    eliminate(K, count + 1)
    share = K[count, RHS]
    for i in range(count - 1, -1, -1):
        K[n + 1 + i, RHS] = K[i, RHS]
    K[n, RHS] = share
    for k in range(n - 1, -1, -1):
        rest = K[count, EVENED + k]
        for i in range(count):
            rest -= K[n + 1 + i, RHS] * K[i, EVENED + k]
        for j in range(k + 1, n):
            rest -= M[m + j, ASIDE + k] * K[j, RHS]
        K[k, RHS] = rest / M[m + k, ASIDE + k]


@kernel
def drop(K, i, count):
    """Take joint i out of those that have the largest share."""
    for k in range(i, count - 1):
        K[ON_TOP, k] = K[ON_TOP, k + 1]
        K[HOLDING, k] = K[HOLDING, k + 1]


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
    """Put a joint in the place of that one of n + 1 others which thereby comes to weigh nothing first."""
    count = n + 1
    for i in range(count):
        other = int(K[ON_TOP, i])
        for k in range(n):
            K[k, i] = slope_along(P, M, other, k)
        K[n, i] = 1.0
    for k in range(n):
        K[k, RHS] = slope_along(P, M, mark, k)
    K[n, RHS] = 1.0
    eliminate(K, count)
    out, far = 0, math.inf
    for i in range(count):
        if K[i, RHS] > LIGHT and K[HOLDING, i] < far * K[i, RHS]:
            out, far = i, K[HOLDING, i] / K[i, RHS]
    if far < math.inf:
        for i in range(count):
            K[HOLDING, i] -= far * K[i, RHS]
        K[HOLDING, out] = far
    K[ON_TOP, out] = mark


@kernel
def write_bends(M, m, n):
    """Write how steps along n ways bend, made such that they bend upwards, and where they begin."""
    put_bends(M, m, n)
    if n == 2:
        turn_down(M, m)
    else:
        turn_all_down(M, m, n)
    bends_up(M, m, n, 0.0)


@kernel
def press(P, K, M, q, m, n):
    """The step that brings the largest share down as far as first order tells: it, its multipliers, the share."""
    write_bends(M, m, n)
    for k in range(n):
        K[k, RHS] = 0.0
    mark, share = worst_of(P, K, M, q, n)
    K[ON_TOP, 0], K[HOLDING, 0] = mark, 1.0
    count = 1
    for _ in range(ROUNDS):
        solve_on_top(P, K, M, q, m, n, count)
        left = keep_or_drop(K, n, count)
        if left < count:
            count = left
            continue
        share = K[n, RHS]
        mark, most = worst_of(P, K, M, q, n)
        if most <= share + EVEN_SHARES:
            break
        if count == n + 1:
            exchange(P, K, M, n, mark)
        else:
            K[ON_TOP, count], K[HOLDING, count] = mark, 0.0
            count += 1
    for k in range(n):
        far = K[k, RHS]
        for j in range(7):
            M[STEP_ROW, j] += far * M[WAYS + k, j]
            M[REST_ROW, j] -= far * M[WAYS + k, 7 + j]
    for i in range(count):
        mark = int(K[ON_TOP, i])
        j = mark // 2
        side = 1.0 if mark % 2 == 1 else -1.0
        M[REST_ROW, j] -= K[n + 1 + i, RHS] * side * P[INVERSE_HALF_RANGE + j]
    return read7(row(M, STEP_ROW)), multipliers(M, m), (share, count)


@kernel
def mend(P, desk, q, m, known, along):
    """The step back to the pose after one along its bends, at which the same joints have the largest share."""
    K, M = desk.shares, desk.copy
    n, count = along
    for j in range(7):
        M[STEP_ROW, j] = 0.0
    for i in range(m):
        for r in range(known):
            M[STEP_ROW, int(M[BASIC_ROW, i])] += M[i, INVERSE + r] * desk.system[7 + r, RHS]
    for k in range(n):
        M[m + k, RHS] = 0.0
        for i in range(count):
            M[m + k, RHS] += K[HOLDING, i] * slope_along(P, M, int(K[ON_TOP, i]), k)
    solve_on_top(P, K, M, q, m, n, count)
    for k in range(n):
        for j in range(7):
            M[STEP_ROW, j] += K[k, RHS] * M[WAYS + k, j]
    return read7(row(M, STEP_ROW))


@kernel
def widen(P, q, pose, freedom, rival, desk):
    """The posture around one whose largest share is least: q, that share, and the error of the pose (m, rad).

    Args:
        P: packed limb.
        q: posture to start from.
        pose: rotation and position.
        freedom: what the pose leaves free.
        rival: a share that is known; searches that do not come to a lower one end early.
        desk: work space.
    """
    K, M, J = desk.system, desk.copy, desk.J
    forces, last, asked = NO_FORCE, NO_FORCE, NO_FORCE
    before, step = q, NO_SEED
    known, part, radius, rank, n, count = 0, 1.0, MAX_STEP, 0, 0, 0
    error, size, worth, best = math.inf, math.inf, math.inf, math.inf
    mended, curved = False, False
    for _ in range(STEPS):
        m, error, turns = equations(P, q, pose, freedom, desk)
        m = on_edge(m, known, forces)
        share = largest_share(P, q)
        if error < MET and (size < SETTLED or abs(best - share) < GAINED):
            break
        if curved and error < ALMOST_ON and abs(best - share) < LITTLE:
            break
        wider = share < best and error < NEARLY
        if share + price(forces) * error > worth and size > CLOSE_BY and not wider:
            if not mended and m == known:
                q, mended = along7(q, 1.0, mend(P, desk, q, rank, m, (n, count))), True
                continue
            mended = False
            step = along7(NO_SEED, SHORTER, step)
            size *= SHORTER
            part *= SHORTER
            radius = size
            forces = part_way(last, part, asked)
            q = along7(before, 1.0, step)
            continue
        best, mended = share, False
        radius = min(2.0 * radius, MAX_STEP)
        curve = bends(m, forces, turns, freedom.cone)
        curved = error < ALMOST and known == m
        own = Liking(q, EVEN, NO_SEED, NO_SEED, 0.0, NO_SEED)
        fill(J, K, q, own, curve, (1.0 if curved else 0.0, STIFF if curved else STIFFER))
        basic, rank = solve_equations(K, M, m, 0, NO_SEED)
        if basic < 0:
            return q, share, math.inf
        n = write_ways(K, M, rank, basic, 0, NO_SEED)
        step, asked, (ahead, count) = press(P, desk.shares, M, q, rank, n)
        if m == 3 and leaves_cone(K, freedom, step):
            m = 4
            basic, rank = solve_equations(K, M, m, 0, NO_SEED)
            if basic < 0:
                return q, share, math.inf
            n = write_ways(K, M, rank, basic, 0, NO_SEED)
            step, asked, (ahead, count) = press(P, desk.shares, M, q, rank, n)
        last = forces if known == m else asked
        known = m
        worth = share + price(asked) * error
        size, part = 0.0, 1.0
        for j in range(7):
            size = max(size, abs(step[j]))
        if size > radius:
            part = radius / size
            step = along7(NO_SEED, part, step)
            size = radius
        forces = part_way(last, part, asked)
        before = q
        q = along7(q, 1.0, step)
        if curved and ahead - size * min(NO_WIDER, BENT * size) > rival - NO_GAIN:
            return q, share, math.inf
    return q, largest_share(P, q), error
