"""A path made better within a corridor: the same programme over a few postures to both sides of each of its own."""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import IS_CLOSED, LIMITED, PHASE, SHOULDER, WRIST
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.poses import read7, read_pose
from srs_ik.kernels.limb.self_motion import rates
from srs_ik.kernels.limb.triangle import elbow_side, place
from srs_ik.kernels.path.followed import away, posture_of, settled
from srs_ik.kernels.path.near_strips import direction, moved_along
from srs_ik.kernels.path.pose_strips import list_strips
from srs_ik.kernels.path.programme import advance, cheapest, first_costs, largest, scale_settings, step_back
from srs_ik.kernels.path.strips import NODE, NODE_PSI, STRIP, put_node

WIDTH = 2
"""Postures to each side."""

ACROSS = 2 * WIDTH + 1

WIDEST_MOVE = 0.3
"""Longest move of an arm angle, rad."""

SPLIT = 1e-7
"""Sine of a middle angle under which joints 1 and 3, or 5 and 7, turn against each other freely."""

ON_LIMIT = 1e-9

FARTHEST = 0.5
"""A posture of a strip is no farther, rad, from the straight line between its neighbours."""


@kernel
def moving_rates(P, place_, side, q, R, p, J, A):
    """Joint rates with the arm angle, on a near limb along its curve, and whether there are any."""
    if A is not None:
        return direction(P, q, R, p, J, A)
    return rates(P, q, place_[0], side[3])


@kernel
def split_of(P, q):
    """How joints turn at a singular posture while the pose stands still: seven rates, and whether there are any."""
    if P[IS_CLOSED] != 1.0:
        return NO_SEED, False
    s = q[1] - P[SHOULDER + PHASE]
    w = q[5] - P[WRIST + PHASE]
    if abs(math.sin(s)) < SPLIT:
        return (1.0, 0.0, math.copysign(1.0, -math.cos(s)), 0.0, 0.0, 0.0, 0.0), True
    if abs(math.sin(w)) < SPLIT:
        return (0.0, 0.0, 0.0, 0.0, 1.0, 0.0, math.copysign(1.0, -math.cos(w))), True
    return NO_SEED, False


@kernel
def along_split(P, q, split, x):
    """The posture turned along a split, and whether it is inside its limits."""
    return settled(
        P, (q[0] + x * split[0], q[1], q[2] + x * split[2], q[3], q[4] + x * split[4], q[5], q[6] + x * split[6]), 0.0
    )


@kernel
def beside(P, side, R, p, psi, move, v, branch, q, bounds, farthest, J, A):
    """The posture at an arm angle moved on, or half as far, or a quarter: posture, arm angle, whether there is one.

    On a near limb, the posture so far along its curve, whose direction is v.
    """
    for _ in range(3):
        there = min(max(psi + move, bounds[0]), bounds[1])
        if there == psi:
            break
        if A is not None:
            moved, good = moved_along(P, q, v, move, R, p, J, A)
        else:
            moved, good = posture_of(P, side, there, branch, q, True)
        moved, inside = settled(P, moved, ON_LIMIT)
        if good and inside and away(moved, q) < farthest:
            return moved, there, True
        move *= 0.5
    return q, psi, False


@kernel
def put_across(P, T, q, psi, branch, fixed, bounds, width, nodes, n, J, A):
    """Write the postures of a corridor at a pose, that of the path in the middle; the next free row."""
    if fixed:
        put_node(nodes, n, q, psi, branch)
        return n + 1
    R, p, _ = read_pose(T)
    place_ = place(P, R, p)
    side = elbow_side(P, place_, branch >> 2)
    split, is_singular = split_of(P, q)
    v, good = moving_rates(P, place_, side, q, R, p, J, A)
    move = min(width / max(largest(v), 1e-3), WIDEST_MOVE)
    for k in range(ACROSS):
        x = float(k - WIDTH)
        if k == WIDTH:
            put_node(nodes, n, q, psi, branch)
            n += 1
        elif is_singular:
            turned, inside = along_split(P, q, split, x * width)
            if inside:
                put_node(nodes, n, turned, psi, branch)
                n += 1
        elif good:
            moved, there, found = beside(P, side, R, p, psi, x * move, v, branch, q, bounds, 4.0 * WIDTH * width, J, A)
            if found:
                put_node(nodes, n, moved, there, branch)
                n += 1
    return n


