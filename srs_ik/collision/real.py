"""The real forms, for coal: collision geometries, and the bodies of an arm as it carries them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import coal
import numpy as np
from numpy.typing import NDArray

from srs_ik.collision.forms import Form, ball_around, surface

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from srs_ik.collision.bodies import Body
    from srs_ik.collision.owner import BodyOwner
    from srs_ik.collision.scene import Scene

Array = NDArray[np.float64]


def geometry(form: Form) -> tuple[Any, Any]:
    """A form as coal's geometry, and its place as coal's transform."""
    if form.kind == "box":
        shape: Any = coal.Box(*form.size)
    elif form.kind == "cylinder":
        shape = coal.Cylinder(*form.size)
    elif form.kind == "sphere":
        shape = coal.Sphere(*form.size)
    elif form.kind == "capsule":
        shape = coal.Capsule(*form.size)
    else:
        assert form.vertices is not None
        assert form.faces is not None
        shape = mesh(form.vertices, form.faces)
    return shape, transform(form.T)


def mesh(vertices: Array, faces: NDArray[np.int64]) -> Any:
    """Triangles, in a hierarchy of boxes."""
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(faces), len(vertices))
    points = coal.StdVec_Vec3s()
    points.extend([np.ascontiguousarray(v, dtype=float) for v in vertices])
    triangles = coal.StdVec_Triangle()
    triangles.extend([coal.Triangle(int(a), int(b), int(c)) for a, b, c in faces])
    model.addSubModel(points, triangles)
    model.endModel()
    return model


def hull(forms: Iterable[Form]) -> Any:
    """The convex hull of some forms."""
    points = np.concatenate([surface(form)[0] for form in forms])
    corners = coal.StdVec_Vec3s()
    corners.extend(list(points))
    return coal.Convex.convexHull(corners, False, "")


def transform(T: Array) -> Any:
    """A (4, 4) pose as coal's transform."""
    return coal.Transform3s(np.ascontiguousarray(T[:3, :3]), np.ascontiguousarray(T[:3, 3]))


class RealBodies:
    """Bodies of an arm, each as its forms and as the convex hull of these, to be placed by the frames of joints."""

    def __init__(self, bodies: Sequence[Body]) -> None:
        self._joints = [body.joint for body in bodies]
        self._forms = [[geometry(form) for form in _forms(body)] for body in bodies]
        self._hulls = [hull(_forms(body)) for body in bodies]
        self._request = coal.DistanceRequest()
        self._collide = coal.CollisionRequest()

    def hull_distance(self, frames: Sequence[Any], a: int, b: int) -> float:
        """Distance of the hulls of two bodies, m; not positive where they meet."""
        result = coal.DistanceResult()
        T_a, T_b = frames[self._joints[a]], frames[self._joints[b]]
        return float(coal.distance(self._hulls[a], T_a, self._hulls[b], T_b, self._request, result))

    def distance(self, frames: Sequence[Any], a: int, b: int) -> float:
        """Distance of two bodies, m; not positive where they meet."""
        least = np.inf
        for shape_a, T_a in self._forms[a]:
            for shape_b, T_b in self._forms[b]:
                result = coal.DistanceResult()
                at_a, at_b = frames[self._joints[a]] * T_a, frames[self._joints[b]] * T_b
                least = min(least, float(coal.distance(shape_a, at_a, shape_b, at_b, self._request, result)))
        return least

    def meet(self, frames: Sequence[Any], a: int, b: int) -> bool:
        """Whether two bodies touch."""
        for shape_a, T_a in self._forms[a]:
            for shape_b, T_b in self._forms[b]:
                result = coal.CollisionResult()
                at_a, at_b = frames[self._joints[a]] * T_a, frames[self._joints[b]] * T_b
                if coal.collide(shape_a, at_a, shape_b, at_b, self._collide, result):
                    return True
        return False


def _forms(body: Body) -> Sequence[Form]:
    """The forms of a body, or its spheres where it has none."""
    if body.forms:
        return body.forms
    return [Form("sphere", (float(r),), _at(c)) for *c, r in body.spheres]


def _at(centre: Any) -> Array:
    T = np.eye(4)
    T[:3, 3] = centre
    return T


_TURNING = (2, 3, 4, 5)


