"""Exhaustive dynamic programming over swept postures, compiled by Numba: every step between two poses is looked at.

Left out is what cannot be part of a better path alone: steps that are longer than a continuous one, which lie in no
neighbouring cell of a grid over three joints, and postures that cost more by themselves than a whole path that is
known.
"""

from __future__ import annotations

import numpy as np
from numba import njit

TURN = 2.0 * np.pi
BREAK = 1e6
"""Cost of a break; all postures of a pose are reached by one."""

BINNED = 3
"""Joints over which the grid lies."""


def best_path(
    nodes: list[np.ndarray], seed: np.ndarray | None, longest: float, endless: np.ndarray, known: float
) -> tuple[int, float]:
    """Fewest breaks, and without any the least sum of squared joint steps, over postures given for each pose.

    Args:
        nodes: (m, 7) postures of each pose.
        seed: (7,) posture before the first one, or None.
        longest: longest joint step that is continuous, rad.
        endless: (7,) which joints turn without end.
        known: breaks times `BREAK`, and the sum of squared joint steps, of a path that is known; inf: none is.
    """
    before, cost = nodes[0], np.zeros(len(nodes[0]))
    if seed is not None:
        cost = advance(seed[None], np.zeros(1), before, longest, endless)
    for behind in nodes[1:]:
        kept = cost <= known
        before, cost = before[kept], cost[kept]
        if not len(before):
            return int(known // BREAK), np.inf
        cost = advance(before, cost, behind, longest, endless)
        before = behind
    total = float(cost.min())
    return int(total // BREAK), total % BREAK


def advance(before: np.ndarray, cost: np.ndarray, now: np.ndarray, longest: float, endless: np.ndarray) -> np.ndarray:
    """(k,) least costs of postures now (k, 7), from those of postures before (m, 7): no longer step, or one break."""
    low, spread = before.min(axis=0), np.where(endless, TURN, np.ptp(before, axis=0))
    joints = np.argsort(-spread)[:BINNED]
    counts = np.maximum((spread[joints] / longest).astype(np.int64), 1)
    # The cells of joints without end close to a circle, so that these are a little wider.
    sizes = np.where(endless[joints], TURN / counts, longest)
    counts = np.where(endless[joints], counts, counts + 1)
    cells = np.floor((before[:, joints] - low[joints]) / sizes).astype(np.int64)
    cells = np.where(endless[joints], cells % counts, cells)
    flat = np.ravel_multi_index(tuple(cells.T), tuple(counts))
    order = np.argsort(flat, kind="stable")
    starts = np.searchsorted(flat[order], np.arange(np.prod(counts) + 1))
    places = np.floor((now[:, joints] - low[joints]) / sizes).astype(np.int64)
    grid = places, counts, endless[joints], starts
    periods = np.where(endless, TURN, 0.0)
    least = _cheapest(np.ascontiguousarray(before[order]), cost[order], now, longest, periods, grid)
    return np.minimum(least, cost.min() + BREAK)


@njit(cache=True)
def _cheapest(before, cost, now, longest, periods, grid):
    """(k,) least costs by steps that are not too long; inf where there is none."""
    places, counts, round_, starts = grid
    least = np.full(now.shape[0], np.inf)
    for i in range(now.shape[0]):
        for neighbour in range(27):
            offsets = (neighbour // 9 - 1, neighbour // 3 % 3 - 1, neighbour % 3 - 1)
            flat, inside = 0, True
            for k in range(3):
                cell = places[i, k] + offsets[k]
                if round_[k]:
                    cell %= counts[k]
                inside = inside and 0 <= cell < counts[k]
                flat = flat * counts[k] + cell
            if not inside:
                continue
            for a in range(starts[flat], starts[flat + 1]):
                total = cost[a]
                for j in range(7):
                    d = now[i, j] - before[a, j]
                    if periods[j] > 0.0:
                        d -= periods[j] * np.floor(d / periods[j] + 0.5)
                    total += d * d
                    if total >= least[i] or abs(d) > longest:
                        total = np.inf
                        break
                least[i] = min(least[i], total)
    return least
