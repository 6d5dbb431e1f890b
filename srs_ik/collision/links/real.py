"""The bodies of an arm by their real forms, for coal, as the arm carries them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import coal
import numpy as np

from srs_ik.collision.forms import Form
from srs_ik.collision.parts import apart, hull, is_convex, parts_of
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from srs_ik.collision.links.bodies import Body


class RealBodies:
    """Bodies of an arm, each as its parts and as the convex hull of these, to be placed by the frames of joints."""

    def __init__(self, bodies: Sequence[Body]) -> None:
        self._joints = [body.joint for body in bodies]
        self._parts = [parts_of(real_forms(body)) for body in bodies]
        self._hulls = [hull(real_forms(body)) for body in bodies]
        self._request = coal.DistanceRequest()
        self._collide = coal.CollisionRequest()

    @staticmethod
    def at_place(T: Any) -> Any:
        """A pinocchio.SE3 as coal's transform."""
        return coal.Transform3s(T.rotation, T.translation)

    def hull_distance(self, frames: Mapping[int, Any], a: int, b: int) -> float:
        """Distance of the hulls of two bodies, m; not positive where they meet."""
        result = coal.DistanceResult()
        T_a, T_b = frames[self._joints[a]], frames[self._joints[b]]
        return float(coal.distance(self._hulls[a], T_a, self._hulls[b], T_b, self._request, result))

    def distance(self, frames: Mapping[int, Any], a: int, b: int) -> float:
        """Distance of two bodies, m; where they meet, minus a depth that they have at least."""
        least = np.inf
        T_a, T_b = frames[self._joints[a]], frames[self._joints[b]]
        for one in self._parts[a]:
            for other in self._parts[b]:
                value = apart(one, T_a * one.at, other, T_b * other.at)
                least = min(least, value if value > 0.0 or is_convex(one, other) else 0.0)
        return least

    def meet(self, frames: Mapping[int, Any], a: int, b: int) -> bool:
        """Whether two bodies touch."""
        T_a, T_b = frames[self._joints[a]], frames[self._joints[b]]
        for one in self._parts[a]:
            for other in self._parts[b]:
                result = coal.CollisionResult()
                if coal.collide(one.shape, T_a * one.at, other.shape, T_b * other.at, self._collide, result):
                    return True
        return False


def real_forms(body: Body) -> Sequence[Form]:
    """The forms of a body, or its spheres where it has none."""
    if body.forms:
        return body.forms
    return [Form("sphere", (float(r),), _at(c)) for *c, r in body.spheres]


def _at(centre: Any) -> Array:
    T = np.eye(4)
    T[:3, 3] = centre
    return T
