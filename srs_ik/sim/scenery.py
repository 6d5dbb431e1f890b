"""The world of a simulation as triangles, to be looked at."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from srs_ik.inputs.poses import as_rigid_matrix
from srs_ik.sim.world import World

if TYPE_CHECKING:
    import trimesh

SIDE, THICKNESS = 0.8, 0.01
"""Of the plate that stands for a half-space, m."""


def meshes(world: World) -> list[trimesh.Trimesh]:
    """Walls, pegs and boxes in the base frame, m; of a half-space a plate around its point, and no payload."""
    import trimesh

    found = []
    for wall in world.walls:
        n = np.asarray(wall.normal, dtype=float)
        T = trimesh.geometry.align_vectors([0.0, 0.0, 1.0], n / np.linalg.norm(n))
        T[:3, 3] = np.asarray(wall.point) - 0.5 * THICKNESS * n / np.linalg.norm(n)
        found.append(trimesh.creation.box([SIDE, SIDE, THICKNESS], T))
    for peg in world.pegs:
        start, end = np.asarray(peg.start, dtype=float), np.asarray(peg.end, dtype=float)
        found.append(trimesh.creation.cylinder(peg.radius, segment=[start, end], sections=24))
        found += [trimesh.creation.icosphere(2, peg.radius).apply_translation(point) for point in (start, end)]
    found += [trimesh.creation.box(np.asarray(box.size, dtype=float), as_rigid_matrix(box.pose)) for box in world.boxes]
    return found
