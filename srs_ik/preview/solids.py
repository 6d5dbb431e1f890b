"""Solids to draw: triangles with a colour, and the few forms that a preview is made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from srs_ik.preview.palette import Rgb

_SHARP = 0.6
"""Edges whose faces meet at more than this angle, rad, are drawn as edges, flatter ones are drawn round."""

_SMALL = 0.03
"""Spheres up to this radius, metres, are small."""

_SMOOTHED = 200_000
"""Meshes of more faces are not searched for sharp edges, which would take seconds."""


@dataclass(frozen=True, eq=False)
class Solid:
    """Triangles of one colour."""

    mesh: trimesh.Trimesh  # vertices in metres; where vertices are shared the surface is drawn round
    colour: Rgb  # red, green, blue, 0 to 1
    opacity: float = 1.0  # 0 to 1
    overlaid: bool = False  # drawn over what lies in front of it, where the viewer can do that

    def faded(self, colour: Rgb, opacity: float) -> Solid:
        """The same triangles in another colour."""
        return replace(self, colour=colour, opacity=opacity)


def creased(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """A mesh of its own vertices on both sides of each sharp edge."""
    if len(mesh.faces) > _SMOOTHED:
        return mesh
    return trimesh.graph.smooth_shade(mesh, angle=_SHARP)


def box(size: ArrayLike) -> trimesh.Trimesh:
    """A box about the origin; three edges, metres."""
    return creased(trimesh.creation.box(np.asarray(size, dtype=float)))


def cylinder(radius: float, length: float) -> trimesh.Trimesh:
    """A cylinder about the origin, along z."""
    return creased(trimesh.creation.cylinder(radius, length, sections=48))


def capsule(radius: float, length: float) -> trimesh.Trimesh:
    """A cylinder about the origin, along z, with half a sphere beyond each end of its length."""
    mesh = trimesh.creation.capsule(height=length, radius=radius, count=(24, 24))
    return mesh.apply_translation([0.0, 0.0, -mesh.bounds.mean(axis=0)[2]])


def ball(radius: float, centre: ArrayLike = (0.0, 0.0, 0.0)) -> trimesh.Trimesh:
    """A sphere; small ones of fewer triangles."""
    return trimesh.creation.icosphere(subdivisions=3 if radius > _SMALL else 2, radius=radius).apply_translation(
        np.asarray(centre, dtype=float)
    )


def rods(points: Sequence[ArrayLike], radius: float) -> list[trimesh.Trimesh]:
    """Cylinders from each point to the next; none between points that are one."""
    ends = [np.asarray(point, dtype=float) for point in points]
    return [
        creased(trimesh.creation.cylinder(radius, segment=[a, b], sections=24))
        for a, b in pairwise(ends)
        if np.linalg.norm(b - a) > 1e-9
    ]


def arrow(start: ArrayLike, vector: ArrayLike, radius: float) -> trimesh.Trimesh:
    """An arrow from a point; its head is 2.4 times as thick as its shaft, and at most half of its length."""
    a, v = np.asarray(start, dtype=float), np.asarray(vector, dtype=float)
    length = float(np.linalg.norm(v))
    head = min(7.0 * radius, 0.5 * length)
    shaft = trimesh.creation.cylinder(radius, height=length - head, sections=24)
    shaft.apply_translation([0.0, 0.0, 0.5 * (length - head)])
    cone = trimesh.creation.cone(2.4 * radius, head, sections=24).apply_translation([0.0, 0.0, length - head])
    T = trimesh.geometry.align_vectors([0.0, 0.0, 1.0], v / length)
    T[:3, 3] = a
    return _joined(creased(shaft), creased(cone)).apply_transform(T)


def plate(centre: ArrayLike, normal: ArrayLike, radius: float) -> trimesh.Trimesh:
    """A thin disc."""
    n = np.asarray(normal, dtype=float)
    T = trimesh.geometry.align_vectors([0.0, 0.0, 1.0], n / np.linalg.norm(n))
    T[:3, 3] = centre
    return cylinder(radius, 0.01 * radius).apply_transform(T)


def ring(
    centre: ArrayLike, across: ArrayLike, axis: ArrayLike, radius: float, start: float, end: float, thickness: float
) -> trimesh.Trimesh:
    """A piece of a ring (torus), with round ends, from a start to an end angle, rad; 2 pi and more make a whole ring.

    `across` (3,) is the unit vector in its plane where the angle is zero, `axis` (3,) that across the plane, about
    which angles are right-handed; `radius` is that of the circle in its middle, `thickness` that of the section,
    metres.
    """
    c, u, w = (np.asarray(vector, dtype=float) for vector in (centre, across, axis))
    v = np.cross(w, u)
    end = min(end, start + 2.0 * np.pi)
    count, sides = max(2, int(np.ceil((end - start) / 0.06)) + 1), 10
    outward = np.cos(angles := np.linspace(start, end, count))[:, None] * u + np.sin(angles)[:, None] * v
    turns = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    section = np.cos(turns)[None, :, None] * outward[:, None] + np.sin(turns)[None, :, None] * w
    vertices = (c + radius * outward[:, None] + thickness * section).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(count - 1), np.arange(sides), indexing="ij")
    a, b = i * sides + j, i * sides + (j + 1) % sides
    faces = np.stack([[a, a + sides, b], [b, a + sides, b + sides]], axis=-1).transpose(1, 2, 0, 3).reshape(-1, 3)
    tube = trimesh.Trimesh(vertices, faces, process=False)
    if end - start >= 2.0 * np.pi - 1e-9:
        return tube
    ends = [trimesh.creation.icosphere(2, thickness).apply_translation(c + radius * outward[k]) for k in (0, -1)]
    return _joined(tube, *ends)


def triad(length: float) -> list[Solid]:
    """Axes x, y, z of a frame at the origin in red, green and blue."""
    colours: tuple[Rgb, ...] = ((0.86, 0.16, 0.16), (0.16, 0.62, 0.22), (0.14, 0.36, 0.86))
    return [Solid(arrow(np.zeros(3), length * np.eye(3)[k], 0.025 * length), colours[k]) for k in range(3)]


def _joined(*meshes: trimesh.Trimesh) -> trimesh.Trimesh:
    firsts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + first for mesh, first in zip(meshes, firsts[:-1], strict=True)]
    vertices = np.concatenate([mesh.vertices for mesh in meshes])
    return trimesh.Trimesh(vertices, np.concatenate(faces), process=False)
