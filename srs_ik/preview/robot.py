"""How an arm looks: the shapes of its robot, its skeleton where there are none, and the limb inside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pinocchio as pin
import trimesh

from srs_ik.meshes import bounds
from srs_ik.meshes.files import MeshFinder, MeshMissing, MeshShelf, Piece
from srs_ik.meshes.folders import folders_of
from srs_ik.preview import palette, solids
from srs_ik.preview.solids import Solid
from srs_ik.robot.description.shapes import Shape, read_shapes, read_tree
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.arm import Arm


_BENT = 0.8
"""Distance from shoulder to wrist of the arm at rest, as a share of that of the stretched arm."""

_ASIDE = 0.35
"""Angle of joints 2 and 6 of the arm at rest from the middle of their ranges, rad."""

_BENDS = 61
"""So many elbow angles are tried for it."""


class Part(NamedTuple):
    """A solid that a joint carries."""

    joint: int  # 0 for what stands still, 1 to 7 for what that joint moves
    solid: Solid  # in the frame of the joint


class Look(NamedTuple):
    """All that is drawn of a robot, and what could not be."""

    parts: list[Part]
    missing: list[str]  # one clause for each shape that is not drawn


class Stage(NamedTuple):
    """How the arm stands before the camera."""

    R_scene_base: Array
    """(3, 3) rotation that sets the root of the robot upright, or the base frame where that was given to the arm."""
    floor: float  # height of the lowest part that stands still, above the base frame, metres

    @classmethod
    def of(cls, arm: Arm, parts: Sequence[Part]) -> Stage:
        """The stage for an arm of these parts."""
        T_base_root = arm.joint_frames(np.zeros(7))[0]
        base = next(frame for frame in arm.model.frames if frame.name == arm.base)
        # A base frame that is no part of the robot is that of its surroundings, see `Arm.with_base`.
        R = np.eye(3) if base.type == pin.FrameType.OP_FRAME else T_base_root[:3, :3].T
        standing = [part.solid.mesh.vertices @ T_base_root[:3, :3].T for part in parts if part.joint == 0]
        heights = [float((R @ T_base_root[:3, 3])[2] + (points @ R[2]).min(initial=0.0)) for points in standing]
        return cls(R, min([0.0, *heights]))


def look(arm: Arm, folders: str | Path | Sequence[str | Path] = ()) -> Look:
    """The shapes of the whole robot: its meshes where they are found, else its primitive shapes, else its skeleton.

    Raises:
        InvalidRobot: the file that the arm was loaded from is gone, or is no URDF any more; or there is no such folder.
    """
    searched = folders_of(folders)
    shapes, senseless = read_shapes(arm.drawing)
    shelf = MeshShelf(MeshFinder(arm.drawing.file if arm.drawing else None, searched))
    frames = {f.name: f for f in arm.model.frames if f.type == pin.FrameType.BODY}
    drawn = _Drawn(shelf)
    missing = [f"{senseless} shapes have no size or an unknown form"] if senseless else []
    bare = set()
    for link, own in _by_link(shapes, frames).items():
        T_joint_link, joint = frames[link].placement.homogeneous, frames[link].parentJoint
        clause = drawn.add([shape for shape in own if shape.visual], joint, T_joint_link)
        if clause:
            missing.append(f"{link}: {clause}")
            spare = [shape for shape in own if not shape.visual and shape.kind != "mesh"]
            if not spare or drawn.add(spare, joint, T_joint_link):
                bare.add(link)
    if drawn.left_out:
        most = f"{bounds.PIECES:,} shapes with {bounds.TRIANGLES:,} triangles are drawn of a robot"
        missing.append(f"{drawn.left_out} shapes, the first of link {drawn.first_left_out}: {most}")
    carried = {part.joint for part in drawn.parts}
    if any(frames[link].parentJoint for link in bare) or not carried & set(range(1, 8)):
        drawn.parts += skeleton(arm)
    if bare or not carried:
        drawn.parts += body(arm)[: bounds.PIECES]
    return Look(drawn.parts, missing)


def _by_link(shapes: Sequence[Shape], frames: Mapping[str, pin.Frame]) -> dict[str, list[Shape]]:
    found: dict[str, list[Shape]] = {}
    for shape in shapes:
        if shape.link in frames:
            found.setdefault(shape.link, []).append(shape)
    return found


class _Drawn:
    """The parts of a robot as they come together, within the bounds of what is drawn."""

    def __init__(self, shelf: MeshShelf) -> None:
        self.parts: list[Part] = []
        self.left_out = 0
        self.first_left_out = ""
        self._triangles = 0
        self._shelf = shelf
        self._creased: dict[tuple[str, tuple[float, ...]], list[Piece]] = {}

    def add(self, shapes: Sequence[Shape], joint: int, T_joint_link: Array) -> str:
        """Draw the shapes of a link, none of them if one cannot be shown: a clause that says why, empty if all can.

        Those beyond the bounds are left out.
        """
        try:
            found = [(shape, self._pieces(shape)) for shape in shapes if not self._full(shape)]
        except MeshMissing as error:
            return str(error)
        for shape, pieces in found:
            count = sum(len(mesh.faces) for mesh, _ in pieces)
            if self._full(shape, len(pieces), count):
                continue
            self._triangles += count
            for mesh, own in pieces:
                r, g, b, opacity = own or shape.rgba or palette.PLAIN
                T_joint_shape = T_joint_link @ shape.T_link_shape
                self.parts.append(Part(joint, _moved(Solid(mesh, (r, g, b), opacity), T_joint_shape)))
        return ""

    def _full(self, shape: Shape, pieces: int = 1, triangles: int = 1) -> bool:
        """Whether there is no room for a shape, of which note is then taken."""
        full = len(self.parts) + pieces > bounds.PIECES or self._triangles + triangles > bounds.TRIANGLES
        if full:
            self.left_out += 1
            self.first_left_out = self.first_left_out or shape.link
        return full

    def _pieces(self, shape: Shape) -> list[Piece]:
        """The shape in its own frame, not to be changed; raises MeshMissing where it cannot be shown."""
        key = shape.file, shape.size
        if shape.kind != "mesh":
            _check_extent(shape, max(shape.size))
            return [(_primitive(shape), None)]
        if key not in self._creased:
            raw = self._shelf.pieces(shape.file)
            _check_extent(shape, max(float(np.abs(mesh.bounds * shape.size).max()) for mesh, _ in raw))
            self._creased[key] = [(solids.creased(mesh.copy().apply_scale(shape.size)), own) for mesh, own in raw]
        _check_extent(shape, 0.0)
        return self._creased[key]


def _check_extent(shape: Shape, size: float) -> None:
    """Raise MeshMissing where a shape reaches so far from its own origin, metres, that it leaves its link."""
    # The negation also holds for what is no number.
    if not size + float(np.abs(shape.T_link_shape[:3, 3]).max()) <= bounds.EXTENT:
        raise MeshMissing(f"a {shape.kind} reaches farther than {bounds.EXTENT:g} m from its link")


def _primitive(shape: Shape) -> trimesh.Trimesh:
    if shape.kind == "box":
        return solids.box(shape.size)
    if shape.kind == "sphere":
        return solids.ball(*shape.size)
    if shape.kind == "capsule":
        return solids.capsule(*shape.size)
    return solids.cylinder(*shape.size)


def skeleton(arm: Arm) -> list[Part]:
    """The arm as its joints, drums along their axes, and rods between them."""
    T_base_joint = arm.joint_frames(np.zeros(7))
    thickness = 0.022 * reach(arm)
    points = [np.zeros(3), *T_base_joint[1:, :3, 3], arm.limb.T_base_tip_zero[:3, 3]]
    parts = []
    for k in range(8):
        T_joint_base = np.linalg.inv(T_base_joint[k])
        bones = [Solid(bone, palette.BONE) for bone in solids.rods(points[k : k + 2], thickness)]
        if k > 0:
            along = 1.6 * thickness * arm.limb.axes[k - 1]
            drums = solids.rods((points[k] - along, points[k] + along), 1.5 * thickness)
            bones += [Solid(drum, palette.JOINT) for drum in drums]
        parts += [Part(k, _moved(bone, T_joint_base)) for bone in bones]
    return parts


def body(arm: Arm) -> list[Part]:
    """What stands still of the rest of the robot, its other limbs, as rods from each link to those that it carries."""
    still = [f for f in arm.model.frames if f.type == pin.FrameType.BODY and not f.parentJoint]
    places = {frame.name: frame.placement.translation for frame in still}
    ends = [(places[a], places[b]) for a, b in read_tree(arm.drawing) if a in places and b in places]
    return [Part(0, Solid(rod, palette.BONE)) for pair in ends for rod in solids.rods(pair, 0.016 * reach(arm))]


def limb(arm: Arm) -> list[Part]:
    """Shoulder, elbow, wrist and tip of the recognised limb, and the straight lines between them."""
    T_base_joint = arm.joint_frames(np.zeros(7))
    found = arm.limb
    points = [found.shoulder, found.elbow, found.wrist, found.T_base_tip_zero[:3, 3]]
    thickness = 0.005 * reach(arm)
    parts = []
    # The upper arm is what joint 3 carries, the forearm what joint 4 and the hand what joint 7 carries.
    for joint, start, end in zip((3, 4, 7), points[:-1], points[1:], strict=True):
        T_joint_base = np.linalg.inv(T_base_joint[joint])
        for mesh in (*solids.rods((start, end), thickness), solids.ball(2.4 * thickness, start)):
            parts.append(Part(joint, _moved(Solid(mesh, palette.LIMB, overlaid=True), T_joint_base)))
    return parts


def reach(arm: Arm) -> float:
    """Length of the stretched arm, shoulder to tip, metres: the measure of everything that is drawn."""
    return arm.limb.upper_arm + arm.limb.forearm + arm.limb.hand


def resting(arm: Arm) -> Array:
    """(7,) near the middle of the ranges, rad, bent so far that one sees where the elbow lies."""
    limited = np.isfinite(arm.lower) & np.isfinite(arm.upper)
    lower, upper = np.where(limited, arm.lower, -np.pi), np.where(limited, arm.upper, np.pi)
    q = 0.5 * (lower + upper)
    # In the very middle the axes of shoulder and wrist often line up, where single joints say nothing.
    q[[1, 5]] = np.minimum(q[[1, 5]] + _ASIDE, upper[[1, 5]])
    bends = np.tile(q, (_BENDS, 1))
    bends[:, 3] = np.linspace(lower[3], upper[3], _BENDS)
    to_wrist = np.linalg.inv(arm.joint_frames(np.zeros(7))[4]) @ [*arm.limb.wrist, 1.0]
    spans = [np.linalg.norm((arm.joint_frames(bent)[4] @ to_wrist)[:3] - arm.limb.shoulder) for bent in bends]
    wanted = _BENT * (arm.limb.upper_arm + arm.limb.forearm)
    return bends[int(np.argmin(np.abs(np.array(spans) - wanted)))]


def _moved(solid: Solid, T: Array) -> Solid:
    return replace(solid, mesh=solid.mesh.copy().apply_transform(T))
