"""How an arm looks: the shapes of its robot, its skeleton where there are none, and the limb inside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from srs_ik.preview import palette, solids
from srs_ik.preview.mesh_files import MeshFinder, MeshMissing, read_mesh
from srs_ik.preview.solids import Solid
from srs_ik.robot.description.shapes import Shape, read_shapes

if TYPE_CHECKING:
    from srs_ik.arm import Arm

Array = NDArray[np.float64]


_BENT = 0.8
"""Distance from shoulder to wrist of the arm at rest, as a share of that of the stretched arm."""

_ASIDE = 0.35
"""Angle of joints 2 and 6 of the arm at rest from the middle of their ranges, rad."""

_BENDS = 61
"""So many elbow angles are tried for it."""


class Part(NamedTuple):
    """A solid that a joint carries."""

    joint: int
    """0 for what stands still, 1 to 7 for what that joint moves."""
    solid: Solid
    """In the frame of the joint."""


class Look(NamedTuple):
    """All that is drawn of a robot, and what could not be."""

    parts: list[Part]
    missing: list[str]
    """One clause for each shape that is not drawn."""


class Stage(NamedTuple):
    """How the arm stands before the camera."""

    centre: Array
    """(3,) the shoulder in the base frame, which the camera turns about."""
    R_scene_base: Array
    """(3, 3) rotation that sets the root of the robot upright, or the base frame where that was given to the arm."""
    floor: float
    """Height of the lowest part that stands still, above the centre, metres."""

    @classmethod
    def of(cls, arm: Arm, parts: Sequence[Part]) -> Stage:
        """The stage for an arm of these parts."""
        T_base_root = arm.joint_frames(np.zeros(7))[0]
        base = next(frame for frame in arm.model.frames if frame.name == arm.base)
        # A base frame that is no part of the robot is that of its surroundings, see `Arm.with_base`.
        R = np.eye(3) if base.type == pin.FrameType.OP_FRAME else T_base_root[:3, :3].T
        standing = [part.solid.mesh.vertices @ T_base_root[:3, :3].T for part in parts if part.joint == 0]
        heights = [float((R @ T_base_root[:3, 3])[2] + (points @ R[2]).min(initial=0.0)) for points in standing]
        level = float(R[2] @ arm.limb.shoulder)
        return cls(arm.limb.shoulder, R, min([0.0, *heights]) - level)


def look(arm: Arm, folders: Sequence[str | Path] = ()) -> Look:
    """The shapes of the whole robot: its meshes where they are found, else its primitive shapes, else its skeleton.

    Args:
        arm: the arm.
        folders: folders to search for meshes, see `MeshFinder`.

    Raises:
        InvalidRobot: the file that the arm was loaded from is gone, or is no URDF any more.
    """
    shapes, senseless = read_shapes(arm.drawing)
    finder = MeshFinder(arm.drawing.file if arm.drawing else None, folders)
    frames = {f.name: f for f in arm.model.frames if f.type == pin.FrameType.BODY}
    parts: list[Part] = []
    missing = [f"{senseless} shapes have no size or an unknown form"] if senseless else []
    bare = set()
    for link in dict.fromkeys(shape.link for shape in shapes if shape.link in frames):
        visuals = [shape for shape in shapes if shape.link == link and shape.visual]
        found: list[Solid] = []
        try:
            found = [solid for shape in visuals for solid in _solids(shape, finder)]
        except MeshMissing as error:
            missing.append(f"{link}: {error}")
            spare = [s for s in shapes if s.link == link and not s.visual and s.kind != "mesh"]
            found = [solid for shape in spare for solid in _solids(shape, finder)]
            if not found:
                bare.add(frames[link].parentJoint)
        T_joint_link = frames[link].placement.homogeneous
        parts += [Part(frames[link].parentJoint, _moved(solid, T_joint_link)) for solid in found]
    carried = {part.joint for part in parts}
    if bare - {0} or not carried & set(range(1, 8)):
        parts += skeleton(arm)
    return Look(parts, missing)


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


def _solids(shape: Shape, finder: MeshFinder) -> list[Solid]:
    """The shape in the frame of its link."""
    if shape.kind == "mesh":
        pieces = [
            (solids.creased(mesh.apply_scale(shape.size)), own) for mesh, own in read_mesh(finder.find(shape.file))
        ]
    elif shape.kind == "box":
        pieces = [(solids.box(shape.size), None)]
    elif shape.kind == "sphere":
        pieces = [(solids.ball(*shape.size), None)]
    elif shape.kind == "capsule":
        pieces = [(solids.capsule(*shape.size), None)]
    else:
        pieces = [(solids.cylinder(*shape.size), None)]
    found = []
    for mesh, own in pieces:
        r, g, b, opacity = own or shape.rgba or palette.PLAIN
        found.append(_moved(Solid(mesh, (r, g, b), opacity), shape.T_link_shape))
    return found


def _moved(solid: Solid, T: Array) -> Solid:
    return replace(solid, mesh=solid.mesh.copy().apply_transform(T))
