"""Entry points for joint paths: the strips of all poses, the best way through them, and its refinement."""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.elbow import elbow_side, place
from srs_ik.kernels.intervals import MAX_PIECES, find_intervals
from srs_ik.kernels.jit import entry, kernel
from srs_ik.kernels.layout import LIMITED, LOOSE
from srs_ik.kernels.limits import settle
from srs_ik.kernels.memory import row
from srs_ik.kernels.near_intervals import true_intervals
from srs_ik.kernels.path import BREAK, IMPOSSIBLE, advance, cheapest, largest, product, step_back, steps_between
from srs_ik.kernels.poses import read7, read_pose
from srs_ik.kernels.rows import SOLVED
from srs_ik.kernels.samples import MAX_SAMPLES
from srs_ik.kernels.strips import (
    DEEPEST,
    NODE,
    NODE_BRANCH,
    NODE_PSI,
    ROUNDING,
    STRIP,
    is_wide,
    list_strips,
    put_node,
    settled,
    take_strip,
    turn_strips,
)

MOST_NODES = 4096
"""Most postures of a pose."""

MOST_STRIPS = 512
"""Most strips of a pose."""


@kernel
def path_intervals(family, place_, R, p, found, J, A):
    """Feasible intervals of a pose, those included for which two joints on their limits leave one arm angle alone."""
    if J is not None:
        return true_intervals(row(family, LIMITED), place_, R, p, True, found, J, A)
    return find_intervals(row(family, LOOSE), place_, -1, found) if abs(place_[5]) < SOLVED else 0


@kernel
def pose_strips(family, T, found, nodes, linked, n, strips, m, work, turns, wide, J, A):
    """Write the strips of a pose: the next free rows of postures and strips."""
    P = row(family, LIMITED)
    R, p, _ = read_pose(T)
    place_ = place(P, R, p)
    count = path_intervals(family, place_, R, p, found, J, A)
    sides = (elbow_side(P, place_, 0), elbow_side(P, place_, 1))
    begin = n
    for i in range(count):
        branch = int(found[i, 0])
        side = sides[0] if branch < 4 else sides[1]
        first = n
        n = take_strip(P, place_, side, R, p, branch, found[i, 1], found[i, 2], nodes, linked, n, work, A)
        if wide:
            n = turn_strips(P, nodes, linked, first, n, turns)
        else:
            n = keep_inside(P, nodes, linked, first, n)
    return n, list_strips(nodes, linked, begin, n, strips, m)


@kernel
def keep_inside(P, nodes, linked, first, last):
    """Put postures that are outside their limits by rounding on them, and leave out what is farther outside."""
    n = first
    for i in range(first, last):
        q, inside = settled(P, read7(row(nodes, i)), ROUNDING)
        if not inside:
            if n > first:
                linked[n - 1] = False
            continue
        put_node(nodes, n, q, nodes[i, NODE_PSI], nodes[i, NODE_BRANCH])
        linked[n] = linked[i]
        n += 1
    return n


@entry
def sweep(family, poses, keys, first, known, has_known, seed, settings, limited, exact, J, A, nodes, cost, strips, ends):
    """Costs of all postures of the key poses from number `first` on, until the arrays are full.

    Args:
        family: packed limb.
        poses: (n, 4, 4).
        keys: (k,) the poses that count.
        first: number of the first key pose; that before it is in the arrays already, as `ends[first - 1]` says.
        known: (n, 7) postures that are given.
        has_known: (n,) where they are.
        seed: (7,) posture before the first one, or None.
        settings: (SETTINGS, 7).
        limited: whether there are velocity limits.
        exact: whether breaks are to be the shortest.
        J: (6, 7) work space, or None.
        A: (16, 9) work space, or None.
        nodes: (N, NODE) output.
        cost: (N,) output.
        strips: (M, STRIP) output.
        ends: (k + 1, 4) output: first row of each pose in `nodes`, one behind its last, the same in `strips`.

    Returns:
        The number of the next key pose.
    """
    P = row(family, LIMITED)
    wide = False
    for joint in range(7):
        wide = wide or is_wide(P, joint)
    linked = np.zeros(nodes.shape[0], np.bool_)
    found = np.empty((8 * MAX_PIECES, 3))
    work = (np.empty(MAX_SAMPLES), np.empty((DEEPEST, NODE)))
    turns = np.zeros(7)
    scaled = settings.copy()
    n = m = 0
    if first > 0:
        n, m = ends[first - 1, 1], ends[first - 1, 3]
    i = first
    while i < keys.shape[0] and n + MOST_NODES <= nodes.shape[0] and m + MOST_STRIPS <= strips.shape[0]:
        pose = keys[i]
        ends[i, 0] = n
        ends[i, 2] = m
        if has_known[pose]:
            put_node(nodes, n, read7(row(known, pose)), 0.0, -1)
            linked[n] = False
            m = list_strips(nodes, linked, n, n + 1, strips, m)
            n += 1
        else:
            n, m = pose_strips(
                family, row(poses, pose), found, nodes, linked, n, strips, m, work, turns, wide, J, A
            )
        ends[i, 1] = n
        ends[i, 3] = m
        begin, end = ends[i, 0], ends[i, 1]
        if i == 0:
            for k in range(begin, end):
                cost[k] = 0.0
                if seed is not None:
                    e = steps_between(settings, read7(seed), row(nodes, k))
                    cost[k] = product(e, e) + (BREAK if largest(e) > settings[1, 0] else 0.0)
        elif end > begin:
            between = pose - keys[i - 1]
            for j in range(7):
                scaled[0, j] = settings[0, j] * between
            before = (ends[i - 1, 0], ends[i - 1, 1], ends[i - 1, 2], ends[i - 1, 3])
            now = (begin, end, ends[i, 2], ends[i, 3])
            advance(nodes, cost, strips, before, now, scaled, limited, 1.0 / between, exact)
        i += 1
    return i


@entry
def go_back(keys, first, last, settings, limited, nodes, cost, strips, ends, q, psi, branch):
    """Write the best way's postures of the key poses first to last - 1: q (n, 7), psi (n,), branch (n,).

    That of the key pose `last` has to be there, unless it is one behind the last: then the cheapest is taken.
    """
    scaled = settings.copy()
    for i in range(last - 1, first - 1, -1):
        pose = keys[i]
        if i == keys.shape[0] - 1:
            at = float(cheapest(cost, ends[i, 0], ends[i, 1]))
        else:
            between = keys[i + 1] - pose
            for j in range(7):
                scaled[0, j] = settings[0, j] * between
            before = (ends[i, 0], ends[i, 1], ends[i, 2], ends[i, 3])
            _, at = step_back(row(q, keys[i + 1]), nodes, cost, strips, before, scaled, limited, 1.0 / between)
        k = int(math.floor(at))
        t = at - k
        following = k + 1 if t > 0.0 else k
        for j in range(7):
            q[pose, j] = nodes[k, j] + t * (nodes[following, j] - nodes[k, j])
        psi[pose] = nodes[k, NODE_PSI] + t * (nodes[following, NODE_PSI] - nodes[k, NODE_PSI])
        branch[pose] = int(nodes[k, NODE_BRANCH])
