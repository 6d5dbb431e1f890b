"""The best path by brute force: every posture of a fine sweep, every step between two poses, nothing clever."""

from __future__ import annotations

from itertools import pairwise, product

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

import srs_ik

TURN = 2.0 * np.pi
BREAK = 1e6


def swept_postures(arm: srs_ik.Arm, pose: np.ndarray, count: int) -> np.ndarray:
    """(m, 7) postures inside the limits at `count` arm angles in all branches, in all turns (one if without end)."""
    angles = np.linspace(-np.pi, np.pi, count, endpoint=False) + 1e-4
    poses = np.broadcast_to(pose, (count, 4, 4))
    batch = arm.solve_batch(poses, arm_angle=angles, all_branches=True, respect_limits=False)
    q = (batch.q[batch.ok] + np.pi) % TURN - np.pi
    endless = np.isinf(arm.lower) & np.isinf(arm.upper)
    choices = [(0,) if e else (-1, 0, 1) for e in endless]
    lower, upper = np.where(endless, -np.inf, arm.lower - 1e-9), np.where(endless, np.inf, arm.upper + 1e-9)
    # Joint by joint: all turns of all joints at once would be too many.
    rows = q
    for joint, turns in enumerate(choices):
        moved = np.vstack([rows + TURN * t * np.eye(7)[joint] for t in turns])
        rows = moved[(moved[:, joint] >= lower[joint]) & (moved[:, joint] <= upper[joint])]
    return rows


def best_path(arm: srs_ik.Arm, nodes: list[np.ndarray], seed: np.ndarray | None, longest: float) -> tuple[int, float]:
    """Fewest breaks, and with so many the least sum of squared joint steps, over postures given for each pose."""
    endless = np.isinf(arm.lower) & np.isinf(arm.upper)
    box = np.where(endless, TURN, 0.0)

    def steps(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        d = b - a
        return d - np.where(endless, TURN * np.round(d / TURN), 0.0)

    cost = np.zeros(len(nodes[0]))
    if seed is not None:
        d = steps(seed, nodes[0])
        cost = (d**2).sum(1) + BREAK * (np.abs(d).max(1) > longest)
    for before, now in pairwise(nodes):
        place = cKDTree(np.where(endless, before % TURN, before), boxsize=box)
        best = np.full(len(now), np.inf)
        asked = np.where(endless, now % TURN, now)
        pairs = place.query_ball_point(asked, longest, p=np.inf)
        counts = np.array([len(p) for p in pairs])
        if counts.sum():
            first = np.concatenate([p for p in pairs if p]).astype(int)
            second = np.repeat(np.arange(len(now)), counts)
            value = cost[first] + (steps(before[first], now[second]) ** 2).sum(1)
            np.minimum.at(best, second, value)
        late = best > cost.min() + BREAK
        if late.any():
            # cdist knows no joints without end: a turn either way is as near.
            shifts = product(*[(-TURN, 0.0, TURN) if e else (0.0,) for e in endless])
            there = now[late]
            least = np.full(late.sum(), np.inf)
            for shift in shifts:
                squared = cdist(there + np.array(shift), before, "sqeuclidean")
                least = np.minimum(least, (squared + cost).min(1))
            best[late] = np.minimum(best[late], least + BREAK)
        cost = best
    total = float(cost.min())
    return int(total // BREAK), total % BREAK
