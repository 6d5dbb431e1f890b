"""Straight lines of joint angles that are certified: by the spheres, and where these are in the way by real shapes."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.layout import collision as at
from srs_ik.solve.solution import Collision
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.in_scene.surroundings import Surroundings


class PathCollision(NamedTuple):
    """What is in the way on the straight line of joint angles from one posture of a path to the next."""

    sample: int
    """The posture before, counted from 0."""
    at: float
    """Where on the line, 0 to 1."""
    collision: Collision
    """Which two bodies meet there, or could not be shown to keep the margin."""


class Edges:
    """The lines of a path, looked along: `hits` are what is in the way, or could not be shown to be out, of which.

    By the spheres alone, unless real shapes are asked where these are in the way.
    """

    def __init__(self, around: Surroundings, q: Array, lines: NDArray[np.int64], by_shapes: bool) -> None:
        found = around.along(q[lines], q[lines + 1], np.full(len(lines), around.margin))
        self.hits: list[PathCollision] = []
        for line, edge in zip(lines.tolist(), found, strict=True):
            is_clear = edge[at.EDGE_PAIR] < 0.0
            # Bodies that ranges of joints watch keep apart between two postures in these; else the shapes have to say.
            if is_clear and around.keeps_range(q[line]) and around.keeps_range(q[line + 1]):
                continue
            hit: tuple[float, Collision | None] = float(edge[at.EDGE_AT]), around.collision_of(edge)
            if by_shapes or is_clear:
                hit = _by_shapes(around, q[line], q[line + 1])
            if hit[1] is not None:
                self.hits.append(PathCollision(line, hit[0], hit[1]))


def _by_shapes(around: Surroundings, start: Array, end: Array) -> tuple[float, Collision | None]:
    """Where on a line the real shapes are in the way, and which."""
    formless = around.tables.formless
    if len(formless):
        edge = around.along(start[None], end[None], np.array([around.margin]), formless)[0]
        if edge[at.EDGE_PAIR] >= 0.0:
            return float(edge[at.EDGE_AT]), around.collision_of(edge, formless)
    pairs = around.watched(np.array([start, end]), _TOUCH)
    place, first, second, distance = around.real_world().along(start, end, around.margin + _TOUCH, pairs)
    if not first:
        return 0.0, None
    return place, Collision(first, second, max(around.margin - distance, 0.0))


_TOUCH = 1e-5
"""Distances are known to this, m: coal's tolerance is 1e-6."""
