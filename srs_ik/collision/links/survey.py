"""Bodies of an arm at many postures: which always touch, which never meet, and what a joint says of their distance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from heapq import heapify, heappop, heappush
from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.collision.forms import is_round
from srs_ik.collision.links import store
from srs_ik.collision.links.bodies import Body
from srs_ik.collision.links.ranges import BOXES, FINE, PART, Bounds, JointRange
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.collision.links.real import RealBodies
    from srs_ik.kinematics import ChainKinematics

POSTURES = 200
"""Random postures inside the limits, at which pairs are looked at."""

MANY = 2000
"""Random postures at which shapes must stay apart whose spheres always meet, to be left out."""

ALWAYS = 0.95
"""Bodies that touch at more than this share of them touch by design."""

_HAIR = 1e-3
"""Bodies no farther apart than this, m, count as touching: a joint's housing and what turns in it."""

_TWO = 2
"""Bodies with so many joints between them are told apart by one of these alone."""

_BETWEEN = 3
"""Whether bodies with no more joints than this between them can meet at all is tried to be proved ..."""

_TRIES = 4000
"""... in so many steps ..."""

_COARSE = 0.004
"""... down to where no point moves farther than this, m."""

_MOST_DOUBTFUL = 400

_CLOSE = 0.1
"""Where bodies stay apart, how far is found but for this part of it, ..."""

_AMPLE = 0.1
"""... as long as that is less than this, m, ..."""

_STEPS = 1000
"""... and in so many steps."""

_ENOUGH = 0.8
"""A range that keeps two bodies apart is worth more than their spheres where it is this share of the joint's own."""

_NEVER = 1e3
"""Stands for a distance without end, m."""

_APART = 1e-4
"""Bodies nearer than this, m, are not taken to be apart: coal's own tolerance is 1e-6."""


_Box = tuple[float, float, int, Array, Array]
"""A bound below a distance and the way of its farthest point, m; the joint that does most of that; lower, upper end."""