@kernel
def corridor(family, poses, chain, fixed, bounds, width, seed, settings, limited, q, psi, branch, J, A):
    """Move the postures of a path, in place, to the best way through the corridor around them.

    Args:
        family: packed limb.
        poses: (n, 4, 4).
        chain: (k,) the poses that the path reaches.
        fixed: (n,) whether a posture has to stay.
        bounds: (n, 2) least and largest arm angle of each.
        width: joint step from one posture of the corridor to the next, rad.
        seed: (7,) posture before the first one, or None.
        settings: (SETTINGS, 7).
        limited: whether there are velocity limits.
        q: (n, 7).
        psi: (n,).
        branch: (n,).
        J: (6, 7) work space, or None.
        A: (16, 9) work space, or None.
    """
    P = row(family, LIMITED)
    count = chain.shape[0]
    nodes = np.empty((count * ACROSS, NODE))
    linked = np.ones(count * ACROSS, np.bool_)
    cost = np.empty(count * ACROSS)
    strips = np.empty((count, STRIP))
    ends = np.empty((count + 1, 2), np.int64)
    scaled = settings.copy()
    n = 0
    for c in range(count):
        i = chain[c]
        ends[c, 0] = n
        n = put_across(
            P, row(poses, i), read7(row(q, i)), psi[i], branch[i], fixed[i], row(bounds, i), width, nodes, n, J, A
        )
        ends[c, 1] = n
        list_strips(nodes, linked, ends[c, 0], n, strips, c)
        if c == 0:
            first_costs(nodes, cost, ends[c, 0], n, seed, settings)
            continue
        between = i - chain[c - 1]
        scale_settings(settings, between, scaled)
        before = (ends[c - 1, 0], ends[c - 1, 1], c - 1, c)
        advance(nodes, cost, strips, before, (ends[c, 0], n, c, c + 1), scaled, limited, 1.0 / between, True)
    for c in range(count - 1, -1, -1):
        i = chain[c]
        if c == count - 1:
            at = float(cheapest(cost, ends[c, 0], ends[c, 1]))
        else:
            between = chain[c + 1] - i
            scale_settings(settings, between, scaled)
            before = (ends[c, 0], ends[c, 1], c, c + 1)
            _, at = step_back(row(q, chain[c + 1]), nodes, cost, strips, before, scaled, limited, 1.0 / between)
        if not fixed[i]:
            settle_on(P, row(poses, i), nodes, at, branch[i], q, psi, i, J, A)


@kernel
def on_pose(P, T, q, psi, branch, J, A):
    """The posture at an arm angle next to one that almost meets its pose, on a near limb the nearest one."""
    R, p, _ = read_pose(T)
    if A is not None:
        v, good = direction(P, q, R, p, J, A)
        if not good:
            return q, False
        return moved_along(P, q, v, 0.0, R, p, J, A)
    return posture_of(P, elbow_side(P, place(P, R, p), branch >> 2), psi, branch, q, True)


@kernel
def settle_on(P, T, nodes, at, branch, q, psi, i, J, A):
    """Take the posture at a place between two of a corridor, or the nearer one of them."""
    k = math.floor(at)
    t = at - k
    following = k + 1 if t > 0.0 else k
    nearer = read7(row(nodes, k if t < 0.5 else following))
    angle = nodes[k if t < 0.5 else following, NODE_PSI]
    if t > 0.0:
        a, b = read7(row(nodes, k)), read7(row(nodes, following))
        between = (
            a[0] + t * (b[0] - a[0]),
            a[1] + t * (b[1] - a[1]),
            a[2] + t * (b[2] - a[2]),
            a[3] + t * (b[3] - a[3]),
            a[4] + t * (b[4] - a[4]),
            a[5] + t * (b[5] - a[5]),
            a[6] + t * (b[6] - a[6]),
        )
        there = nodes[k, NODE_PSI] + t * (nodes[following, NODE_PSI] - nodes[k, NODE_PSI])
        if A is None and nodes[k, NODE_PSI] == nodes[following, NODE_PSI]:
            nearer = between
        else:
            found, good = on_pose(P, T, between, there, branch, J, A)
            found, inside = settled(P, found, ON_LIMIT)
            if good and inside and away(found, between) < away(a, b) + 0.1:
                nearer, angle = found, there
    psi[i] = angle
    for j in range(7):
        q[i, j] = nearer[j]


@kernel
def put_on_poses(family, poses, chain, fixed, q, psi, branch, J, A):
    """Bring postures from the straight lines between those of a strip to their poses; whether all could be."""
    P = row(family, LIMITED)
    all_good = True
    for c in range(chain.shape[0]):
        i = chain[c]
        here = read7(row(q, i))
        _, is_singular = split_of(P, here)
        if fixed[i] or is_singular:
            continue
        found, good = on_pose(P, row(poses, i), here, psi[i], branch[i], J, A)
        found, inside = settled(P, found, ON_LIMIT)
        all_good = all_good and good and inside
        if good and inside and away(found, here) < FARTHEST:
            for j in range(7):
                q[i, j] = found[j]
    return all_good
