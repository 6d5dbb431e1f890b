"""Objects that look like messages of ROS, told by their fields alone: no package of ROS is needed.

A pose has ``position`` and ``orientation``, a transform ``translation`` and ``rotation``; their stamped forms hold them
as ``pose`` or ``transform``; an array of poses has ``poses``. A joint state has ``name`` and ``position``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from srs_ik.errors import InvalidConfiguration, did_you_mean, listed
from srs_ik.inputs.rotations import pose_from_xyz_quaternion
from srs_ik.system.arrays import Array

_OUTER = ("pose", "transform")
_DEEPEST = 2
"""A PoseWithCovarianceStamped holds a pose in a pose."""

_PARTS = (("position", "orientation"), ("translation", "rotation"))


def pose_matrix(message: Any) -> Array | None:
    """(4, 4) pose of a message, or None for an object that is none.

    The frame in the header of a stamped message is not looked at: the pose has to be in the base frame.

    Raises:
        InvalidPose: its figures are no pose.
    """
    for _ in range(_DEEPEST):
        message = next((getattr(message, outer) for outer in _OUTER if hasattr(message, outer)), message)
    for where, turn in _PARTS:
        p, q = getattr(message, where, None), getattr(message, turn, None)
        if all(hasattr(p, axis) for axis in "xyz") and all(hasattr(q, axis) for axis in "xyzw"):
            xyz, quaternion = [getattr(p, axis) for axis in "xyz"], [getattr(q, axis) for axis in "xyzw"]
            T: Array = pose_from_xyz_quaternion(xyz, quaternion, order="xyzw").homogeneous
            return T
    return None


def positions_by_name(state: Any) -> dict[str, Any]:
    """Joint positions by name, of a mapping or of an object with `name` and `position`.

    Raises:
        InvalidConfiguration: it is neither, its names and positions differ in number, or a joint has two positions.
    """
    if isinstance(state, Mapping):
        return dict(state)
    names, positions = getattr(state, "name", None), getattr(state, "position", None)
    if not isinstance(names, Iterable) or isinstance(names, str) or not isinstance(positions, Iterable):
        kind = type(state).__name__
        raise InvalidConfiguration(f"a joint state is a mapping or has the fields name and position, unlike a {kind}")
    names, positions = list(names), list(positions)
    if len(names) != len(positions):
        raise InvalidConfiguration(f"the joint state has {len(names)} names and {len(positions)} positions")
    found = dict(zip(names, positions, strict=True))
    for name, position in zip(names, positions, strict=True) if len(found) < len(names) else ():
        # By what they look like: NaN is not equal to itself, and anything may stand there.
        if repr(found[name]) != repr(position):
            raise InvalidConfiguration(f"the joint state has two positions of {name!r}: {position} and {found[name]}")
    return found


def picked(positions: Mapping[str, Any], joint_names: Iterable[str]) -> list[Any]:
    """The positions of some joints, in their order; raises InvalidConfiguration where one is missing."""
    known = [str(name) for name in positions]
    for name in joint_names:
        if name not in positions:
            hint = did_you_mean(name, known)
            raise InvalidConfiguration(f"the joint state lacks {name!r}{hint}; it has {listed(known) or 'no joint'}")
    return [positions[name] for name in joint_names]
