"""How far what is drawn reaches, so that a camera can be put where all of it is seen."""

from __future__ import annotations

import itertools
from collections.abc import Iterable

import numpy as np

from srs_ik.preview.solids import Solid
from srs_ik.system.arrays import Array


class Extent:
    """The corners of all that is drawn, under the names it is drawn under; `a/b` moves with `a`."""

    def __init__(self) -> None:
        self._corners: dict[str, Array] = {}
        self._places: dict[str, Array] = {}

    def draw(self, name: str, solids: Iterable[Solid]) -> None:
        """Take note of what is drawn under a name, in place of what was there."""
        self.erase(name)
        boxes = [solid.mesh.bounds for solid in solids]
        if boxes:
            lower, upper = np.min(boxes, axis=0)[0], np.max(boxes, axis=0)[1]
            self._corners[name] = np.array([*itertools.product(*zip(lower, upper, strict=True))])

    def place(self, name: str, T: Array) -> None:
        """Take note of where a name is moved."""
        self._places[name] = T

    def erase(self, name: str) -> None:
        """Forget a name and all below it."""
        for kept in (self._corners, self._places):
            for other in [other for other in kept if f"{other}/".startswith(f"{name}/")]:
                del kept[other]

    def sphere(self) -> tuple[Array, float]:
        """Centre and radius of a ball about everything, metres; a point in the origin where nothing is drawn."""
        points = np.concatenate([np.zeros((1, 3)), *(self._placed(*item) for item in self._corners.items())])
        centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
        return centre, float(np.linalg.norm(points - centre, axis=1).max())

    def _placed(self, name: str, points: Array) -> Array:
        parts = name.split("/")
        for k in range(len(parts), 0, -1):
            T = self._places.get("/".join(parts[:k]))
            if T is not None:
                points = points @ T[:3, :3].T + T[:3, 3]
        return points
