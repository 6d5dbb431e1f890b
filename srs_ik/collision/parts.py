"""Real forms for coal: collision geometries, and how far two of them are apart."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import Any

import coal
import numpy as np
from numpy.typing import NDArray

from srs_ik.collision.forms import Form, ball_around, least_along, surface
from srs_ik.system.arrays import Array

FAR_APART = 0.02
"""Where even the convex hulls of two bodies are this far apart, m, their distance is near enough to that of both."""

_BULGE = 1e-3
"""A closed mesh whose convex hull has no more volume beyond its own than this part of it counts as its hull."""

_THIN = 1e-6
"""Half the thickness that a flat hull is given, m, ..."""

_FLAT = 1e-7
"""... or this part of its extent, where that is more."""

_request = coal.DistanceRequest()


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
    elif form.kind == "half_space":
        shape = coal.Halfspace(0.0, 0.0, 1.0, 0.0)
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
    """The convex hull of some forms; those that lie in a plane, on a line or in a point are made `_THIN` first."""
    points = thickened(np.concatenate([surface(form)[0] for form in forms]))
    corners = coal.StdVec_Vec3s()
    corners.extend(list(points))
    return coal.Convex.convexHull(corners, False, "")


def thickened(points: Array) -> Array:
    """(n, 3) points, and where they are flat, others to both sides of them: coal's hulls need a volume."""
    middle = points.mean(axis=0)
    _, _, across = np.linalg.svd(points - middle, full_matrices=len(points) < 3)
    extent = np.ptp((points - middle) @ across.T, axis=0)
    thin = max(_THIN, _FLAT * float(extent.max()))
    for direction in across[extent < thin]:
        points = np.concatenate([points + thin * direction, points - thin * direction])
    return points


def transform(T: Array) -> Any:
    """A (4, 4) pose as coal's transform."""
    return coal.Transform3s(np.ascontiguousarray(T[:3, :3]), np.ascontiguousarray(T[:3, 3]))


class Part:
    """One form of a body.

    Attributes:
        form: the form, in the frame of the joint that carries it, or in the base frame.
        T: (4, 4) where its geometry is in that frame.
        at: the same, as coal's transform.
        ball: (4,) a sphere around it, in that frame.
        shape: coal's geometry of it; the hull of a mesh that is convex but for rounding.
        cover: its convex hull, where the form is not convex; else None.
    """

    def __init__(self, form: Form) -> None:
        self.form = form
        self.T = form.T
        self.shape, self.at = geometry(form)
        self.ball = ball_around(form)
        self.cover = None
        if form.kind == "mesh":
            whole = hull([Form("mesh", (), np.eye(4), form.vertices, form.faces)])
            if _is_convex(form):
                self.shape = whole
            else:
                self.cover = whole

    @property
    def rounded(self) -> Any:
        """Its geometry, with a sphere as an ellipsoid."""
        return coal.Ellipsoid(*self.form.size * 3) if self.form.kind == "sphere" else self.shape

    @cached_property
    def points(self) -> Array:
        """(n, 3) points whose convex hull contains the form, in the frame of its carrier."""
        return surface(self.form)[0]

    @cached_property
    def corners(self) -> Array:
        """(n, 3) those of the points that are corners of their convex hull."""
        return corners_of(self.points)


def parts_of(forms: Sequence[Form]) -> list[Part]:
    """Some forms as parts."""
    return [Part(form) for form in forms]


def _is_convex(form: Form) -> bool:
    import trimesh

    own = trimesh.Trimesh(form.vertices, form.faces, process=True)
    return bool(own.is_watertight and own.convex_hull.volume - own.volume <= _BULGE * own.volume)


def apart(first: Part, at_first: Any, second: Part, at_second: Any, enough: float = FAR_APART) -> float:
    """Distance of two parts, or a bound below it that is more than enough, m; not positive where they meet.

    Where both are convex, it is minus the depth then. A half-space is the second one; no hull is nearer to it than what
    it goes around.
    """
    if second.form.kind == "half_space":
        out, T = at_second.getRotation()[:, 2], at_first.getRotation()
        level = float(out @ (at_first.getTranslation() - at_second.getTranslation()))
        return level + least_along(first.form, T.T @ out)
    if is_convex(first, second):
        found = _distance(first.shape, at_first, second.shape, at_second)
        if found < 0.0 and {first.form.kind, second.form.kind} == {"sphere", "cylinder"}:
            # coal takes a sphere out of a cylinder through its side alone; an ellipsoid, by the shortest way.
            found = max(found, _distance(first.rounded, at_first, second.rounded, at_second))
        return found
    hulls = _distance(first.cover or first.shape, at_first, second.cover or second.shape, at_second)
    return hulls if hulls > enough else max(_distance(first.shape, at_first, second.shape, at_second), hulls)


def _distance(first: Any, at_first: Any, second: Any, at_second: Any) -> float:
    # A result of its own: many threads may ask.
    return float(coal.distance(first, at_first, second, at_second, _request, coal.DistanceResult()))


def is_convex(first: Part, second: Part) -> bool:
    """Whether minus the distance of two parts is how deep they are in each other."""
    if second.form.kind == "half_space":
        return True
    return first.cover is None and second.cover is None


def corners_of(points: Array) -> Array:
    """(n, 3) those of some points that are corners of their convex hull."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return np.asarray(points[ConvexHull(points).vertices], dtype=float)
    except QhullError:
        # They lie in a plane.
        return points


def inner_radius(points: Array, centre: Array) -> float:
    """Radius of a ball about a centre within the convex hull of some points, m; minus one for none."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        planes = ConvexHull(points).equations
    except QhullError:
        return -1.0
    radius = -float((planes[:, :3] @ centre + planes[:, 3]).max())
    return radius if radius > 0.0 else -1.0
