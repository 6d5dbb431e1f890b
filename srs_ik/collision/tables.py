"""Bodies, pairs and a scene as the flat tables that kernels read: made once, and copied where objects move."""

from __future__ import annotations

import copy
import threading
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from srs_ik.collision.links.bodies import Body, revolved
from srs_ik.collision.links.pairs import Pair
from srs_ik.collision.links.ranges import JointRange
from srs_ik.collision.scenes.scene import Scene
from srs_ik.collision.scenes.thing import ball_of
from srs_ik.errors import InvalidScene, quoted
from srs_ik.kernels.layout import collision as at
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.kinematics import ChainKinematics
    from srs_ik.robot.limb import SrsLimb

Integers = NDArray[np.int64]

PLACES = (at.BASE, at.BASE, at.UPPER, at.UPPER, at.FORE, at.FORE, at.TIP, at.TIP)
"""What moves the body of each joint, once joints 1, 3, 5 and 7 are taken to be anywhere where they are not known."""

_AXES = {1: 0, 2: 2, 5: 4, 6: 6}
"""Bodies that spin about the axis of a joint against what moves them, which is taken as a solid of revolution."""


class Tables:
    """What kernels know of an arm in a scene.

    Attributes:
        bodies: (rows, BODY_ROW).
        groups: (G, GROUP).
        pairs: (n, 2).
        formless: (m, 2) those with clouds.
        slack: (SLACK,) with a margin of zero.
        names: of each group.
        scene: as it stands in them.
    """

    def __init__(self, own: OwnTables, scene: Scene) -> None:
        self._scene, self._version, self._moves = scene, scene.version, scene.moves
        self.scene = copy.copy(scene)
        things = list(self.scene)
        replaced = frozenset().union(*(thing.replaces for thing in things))
        placed = [thing.placed() for thing in things]
        kinds = [kind for thing in things for kind in thing.kinds]
        sizes = [len(rows) for thing in things for rows in thing.rows]
        labels = [label for thing in things for label in thing.labels]
        for taken in sorted(set(labels) & set(own.names)):
            raise InvalidScene(f"{quoted(taken)} is a body of the arm: an object of the scene needs another name")
        self.names = own.names + labels
        g, n = len(own.names), len(kinds)
        rows = np.concatenate([own.rows, *(rows for _, rows in placed)])
        balls = np.concatenate([own.balls, *(balls for balls, _ in placed)])
        self.bodies = np.ascontiguousarray(np.concatenate([balls, rows]))
        ball_ends = g + np.cumsum([0, *(len(balls) for balls, _ in placed)])
        row_ends = g + n + len(own.rows) + np.cumsum([0, *(len(rows) for _, rows in placed)])
        self._slots = [
            (slice(*balls), slice(*rows))
            for balls, rows in zip(pairwise(ball_ends.tolist()), pairwise(row_ends.tolist()), strict=True)
        ]
        starts = g + n + np.cumsum([0, *own.sizes, *sizes])
        self.groups = np.zeros((g + n, at.GROUP), np.int64)
        self.groups[:, at.FIRST], self.groups[:, at.LAST] = starts[:-1], starts[1:]
        self.groups[:, at.PLACE] = own.places + [at.BASE] * n
        self.groups[:, at.KIND] = [at.SPHERES] * g + kinds
        kept = [(a, b) for a, b in own.pairs if not {own.names[a], own.names[b]} & replaced]
        moving = [k for k in range(g) if own.joints[k] > 0]
        self.pairs = np.array([*kept, *((a, b) for a in moving for b in range(g, g + n))], np.int64).reshape(-1, 2)
        bare = [not (thing.forms or thing.parts) for thing in things for _ in thing.kinds]
        self.formless = self.pairs[np.isin(self.pairs[:, 1], g + np.flatnonzero(bare))]
        self.slack = own.slack
        self.ranges = [r for r in own.ranges if not {own.names[r.first], own.names[r.second]} & replaced]
        self._local = threading.local()

    def of(self, scene: Scene) -> Tables | None:
        """The tables of a scene as it is now, these if nothing has moved; None where there are other objects.

        Those of a question that another thread is at stay as they are.
        """
        if self._scene is not scene or self._version != scene.version:
            return None
        moves = scene.moves
        if self._moves == moves:
            return self
        still = copy.copy(scene)
        if len(still) != len(self.scene):  # another thread is just adding one, or taking one away
            return None
        moved = copy.copy(self)
        moved.scene, moved._moves, moved.bodies = still, moves, self.bodies.copy()
        for before, thing, (balls, rows) in zip(self.scene, moved.scene, self._slots, strict=True):
            if thing is not before:
                moved.bodies[balls], moved.bodies[rows] = thing.placed()
        return moved

    def work(self) -> tuple[Array, Integers]:
        """Work space of this thread: rows as they are seen, and which are."""
        local = self._local
        if not hasattr(local, "rows"):
            local.rows = np.empty((len(self.bodies), at.LOCAL_ROW)), np.empty(len(self.groups), np.int64)
        rows: tuple[Array, Integers] = local.rows
        return rows

    def with_margin(self, margin: float) -> Array:
        """(SLACK,) for a margin, m."""
        slack = self.slack.copy()
        slack[at.MARGIN] = margin
        return slack


