"""Straight lines of joint angles that are certified: by the spheres, and where these are in the way by real shapes."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from srs_ik.collision.reaches import TOUCH
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

    By the spheres alone, unless real shapes are asked where these are in the way, and those next to clouds, too.
    """

    def __init__(
        self, around: Surroundings, q: Array, lines: NDArray[np.int64], by_shapes: bool, by_clouds: bool = False
    ) -> None:
        found = around.along(q[lines], q[lines + 1], np.full(len(lines), around.margin))
        self.hits: list[PathCollision] = []
        for line, edge in zip(lines.tolist(), found, strict=True):
            is_clear = edge[at.EDGE_PAIR] < 0.0
            # Bodies that ranges of joints watch keep apart between two postures in these; else the shapes have to say.
            if is_clear and around.keeps_range(q[line]) and around.keeps_range(q[line + 1]):
                continue
            hit: tuple[float, Collision | None] = float(edge[at.EDGE_AT]), around.collision_of(edge)
            if by_shapes or is_clear:
                look = _first_in_the_way if by_clouds else shapes_in_the_way
                hit = look(around, q[line : line + 2], around.margin)
            if hit[1] is not None:
                self.hits.append(PathCollision(line, hit[0], hit[1]))


def _first_in_the_way(around: Surroundings, line: Array, margin: float) -> tuple[float, Collision | None]:
    """What the real shapes hit first on a straight line (2, 7), clouds too, and where."""
    forms = _forms_in_the_way(around, line, margin, 0.0, 0.0)
    if not len(around.tables.formless):
        return forms
    place, near = around.clouds().along(line[0], line[1], margin)
    return forms if near is None or (forms[1] is not None and forms[0] <= place) else (place, around.told(near))


def shapes_in_the_way(
    around: Surroundings, way: Array, margin: float, tolerance: float = 0.0, part: float = 0.0
) -> tuple[float, Collision | None]:
    """Where on the straight lines through postures (n, 7) the real shapes are closer than a margin, m, and which.

    With a tolerance, m, shapes also count that may come so near on a stretch on which none moves farther than that, or
    that is some part of the whole. Clouds count by the spheres of the arm.
    """
    formless = around.tables.formless
    if len(formless):
        found = around.along(way[:-1], way[1:], np.full(len(way) - 1, margin), formless)
        for line in np.flatnonzero(found[:, at.EDGE_PAIR] >= 0.0).tolist():
            return line + float(found[line, at.EDGE_AT]), around.collision_of(found[line], formless)
    return _forms_in_the_way(around, way, margin, tolerance, part)


def _forms_in_the_way(
    around: Surroundings, way: Array, margin: float, tolerance: float, part: float
) -> tuple[float, Collision | None]:
    pairs = around.watched(way, TOUCH)
    place, first, second, distance = around.real_world().along(way, margin + TOUCH, pairs, tolerance, part)
    if not first:
        return 0.0, None
    return place, Collision(first, second, max(around.margin - distance, 0.0))
