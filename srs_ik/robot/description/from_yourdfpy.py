"""A ``yourdfpy.URDF`` as URDF elements, without the digits that its own XML writer loses.

That writer turns every origin into Euler angles in a way that loses half of the digits near a pitch of 90 degrees, and
needs lxml; here each rotation goes through angles that rebuild it to rounding.
"""

from __future__ import annotations

import math
from typing import Any
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from srs_ik.errors import InvalidRobot


def elements(urdf: Any, source: str) -> Element:
    """Links and joints of a ``yourdfpy.URDF`` as an element `<robot>`, unchecked; the robot itself is not changed.

    Raises:
        InvalidRobot: it holds no robot, or an origin is no rigid transform.
    """
    robot = urdf.robot
    if robot is None:
        raise InvalidRobot(f"{source} holds no robot", source)
    root = Element("robot", _given(name=robot.name))
    for link in robot.links:
        element = SubElement(root, "link", _given(name=link.name))
        inertial = link.inertial
        if inertial is not None and inertial.mass is not None and inertial.inertia is not None:
            inner = SubElement(element, "inertial")
            _add_origin(inner, inertial.origin, f"{source}: the inertia of link {link.name!r}", source)
            SubElement(inner, "mass", _given(value=inertial.mass))
            (ixx, ixy, ixz), (_, iyy, iyz), (_, _, izz) = inertial.inertia
            SubElement(inner, "inertia", _given(ixx=ixx, ixy=ixy, ixz=ixz, iyy=iyy, iyz=iyz, izz=izz))
    for joint in robot.joints:
        element = SubElement(root, "joint", _given(name=joint.name, type=joint.type))
        SubElement(element, "parent", _given(link=joint.parent))
        SubElement(element, "child", _given(link=joint.child))
        _add_origin(element, joint.origin, f"{source}: joint {joint.name!r}", source)
        if joint.axis is not None:
            SubElement(element, "axis", {"xyz": _spelled(joint.axis)})
        limit = joint.limit
        if limit is not None:
            given = _given(effort=limit.effort, velocity=limit.velocity, lower=limit.lower, upper=limit.upper)
            SubElement(element, "limit", given)
        dynamics = joint.dynamics
        if dynamics is not None:
            SubElement(element, "dynamics", _given(damping=dynamics.damping, friction=dynamics.friction))
        if joint.mimic is not None:
            mimic = joint.mimic
            SubElement(element, "mimic", _given(joint=mimic.joint, multiplier=mimic.multiplier, offset=mimic.offset))
    return root


def roll_pitch_yaw(R: np.ndarray) -> tuple[float, float, float]:
    """Angles, rad, whose rotation Rz(yaw) Ry(pitch) Rx(roll) is R (3, 3) to rounding, at any pitch.

    At a pitch of 90 degrees only the sum or difference of roll and yaw is determined. Whatever yaw comes out, roll is
    measured after it is taken away, so the error of the one is not the error of the whole.
    """
    yaw = math.atan2(R[1, 0], R[0, 0])
    c, s = math.cos(yaw), math.sin(yaw)
    pitch = math.atan2(-R[2, 0], c * R[0, 0] + s * R[1, 0])
    roll = math.atan2(s * R[0, 2] - c * R[1, 2], c * R[1, 1] - s * R[0, 1])
    return roll, pitch, yaw


def _add_origin(parent: Element, origin: Any, where: str, source: str) -> None:
    if origin is None:
        return
    T = np.asarray(origin, dtype=float)
    if (
        T.shape != (4, 4)
        or not np.abs(T[:3, :3].T @ T[:3, :3] - np.eye(3)).max() < 1e-6
        or np.linalg.det(T[:3, :3]) < 0
    ):
        raise InvalidRobot(f"{where} has an origin that is no rigid transform", source)
    SubElement(parent, "origin", {"xyz": _spelled(T[:3, 3]), "rpy": _spelled(roll_pitch_yaw(T[:3, :3]))})


def _given(**attributes: Any) -> dict[str, str]:
    """The attributes that are not None, as text; numbers to their last digit."""
    return {
        key: value if isinstance(value, str) else repr(float(value))
        for key, value in attributes.items()
        if value is not None
    }


def _spelled(values: Any) -> str:
    return " ".join(repr(float(value)) for value in values)
