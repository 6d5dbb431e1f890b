"""The best path by brute force: every posture of a fine sweep, every step between two poses, nothing clever."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

import srs_ik

TURN = 2.0 * np.pi
BREAK = 1e6
ANY_STEP = 1e4
"""No step has larger squares."""


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


CHUNK = 64
"""So many postures are looked at together."""


def differences(a: np.ndarray, b: np.ndarray, endless: np.ndarray) -> np.ndarray:
    """(k, m, 7) joint steps from postures a (k, 7) to b (m, 7), the shorter way round for joints without end."""
    d = b[None] - a[:, None]
    d[..., endless] -= TURN * np.floor(d[..., endless] / TURN + 0.5)
    return d


def advance(before: np.ndarray, cost: np.ndarray, now: np.ndarray, longest: float, endless: np.ndarray) -> np.ndarray:
    """(m,) least costs of postures now from those of postures before, all pairs; one of a break where it is cheaper.

    Both are sorted by the joint that differs most of those that have ends: who is too far away in it is left out.
    """
    spread = np.where(endless, -1.0, np.ptp(before, axis=0))
    key = int(spread.argmax())
    order, queue = np.argsort(before[:, key]), np.argsort(now[:, key])
    before, cost = before[order], cost[order]
    keys = before[:, key]
    cheapest = cost.min()
    open_ended = cost < cheapest + ANY_STEP
    best = np.empty(len(now))
    for first in range(0, len(now), CHUNK):
        some = queue[first : first + CHUNK]
        there = now[some]
        a, b = 0, len(keys)
        if not endless[key]:
            a = np.searchsorted(keys, there[0, key] - longest)
            b = np.searchsorted(keys, there[-1, key] + longest, side="right")
        least = _cheapest(before[a:b], cost[a:b], there, longest, endless)
        lost = least > cheapest + BREAK
        if lost.any():
            leap = _cheapest(before[open_ended], cost[open_ended] + BREAK, there[lost], np.inf, endless)
            least[lost] = np.minimum(least[lost], leap)
        best[some] = least
    return best


def _cheapest(before: np.ndarray, cost: np.ndarray, now: np.ndarray, longest: float, endless: np.ndarray) -> np.ndarray:
    """(m,) least costs by steps that are not too long; inf where there is none."""
    d = differences(now, before, endless)
    total = cost + np.einsum("ijk,ijk->ij", d, d)
    if np.isfinite(longest):
        total[np.abs(d).max(axis=2, initial=0.0) > longest] = np.inf
    return total.min(axis=1, initial=np.inf)


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
