"""What an arm must not touch, as it is drawn: objects, bodies in the colour of their clearance, forbidden arcs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import trimesh

from srs_ik.collision.clearances import clearances
from srs_ik.collision.forms import surface
from srs_ik.collision.links.bodies import joined
from srs_ik.kernels.layout import collision as at
from srs_ik.preview import palette, solids
from srs_ik.preview.palette import Rgb
from srs_ik.preview.solids import Solid
from srs_ik.solve.intervals import Interval
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.collision.scenes.scene import Scene

AMPLE = 0.1
"""From this clearance on, m, a body is drawn in the colour of those that are far away."""

_MOST_POINTS = 5000
"""Of a cloud, so many points are drawn at most."""


def object_solids(scene: Scene) -> dict[str, list[Solid]]:
    """The objects of a scene by name; half-spaces are not drawn."""
    drawn: dict[str, list[Solid]] = {}
    for thing in scene:
        forms = [*thing.forms, *(form for _, part in thing.parts for form in part)]
        finite = [form.moved(thing.T) for form in forms if form.kind != "half_space"]
        meshes = [trimesh.Trimesh(*surface(form), process=False) for form in finite]
        if not forms:
            clouds = [rows for rows, kind in zip(thing.rows, thing.kinds, strict=True) if kind == at.SPHERES]
            rows = np.concatenate([np.empty((0, 4)), *clouds])
            meshes = [_dots(rows[:: max(1, len(rows) // _MOST_POINTS)], thing.T)] if len(rows) else []
        drawn[thing.name] = [Solid(solids.creased(mesh), palette.OBJECT, 0.55) for mesh in meshes]
    return drawn


def _dots(rows: Array, T: Array) -> trimesh.Trimesh:
    """Points as octahedra."""
    corners = np.concatenate([np.eye(3), -np.eye(3)])
    faces = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    centres = rows[:, :3] @ T[:3, :3].T + T[:3, 3]
    vertices = centres[:, None] + np.maximum(rows[:, 3], 0.004)[:, None, None] * corners
    count = np.arange(len(rows))[:, None, None]
    return trimesh.Trimesh(vertices.reshape(-1, 3), (faces + 6 * count).reshape(-1, 3), process=False)


def body_solids(arm: Arm, scene: Scene, q: Array, margin: float) -> dict[str, list[Solid]]:
    """The bodies that the arm moves, as spheres, red at the margin and green from `AMPLE` beyond it on."""
    frames, zero = arm.joint_frames(q), arm.joint_frames(np.zeros(7))
    tables = arm.tables(scene)
    least = clearances(tables, frames, zero)
    drawn = {}
    for body in arm.bodies:
        gap = float(least[tables.names.index(body.name)])
        if body.joint > 0 and math.isfinite(gap):
            T = frames[body.joint]
            balls = [solids.ball(r, T[:3, :3] @ c + T[:3, 3]) for *c, r in body.spheres]
            mesh = trimesh.Trimesh(*joined([(b.vertices, b.faces) for b in balls]), process=False)
            drawn[body.name] = [Solid(mesh, colour_of(gap - margin), 0.4)]
    return drawn


def colour_of(clearance: float) -> Rgb:
    """Red where nothing is left, green from `AMPLE` on, yellow between."""
    share = min(max(clearance / AMPLE, 0.0), 1.0)
    near, middle, far = palette.TOUCHING, palette.CLOSE, palette.CLEAR
    a, b, t = (near, middle, 2.0 * share) if share < 0.5 else (middle, far, 2.0 * share - 1.0)
    r, g, blue = (x + t * (y - x) for x, y in zip(a, b, strict=True))
    return r, g, blue


def forbidden(feasible: Sequence[Interval], free: Sequence[Interval]) -> list[Interval]:
    """What bodies take of feasible arm angles."""
    taken = []
    for each in feasible:
        at = each.lower
        inside = [_within(other, each) for other in free if other.branch == each.branch]
        for lower, upper in sorted(part for part in inside if part is not None):
            if lower > at + _NOTHING:
                taken.append(Interval(each.branch, at, lower))
            at = max(at, upper)
        if each.upper > at + _NOTHING:
            taken.append(Interval(each.branch, at, each.upper))
    return taken


def _within(part: Interval, whole: Interval) -> tuple[float, float] | None:
    """Ends of a part of an interval in the turn in which it lies in that."""
    middle = 0.5 * (part.lower + part.upper)
    turns = 2.0 * math.pi * math.floor((middle - whole.lower) / (2.0 * math.pi))
    lower, upper = part.lower - turns, part.upper - turns
    return (lower, upper) if middle - turns <= whole.upper else None


_NOTHING = 1e-9
