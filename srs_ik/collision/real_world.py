"""The real forms of an arm and of what stands around it, for coal: which pairs are watched, and how far they move."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from srs_ik.collision.forms import is_round
from srs_ik.collision.links.real import real_forms
from srs_ik.collision.parts import apart, parts_of, transform
from srs_ik.collision.solids import Carried, Solids
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.collision.links.bodies import Body
    from srs_ik.collision.links.ranges import JointRange
    from srs_ik.collision.owner import BodyOwner
    from srs_ik.collision.parts import Part
    from srs_ik.collision.scenes.scene import Scene
    from srs_ik.collision.tables import Tables

TURNING = (2, 3, 4, 5)
"""Joints whose bodies turn with the arm angle."""

SPINNING = {1: 0, 2: 2, 5: 4, 6: 6}
"""Joint axis that a body spins about against what moves it: against the base, the upper arm, the forearm, the hand."""

_STILL = np.eye(4)

OBJECT = -1
"""Stands for the joint of what is no body of the arm."""


class RealWorld:
    """Bodies of an arm and objects with forms around it, and the pairs of them that are watched.

    Attributes:
        names: of each body.
        joints: that carry them, 0 for the root, `OBJECT` for objects.
        parts: their forms, in the frames of these joints.
        pairs: numbers of two bodies each.
        axes: (7, 3) each joint axis in the frame of its joint.
        before: largest distance of a point of each body of the arm from the axis of the joint that carries it, m; 0
            where it is round about that axis.
        behind: the same from the axis of the next joint, which it carries.
        solids: the same bodies as the convex solids that kernels read.
        radius: the same from the centre of the shoulder (of the wrist from the forearm on).
    """

    def __init__(self, arm: BodyOwner, scene: Scene, ranges: Sequence[JointRange]) -> None:
        self.scene = scene
        self._frames, self._places = arm.joint_frames, arm.joint_places
        bodies = arm.bodies
        index = {body.name: k for k, body in enumerate(bodies)}
        replaced = frozenset().union(*(thing.replaces for thing in scene))
        zero = arm.joint_frames(np.zeros(7))
        limb = arm.limb
        self.axes = np.array([zero[k + 1, :3, :3].T @ limb.axes[k] for k in range(7)])
        self.joints = [body.joint for body in bodies]
        self.parts = [_own_parts(arm, body) for body in bodies]
        self.names = [body.name for body in bodies]
        self._covers = [body.spheres for body in bodies]
        self._points = [np.concatenate([part.points for part in parts]) for parts in self.parts]
        placed = [
            points @ zero[j, :3, :3].T + zero[j, :3, 3] for points, j in zip(self._points, self.joints, strict=True)
        ]
        # Distances that no posture changes: from the axes of the joints before and behind, and from the centre on the
        # line shoulder-wrist.
        own = list(zip(placed, self.joints, strict=True))

        def reach(k: int, joint: int) -> float:
            line = limb.points[joint], limb.axes[joint]
            forms = [part.form.moved(zero[self.joints[k]]) for part in self.parts[k]]
            return 0.0 if is_round(forms, *line) else from_line(placed[k], *line)

        self.before = [reach(k, j - 1) for k, j in enumerate(self.joints)]
        self.behind = [reach(k, j % 7) for k, j in enumerate(self.joints)]
        centre = dict.fromkeys((0, 1, 2, 3), limb.shoulder) | dict.fromkeys((4, 5, 6, 7), limb.wrist)
        self.radius = [float(np.linalg.norm(points - centre[j], axis=1).max()) for points, j in own]
        self._turn = [radius if j in (2, 5) else None for radius, j in zip(self.radius, self.joints, strict=True)]
        self.pairs = [
            (index[p.first], index[p.second]) for p in arm.pairs if p.kept and not {p.first, p.second} & replaced
        ]
        self._ranges = ranges
        self._add_objects(scene, [k for k, body in enumerate(bodies) if body.joint > 0])
        around = [_ball(points) for points in self._points]
        around += [_ball_around([part.ball for part in parts]) for parts in self.parts[len(around) :]]
        self._balls = np.array(around)
        self._rows: tuple[Tables | None, list[tuple[int, int] | None]] = None, []
        spins = [self.spin(k) if joint in SPINNING else 0.0 for k, joint in enumerate(self.joints)]
        reaches = list(zip(self.before, self.behind, self.radius, strict=True))
        self.solids = Solids(Carried(self.joints, self.parts, spins, reaches), zero, limb)
        self._couples: tuple[Any, Any] = None, None

    def _add_objects(self, scene: Scene, moving: list[int]) -> None:
        """Objects that have forms, each watched for those bodies of the arm that move."""
        for thing in scene:
            for label, forms in thing.parts or ([(thing.name, thing.forms)] if thing.forms else []):
                self.pairs += [(k, len(self.joints)) for k in moving]
                self.joints.append(OBJECT)
                self.names.append(label)
                self.parts.append(parts_of([form.moved(thing.T) for form in forms]))
                self._turn.append(None)

    def ranged(self, margin: float) -> list[tuple[int, int]]:
        """Those pairs that ranges of joints watch which may come within a margin, m."""
        return [(r.first, r.second) for r in self._ranges if r.bounds.min() <= margin]

    def watched(self, margin: float) -> list[tuple[int, int]]:
        """Pairs of bodies that may come within a margin, m: some of those that never meet, too."""
        return [*self.pairs, *(pair for pair in self.ranged(margin) if pair not in self.pairs)]

    def couples(self, tables: Tables, margin: float) -> tuple[NDArray[np.int64], list[tuple[int, int]]]:
        """The pairs of bodies that may come within a margin, m: see `Solids.couples`; found once for a margin."""
        key = tables, margin
        # Read once: another thread may put those of another margin there.
        known, found = self._couples
        if known != key:
            found = self.solids.couples(self.pairs_of(tables), self.watched(margin))
            self._couples = key, found
        couples: tuple[NDArray[np.int64], list[tuple[int, int]]] = found
        return couples

    def pairs_of(self, tables: Tables) -> list[tuple[int, int] | None]:
        """The pair of bodies that each row of pairs stands for; None for those without forms."""
        known_tables, rows = self._rows
        if known_tables is not tables:
            count = sum(joint != OBJECT for joint in self.joints)
            numbers: dict[str, int] = {name: k for k, name in enumerate(self.names) if k >= count}
            of_group = [k if k < count else numbers.get(name, OBJECT) for k, name in enumerate(tables.names)]
            known = {frozenset(pair): pair for pair in self.pairs}
            rows = [known.get(frozenset((of_group[a], of_group[b]))) for a, b in tables.pairs.tolist()]
            self._rows = tables, rows
        return rows

    def places(self, q: Array, bodies: Sequence[int]) -> list[Array]:
        """(4, 4) where some bodies are at a posture."""
        moved = self._places(q, [self.joints[k] for k in bodies if self.joints[k] != OBJECT])
        return [_STILL if self.joints[k] == OBJECT else moved.pop(0).homogeneous for k in bodies]

    def turn(self, k: int, T: Array, line: tuple[Array, Array]) -> float:
        """Largest distance of a point of a body from the line shoulder-wrist, m; 0 if it turns not; T is its place."""
        if self.joints[k] not in TURNING:
            return 0.0
        known = self._turn[k]
        return known if known is not None else from_line(self._points[k] @ T[:3, :3].T + T[:3, 3], *line)

    def spin(self, k: int) -> float:
        """Largest distance of a point of a body from the axis that it spins about, m."""
        axis = SPINNING[self.joints[k]]
        return self.before[k] if axis == self.joints[k] - 1 else self.behind[k]

    def nearest(self, q: Array, margin: float, pairs: Sequence[tuple[int, int]]) -> tuple[str, str, float] | None:
        """Of some pairs the two that are nearest, no farther than a margin, at a posture, and how near, m."""
        apart = self.rooms(self._frames(q), pairs, np.full(len(pairs), margin))
        k = int(np.argmin(apart)) if len(pairs) else -1
        if k < 0 or apart[k] > margin:
            return None
        return self.names[pairs[k][0]], self.names[pairs[k][1]], float(apart[k])

    def _placed(self, frames: Array) -> tuple[list[Array], Array]:
        """Where bodies are, and (n, 3) the centres of the balls around them, by the frames of the joints."""
        places = [frames[joint] if joint >= 0 else _STILL for joint in self.joints]
        stacked = np.array(places)
        return places, np.einsum("nij,nj->ni", stacked[:, :3, :3], self._balls[:, :3]) + stacked[:, :3, 3]

    def cover(self, k: int) -> Array:
        """(n, 4) spheres that cover a body of the arm, in the frame of the joint that carries it."""
        return self._covers[k]

    def ball(self, k: int) -> Array:
        """(4,) a sphere around a body, in the frame of the joint that carries it."""
        ball: Array = self._balls[k]
        return ball

    def rooms(self, frames: Array, pairs: Sequence[tuple[int, int]], enough: Array) -> Array:
        """(n,) how far each of some pairs is apart, or a bound below it that is more than enough (n,), m."""
        places, centres = self._placed(frames)
        first, second = np.array(pairs, np.int64).reshape(-1, 2).T
        found = np.linalg.norm(centres[first] - centres[second], axis=1)
        found -= self._balls[first, 3] + self._balls[second, 3]
        close = np.flatnonzero(found <= enough)
        at = {k: transform(places[k]) for k in {*first[close].tolist(), *second[close].tolist()}}
        for k in close.tolist():
            found[k] = self._distance(at, *pairs[k])
        return found

    def along(
        self, way: Array, margin: float, pairs: Sequence[tuple[int, int]], tolerance: float = 0.0, part: float = 0.0
    ) -> tuple[float, str, str, float]:
        """What of some pairs comes within a margin on straight lines of joints: where, which, how near, m.

        The lines lead through postures (n, 7), and line k is passed from k to k + 1. No names where they are certainly
        clear. What cannot be told on the shortest stretch counts, or on one on which no body moves farther than a
        tolerance, m, or that is no longer than some part of the whole.
        """
        waiting = [(0.0, len(way) - 1.0)]
        while waiting:
            lower, upper = waiting.pop()
            least, most = _box(way, lower, upper)
            doubtful = self._doubtful(self._frames(0.5 * (least + most)), 0.5 * (most - least), margin, pairs)
            if doubtful is None:
                continue
            a, b, distance, moved = doubtful
            middle = 0.5 * (lower + upper)
            if moved <= tolerance or upper - lower <= part * (len(way) - 1):
                return middle, self.names[a], self.names[b], distance
            if upper - lower > 1.0:
                # The middle of several lines need not be on them; a stretch ends where a line does.
                middle = float(round(middle))
            elif distance <= margin or upper - lower < 2.0 * SHORTEST:
                return middle, self.names[a], self.names[b], distance
            waiting += [(middle, upper), (lower, middle)]
        return 0.0, "", "", math.inf

    def _doubtful(
        self, frames: Array, turns: Array, margin: float, pairs: Sequence[tuple[int, int]]
    ) -> tuple[int, int, float, float] | None:
        """The nearest pair that may come within a margin while joints turn so far from a posture; None for none.

        With how near it is, and how far the joints between the two move the outer one at most, m.
        """
        places, centres = self._placed(frames)
        first, second = np.array(pairs, np.int64).reshape(-1, 2).T
        moved = self._moved(first, second, frames, centres, turns)
        room = np.linalg.norm(centres[first] - centres[second], axis=1) - self._balls[first, 3] - self._balls[second, 3]
        at: dict[int, Any] = {}
        worst = None
        for k in np.flatnonzero(room <= margin + moved).tolist():
            pair = pairs[k]
            for body in pair:
                if body not in at:
                    at[body] = transform(places[body])
            distance = self._distance(at, *pair)
            if distance <= margin + moved[k] and (worst is None or distance < worst[2]):
                worst = *pair, distance, float(moved[k])
        return worst

    def _moved(
        self, first: NDArray[np.int64], second: NDArray[np.int64], frames: Array, centres: Array, turns: Array
    ) -> Array:
        """(n,) how far the joints between two bodies move the outer one at most, m."""
        joints = np.array(self.joints)
        swapped = joints[first] > joints[second]
        inner, outer = np.where(swapped, second, first), np.where(swapped, first, second)
        begin, end = np.maximum(joints[inner], 0), joints[outer]
        return self._moved_by(begin, end, outer, frames, centres, turns)

    def swept(self, q: Array, k: int, turns: Array) -> float:
        """How far a body is moved at most, m, while joints turn so far (7,) from a posture."""
        frames = self._frames(q)
        body = np.array([k])
        _, centres = self._placed(frames)
        return float(self._moved_by(np.zeros(1), np.array([self.joints[k]]), body, frames, centres, turns)[0])

    def _moved_by(
        self, begin: Array, end: Array, outer: NDArray[np.int64], frames: Array, centres: Array, turns: Array
    ) -> Array:
        """(n,) how far the joints after `begin` up to `end` move bodies at most, m."""
        reach = np.linalg.norm(centres[outer, None] - frames[None, 1:, :3, 3], axis=2) + self._balls[outer, 3, None]
        total = np.zeros(len(outer))
        for joint in range(7, 0, -1):
            total += ((begin < joint) & (joint <= end)) * turns[joint - 1] * (reach[:, joint - 1] + total)
        return total

    def _distance(self, at: dict[int, Any], a: int, b: int) -> float:
        return min(
            apart(one, at[a] * one.at, other, at[b] * other.at) for one in self.parts[a] for other in self.parts[b]
        )


SHORTEST = 1e-3
"""Shortest half of a stretch that is looked at, as a part of the line."""


def _box(way: Array, lower: float, upper: float) -> tuple[Array, Array]:
    """Least and largest joint angles on a stretch of the lines through postures (n, 7)."""
    first = min(int(lower), len(way) - 2)
    last = max(math.ceil(upper), first + 1)
    ends = [
        way[first] + (lower - first) * (way[first + 1] - way[first]),
        way[last - 1] + (upper - last + 1) * (way[last] - way[last - 1]),
    ]
    on = np.concatenate([ends, way[first + 1 : last]])
    return on.min(axis=0), on.max(axis=0)


def _own_parts(arm: BodyOwner, body: Body) -> list[Part]:
    """The parts of a body, made once for an arm."""
    known: dict[int, list[Part]] = arm.__dict__.setdefault("_parts", {})
    if id(body) not in known:
        known[id(body)] = parts_of(real_forms(body))
    return known[id(body)]


def from_line(points: Array, point: Array, direction: Array) -> float:
    """Largest distance of points (n, 3) from a line, given by a point and a unit vector, m."""
    return float(np.linalg.norm(np.cross(points - point, direction), axis=1).max())


def _ball(points: Array) -> Array:
    """(4,) a sphere around points (n, 3)."""
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    return np.array([*centre, float(np.linalg.norm(points - centre, axis=1).max())])


def _ball_around(balls: Sequence[Array]) -> Array:
    """(4,) a sphere around spheres."""
    centre = np.mean([ball[:3] for ball in balls], axis=0)
    return np.array([*centre, max(float(np.linalg.norm(ball[:3] - centre) + ball[3]) for ball in balls)])
