"""Which cells a path can pass whose joint steps all stay below limits, and the least limit with which one goes through.

A cell is a straight piece of joint space, beside which postures of a pose lie. What of each is reached from the first
pose on, and from the last one back, is exact for cells.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.entries import path_bound as entries
from srs_ik.kernels.layout.path import CELL
from srs_ik.system.arrays import Array

ROUNDING = 1e-9
"""Of a part of a cell."""


@dataclass
class Cells:
    """Cells (m, CELL) of some poses: those of pose i are in rows ends[i] to ends[i + 1] - 1."""

    rows: Array
    ends: NDArray[np.int64]

    def where(self, some: NDArray[np.bool_]) -> Cells:
        """Some of them, (m,)."""
        return Cells(np.ascontiguousarray(self.rows[some]), np.append(0, np.cumsum(some))[self.ends])


def posture_cell(q: Array) -> Array:
    """The cell of one posture, (1, CELL)."""
    row = np.zeros((1, CELL))
    row[0, :7] = q
    return row


def after(seed: Array | None, cells: Cells) -> Cells:
    """The cells of a path, with the posture before the first one if there is one."""
    if seed is None:
        return cells
    return Cells(np.vstack([posture_cell(seed), cells.rows]), np.append(0, cells.ends + 1))


def reached(cells: Cells, limits: Array, settings: Array, backward: bool = False) -> tuple[bool, Array]:
    """Whether a path goes through with steps below limits, and what (m, 2) it reaches of each cell.

    Limits (k, 7) are those of the step to each of the k poses of the cells; those of the first one count nowhere.
    """
    spans = np.tile([0.0, 1.0], (len(cells.rows), 1))
    change = 1 + np.flatnonzero((limits[1:-1] != limits[2:]).any(axis=1))
    pieces = list(pairwise([0, *change.tolist(), len(limits) - 1]))
    for first, last in reversed(pieces) if backward else pieces:
        own = cells.ends[first : last + 2]
        if not entries.reach(cells.rows, own, backward, limits[last], settings, spans):
            return False, spans
    return True, spans


def passed(cells: Cells, limits: Array, settings: Array) -> NDArray[np.bool_]:
    """(m,) which cells may be on a path with steps below limits, as in `reached`."""
    found = np.zeros(len(cells.rows), np.bool_)
    through, forth = reached(cells, limits, settings)
    if through:
        live = forth[:, 0] <= forth[:, 1]
        _, back = reached(cells.where(live), limits, settings, backward=True)
        forth = forth[live]
        found[live] = np.maximum(forth[:, 0], back[:, 0]) <= np.minimum(forth[:, 1], back[:, 1]) + ROUNDING
    return found


def least_through(cells: Cells, low: float, high: float, until: float, settings: Array, most: Array) -> float:
    """What no path through cells has a smaller largest step than, from two bounds of it, as exact as asked for.

    No joint steps farther than `most` (k, 7), as in `reached`.
    """
    while high - low > until:
        middle = 0.5 * (low + high)
        through, _ = reached(cells, np.minimum(middle, most), settings)
        low, high = (low, middle) if through else (middle, high)
    return low