class RealWorld:
    """Bodies of an arm and objects with forms around it, and the pairs of them that are watched.

    Attributes:
        axes: (7, 3) each joint axis in the frame of its joint.
    """

    def __init__(self, arm: BodyOwner, scene: Scene) -> None:
        self.version = scene.version, scene.moves
        self.scene = scene
        self._frames = arm.joint_frames
        bodies = arm.bodies
        index = {body.name: k for k, body in enumerate(bodies)}
        replaced = frozenset().union(*(thing.replaces for thing in scene))
        zero = arm.joint_frames(np.zeros(7))
        limb = arm.limb
        self.axes = np.array([zero[k + 1, :3, :3].T @ limb.axes[k] for k in range(7)])
        self._joints = [body.joint for body in bodies]
        self._forms = [[geometry(form) for form in _forms(body)] for body in bodies]
        self._names = [body.name for body in bodies]
        self._spheres = [body.spheres for body in bodies]
        placed = [
            np.column_stack([b.spheres[:, :3] @ zero[b.joint][:3, :3].T + zero[b.joint][:3, 3], b.spheres[:, 3]])
            for b in bodies
        ]
        # Distances that no posture changes: from the axis that a body spins about, and from the centre on the line.
        self._spin = [
            _from_line(rows, limb.points[k], limb.axes[k]) if (k := _SPIN.get(j)) is not None else 0.0
            for rows, j in zip(placed, self._joints, strict=True)
        ]
        centre = {2: limb.shoulder, 5: limb.wrist}
        self._turn = [
            float((np.linalg.norm(rows[:, :3] - centre[j], axis=1) + rows[:, 3]).max()) if j in centre else None
            for rows, j in zip(placed, self._joints, strict=True)
        ]
        pairs = [(index[p.first], index[p.second]) for p in arm.pairs if p.kept and not {p.first, p.second} & replaced]
        for thing in scene:
            parts = thing.parts or ([(thing.name, thing.forms)] if thing.forms else [])
            for label, forms in parts:
                self._joints.append(-1)
                self._names.append(label)
                self._forms.append([geometry(form.moved(thing.T)) for form in forms])
                balls = np.array([ball_around(form.moved(thing.T)) for form in forms])
                self._spheres.append(balls)
                self._spin.append(0.0)
                self._turn.append(None)
                pairs += [(k, len(self._joints) - 1) for k, body in enumerate(bodies) if body.joint > 0]
        self._pairs = pairs
        self._balls = np.array([_ball(rows) for rows in self._spheres])
        self._request = coal.DistanceRequest()

    def reach(
        self,
        frames: Array,
        line: tuple[Array, Array],
        spins: Callable[[float], tuple[float, float]],
        margin: float,
        best: float,
    ) -> float:
        """How far the arm may turn from a posture, either way, without any watched pair coming within a margin, rad.

        Args:
            frames: (8, 4, 4) of the joints.
            line: a point and the direction of the line shoulder-wrist.
            spins: for a width, the fastest rates within it of the outer joints of shoulder and wrist, rad/rad.
            margin: m.
            best: no more than this is asked for.

        Returns:
            Zero where a pair is within the margin.
        """
        still = np.eye(4)
        places = [frames[joint] if joint >= 0 else still for joint in self._joints]
        centres = np.array([T[:3, :3] @ ball[:3] + T[:3, 3] for T, ball in zip(places, self._balls, strict=True)])
        shoulder, wrist = spins(best)
        while best > _NARROW and not math.isfinite(max(shoulder, wrist)):
            best *= 0.5
            shoulder, wrist = spins(best)
        rates = [self._rates(k, places[k], line, shoulder, wrist) for k in range(len(places))]
        at = [transform(T) for T in places]
        order = []
        for a, b in self._pairs:
            rate = self._rate(a, b, rates)
            room = float(np.linalg.norm(centres[a] - centres[b])) - self._balls[a, 3] - self._balls[b, 3] - margin
            order.append((room / rate if rate > 0.0 else (math.inf if room > 0.0 else -math.inf), a, b, rate))
        for lower, a, b, rate in sorted(order):
            if lower >= best:
                break
            room = self._distance(at, a, b) - margin
            if room <= 0.0:
                return 0.0
            best = min(best, room / rate if rate > 0.0 else math.inf)
        return best

    def along(self, start: Array, end: Array, margin: float) -> tuple[float, str, str, float]:
        """What comes within a margin on a straight line of joint angles: where (0 to 1), which two, how near, m.

        No names where the line is certainly clear. What cannot be told on the shortest stretch counts.
        """
        turns = np.abs(end - start)
        waiting = [(0.0, 1.0)]
        while waiting:
            lower, upper = waiting.pop()
            middle, half = 0.5 * (lower + upper), 0.5 * (upper - lower)
            doubtful = self._doubtful(self._frames(start + middle * (end - start)), half * turns, margin)
            if doubtful is None:
                continue
            a, b, distance = doubtful
            if distance <= margin or half < _SHORTEST:
                return middle, self._names[a], self._names[b], distance
            waiting += [(middle, upper), (lower, middle)]
        return 0.0, "", "", math.inf

    def _doubtful(self, frames: Array, turns: Array, margin: float) -> tuple[int, int, float] | None:
        """The nearest pair that may come within a margin while joints turn so far from a posture; None for none."""
        still = np.eye(4)
        places = [frames[joint] if joint >= 0 else still for joint in self._joints]
        centres = np.array([T[:3, :3] @ ball[:3] + T[:3, 3] for T, ball in zip(places, self._balls, strict=True)])
        at: dict[int, Any] = {}
        worst = None
        for a, b in self._pairs:
            needed = margin + self._moved(a, b, frames, centres, turns)
            room = float(np.linalg.norm(centres[a] - centres[b])) - self._balls[a, 3] - self._balls[b, 3]
            if room > needed:
                continue
            for k in (a, b):
                if k not in at:
                    at[k] = transform(places[k])
            distance = self._distance(at, a, b)
            if distance <= needed and (worst is None or distance < worst[2]):
                worst = a, b, distance
        return worst

    def _moved(self, a: int, b: int, frames: Array, centres: Array, turns: Array) -> float:
        """How far the joints between two bodies move the outer one at most, m."""
        if self._joints[a] > self._joints[b]:
            a, b = b, a
        total = 0.0
        for joint in range(self._joints[b], max(self._joints[a], 0), -1):
            reach = float(np.linalg.norm(centres[b] - frames[joint, :3, 3])) + self._balls[b, 3]
            total += turns[joint - 1] * (reach + total)
        return total

    def _rates(self, k: int, T: Array, line: tuple[Array, Array], shoulder: float, wrist: float) -> tuple[float, float]:
        """How far points of a body move at most by the turn about the line, and by its own spin, m/rad."""
        joint = self._joints[k]
        own = self._spin[k] * (shoulder if joint in (1, 2) else wrist) if joint in _SPIN else 0.0
        if joint not in _TURNING:
            return 0.0, own
        turn = self._turn[k]
        if turn is None:
            rows = self._spheres[k]
            points = np.column_stack([rows[:, :3] @ T[:3, :3].T + T[:3, 3], rows[:, 3]])
            turn = _from_line(points, line[0], line[1] / np.linalg.norm(line[1]))
        return turn, own

    def _rate(self, a: int, b: int, rates: list[tuple[float, float]]) -> float:
        (turn_a, spin_a), (turn_b, spin_b) = rates[a], rates[b]
        together = self._joints[a] in _TURNING and self._joints[b] in _TURNING
        return spin_a + spin_b + (0.0 if together else turn_a + turn_b)

    def _distance(self, at: list[Any] | dict[int, Any], a: int, b: int) -> float:
        least = np.inf
        for shape_a, T_a in self._forms[a]:
            for shape_b, T_b in self._forms[b]:
                result = coal.DistanceResult()
                least = min(
                    least, float(coal.distance(shape_a, at[a] * T_a, shape_b, at[b] * T_b, self._request, result))
                )
                if least <= 0.0:
                    return least
        return least


_SPIN = {1: 0, 2: 2, 5: 4, 6: 6}
"""Joint axis that a body spins about against what moves it: against the base, the upper arm, the forearm, the hand."""

_NARROW = 1e-6

_SHORTEST = 1e-3
"""Shortest half of a stretch that is looked at, as a part of the line."""


def _from_line(rows: Array, point: Array, direction: Array) -> float:
    """Largest distance from a line of a point of spheres (n, 4), m."""
    across = np.cross(rows[:, :3] - point, direction)
    return float((np.linalg.norm(across, axis=1) + rows[:, 3]).max())


def _ball(rows: Array) -> Array:
    """(4,) a sphere around spheres (n, 4)."""
    centre = 0.5 * (rows[:, :3].min(axis=0) + rows[:, :3].max(axis=0))
    return np.array([*centre, float((np.linalg.norm(rows[:, :3] - centre, axis=1) + rows[:, 3]).max())])
