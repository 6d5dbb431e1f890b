"""What is shown at a point: ellipsoids and polytopes at the tip, the directions of a task, a posture as sticks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from srs_ik.errors import InvalidTask
from srs_ik.preview import palette, solids
from srs_ik.preview.palette import Rgb
from srs_ik.preview.solids import Solid
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.analysis.ellipsoids import Ellipsoid
    from srs_ik.analysis.polytopes import Polytope
    from srs_ik.inputs.task import Task
    from srs_ik.solve.posture import Posture

TASK_LEGEND = [
    (palette.VELOCITY, "velocity"),
    (palette.FORCE, "force"),
    (palette.GRASP, "grasp"),
    (palette.NORMAL, "normal"),
]

_THINNEST = 0.01
"""A flat ellipsoid is shown with this share of its largest radius for a thickness."""


def ellipsoid_solids(ellipsoid: Ellipsoid, centre: Array, size: float, colour: Rgb) -> list[Solid]:
    """An ellipsoid and its axes; its largest radius has the given length, metres, whatever its unit is.

    A direction without bound is shown twice as long as the largest radius that has one.
    """
    radii = np.array(ellipsoid.radii[:3], dtype=float)
    bounded = radii[np.isfinite(radii)]
    largest = float(bounded.max()) if len(bounded) and bounded.max() > 0.0 else 1.0
    lengths = np.where(np.isfinite(radii), radii / largest, 2.0)
    lengths *= size / lengths.max()
    mesh = trimesh.creation.icosphere(subdivisions=4)
    axes = np.array(ellipsoid.axes[:3, :3], dtype=float)
    if np.linalg.det(axes) < 0.0:
        axes[:, 2] *= -1.0
    T = np.eye(4)
    T[:3, :3] = axes * np.maximum(lengths, _THINNEST * size)
    T[:3, 3] = centre
    found = [Solid(mesh.apply_transform(T), colour, 0.35)]
    for reach in (axes * lengths).T:
        found += [Solid(line, colour) for line in solids.rods((centre - reach, centre + reach), 0.012 * size)]
    return found


def polytope_solids(polytope: Polytope, centre: Array, size: float, colour: Rgb) -> list[Solid]:
    """A polytope and its edges; its farthest vertex has the given distance from the tip, metres."""
    farthest = float(np.linalg.norm(polytope.vertices, axis=1).max(initial=0.0))
    if not len(polytope.faces) or farthest == 0.0:
        return []
    mesh = trimesh.Trimesh(centre + size / farthest * polytope.vertices, polytope.faces, process=False)
    edges = mesh.face_adjacency_edges[mesh.face_adjacency_angles > 1e-3]
    rods = [rod for edge in edges for rod in solids.rods(mesh.vertices[edge], 0.008 * size)]
    return [Solid(solids.creased(mesh), colour, 0.3), *(Solid(rod, colour) for rod in rods)]


def task_solids(task: Task, normal: ArrayLike, size: float) -> list[Solid]:
    """The plane of a task at its position, with velocity v, force f, grasp g and the normal n."""
    at, n = np.asarray(task.position, dtype=float), np.asarray(normal, dtype=float)
    found = [Solid(solids.plate(at, n, 0.8 * size), palette.PLANE, 0.45)]
    directions: list[tuple[ArrayLike | None, Rgb, float]] = [
        (task.velocity, palette.VELOCITY, 1.0),
        (task.force, palette.FORCE, 1.0),
        (task.grasp, palette.GRASP, 0.8),
        (n, palette.NORMAL, 0.6),
    ]
    for direction, colour, length in directions:
        if direction is not None and np.linalg.norm(direction) > 0.0:
            along = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
            found.append(Solid(solids.arrow(at, length * size * along, 0.02 * size), colour))
    return found


def posture_solids(posture: Posture, size: float) -> list[Solid]:
    """Shoulder, elbow, wrist and hand as balls and sticks, and the plane of the arm."""
    points = [np.asarray(p, dtype=float) for p in (posture.shoulder, posture.elbow, posture.wrist, posture.hand)]
    found = [Solid(solids.ball(1.8 * size, p), palette.POSTURE) for p in points]
    found += [Solid(rod, palette.POSTURE) for rod in solids.rods(points, size)]
    return [*found, *_triangle(points[:3])]


def measures(part: str, shape: str) -> list[tuple[Rgb, str]]:
    """The legend of ellipsoids or polytopes, by the name of the shape, of the linear or the angular part."""
    velocity, force = ("velocity", "force") if part == "linear" else ("angular velocity", "moment")
    return [(palette.VELOCITY, f"{shape} of {velocity}"), (palette.FORCE, f"{shape} of {force}")]


def check_single(posture: Posture, task: Task | None) -> None:
    """Raise InvalidTask unless one posture, and one task or none, are to be shown."""
    for thing, points, kind in ((posture, "hand", "Posture"), (task, "position", "Task")):
        point = getattr(thing, points, None)
        if point is None and not (kind == "Task" and thing is None):
            raise InvalidTask(f"a {kind} is shown, not an object of type {type(thing).__name__}")
        if point is not None and np.ndim(point) != 1:
            raise InvalidTask(f"one {kind} is shown at a time, not {len(point)}: choose one by its index")


def check_part(part: str) -> None:
    """Raise InvalidTask for a part that cannot be shown in three dimensions."""
    if part not in ("linear", "angular"):
        raise InvalidTask(f"part is 'linear' or 'angular' in a picture of three dimensions, not {part!r}")


def _triangle(corners: Sequence[Array]) -> list[Solid]:
    if np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0])) < 1e-9:
        return []
    mesh = trimesh.Trimesh(np.array(corners), [[0, 1, 2]], process=False)
    return [Solid(solids.creased(mesh), palette.POSTURE, 0.25)]
