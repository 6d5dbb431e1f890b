"""An MJCF file as a ``pinocchio.Model``."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from srs_ik.errors import InvalidRobot, quoted
from srs_ik.robot.description.mjcf.actuators import joint_efforts
from srs_ik.robot.description.mjcf.attributes import Reader
from srs_ik.robot.description.mjcf.bodies import WORLD, Body, Joint, read_bodies
from srs_ik.robot.description.mjcf.text import whole
from srs_ik.robot.description.mjcf.ties import tied_joints
from srs_ik.system import bounds

_ALIGNED = {
    "hinge": (pin.JointModelRX, pin.JointModelRY, pin.JointModelRZ),
    "slide": (pin.JointModelPX, pin.JointModelPY, pin.JointModelPZ),
}
_UNALIGNED = {"hinge": pin.JointModelRevoluteUnaligned, "slide": pin.JointModelPrismaticUnaligned}
_RIGID = 1e-9
"""Largest entry of R'R - 1 of a rotation."""


def build(path: Path, content: bytes, label: str) -> tuple[pin.Model, dict[str, float | None]]:
    """The model of an MJCF file, and the joints that are tied to others, or held where the figure says, rad or m.

    Joint positions are those of MuJoCo; a body with several joints has one joint of the model for each. A free body
    stands where the file puts it at the neutral configuration. Masses that depend on meshes are unknown; then the model
    has none at all.

    Args:
        path: the file.
        content: what is in it.
        label: what error messages call it.

    Raises:
        InvalidRobot: the file, or one that it includes, is too large or too deep, or something in it that moves bodies
            or joints makes no sense or is not understood; the message names it.
    """
    root = whole(path, content, label)
    read = Reader(root, label)
    bodies = read_bodies(root, read)
    tied = tied_joints(root, bodies, read)
    name = root.get("model", "")
    known_name = name if name.isprintable() and 0 < len(name) <= bounds.NAME else "robot"
    assembly = _Assembly(known_name, joint_efforts(root, read))
    _check_depth(bodies, read)
    inertias = [body.masses.inertia for body in bodies]
    masses_known = all(inertia is not None for inertia in inertias[1:])
    assembly.add_sites(bodies[0])
    for body, inertia in zip(bodies[1:], inertias[1:], strict=True):
        assembly.add(body, inertia if masses_known else pin.Inertia.Zero())
    assembly.model.gravity.linear = _gravity(root, read)
    _check(assembly.model, label)
    return assembly.model, tied


def _gravity(root: Element, read: Reader) -> np.ndarray:
    """(3,) acceleration of gravity, m/s^2; of several settings the last one counts."""
    gravity, works = np.array([0.0, 0.0, -9.81]), "enable"
    for option in root.iterfind("option"):
        if "gravity" in option.attrib:
            gravity = read.vector(option.attrib["gravity"], 3, "gravity of <option>")
        for flag in option.iterfind("flag"):
            works = flag.get("gravity", works)
    if works not in ("enable", "disable") or np.abs(gravity).max() > bounds.FARTHEST:
        raise read.fail("<option> has a gravity that makes no sense")
    return gravity if works == "enable" else np.zeros(3)


class _Assembly:
    """A model that grows by bodies, parents first."""

    def __init__(self, name: str, efforts: Mapping[str, float]) -> None:
        self.model = pin.Model()
        self._efforts = efforts
        self.model.name = name
        # The world has MuJoCo's name too, beside that which Pinocchio gives its first frame.
        world = self.model.addBodyFrame(WORLD, 0, pin.SE3.Identity(), 0)
        # For each body: the joint that carries it, its frame on this joint, and the index of its frame.
        self._placed: list[tuple[int, pin.SE3, int]] = [(0, pin.SE3.Identity(), world)]

    def add(self, body: Body, inertia: pin.Inertia) -> None:
        """Add a body with its joints and sites."""
        carrier, placement, frame = self._placed[body.parent]
        placement = placement * body.placement
        for joint in body.joints:
            carrier, placement = self._add_joint(joint, carrier, placement)
            frame = self.model.addJointFrame(carrier, frame)
        if not body.joints:
            fixed = pin.Frame(f"{body.name}_fixed", carrier, frame, placement, pin.FrameType.FIXED_JOINT)
            frame = self.model.addFrame(fixed)
        self.model.appendBodyToJoint(carrier, inertia, placement)
        frame = self.model.addBodyFrame(body.name, carrier, placement, frame)
        self._placed.append((carrier, placement, frame))
        self.add_sites(body)

    def add_sites(self, body: Body) -> None:
        """Add the sites of the body that was added last, or of the world before any is."""
        carrier, placement, frame = self._placed[-1]
        for name, place in body.sites:
            self.model.addFrame(pin.Frame(name, carrier, frame, placement * place, pin.FrameType.OP_FRAME))

    def _add_joint(self, joint: Joint, parent: int, placement: pin.SE3) -> tuple[int, pin.SE3]:
        """Add a joint; its index, and the frame of its body on it."""
        anchor = pin.SE3(np.eye(3), joint.anchor)
        place = placement * anchor
        if joint.kind == "hinge":
            place = place * pin.SE3(pin.AngleAxis(-joint.ref, joint.axis).toRotationMatrix(), np.zeros(3))
        elif joint.kind == "slide":
            place = place * pin.SE3(np.eye(3), -joint.ref * joint.axis)
        if joint.kind in ("hinge", "slide"):
            effort = min(joint.effort, self._efforts.get(joint.name, math.inf))
            figures = (effort, math.inf, joint.lower, joint.upper)
            limits = [np.array([figure]) for figure in figures]
            index = self.model.addJoint(parent, _sliding_or_turning(joint), place, joint.name, *limits)
        else:
            kind = pin.JointModelSpherical() if joint.kind == "ball" else pin.JointModelFreeFlyer()
            index = self.model.addJoint(parent, kind, place, joint.name)
        first = self.model.joints[index].idx_v
        for k in range(first, first + self.model.joints[index].nv):
            self.model.damping[k], self.model.armature[k] = joint.damping, joint.armature
            self.model.friction[k] = joint.friction
        return index, anchor.inverse()


def _sliding_or_turning(joint: Joint) -> pin.JointModel:
    for aligned, unit in zip(_ALIGNED[joint.kind], np.eye(3), strict=True):
        if np.array_equal(joint.axis, unit):
            return aligned()
    return _UNALIGNED[joint.kind](joint.axis)


def _check_depth(bodies: list[Body], read: Reader) -> None:
    depth = [0]
    for body in bodies[1:]:
        depth.append(depth[body.parent] + max(1, len(body.joints)))
    if max(depth) > bounds.CHAIN:
        raise read.fail(f"it has a chain of more than {bounds.CHAIN} joints, longer than is read")


def _check(model: pin.Model, label: str) -> None:
    """Check that every placement is a rigid transform within reach."""
    placements = [(frame.name, frame.placement) for frame in model.frames]
    for name, place in [*zip(model.names, model.jointPlacements, strict=True), *placements]:
        R = place.rotation
        if not np.abs(place.translation).max() <= bounds.FARTHEST:
            raise InvalidRobot(f"{label}: {quoted(name)} lies nowhere, or farther than {bounds.FARTHEST:g} m", label)
        if not np.abs(R.T @ R - np.eye(3)).max() <= _RIGID or not np.linalg.det(R) > 0.0:
            raise InvalidRobot(f"{label}: {quoted(name)} has an orientation that is no rotation", label)
