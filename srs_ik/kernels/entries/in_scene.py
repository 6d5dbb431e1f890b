"""Entry points for many poses of exact limbs among bodies: what is free of each, and the best posture in it.

The tables of bodies are those of `layout.collision`; `local` (rows, LOCAL_ROW) and `ready` (G,) are work space.
"""

from __future__ import annotations

import numpy as np

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.collision.free import best_of, left_of
from srs_ik.kernels.collision.seen import World
from srs_ik.kernels.jit import entry
from srs_ik.kernels.layout.answer import GOOD_POSE, MOST_INTERVALS
from srs_ik.kernels.layout.asked import Target
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
def best_range(family, poses, first, last, rows, offsets, branch, seeds, respect, out):
    """The best posture of an exact limb in given intervals, for the poses from first to last - 1 that have any.

    Args:
        family: packed limbs.
        poses: (N, 4, 4) poses, good ones.
        first: first pose to be answered.
        last: one behind the last.
        rows: (n, 3) intervals: branch, lower and upper end, pose after pose.
        offsets: (N + 1,) where those of each pose begin.
        branch: the only one that is wanted; -1: all.
        seeds: (7,) posture to be near to, one for all or one a pose; None: farthest from the limits.
        respect: whether the joint limits have to be kept.
        out: (N, ROW) output; the rows of other poses are left as they are.
    """
    P = row(family, LIMITED)
    for i in range(first, last):
        if offsets[i + 1] > offsets[i]:
            R, p, _ = read_pose(row(poses, i))
            goal = (seeds is not None, seed_or_zero(own_seed(seeds, i)), respect)
            found = rows[offsets[i] : offsets[i + 1]]
            best_of(P, Spot(R, p, place(P, R, p)), found, branch, goal, row(out, i))
