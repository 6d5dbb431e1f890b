"""Poses from position and quaternion, with the order of its four numbers named, or from the angles of a URDF."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable
from typing import Any, Literal, cast

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from srs_ik.errors import InvalidPose, quoted
from srs_ik.inputs.numbers import array_or_empty, real_array
from srs_ik.system.arrays import Array

Order = Literal["xyzw", "wxyz"]

_TO_XYZW = {"xyzw": [0, 1, 2, 3], "wxyz": [1, 2, 3, 0]}
_FROM_XYZW = {"xyzw": [0, 1, 2, 3], "wxyz": [3, 0, 1, 2]}

LENGTH_TOLERANCE = 1e-3
"""A quaternion written with four digits is still one; it is normalised."""


def pose_from_xyz_quaternion(xyz: ArrayLike, quaternion: ArrayLike, *, order: Order) -> pin.SE3:
    """A pose from a position and a unit quaternion.

    Args:
        xyz: (3,) metres.
        quaternion: (4,) unit quaternion, normalised if its length is within 0.001 of 1.
        order: "xyzw" with the scalar part last, as in ROS, SciPy and Pinocchio; "wxyz" with it first, as in MuJoCo and
            Eigen's constructor. There is no default, because a wrong order is a wrong rotation without an error.

    Raises:
        InvalidPose: not 3 and 4 finite numbers, a length that is not 1, or another order.
    """
    order = checked_order(order)
    position, q = _numbers(xyz, 3, "a position"), _numbers(quaternion, 4, "a quaternion")
    length = float(np.linalg.norm(q))
    if abs(length - 1.0) > LENGTH_TOLERANCE:
        raise InvalidPose(f"a quaternion is a rotation only if its length is 1, not {length:.6g}")
    return pin.SE3(pin.Quaternion(q[_TO_XYZW[order]] / length), position)


def pose_from_xyz_rpy(xyz: ArrayLike, rpy: ArrayLike) -> pin.SE3:
    """A pose from a position and the angles of a URDF; a warning says where these look like degrees.

    Args:
        xyz: (3,) metres.
        rpy: (3,) angles about the fixed x, then y, then z axis, rad.

    Raises:
        InvalidPose: not 3 and 3 finite numbers.
    """
    pose = pose_of_xyz_rpy(xyz, rpy)
    warn_of_degrees("rpy", real_array(rpy).tolist())
    return pose


def pose_of_xyz_rpy(xyz: ArrayLike, rpy: ArrayLike) -> pin.SE3:
    """The same for angles whose unit somebody else looks at."""
    position, angles = _numbers(xyz, 3, "a position"), _numbers(rpy, 3, "roll, pitch and yaw")
    return pin.SE3(pin.rpy.rpyToMatrix(*angles), position)


def warn_of_degrees(what: str, rpy: Iterable[float]) -> None:
    """Warn, naming what they belong to, where angles, which are in radians, are more than a turn."""
    largest = max(rpy, key=abs)
    if abs(largest) > 2.0 * math.pi:
        said = f"{what} is in radians, and {largest:g} rad is more than a turn: are these degrees?"
        warnings.warn(said, UserWarning, stacklevel=3)


def checked_order(order: Any) -> Order:
    """The order of a quaternion, "xyzw" or "wxyz"; raises InvalidPose for any other."""
    if not isinstance(order, str) or order not in _TO_XYZW:
        raise InvalidPose(f"the order of a quaternion is 'xyzw' or 'wxyz', not {quoted(order)}")
    return cast(Order, order)


def quaternion_of(R: Array, order: Order) -> Array:
    """(4,) unit quaternion of a rotation matrix (3, 3), the scalar part not negative."""
    q = pin.Quaternion(np.ascontiguousarray(R)).normalized().coeffs()
    return (q if q[3] >= 0.0 else -q)[_FROM_XYZW[order]]


def _numbers(values: ArrayLike, count: int, what: str) -> Array:
    array = array_or_empty(values)
    if array.shape != (count,) or not np.isfinite(array).all():
        given = quoted(values)
        if all(hasattr(values, axis) for axis in "xyzw"):
            given = f"{type(values).__name__}; [q.x, q.y, q.z, q.w] are, in the order 'xyzw'"
        raise InvalidPose(f"{what} is {count} finite numbers, not {given}")
    return array
