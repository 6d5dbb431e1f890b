"""The bodies of an arm: its links, as spheres that cover their shapes, and as the shapes themselves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from srs_ik.collision.forms import Form, ball_around, row_of_spheres, surface
from srs_ik.collision.links import store
from srs_ik.collision.links.cover import cover
from srs_ik.errors import InvalidScene, NoBodies, did_you_mean, listed, quoted
from srs_ik.meshes.files import MeshFinder, MeshMissing, MeshShelf
from srs_ik.robot.description.shapes import Shape, read_shapes
from srs_ik.robot.limb import ReadOnlyArrays
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.kinematics import ChainKinematics
    from srs_ik.robot.description.model import Drawing

Source = Literal["collision", "visual", "spheres", "object"]

SPHERES = 32
"""Spheres a link of the arm, about; one that does not move has fewer."""

_STILL = 12
_FEWEST = 4
_LARGE = 0.15
"""A link of this size, m, has all the spheres."""

_APART = 6
_SHORT = 1e-9


@dataclass(frozen=True, eq=False)
class Body(ReadOnlyArrays):
    """A link of an arm, or an object in its hand.

    Attributes:
        name: of the link or object.
        joint: 0 for what stands still, 1 to 7 for what that joint moves.
        spheres: (n, 4) centre and radius in the frame of the joint (0: of the root), m. They cover the shapes.
        protrusion: how far they stick out of the shapes, m; NaN where there are no shapes to compare with.
        source: what was covered, the "collision" or the "visual" shapes, or "spheres" of a file, or an "object".
        forms: the shapes, in the frame of the joint; empty for spheres of a file.
    """

    name: str
    joint: int
    spheres: Array
    protrusion: float
    source: Source
    forms: tuple[Form, ...] = ()

    def __repr__(self) -> str:
        return f"Body({self.name!r}, joint {self.joint}, {len(self.spheres)} spheres, {1e3 * self.protrusion:.1f} mm)"


def link_bodies(
    arm: ChainKinematics,
    drawing: Drawing | None,
    folders: Sequence[str | Path],
    spheres: Mapping[str, Array] | None,
) -> list[Body]:
    """The links of a robot that have shapes, in the order of the model.

    Args:
        arm: the seven joints.
        drawing: where the shapes are; None for none.
        folders: folders to search for meshes.
        spheres: (n, 4) of links whose spheres are given, in the frames of these links; all of them, if of any.

    Raises:
        NoBodies: there are no shapes, or meshes of a link are not at hand; or no spheres of a link that moves.
        InvalidScene: spheres are given for a link that the robot does not have.
        InvalidRobot: the file that the arm was loaded from is gone, or is no URDF any more.
    """
    frames = link_frames(arm)
    if spheres is not None:
        return _all_given(arm.name, frames, spheres)
    shapes = [shape for shape in read_shapes(drawing)[0] if shape.link in frames]
    if not any(frames[shape.link].parentJoint for shape in shapes):
        raise NoBodies(
            f"{arm.name}: its description has no shapes of links that move; give spheres of them: "
            "arm.with_bodies(spheres=FILE)"
        )
    shelf = MeshShelf(MeshFinder(drawing.file if drawing else None, folders))
    by_link: dict[str, list[Shape]] = {}
    for shape in shapes:
        by_link.setdefault(shape.link, []).append(shape)
    return [_of_link(arm, name, frames[name], own, shelf) for name, own in by_link.items()]


def link_frames(arm: ChainKinematics) -> dict[str, Any]:
    """The frames of all links by name, in the order of the model."""
    return {f.name: f for f in arm.model.frames if f.type == pin.FrameType.BODY}


def _all_given(robot: str, frames: Mapping[str, Any], spheres: Mapping[str, Array]) -> list[Body]:
    """The links whose spheres are given; with none of one that moves, nothing would ever be hit."""
    found = []
    for name, rows in spheres.items():
        if not len(rows):
            continue
        if name not in frames:
            hint = did_you_mean(name, frames)
            raise InvalidScene(
                f"spheres are given for {quoted(name)}{hint}; the links of {robot} are {listed(list(frames))}"
            )
        found.append(_given(name, frames[name], rows))
    if not any(body.joint for body in found):
        raise NoBodies(f"{robot}: no link that moves has one of the spheres that are given, of radii above 0")
    return found


def _given(name: str, frame: Any, rows: Array) -> Body:
    T = frame.placement.homogeneous
    centres = rows[:, :3] @ T[:3, :3].T + T[:3, 3]
    return Body(name, frame.parentJoint, np.column_stack([centres, rows[:, 3]]), np.nan, "spheres")


def _of_link(arm: ChainKinematics, name: str, frame: Any, shapes: Sequence[Shape], shelf: MeshShelf) -> Body:
    complaint = ""
    for visual in (False, True):
        own = [shape for shape in shapes if shape.visual == visual]
        try:
            forms = tuple(_form(shape, shelf).moved(frame.placement.homogeneous) for shape in own)
        except MeshMissing as error:
            complaint = complaint or str(error)
            continue
        if forms:
            rows, protrusion = covered(forms, _count(forms, SPHERES if frame.parentJoint else _STILL))
            return Body(name, frame.parentJoint, rows, protrusion, "visual" if visual else "collision", forms)
    raise NoBodies(
        f"{arm.name}: the mesh of link {name!r} is not at hand ({complaint}); name its folder or give spheres: "
        "arm.with_bodies(folders=[...]) or arm.with_bodies(spheres=FILE), on the command line --meshes"
    )


def _count(forms: Sequence[Form], most: int) -> int:
    """How many spheres a link is worth: fewer where it is small."""
    size = 2.0 * max(float(ball_around(form)[3]) for form in forms)
    return min(max(round(most * size / _LARGE), _FEWEST), most)


def _form(shape: Shape, shelf: MeshShelf) -> Form:
    if shape.kind != "mesh":
        return Form(shape.kind, shape.size, shape.T_link_shape)
    meshes = [mesh for mesh, _ in shelf.pieces(shape.file)]
    vertices, faces = joined([(mesh.vertices, mesh.faces) for mesh in meshes])
    vertices = vertices * np.array(shape.size)
    if np.prod(shape.size) < 0.0:
        faces = faces[:, ::-1]
    return Form("mesh", (), shape.T_link_shape, np.asarray(vertices, dtype=float), np.asarray(faces, dtype=np.int64))


def covered(forms: Sequence[Form], count: int) -> tuple[Array, float]:
    """(n, 4) spheres that cover forms, and how far they stick out, m; of spheres and capsules, of themselves."""
    rows, rest = [], []
    for form in forms:
        own = row_of_spheres(form)
        if own is None:
            rest.append(surface(form))
        else:
            rows.append(own)
    # Apart, forms that overlap have no surface inside of each other; many small ones share their spheres.
    parts = rest if len(rest) <= _APART else [joined(rest)]
    areas = np.array([_area(*part) for part in parts])
    protrusion = 0.0
    for part, share in zip(parts, areas / areas.sum() if parts else areas, strict=True):
        found, off = covered_mesh(*part, max(round(count * share), _FEWEST))
        rows.append(found)
        protrusion = max(protrusion, off)
    return np.concatenate(rows), protrusion


def joined(surfaces: Sequence[tuple[Array, NDArray[np.int64]]]) -> tuple[Array, NDArray[np.int64]]:
    """Vertices and faces of several surfaces as one."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in surfaces)])
    faces = [faces + start for (_, faces), start in zip(surfaces, starts[:-1], strict=True)]
    return np.concatenate([vertices for vertices, _ in surfaces]), np.concatenate(faces)


