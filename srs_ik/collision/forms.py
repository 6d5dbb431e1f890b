"""Forms in space, of links and of objects: their surface as triangles, and planes around those that are convex."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from srs_ik.system.arrays import Array

Kind = Literal["box", "cylinder", "sphere", "capsule", "mesh", "half_space"]

_SECTIONS = 24
"""Sides of the prism around a cylinder."""

_AROUND = 12
"""Directions around an axis, of planes."""


@dataclass(frozen=True, eq=False)
class Form:
    """A form in the frame of what carries it."""

    # a cylinder or capsule has its axis along z, and its centre in the origin; a half-space is all below z = 0
    kind: Kind
    # box: 3 edges; cylinder and capsule: radius and length (of its cylinder); sphere: radius, m; others: none
    size: tuple[float, ...]
    T: Array  # (4, 4) where it is
    vertices: Array | None = None  # (n, 3) of a mesh, m
    faces: NDArray[np.int64] | None = None  # (m, 3) of a mesh

    def __str__(self) -> str:
        sizes = " x ".join(f"{size:.4g}" for size in self.size)
        return f"{self.kind} {sizes} m" if sizes else str(self.kind)

    def moved(self, T: Array) -> Form:
        """The form in another frame."""
        return Form(self.kind, self.size, T @ self.T, self.vertices, self.faces)


def frame_along(unit: Array, origin: Array) -> Array:
    """(4, 4) a frame whose z axis has a direction (3,), of length one."""
    T = np.eye(4)
    across = np.linalg.svd(unit[None])[2][1]
    T[:3] = np.column_stack([across, np.cross(unit, across), unit, origin])
    return T


def least_along(form: Form, direction: Array) -> float:
    """The least that a form reaches along a unit vector, both in its own frame and not in that of its carrier, m."""
    if form.kind == "mesh":
        assert form.vertices is not None
        return float((form.vertices @ direction).min())
    if form.kind == "box":
        return -0.5 * float(np.abs(direction) @ np.array(form.size))
    if form.kind == "sphere":
        return -form.size[0]
    radius, length = form.size
    across = 1.0 if form.kind == "capsule" else math.hypot(direction[0], direction[1])
    return -radius * across - 0.5 * length * abs(float(direction[2]))


def surface(form: Form) -> tuple[Array, NDArray[np.int64]]:
    """Vertices and faces, in the frame of the carrier, that go around a form; those of a mesh are its own."""
    import trimesh

    if form.kind == "mesh":
        assert form.vertices is not None
        assert form.faces is not None
        vertices, faces = form.vertices, form.faces
    elif form.kind == "box":
        mesh = trimesh.creation.box(np.array(form.size))
        vertices, faces = mesh.vertices, mesh.faces
    elif form.kind == "cylinder":
        radius, length = form.size
        mesh = trimesh.creation.cylinder(radius / math.cos(math.pi / _SECTIONS), length, sections=_SECTIONS)
        vertices, faces = mesh.vertices, mesh.faces
    else:
        radius, length = (form.size[0], 0.0) if form.kind == "sphere" else form.size
        ball = trimesh.creation.icosphere(subdivisions=3)
        # Its faces lie inside of the sphere: their planes are moved out as far as the nearest one needs it.
        depth = float(np.einsum("ij,ij->i", ball.triangles_center, ball.face_normals).min())
        points = ball.vertices * (radius / depth)
        if length:
            from scipy.spatial import ConvexHull

            up = np.array([0.0, 0.0, 0.5 * length])
            points = np.concatenate([points + up, points - up])
            faces = _outwards(points, ConvexHull(points).simplices)
        else:
            faces = ball.faces
        vertices = points
    return np.asarray(vertices @ form.T[:3, :3].T + form.T[:3, 3], dtype=float), np.asarray(faces, dtype=np.int64)


def _outwards(points: Array, faces: NDArray[np.int32]) -> NDArray[np.int64]:
    a, b, c = (points[faces[:, k]] for k in range(3))
    inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), a - points.mean(axis=0)) < 0.0
    out = faces.astype(np.int64)
    out[inwards] = out[inwards][:, ::-1]
    return out


THINNEST = 1000.0
"""A capsule longer than so many times its radius is no row of spheres."""


def row_of_spheres(form: Form) -> Array | None:
    """(n, 4) spheres that cover a sphere or a capsule with next to nothing beyond it; else None."""
    if form.kind == "sphere":
        return np.array([[*form.T[:3, 3], form.size[0]]])
    if form.kind != "capsule" or form.size[1] > THINNEST * form.size[0]:
        return None
    radius, length = form.size
    count = 1 + math.ceil(length / (0.6 * radius))
    spacing = length / max(count - 1, 1)
    z = np.linspace(-0.5 * length, 0.5 * length, count)
    centres = np.column_stack([np.zeros((count, 2)), z]) @ form.T[:3, :3].T + form.T[:3, 3]
    return np.column_stack([centres, np.full(count, math.hypot(radius, 0.5 * spacing))])


def planes(form: Form) -> Array:
    """(n, 4) planes, normals outwards and offsets, between which a convex form lies; in the frame of the carrier.

    Faces and, so that little is lost where spheres touch edges and corners, planes across these.
    """
    if form.kind == "box":
        half = 0.5 * np.array(form.size)
        grid = np.array(np.meshgrid([-1, 0, 1], [-1, 0, 1], [-1, 0, 1])).reshape(3, -1).T
        normals = grid[np.any(grid != 0, axis=1)].astype(float)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        offsets = np.abs(normals) @ half
    else:
        radius, length = form.size
        tilts = [0.0, 0.25 * math.pi] if form.kind == "cylinder" else [0.0, math.pi / 6.0, math.pi / 3.0]
        turns = 2.0 * math.pi * np.arange(_AROUND) / _AROUND
        rows = [
            np.column_stack([math.cos(t) * np.cos(turns), math.cos(t) * np.sin(turns), np.full(_AROUND, math.sin(t))])
            for t in sorted({*tilts, *(-tilt for tilt in tilts)})
        ]
        normals = np.concatenate([*rows, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
        along = 0.5 * length * np.abs(normals[:, 2])
        across = radius * (np.hypot(normals[:, 0], normals[:, 1]) if form.kind == "cylinder" else 1.0)
        offsets = along + across
    turned = normals @ form.T[:3, :3].T
    return np.column_stack([turned, offsets + turned @ form.T[:3, 3]])


def is_round(forms: Iterable[Form], point: Array, direction: Array) -> bool:
    """Whether forms look the same however they are turned about a line, given by a point and a unit vector."""
    for form in forms:
        if form.kind not in ("sphere", "cylinder", "capsule"):
            return False
        off = np.linalg.norm(np.cross(form.T[:3, 3] - point, direction))
        tilted = 0.0 if form.kind == "sphere" else np.linalg.norm(np.cross(form.T[:3, 2], direction))
        if max(off, tilted) > _ROUND:
            return False
    return True


_ROUND = 1e-9
"""Off a line by less than this, m and rad, is on it."""


def ball_around(form: Form) -> Array:
    """(4,) a sphere that contains a form."""
    if form.kind == "mesh":
        assert form.vertices is not None
        points = form.vertices @ form.T[:3, :3].T + form.T[:3, 3]
        centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
        return np.array([*centre, float(np.linalg.norm(points - centre, axis=1).max())])
    if form.kind == "half_space":
        radius = math.inf
    elif form.kind == "box":
        radius = 0.5 * float(np.linalg.norm(form.size))
    elif form.kind == "cylinder":
        radius = math.hypot(form.size[0], 0.5 * form.size[1])
    else:
        radius = form.size[0] + (0.5 * form.size[1] if form.kind == "capsule" else 0.0)
    return np.array([*form.T[:3, 3], radius])
