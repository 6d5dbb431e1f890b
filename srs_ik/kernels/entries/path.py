"""Entry points for joint paths: choose postures for all poses of a path, then make the path smooth."""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.chain.answer import measure_row
from srs_ik.kernels.chain.newton import clipped
from srs_ik.kernels.exact.intervals import find_intervals
from srs_ik.kernels.jit import entry, kernel
from srs_ik.kernels.layout.answer import GOOD_POSE, MAX_PIECES, OK, ROW_ARM_ANGLE, ROW_STATUS
from srs_ik.kernels.layout.limb import FAR, IS_CLOSED, LIMITED
from srs_ik.kernels.limb.goal import OUTSIDE
from srs_ik.kernels.limb.limits import middles
from srs_ik.kernels.limb.poses import read7, read_pose
from srs_ik.kernels.limb.triangle import place, shoulder_to_wrist
from srs_ik.kernels.path.programme import (
    BREAK,
    GRID,
    IMPOSSIBLE,
    SLOTS,
    add_missed,
    advance,
    begin,
    carried_zeros,
    fill_states,
    is_possible,
    leap,
    may_change_sides,
    pose_change,
    window_of,
)
from srs_ik.kernels.path.smoothing import (
    SWEEPS,
    assemble,
    close_to,
    feasible_move,
    is_linked,
    posture,
    solve_tridiagonal,
    squared_step,
    wrapped,
    write_rates,
)
from srs_ik.kernels.pose.solve import solve_row

STATES = 8 * SLOTS

KEY_CHANGE = 0.04
"""A path is planned at poses this far apart, rad."""

NO_STATE = -2
"""Predecessor of the states of a pose that has none."""

NEAR_MISS = 0.03
"""How far beyond reach, relative to it, a near limb's nearest exact limb may find a pose."""


@kernel
def within_reach(P, place_):
    """Whether the pose may be reached, as far as the nearest exact limb can tell."""
    return abs(place_[5]) <= (1e-9 if P[IS_CLOSED] == 1.0 else NEAR_MISS * P[FAR])


@kernel
def any_state(now, count):
    """Whether a pose has a posture inside the limits among its states."""
    for e in range(2):
        for k in range(count):
            for s in range(2):
                for w in range(2):
                    if is_possible(now, e, k, s, w):
                        return True
    return False


@kernel
def interpolate(keys, psis, branches):
    """Fill in the poses between two planned ones of the same branch, arm angles the shorter way round."""
    last = 0
    for i in range(1, psis.shape[0]):
        if not keys[i]:
            continue
        if branches[i] >= 0 and branches[i] == branches[last]:
            across = wrapped(psis[i] - psis[last])
            for k in range(last + 1, i):
                psis[k] = psis[last] + across * (k - last) / (i - last)
                branches[k] = branches[i]
        last = i


@entry
def choose_keys(family, poses, keys, verdicts):
    """Mark the poses among which a path is planned: the ends, and one for every `KEY_CHANGE` that the pose turns."""
    P = row(family, LIMITED)
    n = poses.shape[0]
    R, p, verdicts[0] = read_pose(row(poses, 0))
    if verdicts[0] != GOOD_POSE:
        return
    before = place(P, R, p)
    keys[0] = True
    keys[n - 1] = True
    for i in range(1, n):
        R, p, verdicts[i] = read_pose(row(poses, i))
        if verdicts[i] != GOOD_POSE:
            return
        here = place(P, R, p)
        if pose_change(before, here) > KEY_CHANGE or within_reach(P, before) != within_reach(P, here):
            keys[i - 1] = True
            before = here