def _area(vertices: Array, faces: NDArray[np.int64]) -> float:
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def covered_mesh(vertices: Array, faces: NDArray[np.int64], count: int) -> tuple[Array, float]:
    """`cover` of a mesh, kept on disk."""
    key = store.key_of(str(count), vertices, faces)
    kept = store.load(key)
    if kept is None:
        found = cover(vertices, faces, count)
        kept = np.vstack([found.spheres, [found.protrusion, 0.0, 0.0, 0.0]])
        store.keep(key, kept)
    return kept[:-1], float(kept[-1, 0])


def revolved(arm: ChainKinematics, body: Body, axis: int, lines: tuple[Array, Array]) -> Array:
    """(n, 4) spheres, in the base frame at zero, that cover all turns of a body about a joint axis, 0 to 6.

    `lines` are axes and points of the seven joints in the base frame at zero.
    """
    T = arm.joint_frames(np.zeros(7))[body.joint]
    direction, point = lines[0][axis], lines[1][axis]
    # In the frame of the joint and without the last digits: on any base it is the same, and found again on the disk.
    own_direction, own_point = (
        given.round(_DIGITS) + 0.0 for given in (direction @ T[:3, :3], (point - T[:3, 3]) @ T[:3, :3])
    )
    vertices, faces = _lathe(*_profile(body, own_direction, own_point).T)
    rows, _ = covered_mesh(vertices, faces, SPHERES)
    side = np.linalg.svd(own_direction[None])[2][1:]
    if np.linalg.det(np.vstack([side, own_direction])) < 0.0:
        side = side[::-1]
    centres = rows[:, :3] @ np.vstack([side, own_direction]) + own_point
    return np.column_stack([centres @ T[:3, :3].T + T[:3, 3], rows[:, 3]])


