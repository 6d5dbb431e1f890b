"""How near bodies of the arm are to clouds of points, at a posture and on lines of joint angles, by real shapes.

Kernels take links 1, 2, 5 and 6 as solids of revolution against clouds; here they are where the posture has them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from srs_ik.collision.forms import Form
from srs_ik.collision.parts import Part, apart, transform
from srs_ik.collision.real_world import SHORTEST
from srs_ik.kernels.layout import collision as at
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.collision.real_world import RealWorld
    from srs_ik.collision.tables import Tables

Near = tuple[str, str, float]
"""A body of the arm, a cloud, and how near they are, m."""


class Clouds:
    """The clouds around an arm."""

    def __init__(self, world: RealWorld, tables: Tables) -> None:
        self._world, self._tables = world, tables
        pairs = tables.formless
        self._cells = {body: pairs[pairs[:, 0] == body, 1] for body in np.unique(pairs[:, 0]).tolist()}
        self._balls: dict[float, Part] = {}

    def nearest(self, q: Array, margin: float, turns: Array | None = None) -> Near | None:
        """Of those no farther apart than a margin, and what joints move the body that turn so far, the two nearest."""
        best: Near | None = None
        for body, cells in self._cells.items():
            moved = 0.0 if turns is None else self._world.swept(q, body, turns)
            enough = margin + moved if best is None else min(margin + moved, best[2])
            near = self._nearest(q, body, cells, enough)
            if near is not None:
                best = self._tables.names[body], self._tables.names[near[0]], near[1]
        return best

    def along(self, start: Array, end: Array, margin: float) -> tuple[float, Near | None]:
        """Where on a straight line of joint angles bodies come within a margin first, 0 to 1, and who; None if clear.

        What cannot be told on the shortest stretch counts.
        """
        waiting = [(0.0, 1.0)]
        while waiting:
            lower, upper = waiting.pop()
            middle = 0.5 * (lower + upper)
            turns = 0.5 * (upper - lower) * np.abs(end - start)
            near = self.nearest(start + middle * (end - start), margin, turns)
            if near is None:
                continue
            if near[2] <= margin or upper - lower < 2.0 * SHORTEST:
                return middle, near
            waiting += [(middle, upper), (lower, middle)]
        return 0.0, None

    def _nearest(self, q: Array, body: int, cells: NDArray[np.int64], enough: float) -> tuple[int, float] | None:
        """The cell with the point that a body is nearest to, no farther than that, and how near, m."""
        world, tables = self._world, self._tables
        (T,) = world.places(q, [body])
        cells = cells[self._least(body, T, tables.bodies[cells]) <= enough]
        if not len(cells):
            return None
        ends = tables.groups[cells][:, [at.FIRST, at.LAST]]
        spheres = tables.bodies[np.concatenate([np.arange(*pair) for pair in ends])]
        owners = np.repeat(cells, ends[:, 1] - ends[:, 0])
        bounds = self._least(body, T, spheres)
        own = transform(T)
        found = None
        for k in np.argsort(bounds, kind="stable").tolist():
            if bounds[k] > enough:
                break
            place = np.eye(4)
            place[:3, 3] = spheres[k, :3]
            ball, there = self._ball(float(spheres[k, 3])), transform(place)
            distance = min(apart(part, own * part.at, ball, there) for part in world.parts[body])
            if distance <= enough:
                found, enough = (int(owners[k]), distance), distance
        return found

    def _least(self, body: int, T: Array, spheres: Array) -> Array:
        """(n,) no sphere is nearer to a body, m: that is within its cover, and all of it within a ball."""
        cover, ball = self._world.cover(body), self._world.ball(body)
        points = (spheres[:, :3] - T[:3, 3]) @ T[:3, :3]
        whole = np.linalg.norm(points - ball[:3], axis=1) - ball[3]
        apart = (np.linalg.norm(points[:, None] - cover[:, :3], axis=2) - cover[:, 3]).min(axis=1)
        # Of a point in the cover, the spheres do not tell how deep it is in all of them together.
        least: Array = np.where(apart > 0.0, np.maximum(apart, whole), whole) - spheres[:, 3]
        return least

    def _ball(self, radius: float) -> Part:
        if radius not in self._balls:
            self._balls[radius] = Part(Form("sphere", (radius,), np.eye(4)))
        return self._balls[radius]
