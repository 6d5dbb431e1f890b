"""What given joint angles hit, and the straight lines between them: of other planners, of recordings, of a robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from srs_ik.solve.in_scene.edges import Edges, PathCollision
from srs_ik.solve.solution import Collision
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.in_scene.surroundings import Surroundings


def collision(around: Surroundings, q: Array) -> Collision | None:
    """Which two bodies are closest of those that come within the margin at a posture (7,); None for none."""
    return None if around.is_clear(q, False) else around.closest_at(q)


def path_collisions(around: Surroundings, q: Array) -> list[PathCollision]:
    """What is in the way on which lines of a path (N, 7), its postures included."""
    if len(q) == 1:
        q = np.concatenate([q, q])
    return Edges(around, q, np.arange(len(q) - 1), by_shapes=True, by_clouds=True).hits
