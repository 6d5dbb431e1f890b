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


class EdgeHit(NamedTuple):
    """What is in the way of a line."""

    line: int  # from this posture of the path to the next
    at: float  # where on it, 0 to 1
    collision: Collision


class Edges:
    """The lines of a path, looked along: `hits` are what is in the way, or could not be shown to be out, of which."""

    def __init__(self, around: Surroundings, q: Array, lines: NDArray[np.int64]) -> None:
        found = around.along(q[lines], q[lines + 1], np.full(len(lines), around.margin))
        self.hits: list[EdgeHit] = []
        for line, edge in zip(lines.tolist(), found, strict=True):
            is_clear = edge[at.EDGE_PAIR] < 0.0
            # Bodies that ranges of joints watch keep apart between two postures in these; else the shapes have to say.
            if is_clear and around.keeps_range(q[line]) and around.keeps_range(q[line + 1]):
                continue
            hit: tuple[float, Collision | None] = float(edge[at.EDGE_AT]), around.collision_of(edge)
            if around.is_exact or is_clear:
                hit = _by_shapes(around, q[line], q[line + 1])
            if hit[1] is not None:
                self.hits.append(EdgeHit(line, hit[0], hit[1]))


def _by_shapes(around: Surroundings, start: Array, end: Array) -> tuple[float, Collision | None]:
    """Where on a line the real shapes are in the way, and which."""
    formless = around.tables.formless
    if len(formless):
        edge = around.along(start[None], end[None], np.array([around.margin]), formless)[0]
        if edge[at.EDGE_PAIR] >= 0.0:
            return float(edge[at.EDGE_AT]), around.collision_of(edge, formless)
    place, first, second, distance = around.real_world().along(start, end, around.margin + _TOUCH)
    if not first:
        return 0.0, None
    return place, Collision(first, second, max(around.margin - distance, 0.0))


_TOUCH = 1e-5
"""Distances are known to this, m: coal's tolerance is 1e-6."""
