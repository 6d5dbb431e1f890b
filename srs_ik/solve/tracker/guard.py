"""What keeps a tracker from driving into a scene: no step after which the joints could not stop in time."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from srs_ik.collision.reaches import TOUCH
from srs_ik.collision.scenes.figures import as_margin
from srs_ik.kernels.layout import collision as at
from srs_ik.solve.in_scene import freedom as free_solver
from srs_ik.solve.in_scene import pose as pose_solver
from srs_ik.solve.in_scene.edges import shapes_in_the_way
from srs_ik.solve.in_scene.surroundings import Surroundings
from srs_ik.solve.solution import Collision, Solution
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.collision.owner import BodyOwner
    from srs_ik.collision.scenes.scene import Scene
    from srs_ik.inputs.freedom import FreeAxis
    from srs_ik.solve.packed import PackedArm

TOLERANCE = 2e-4
"""A way is not looked at in stretches on which bodies move less than this, m: the arm stops so far before it must."""

PART = 0.125
"""Nor in stretches shorter than this part of it while joints move, so that it takes no longer the faster they are."""

LEFT = 2.0 * TOUCH
"""What ways are to leave more than the margin, m, so that where they end is told from a contact."""

CONTACT = TOLERANCE + 2.0 * LEFT
"""Within this of the margin, m, an arm may be that is not allowed to move in stretches so long, and comes away."""


class Verdict(NamedTuple):
    """What a guard says of a step."""

    allowed: bool
    """Whether it may be taken."""
    collision: Collision | None
    """Who would meet, with a depth of zero, or is too close already, with how much; None for nobody."""


FREE = Verdict(True, None)


class Room(NamedTuple):
    """The two bodies that are closest at a posture, and how much more than the margin is between them, m."""

    first: str
    second: str
    left: float


class Guard:
    """Looks at ways of joints to rest: by the spheres of all bodies, and where these meet, by the real shapes.

    Attributes:
        scene: what stands around the arm, where it is now.
        margin: what is to be left between two bodies, m, with the scene's own.

    Raises:
        InvalidScene: no `Scene`, or no margin.
        NoBodies: no shapes of the arm are at hand.
    """

    def __init__(self, owner: BodyOwner, packed: PackedArm, scene: Scene, margin: Any) -> None:
        self._owner, self._packed = owner, packed
        self.scene, self.margin = scene, as_margin(margin)
        self._known = Surroundings(owner, packed, scene, self.margin)
        self._as_of = self._now()
        # What takes a moment once: the real shapes.
        self._known.real_world()

    def _now(self) -> tuple[int, int, float]:
        return self.scene.version, self.scene.moves, self.scene.margin

    @property
    def around(self) -> Surroundings:
        """The arm in the scene as it is now."""
        now = self._now()
        if self._as_of != now:
            self._known, self._as_of = Surroundings(self._owner, self._packed, self.scene, self.margin), now
        return self._known

    def look(self, way: Array, braked: Callable[[], Array]) -> Verdict:
        """Whether a step may be taken.

        It may where its whole way to rest is free. An arm that is too close to something, since it began so or an
        object was moved, may go where it comes away from that, and on the way no closer than it is.

        Args:
            way: (n, 7) postures from the present one by the end of the step to rest, n at least 2.
            braked: tells (m, 7) the same if the joints brake now; they can always.
        """
        around = self.around
        if _is_clear(around, way):
            return FREE
        stop = braked()
        hit = shapes_in_the_way(around, way, around.margin + LEFT, TOLERANCE, PART if len(stop) > 1 else 0.0)[1]
        if hit is None:
            return FREE
        here = _room(around, stop[0])
        rest = here if len(stop) == 1 else _room(around, stop[-1])
        least = min(here.left, rest.left)
        if least > CONTACT:
            return Verdict(False, hit._replace(depth=0.0))
        nearest = rest if rest.left <= CONTACT else here
        said = Collision(nearest.first, nearest.second, max(-nearest.left, 0.0))
        leaves = _room(around, way[-1]).left > rest.left
        return Verdict(leaves and shapes_in_the_way(around, way, around.margin + least - LEFT)[1] is None, said)

    def nearest(self, T: Array, q: Array, free_axis: FreeAxis | None) -> Solution:
        """The free posture of a pose that is nearest to another, or why there is none."""
        if free_axis is None:
            return pose_solver.solve(self.around, T, None, q, -1, True)
        return free_solver.solve(self.around, T, free_axis, q, True)


def _is_clear(around: Surroundings, way: Array) -> bool:
    """Whether nothing is in the way on the straight lines through postures, by the spheres and the ranges of joints."""
    lines = around.along(way[:-1], way[1:], np.full(len(way) - 1, around.margin))
    return bool((lines[:, at.EDGE_PAIR] < 0.0).all()) and around.keeps_range(way)


def _room(around: Surroundings, q: Array) -> Room:
    """Who is closest to whom at a posture, of all that are closer than about the margin; endless room if nobody is."""
    enough = around.margin + 2.0 * CONTACT
    near = around.real_world().nearest(q, enough, around.watched(q, 2.0 * CONTACT))
    rooms = [] if near is None else [Room(near[0], near[1], near[2] - around.margin)]
    formless = around.tables.formless
    if len(formless):
        edge = around.along(q[None], q[None], np.array([enough]), formless)[0]
        if edge[at.EDGE_PAIR] >= 0.0:
            first, second = (around.tables.names[k] for k in formless[int(edge[at.EDGE_PAIR])])
            rooms.append(Room(first, second, float(edge[at.EDGE_CLEARANCE]) - around.margin))
    return min(rooms, key=lambda room: room.left, default=Room("", "", np.inf))