class OwnTables:
    """The part of the tables that is the arm's own."""

    def __init__(
        self,
        arm: ChainKinematics,
        limb: SrsLimb,
        bodies: Sequence[Body],
        pairs: Sequence[Pair],
        ranges: Sequence[JointRange],
    ) -> None:
        frames = arm.joint_frames(np.zeros(7))
        lines = (limb.axes, limb.points)
        rows = [_rows(arm, body, frames, lines) for body in bodies]
        self.names = [body.name for body in bodies]
        self.joints = [body.joint for body in bodies]
        self.places = [PLACES[body.joint] for body in bodies]
        self.sizes = [len(own) for own in rows]
        self.rows = np.concatenate(rows)
        self.balls = np.array([ball_of(own) for own in rows])
        index = {name: k for k, name in enumerate(self.names)}
        self.ranges = list(ranges)
        ranged = {frozenset((self.names[r.first], self.names[r.second])) for r in ranges}
        self.pairs = []
        for pair in pairs:
            a, b = index[pair.first], index[pair.second]
            if pair.kept and frozenset((pair.first, pair.second)) not in ranged:
                # What turns comes first.
                self.pairs.append((a, b) if self.places[a] >= self.places[b] else (b, a))
        self.slack = np.zeros(at.SLACK)
        self.slack[at.DRIFT] = _drift(limb)
        for place, column, centre in ((at.UPPER, at.REACH_UPPER, limb.shoulder), (at.FORE, at.REACH_FORE, limb.elbow)):
            of_place = [own for own, own_place in zip(rows, self.places, strict=True) if own_place == place]
            reaches = [np.linalg.norm(own[:, :3] - centre, axis=1).max() for own in of_place]
            self.slack[column] = max(reaches, default=0.0)


def _rows(arm: ChainKinematics, body: Body, frames: Array, lines: tuple[Array, Array]) -> Array:
    """(n, 4) spheres of a body in the base frame at zero; of one that spins, of all its turns."""
    if body.joint in _AXES:
        return revolved(arm, body, _AXES[body.joint], lines)
    T = frames[body.joint]
    return np.column_stack([body.spheres[:, :3] @ T[:3, :3].T + T[:3, 3], body.spheres[:, 3]])


def _drift(limb: SrsLimb) -> float:
    """How far links may be from those of the nearest exact limb at the same joint angles, m."""
    worst = float(limb.misses.max())
    return 0.0 if worst < _EXACT else 2.0 * float(limb.offsets.sum())


_EXACT = 1e-12
