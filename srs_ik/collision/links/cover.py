"""Spheres that cover a mesh for certain, and stick out of it as little as a number of spheres allows.

Every triangle is cut until it is small, and each small one lies in one sphere, whole: its three corners do, and a
sphere is convex. Where the spheres go is a matter of quality alone: their centres are those of the largest balls that
fit into the mesh, and a greedy choice among them takes those that, grown by some depth, cover most. The depth is the
least one for which the number suffices.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from srs_ik.system.arrays import Array

_PARTS = 64
"""Triangles are cut to this part of the diagonal of the mesh ..."""

_MOST_CORNERS = 15_000
"""... or coarser ones, where these would have more corners."""

_CENTRES = 350
"""Balls among which spheres are chosen ..."""

_LOOKED_AT = 2_500
"""... by how many of so many triangles they cover."""

_SHRINKS = 14
_HALVINGS = 8
_ROUNDING = 1e-9
"""Added to every radius, m: sums of squares round."""

_DIRECTIONS = 200
"""Points of a sphere at which its protrusion is measured."""


class Cover(NamedTuple):
    """Spheres that contain a surface."""

    spheres: Array  # (n, 4) centre and radius, m
    protrusion: float
    """Largest distance from the surface of a point of the spheres that lies outside of it, m; measured."""


def cover(vertices: Array, faces: NDArray[np.int64], count: int) -> Cover:
    """Cover the triangles of a mesh, vertices (n, 3), m, and faces (m, 3) outwards, with about `count` spheres."""
    corners, triangles, lost = _small_triangles(vertices, faces)
    normals = _normals(corners, triangles)
    tree = cKDTree(corners)
    centres, clearance = _inner_balls(corners, normals, tree)
    chosen = _greedy(corners, triangles, centres, clearance, count, float(np.ptp(corners, axis=0).max()))
    spheres = _tightened(corners, triangles, chosen)
    spheres[:, 3] += lost + _ROUNDING
    return Cover(spheres, protrusion(spheres, corners, normals, tree))


def _small_triangles(vertices: Array, faces: NDArray[np.int64]) -> tuple[Array, NDArray[np.int64], float]:
    """Corners and triangles that make up the same surface, and how far they may be from it, m."""
    import trimesh

    extent = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    vertices, faces, lost = _merged(vertices, faces, extent)
    length = extent / _PARTS
    while True:
        corners, triangles = trimesh.remesh.subdivide_to_size(vertices, faces, length, max_iter=40)
        corners, triangles, more = _merged(corners, triangles, extent)
        if len(corners) <= _MOST_CORNERS or len(corners) <= len(vertices):
            return corners, triangles, lost + more
        length *= 1.5


def _merged(vertices: Array, faces: NDArray[np.int64], extent: float) -> tuple[Array, NDArray[np.int64], float]:
    """Corners that are one put together; of too many, those in one cell of a grid, and how far that moves them, m."""
    cell = 1e-7 * max(extent, 1e-3)
    while True:
        keys = np.round(vertices / cell).astype(np.int64)
        first, inverse = _distinct(keys)
        if len(first) <= 2 * _MOST_CORNERS:
            break
        cell = max(2.0 * cell, extent / 400.0)
    moved = float(np.linalg.norm(vertices - vertices[first][inverse], axis=1).max(initial=0.0))
    # A triangle that has become a line or a point stays: what is left of it has to be covered, too.
    joined, _ = _distinct(np.sort(inverse[faces], axis=1))
    return vertices[first], inverse[faces][joined], moved


def _distinct(rows: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The first of each kind of row, in the order of rows, and of which kind each row is; NumPy's own takes long."""
    order = np.lexsort(rows.T[::-1])
    ordered = rows[order]
    new = np.append(True, (ordered[1:] != ordered[:-1]).any(axis=1))[: len(rows)]
    kind = np.empty(len(rows), np.int64)
    kind[order] = np.cumsum(new) - 1
    return order[new], kind


def _normals(corners: Array, triangles: NDArray[np.int64]) -> Array:
    """(n, 3) mean outward direction at each corner; zero where there is none."""
    a, b, c = (corners[triangles[:, k]] for k in range(3))
    areas = np.cross(b - a, c - a)
    normals = np.zeros_like(corners)
    for k in range(3):
        np.add.at(normals, triangles[:, k], areas)
    if np.einsum("ij,ij->", a, areas) < 0.0:
        normals = -normals  # A mesh whose triangles face inwards.
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return normals / np.where(length > 0.0, length, 1.0)


