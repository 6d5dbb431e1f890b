"""Intervals against a sweep that knows nothing of them."""

from itertools import pairwise

import numpy as np
from oracles import room, wrapped

from srs_ik import Interval

TURN = 2.0 * np.pi


def sweep(arm, pose, angles):
    """(len(angles), 8) booleans: whether the posture of each branch exists and keeps the limits in some turn."""
    poses = np.broadcast_to(pose.homogeneous, (len(angles), 4, 4))
    batch = arm.solve_batch(poses, arm_angle=angles, all_branches=True, respect_limits=False)
    return batch.ok & (room(batch.q, arm.lower, arm.upper) >= 0.0).all(axis=-1)


def covered(intervals, branch, angles):
    """Whether arm angles lie in an interval of a branch, and how far they are from the nearest end."""
    inside_any = np.zeros(len(angles), bool)
    from_end = np.full(len(angles), np.inf)
    for interval in intervals:
        if interval.branch == branch:
            inside_any |= (angles - interval.lower) % TURN <= interval.upper - interval.lower
            for end in (interval.lower, interval.upper):
                from_end = np.minimum(from_end, np.abs(wrapped(angles - end)))
    return inside_any, from_end


def disagreements(arm, pose, intervals, count=720):
    """Arm angles at which sweep and intervals differ although no end is within 1e-9."""
    angles = wrapped(np.linspace(-np.pi, np.pi, count, endpoint=False) + 1e-4)
    feasible = sweep(arm, pose, angles)
    wrong = []
    for branch in range(8):
        inside_any, from_end = covered(intervals, branch, angles)
        wrong += [(branch, psi) for psi in angles[(feasible[:, branch] != inside_any) & (from_end > 1e-9)]]
    return wrong


def assert_well_formed(intervals):
    """In order, each within a turn, and those of a branch apart."""
    assert [i.branch for i in intervals] == sorted(i.branch for i in intervals)
    for i in intervals:
        assert isinstance(i, Interval)
        assert 0 <= i.branch <= 7
        assert -np.pi <= i.lower < np.pi
        assert i.lower <= i.upper <= i.lower + TURN + 1e-12
        assert i.lower in i
        assert i.upper in i
        assert 0.5 * (i.lower + i.upper) in i
    for branch in range(8):
        own = sorted((i for i in intervals if i.branch == branch), key=lambda i: i.lower)
        for a, b in pairwise(own):
            assert a.upper <= b.lower + 1e-9, "intervals of a branch overlap"
        if len(own) > 1:
            assert own[-1].upper - TURN <= own[0].lower + 1e-9, "the last one overlaps the first"
