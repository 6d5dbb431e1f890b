"""The real forms, for coal: collision geometries, and the bodies of an arm as it carries them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import coal
import numpy as np
from numpy.typing import NDArray

from srs_ik.collision.forms import Form, surface

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from srs_ik.collision.bodies import Body

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
