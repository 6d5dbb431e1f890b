"""Entry points for many poses of exact limbs among bodies: what is free of each, and the best posture in it.

The tables of bodies are those of `layout.collision`; `local` (rows, LOCAL_ROW) and `ready` (G,) are work space.
"""

from __future__ import annotations

import numpy as np

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.collision.free import best_of, left_of
from srs_ik.kernels.collision.seen import World
from srs_ik.kernels.exact.farthest import keep_branch
from srs_ik.kernels.jit import entry
from srs_ik.kernels.layout.answer import GOOD_POSE, MOST_INTERVALS, ROW_STATUS
from srs_ik.kernels.layout.asked import Target
from srs_ik.kernels.layout.collision import NOTHING_FREE
from srs_ik.kernels.layout.limb import LIMITED
from srs_ik.kernels.layout.path import Spot
from srs_ik.kernels.limb.poses import read_pose
from srs_ik.kernels.limb.triangle import place
from srs_ik.kernels.pose.intervals import all_intervals
from srs_ik.kernels.pose.solve import own_seed, seed_or_zero


@entry
def free_range(
    family,
    limits,
    poses,
    first,
    last,
    respect,
    bodies,
    groups,
    pairs,
    slack,
    local,
    ready,
    rows,
    counts,
    verdicts,
):
    """Free intervals of the poses from first to last - 1, as far as rows suffice: the next pose, and the rows used.

    Args:
        family: packed limbs.
        limits: the same limb packed with the limits that count.
        poses: (N, 4, 4) poses.
        first: first pose to be answered.
        last: one behind the last.
        respect: whether limits have to be kept.
        bodies: (rows, BODY_ROW).
        groups: (G, GROUP) integers.
        pairs: (n, 2) integers.
        slack: (SLACK,) margin and drift.
        local: (rows, LOCAL_ROW) work space.
        ready: (G,) integers, work space.
        rows: (n, 3) output: branch, lower and upper end of each interval, pose after pose; n at least MOST_INTERVALS.
        counts: (N,) output: intervals of each pose.
        verdicts: (N,) output: verdict on each pose.
    """
    world = World(bodies, groups, pairs, local, ready)
    P = row(family, LIMITED)
    found = np.empty((MOST_INTERVALS, 3))
    used = 0
    i = first
    while i < last and used + MOST_INTERVALS <= rows.shape[0]:
        R, p, verdicts[i] = read_pose(row(poses, i))
        counts[i] = 0
        if verdicts[i] == GOOD_POSE:
            spot = Spot(R, p, place(P, R, p))
            target = Target(R, p, place(row(limits, LIMITED), R, p))
            n = all_intervals(limits, target, respect, None, None, found)
            if n > 0:
                counts[i] = left_of(P, spot, found[:n], world, slack, rows[used : used + MOST_INTERVALS])
        used += counts[i]
        i += 1
    return i, used


@entry
def solve_range(
    family,
    limits,
    poses,
    first,
    last,
    branch,
    seeds,
    respect,
    limited,
    bodies,
    groups,
    pairs,
    slack,
    local,
    ready,
    out,
    verdicts,
):
    """The best free posture of an exact limb for each of the poses from first to last - 1.

    Args:
        family: packed limbs.
        limits: the same limb packed with the limits that count.
        poses: (N, 4, 4) poses.
        first: first pose to be answered.
        last: one behind the last.
        branch: the only one that is wanted; -1: all.
        seeds: (7,) posture to be near to, one for all or one a pose; None: farthest from the limits.
        respect: whether the joint limits have to be kept.
        limited: whether the limits that count have to be kept.
        bodies: (rows, BODY_ROW).
        groups: (G, GROUP) integers.
        pairs: (n, 2) integers.
        slack: (SLACK,) margin and drift.
        local: (rows, LOCAL_ROW) work space.
        ready: (G,) integers, work space.
        out: (N, ROW) output; the status is NOTHING_FREE, and the rest as it was, where nothing is.
        verdicts: (N,) output: verdict on each pose.
    """
    world = World(bodies, groups, pairs, local, ready)
    P = row(family, LIMITED)
    found, left = np.empty((MOST_INTERVALS, 3)), np.empty((MOST_INTERVALS, 3))
    for i in range(first, last):
        R, p, verdicts[i] = read_pose(row(poses, i))
        out[i, ROW_STATUS] = NOTHING_FREE
        if verdicts[i] == GOOD_POSE:
            target = Target(R, p, place(row(limits, LIMITED), R, p))
            n = all_intervals(limits, target, limited, None, None, found)
            spot = Spot(R, p, place(P, R, p))
            n = left_of(P, spot, found[:n], world, slack, left) if n > 0 else 0
            n = keep_branch(left, n, branch) if branch >= 0 else n
            if n > 0:
                goal = (seeds is not None, seed_or_zero(own_seed(seeds, i)), respect)
                best_of(P, spot, left[:n], branch, goal, row(out, i))
