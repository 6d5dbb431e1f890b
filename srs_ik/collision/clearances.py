"""How near each body of an arm is to what it must not meet, at a posture; by NumPy, for pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from srs_ik.kernels.layout import collision as at
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.collision.tables import Tables

CARRIERS = (0, 7, 3, 4)
"""The joint that carries each place of the layout."""


def clearances(tables: Tables, frames: Array, zero: Array) -> Array:
    """(G,) least distance of each group to all groups that it is watched against, m; inf where there is none.

    `frames` (8, 4, 4) are those of the joints at the posture, `zero` the same at zero.
    """
    moved = [frames[k] @ np.linalg.inv(zero[k]) for k in CARRIERS]
    rows = [tables.bodies[first:last] for first, last, *_ in tables.groups]
    placed = [
        _placed(own, moved[place]) if kind == at.SPHERES else own
        for own, (_, _, place, kind, _) in zip(rows, tables.groups, strict=True)
    ]
    least = np.full(len(rows), np.inf)
    for a, b in tables.pairs:
        flat = tables.groups[b, at.KIND] == at.PLANES
        gap = _from_planes(placed[a], placed[b]) if flat else _apart(placed[a], placed[b])
        least[a], least[b] = min(least[a], gap), min(least[b], gap)
    return least


def _placed(rows: Array, T: Array) -> Array:
    return np.column_stack([rows[:, :3] @ T[:3, :3].T + T[:3, 3], rows[:, 3]])


def _apart(a: Array, b: Array) -> float:
    gap = np.linalg.norm(a[:, None, :3] - b[None, :, :3], axis=2)
    return float((gap - a[:, None, 3] - b[None, :, 3]).min())


def _from_planes(spheres: Array, planes: Array) -> float:
    height = spheres[:, :3] @ planes[:, :3].T - planes[:, 3]
    return float((height.max(axis=1) - spheres[:, 3]).min())