def _inner_balls(corners: Array, normals: Array, tree: cKDTree) -> tuple[Array, Array]:
    """Centres (n, 3) of the largest balls that touch the surface from inside, and their distance from it (n,)."""
    extent = float(np.ptp(corners, axis=0).max())
    chosen = np.random.default_rng(0).permutation(len(corners))[:_CENTRES]
    p, n = corners[chosen], normals[chosen]
    radius = np.full(len(p), 0.5 * extent)
    for _ in range(_SHRINKS):
        centre = p - radius[:, None] * n
        distance, nearest = tree.query(centre)
        across = p - corners[nearest]
        along = np.einsum("ij,ij->i", n, across)
        smaller = (distance < radius * (1.0 - 1e-3)) & (along > 1e-9 * extent)
        if not smaller.any():
            break
        square = np.einsum("ij,ij->i", across, across)
        radius = np.where(smaller, square / (2.0 * np.where(smaller, along, 1.0)), radius)
    centre = p - radius[:, None] * n
    # On the surface there are the smallest balls of all.
    centre = np.concatenate([centre, p])
    distance, nearest = tree.query(centre)
    inside = np.einsum("ij,ij->i", centre - corners[nearest], normals[nearest]) <= 1e-3 * extent
    return centre[inside], distance[inside]


def _greedy(
    corners: Array, triangles: NDArray[np.int64], centres: Array, clearance: Array, count: int, extent: float
) -> Array:
    """(n, 4) spheres of the least depth that cover the triangles looked at with so many of them."""
    if len(triangles) > _LOOKED_AT:
        triangles = triangles[np.random.default_rng(1).permutation(len(triangles))[:_LOOKED_AT]]
    used, triangles = np.unique(triangles, return_inverse=True)
    corners, triangles = corners[used], triangles.reshape(-1, 3)
    square = np.einsum("ij,ij->i", corners, corners)[:, None] - 2.0 * corners @ centres.T
    distance = np.sqrt(np.maximum(square + np.einsum("ij,ij->i", centres, centres), 0.0))
    # What all three corners of a triangle need for lying in the sphere, beyond the clearance of its centre.
    needed = (np.maximum.reduce([distance[triangles[:, k]] for k in range(3)]) - clearance).astype(np.float32)
    low, high, best = 0.0, extent, None
    for _ in range(_HALVINGS):
        depth = 0.5 * (low + high) if best is not None else high
        found = _choose(needed <= depth, count)
        if found is None:
            low = depth
            if best is None:
                break
        else:
            high, best = depth, (found, depth)
    if best is None:  # One sphere around everything.
        centre = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
        return np.array([[*centre, float(np.linalg.norm(corners - centre, axis=1).max())]])
    found, depth = best
    return np.column_stack([centres[found], clearance[found] + depth])


def _choose(inside: NDArray[np.bool_], count: int) -> list[int] | None:
    """Columns that together are true in every row, chosen one by one; None where more than `count` are needed."""
    left = np.ones(len(inside), bool)
    gain = inside.sum(axis=0)
    chosen: list[int] = []
    while left.any():
        best = int(gain.argmax())
        if gain[best] == 0 or len(chosen) == count:
            return None
        chosen.append(best)
        new = left & inside[:, best]
        gain -= inside[new].sum(axis=0)
        left &= ~new
    return chosen


def _tightened(corners: Array, triangles: NDArray[np.int64], spheres: Array) -> Array:
    """The spheres, each no larger than the triangles that lie deepest in it need; those without any left out."""
    distance = np.linalg.norm(corners[:, None, :] - spheres[None, :, :3], axis=2)
    reach = np.maximum.reduce([distance[triangles[:, k]] for k in range(3)])
    owner = (reach - spheres[:, 3]).argmin(axis=1)
    kept = []
    for k, sphere in enumerate(spheres):
        own = owner == k
        if own.any():
            kept.append([*sphere[:3], float(reach[own, k].max())])
    return np.array(kept)


def protrusion(spheres: Array, corners: Array, normals: Array, tree: cKDTree) -> float:
    """How far spheres stick out of a surface, m, at many points of each."""
    k = np.arange(_DIRECTIONS) + 0.5
    height, turn = 1.0 - 2.0 * k / _DIRECTIONS, np.pi * (1.0 + np.sqrt(5.0)) * k
    across = np.sqrt(1.0 - height * height)
    directions = np.column_stack([across * np.cos(turn), across * np.sin(turn), height])
    points = (spheres[:, None, :3] + spheres[:, None, 3:] * directions).reshape(-1, 3)
    distance, nearest = tree.query(points)
    outside = np.einsum("ij,ij->i", points - corners[nearest], normals[nearest]) > 0.0
    return float(distance[outside].max(initial=0.0))