class Survey:
    """Bodies at random postures, and what that says of their pairs."""

    def __init__(self, arm: ChainKinematics, bodies: Sequence[Body]) -> None:
        self._arm, self._bodies = arm, bodies
        self._lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
        self._upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
        self._angles = np.random.default_rng(0).uniform(self._lower, self._upper, (POSTURES, 7))
        frames = arm.joint_frames(np.zeros(7))
        # As the root of the robot sees them: no base changes how its links meet.
        self._zero = np.linalg.inv(frames[0]) @ frames
        self._axes = arm.jacobian(np.zeros(7))[3:].T @ frames[0, :3, :3]
        self._hops = np.linalg.norm(np.diff(self._zero[:, :3, 3], axis=0), axis=1)
        self._sizes = [_size(body) for body in bodies]

    @cached_property
    def _real(self) -> RealBodies:
        # Where all that is asked has been kept on disk, nobody needs the shapes.
        from srs_ik.collision.links.real import RealBodies

        return RealBodies(self._bodies)

    def _frames(self, q: Array, i: int, j: int) -> dict[int, Any]:
        """Where the joints of two bodies are, as `RealBodies` has it."""
        joints = self._bodies[i].joint, self._bodies[j].joint
        places = self._arm.joint_places(q, joints)
        return {joint: self._real.at_place(T) for joint, T in zip(joints, places, strict=True)}

    def reason(self, i: int, j: int) -> str:
        """Why two bodies need not be watched; empty where they have to."""
        if self._always_touch(i, j):
            return f"touch at more than {ALWAYS:.0%} of postures"
        return ""

    def only_spheres_meet(self, i: int, j: int) -> bool:
        """Whether the spheres of two bodies next to each other meet at all postures, and their shapes at none of many.

        Watched by spheres, they would leave nothing free.
        """
        if self._bodies[j].joint - self._bodies[i].joint > _BETWEEN or not all(self._bodies[k].forms for k in (i, j)):
            return False
        if not all(self._spheres_meet(i, j, q) for q in self._angles):
            return False
        return self._told_once(self._key(i, j, f"apart {MANY}"), lambda: self._apart_at_many(i, j))

    def _apart_at_many(self, i: int, j: int) -> bool:
        angles = np.random.default_rng(1).uniform(self._lower, self._upper, (MANY, 7))
        return all(not self._touch(self._frames(q, i, j), i, j) for q in angles)

    @staticmethod
    def _told_once(key: str, find: Callable[[], bool]) -> bool:
        """A verdict that is kept on disk."""
        kept = store.load(key)
        if kept is None:
            kept = np.full((1, 4), float(find()))
            store.keep(key, kept)
        return bool(kept[0, 0])

    def _spheres_meet(self, i: int, j: int, q: Array) -> bool:
        frames = self._arm.joint_frames(q)
        centres = []
        for k in (i, j):
            T, rows = frames[self._bodies[k].joint], self._bodies[k].spheres
            centres.append(rows[:, :3] @ T[:3, :3].T + T[:3, 3])
        gaps = np.linalg.norm(centres[0][:, None] - centres[1][None], axis=2)
        return bool((gaps < self._bodies[i].spheres[:, None, 3] + self._bodies[j].spheres[None, :, 3]).any())

    def told_by_a_joint(self, i: int, j: int) -> JointRange | None:
        """How near two bodies come, told by one joint between them; None where it says little."""
        between = self._bodies[j].joint - self._bodies[i].joint
        if between == _TWO:
            return max((self.joint_range(i, j, which) for which in (0, 1)), key=_told)
        return self.where(i, j) if between <= _BETWEEN else None

    def joint_range(self, i: int, j: int, which: int) -> JointRange:
        """How near two bodies come that are two joints apart, told by the first or the second joint between them."""
        joints = [self._bodies[i].joint + (which + k) % _TWO for k in range(_TWO)]
        k, other = joints
        turn = float(self._lower[other]), float(min(self._upper[other], self._lower[other] + 2.0 * np.pi))
        reaches = self._reaches(i, j).tolist()
        key = self._key(i, j, f"range {which}")
        kept = store.load(key)
        if kept is None:
            q = 0.5 * (self._lower + self._upper)

            def distance(first: float, second: float) -> float:
                q[joints] = first, second
                frames = self._frames(q, i, j)
                hulls = self._real.hull_distance(frames, i, j)
                return hulls if hulls > _AMPLE else self._real.distance(frames, i, j)

            bounds = Bounds(distance, turn, (reaches[which], reaches[1 - which]))
            kept = np.clip(bounds.over(float(self._lower[k]), float(self._upper[k])), -_NEVER, _NEVER)
            store.keep(key, kept)
        edges = np.append(kept[:, 0], kept[-1, 1])
        return JointRange(i, j, k, edges, kept[:, 2].copy(), kept[:, 3].copy())

    def _reaches(self, i: int, j: int) -> Array:
        """How far a turn of each joint between two bodies moves a point of the one against the other, at most."""
        first, last = self._bodies[i].joint, self._bodies[j].joint
        reach = np.array([self._hops[k:last].sum() + self._sizes[j] for k in range(first + 1, last + 1)])
        # The first of these joints may as well turn the first body, and the last one turns the second about its axis.
        reach[0] = min(reach[0], self._from_axis(i, first))
        reach[-1] = min(reach[-1], self._from_axis(j, last - 1))
        return reach

    def _from_axis(self, i: int, k: int) -> float:
        """Largest distance of a point of a body from the axis of joint k, 0 to 6, at one end, m; 0 where round."""
        rows, zero = self._bodies[i].spheres, self._zero[self._bodies[i].joint]
        centres = rows[:, :3] @ zero[:3, :3].T + zero[:3, 3]
        origin = self._zero[k + 1, :3, 3]
        forms = self._bodies[i].forms
        if forms and is_round([form.moved(zero) for form in forms], origin, self._axes[k]):
            return 0.0
        across = np.cross(centres - origin, self._axes[k])
        return float((np.linalg.norm(across, axis=1) + rows[:, 3]).max())

    def _always_touch(self, i: int, j: int) -> bool:
        key = self._key(i, j, f"touch {POSTURES} {ALWAYS} {_HAIR}")
        return self._told_once(key, lambda: self._touch_at_random(i, j))

    def _touch_at_random(self, i: int, j: int) -> bool:
        free = 0
        for q in self._angles:
            free += not self._touch(self._frames(q, i, j), i, j)
            if free >= (1.0 - ALWAYS) * POSTURES:
                return False
        return True

    def _touch(self, frames: dict[int, Any], i: int, j: int) -> bool:
        """Whether two bodies touch, or are a hair apart."""
        if self._real.hull_distance(frames, i, j) > _HAIR:
            return False
        return self._real.meet(frames, i, j) or self._real.distance(frames, i, j) <= _HAIR

    def where(self, i: int, j: int) -> JointRange | None:
        """A range of one joint in which two bodies are proved not to meet; None where it leaves too little.

        Its bounds are minus infinity where that is not proved.
        """
        first, last = self._bodies[i].joint, self._bodies[j].joint
        key = self._key(i, j, "where")
        kept = store.load(key)
        if kept is None:
            kept = np.full((BOXES + 1, 4), -np.inf)
            boxes = self._proved(i, j)
            best = 0.0
            for k in range(first, last) if boxes is not None else ():
                edges = np.linspace(self._lower[k], self._upper[k], BOXES + 1)
                bounds = np.full(BOXES, np.inf)
                for bound, lower, upper in boxes or []:
                    touched = (edges[:-1] <= upper[k - first]) & (edges[1:] >= lower[k - first])
                    bounds[touched] = np.minimum(bounds[touched], bound if bound > 0.0 else -np.inf)
                found = JointRange(i, j, k, edges, bounds, bounds)
                if _told(found) > best:
                    best = _told(found)
                    kept[:, 0], kept[:-1, 1], kept[:, 2], kept[:, 3] = edges, bounds, k, found.share()
            kept = np.clip(kept, -_NEVER, _NEVER)
            store.keep(key, kept)
        if kept[0, 3] < _ENOUGH:
            return None
        tops = np.full(len(kept) - 1, _NEVER)
        return JointRange(i, j, int(kept[0, 2]), kept[:, 0].copy(), kept[:-1, 1].copy(), tops)

    def _proved(self, i: int, j: int) -> list[tuple[float, Array, Array]] | None:
        """Boxes of the joint angles between two bodies, each with a bound below their distance, m.

        Not positive where they may meet; None where these boxes are too many.
        """
        first, last = self._bodies[i].joint, self._bodies[j].joint
        reach = self._reaches(i, j)
        joints = slice(first, last)
        q = 0.5 * (self._lower + self._upper)
        tries = 0

        def looked_at(lower: Array, upper: Array, below: float) -> _Box:
            nonlocal tries
            tries += 1
            q[joints] = 0.5 * (lower + upper)
            moves = 0.5 * (upper - lower) * reach
            frames = self._frames(q, i, j)
            distance = self._real.hull_distance(frames, i, j)
            if distance <= _AMPLE + moves.sum():
                distance = self._real.distance(frames, i, j)
            return max(distance - moves.sum() - _APART, below), float(moves.sum()), int(moves.argmax()), lower, upper

        def halves(box: _Box) -> list[_Box]:
            bound, _, widest, lower, upper = box
            middle = 0.5 * (lower[widest] + upper[widest])
            below, above = upper.copy(), lower.copy()
            below[widest], above[widest] = middle, middle
            return [looked_at(lower, below, bound), looked_at(above, upper, bound)]

        # First, whether they meet; then, how far apart they are where that is least certain.
        waiting = [looked_at(self._lower[joints], self._upper[joints], -np.inf)]
        doubtful, apart = [], []
        while waiting:
            box = waiting.pop()
            if box[0] > 0.0:
                apart.append(box)
            elif box[1] < _COARSE:
                doubtful.append(box)
            else:
                waiting += halves(box)
            if tries > _TRIES or len(doubtful) > _MOST_DOUBTFUL:
                return None
        heap = [(box[0], k, box) for k, box in enumerate(apart)]
        heapify(heap)
        for k in range(len(heap), len(heap) + _STEPS):
            if not heap or heap[0][0] >= _AMPLE or heap[0][2][1] <= _CLOSE * heap[0][0]:
                break
            for part, box in enumerate(halves(heappop(heap)[2])):
                heappush(heap, (box[0], 2 * k + part, box))
        return [(bound, lower, upper) for bound, _, _, lower, upper in (*doubtful, *(entry[2] for entry in heap))]

    def _key(self, i: int, j: int, what: str) -> str:
        """Of a question about two bodies; the same on any base."""
        bodies = self._bodies[i], self._bodies[j]
        figures = [figure for body in bodies for figure in (body.spheres, *(form.T for form in body.forms))]
        what += f" {BOXES} {FINE} {PART} {_CLOSE} {_AMPLE} {_STEPS}"
        return store.key_of(what, self._lower, self._upper, self._zero, *figures)


def _told(found: JointRange) -> float:
    """What is more for a joint that says more of a distance: the share of it that it allows, then how far apart."""
    return found.share() + 1e-3 * float(np.clip(found.bounds, 0.0, _AMPLE).mean())


def _size(body: Body) -> float:
    """Largest distance of a point of a body from the origin of its joint, m."""
    return float((np.linalg.norm(body.spheres[:, :3], axis=1) + body.spheres[:, 3]).max())
