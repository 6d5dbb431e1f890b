"""The best path by brute force: every posture of a fine sweep, every step between two poses, nothing clever."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numba import njit

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


@njit(cache=True)
def advance(before: np.ndarray, cost: np.ndarray, now: np.ndarray, longest: float, endless: np.ndarray) -> np.ndarray:
    """(m,) least costs of postures now from those of postures before, all pairs; one of a break where it is cheaper.

    Postures before are sorted by their first joint that has ends, so that those too far away in it are left out.
    """
    key = 0
    while endless[key] and key < 6:
        key += 1
    order = np.argsort(before[:, key])
    keys = before[order, key]
    cheapest = cost.min()
    best = np.empty(len(now))
    for i in range(len(now)):
        least = 1e300
        first, last = 0, len(order)
        if not endless[key]:
            first = np.searchsorted(keys, now[i, key] - longest)
            last = np.searchsorted(keys, now[i, key] + longest, side="right")
        for k in range(first, last):
            total, most = cost[order[k]], 0.0
            for j in range(7):
                d = now[i, j] - before[order[k], j]
                if endless[j]:
                    d -= TURN * np.floor(d / TURN + 0.5)
                most = max(most, abs(d))
                total += d * d
                if most > longest or total >= least:
                    break
            if most <= longest and total < least:
                least = total
        if least > cheapest + BREAK:
            for k in range(len(before)):
                total = cost[k] + BREAK
                if total >= least:
                    continue
                for j in range(7):
                    d = now[i, j] - before[k, j]
                    if endless[j]:
                        d -= TURN * np.floor(d / TURN + 0.5)
                    total += d * d
                least = min(least, total)
        best[i] = least
    return best


def best_path(arm: srs_ik.Arm, nodes: list[np.ndarray], seed: np.ndarray | None, longest: float) -> tuple[int, float]:
    """Fewest breaks, and with so many the least sum of squared joint steps, over postures given for each pose."""
    endless = np.isinf(arm.lower) & np.isinf(arm.upper)
    cost = np.zeros(len(nodes[0]))
    if seed is not None:
        cost = advance(seed[None], np.zeros(1), nodes[0], longest, endless)
    for before, now in pairwise(nodes):
        cost = advance(before, cost, now, longest, endless)
    total = float(cost.min())
    return int(total // BREAK), total % BREAK