_SLICES = 20
_DIGITS = 12


def _profile(body: Body, direction: Array, point: Array) -> Array:
    """(n, 3) slices along an axis in a body's frame that contain the body: lower and upper end, and radius, m."""
    spans = [_spans(*surface(form), direction, point) for form in body.forms]
    if not spans:
        offset = body.spheres[:, :3] - point
        along = offset @ direction
        r = body.spheres[:, 3]
        across = np.linalg.norm(offset - along[:, None] * direction, axis=1)
        spans.append(np.column_stack([along - r, along + r, across + r]))
    low, high, radius = np.concatenate(spans).T
    edges = np.linspace(low.min(), high.max() + _SHORT, _SLICES + 1)
    slices = []
    for a, b in pairwise(edges):
        inside = (low <= b) & (high >= a)
        if inside.any():
            slices.append((a, b, max(float(radius[inside].max()), _SHORT)))
    return np.array(slices)


def _spans(points: Array, faces: NDArray[np.int64], direction: Array, point: Array) -> Array:
    """(n, 3) of small triangles: extent along an axis, and largest distance from it, which a corner has."""
    import trimesh

    extent = float(np.ptp(points, axis=0).max())
    points, faces = trimesh.remesh.subdivide_to_size(points, faces, max(extent / _SLICES, _SHORT), max_iter=40)
    offset = points - point
    along = offset @ direction
    across = np.linalg.norm(offset - along[:, None] * direction, axis=1)
    return np.column_stack([along[faces].min(axis=1), along[faces].max(axis=1), across[faces].max(axis=1)])


def _lathe(low: Array, high: Array, radius: Array) -> tuple[Array, NDArray[np.int64]]:
    """A stack of prisms around slices along z."""
    sides = 24
    turns = 2.0 * np.pi * np.arange(sides) / sides
    ring = np.column_stack([np.cos(turns), np.sin(turns)]) / np.cos(np.pi / sides)
    outline = [(low[0], 0.0)]
    for a, b, r in zip(low, high, radius, strict=True):
        outline += [(a, r), (b, r)]
    outline.append((high[-1], 0.0))
    vertices = np.concatenate([np.column_stack([r * ring, np.full(sides, z)]) for z, r in outline])
    faces = []
    for k in range(len(outline) - 1):
        for i in range(sides):
            a, b = k * sides + i, k * sides + (i + 1) % sides
            faces += [(a, b, b + sides), (a, b + sides, a + sides)]
    return vertices, np.array(faces, dtype=np.int64)


def held(name: str, forms: Sequence[Form], T_joint_tip: Array) -> Body:
    """An object that the hand holds, given by forms in the tip frame."""
    rows, protrusion = covered(forms, SPHERES)
    centres = rows[:, :3] @ T_joint_tip[:3, :3].T + T_joint_tip[:3, 3]
    moved = tuple(form.moved(T_joint_tip) for form in forms)
    return Body(name, 7, np.column_stack([centres, rows[:, 3]]), protrusion, "object", moved)