@entry
def plan(family, poses, keys, seeded, seed, longest, psis, branches, stop):
    """Choose arm angle and branch of each pose (branch -1 where there is none, or its neighbours disagree); see `path`.

    Args:
        family: packed limb.
        poses: (n, 4, 4).
        keys: (n,) the poses that are planned; between two of the same branch the arm angle is interpolated.
        seeded: whether to start near a seed.
        seed: (7,).
        longest: (3, 7) joint steps, by velocity and by continuity, and the square of the shortest of all.
        psis: (n,) output.
        branches: (n,) integer output.
        stop: (1,) set by another thread where nobody wants the answer any more; it is then left as it is.
    """
    P = row(family, LIMITED)
    n = poses.shape[0]
    sws = np.empty((n, 3))
    for i in range(n):
        R, p, _ = read_pose(row(poses, i))
        sws[i, 0], sws[i, 1], sws[i, 2] = shoulder_to_wrist(P, R, p)
    zero_angles = np.empty(n)
    carried_zeros(P, sws, np.empty((n, 3)), zero_angles)

    back = np.full((n, STATES), NO_STATE, np.int16)
    extra = np.zeros((n, SLOTS))
    stores = (
        (np.empty((2, SLOTS, 2, 4)), np.empty((2, SLOTS, 2, 4)), np.empty((2, 2))),
        (np.empty((2, SLOTS, 2, 4)), np.empty((2, SLOTS, 2, 4)), np.empty((2, 2))),
    )
    current = 0
    cost = np.empty(STATES)
    best = np.empty(STATES)
    found = np.empty((8 * MAX_PIECES, 3))
    start = read7(seed)
    count0 = 0
    R, p, _ = read_pose(row(poses, 0))
    place0 = place(P, R, p)
    last = -1
    allowed = longest.copy()
    for i in range(n):
        if stop[0]:
            return
        if not keys[i]:
            continue
        R, p, _ = read_pose(row(poses, i))
        place_ = place(P, R, p)
        slots = extra[i]
        for k in range(GRID):
            slots[k] = -math.pi + k * (2.0 * math.pi / GRID)
        if not within_reach(P, place_):
            continue
        count = add_missed(found, find_intervals(P, place_, -1, found), zero_angles[i], slots)
        now = stores[current]
        before = stores[1 - current]
        fill_states(P, place_, zero_angles[i], slots, count, now[0], now[1], now[2])
        if not any_state(now, count):
            continue
        if last < 0:
            begin(P, now, count, seeded, start, cost)
            back[i, :] = -1
        else:
            change = pose_change(place0, place_)
            window = window_of(change)
            sides = may_change_sides(place0, place_, change)
            for j in range(7):
                allowed[0, j] = longest[0, j] * (i - last)
            advance(P, before, now, count0, count, extra[last], slots, window, sides, allowed, cost, best, back[i])
            if best.min() >= cost.min() + BREAK:
                leap(P, before, now, count, cost, best, back[i])
            for k in range(STATES):
                cost[k] = best[k]
        count0 = count
        place0 = place_
        last = i
        current = 1 - current
    for i in range(n):
        branches[i] = -1
        psis[i] = 0.0
    if last < 0:
        return
    number = 0
    for k in range(STATES):
        if cost[k] < cost[number]:
            number = k
    if cost[number] >= IMPOSSIBLE:
        return
    for i in range(last, -1, -1):
        if back[i, 0] == NO_STATE:
            continue
        psis[i] = extra[i, (number // 4) % SLOTS]
        branches[i] = 4 * (number // (4 * SLOTS)) + number % 4
        number = back[i, number]
    interpolate(keys, psis, branches)
    for i in range(n):
        psis[i] += zero_angles[i]


@entry
def smooth(family, poses, seeded, seed, longest, psis, branches, q, stop):
    """Move the arm angles of a chosen path, in place, so that the squared joint steps become least; write its postures.

    Postures are those of the nearest exact limb; `finish` closes them on the true chain. For `stop` see `plan`.
    """
    P = row(family, LIMITED)
    n = poses.shape[0]
    start = read7(seed)
    rate = np.zeros((n, 7))
    linked = np.zeros(n, np.bool_)
    diagonal = np.empty(n)
    beside = np.empty(n)
    move = np.empty(n)
    trial = psis.copy()
    q_trial = np.empty((n, 7))
    lowest = math.inf
    for _ in range(SWEEPS):
        total = 0.0
        near = start if seeded else middles(P)
        for i in range(n):
            if stop[0]:
                return
            if branches[i] < 0:
                linked[i] = False
                if i > 0:
                    linked[i - 1] = False
                for j in range(7):
                    q_trial[i, j] = near[j]
                    rate[i, j] = 0.0
                continue
            R, p, _ = read_pose(row(poses, i))
            place_ = place(P, R, p)
            here, _, w = posture(P, place_, trial[i], branches[i], near)
            for j in range(7):
                q_trial[i, j] = here[j]
            write_rates(P, place_, here, w, rate[i])
            linked[i] = True
            if i > 0 and linked[i - 1]:
                linked[i - 1] = is_linked(P, near, here, longest)
                total += squared_step(P, near, here) if linked[i - 1] else BREAK
            elif i == 0 and seeded:
                total += squared_step(P, start, here)
            near = here
        if total > lowest * (1.0 - 1e-6):
            if total < lowest:
                q[:] = q_trial
                psis[:] = trial
            break
        lowest = total
        q[:] = q_trial
        psis[:] = trial
        assemble(P, q, rate, linked, seeded, start, diagonal, beside, move, n)
        solve_tridiagonal(diagonal, beside, move, n)
        for i in range(n):
            if branches[i] >= 0 and move[i] != 0.0:
                R, p, _ = read_pose(row(poses, i))
                place_ = place(P, R, p)
                trial[i] = psis[i] + feasible_move(P, place_, psis[i], move[i], branches[i], read7(q[i]))


@entry
def track(family, poses, start, J, A, rows, stop):
    """The nearest posture to the one before, pose after pose, from a first posture; rows (n, ROW).

    For `stop` see `plan`.
    """
    near = read7(start)
    for i in range(poses.shape[0]):
        if stop[0]:
            return i
        solve_row(family, row(poses, i), -1, near, True, J, A, row(rows, i))
        if rows[i, ROW_STATUS] != OK:
            return i
        near = read7(rows[i])
    return poses.shape[0]


@entry
def finish(family, poses, psis, branches, q, out):
    """Close the postures of a path on the true chain and write their rows (n, ROW), where there are any."""
    P = row(family, LIMITED)
    J = np.empty((6, 7))
    A = np.empty((16, 9))
    for i in range(poses.shape[0]):
        if branches[i] < 0:
            continue
        R, p, _ = read_pose(row(poses, i))
        place_ = place(P, R, p)
        here, closed = close_to(P, place_, R, p, read7(q[i]), psis[i], True, J, A)
        measure_row(P, place_, R, p, clipped(P, here), branches[i], 0.0 if closed else OUTSIDE, True, row(out, i))
        if P[IS_CLOSED] == 1.0:
            out[i, ROW_ARM_ANGLE] = wrapped(psis[i])
