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


def pose_from_xyz_quaternion(xyz: ArrayLike, quaternion: ArrayLike, *, order: Order) -> Any:
    """A pose from a position and a unit quaternion, or N of them, such as columns of a table.

    Args:
        xyz: (3,) or (N, 3) metres.
        quaternion: (4,) or (N, 4) unit quaternions, normalised if their length is within 0.001 of 1.
        order: "xyzw" with the scalar part last, as in ROS, SciPy and Pinocchio; "wxyz" with it first, as in MuJoCo and
            Eigen's constructor. There is no default, because a wrong order is a wrong rotation without an error.

    Returns:
        A `pinocchio.SE3`, or an (N, 4, 4) array.

    Raises:
        InvalidPose: not 3 and 4 finite numbers or N of each, a length that is not 1, or another order.
    """
    order = checked_order(order)
    count = _count_of(quaternion)
    position, q = _numbers(xyz, 3, "a position", count), _numbers(quaternion, 4, "a quaternion", count)
    # The square of 1e200 is no float.
    with np.errstate(over="ignore"):
        lengths = np.linalg.norm(q, axis=-1, keepdims=True)
    far = np.abs(lengths.ravel() - 1.0) > LENGTH_TOLERANCE
    if far.any():
        k = int(far.argmax())
        which = "a quaternion" if count is None else f"quaternion {k} of {count}"
        raise InvalidPose(f"{which} is a rotation only if its length is 1, not {math.hypot(*np.atleast_2d(q)[k]):.6g}")
    q = q[..., _TO_XYZW[order]] / lengths
    if count is None:
        return pin.SE3(pin.Quaternion(q), position)
    from scipy.spatial.transform import Rotation

    return _poses(Rotation.from_quat(q).as_matrix() if count else np.empty((0, 3, 3)), position)


def pose_from_xyz_rpy(xyz: ArrayLike, rpy: ArrayLike) -> Any:
    """A pose from a position and the angles of a URDF, or N of them; a warning says where these look like degrees.

    Args:
        xyz: (3,) or (N, 3) metres.
        rpy: (3,) or (N, 3) angles about the fixed x, then y, then z axis, rad.

    Returns:
        A `pinocchio.SE3`, or an (N, 4, 4) array.

    Raises:
        InvalidPose: not 3 and 3 finite numbers, or N of each.
    """
    pose = pose_of_xyz_rpy(xyz, rpy)
    warn_of_degrees("rpy", real_array(rpy).ravel().tolist())
    return pose


def pose_of_xyz_rpy(xyz: ArrayLike, rpy: ArrayLike) -> Any:
    """The same for angles whose unit somebody else looks at."""
    count = _count_of(rpy)
    position, angles = _numbers(xyz, 3, "a position", count), _numbers(rpy, 3, "roll, pitch and yaw", count)
    if count is None:
        return pin.SE3(pin.rpy.rpyToMatrix(*angles), position)
    from scipy.spatial.transform import Rotation

    return _poses(Rotation.from_euler("xyz", angles).as_matrix() if count else np.empty((0, 3, 3)), position)


def _poses(R: Array, position: Array) -> Array:
    """(N, 4, 4) poses of rotations (N, 3, 3) and positions (N, 3)."""
    T = np.zeros((len(position), 4, 4))
    T[:, :3, :3], T[:, :3, 3], T[:, 3, 3] = R, position, 1.0
    return T


def _count_of(values: Any) -> int | None:
    """How many rotations are given; None for one."""
    array = array_or_empty(values)
    return len(array) if array.ndim == 2 else None


def warn_of_degrees(what: str, rpy: Iterable[float]) -> None:
    """Warn, naming what they belong to, where angles, which are in radians, are more than a turn."""
    largest = max(rpy, key=abs, default=0.0)
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


def _numbers(values: ArrayLike, size: int, what: str, count: int | None) -> Array:
    """(size,) finite numbers, or (count, size)."""
    array = array_or_empty(values)
    if count is not None and (array.shape != (count, size) or not np.isfinite(array).all()):
        given = f"of shape {array.shape}" if array.shape != (count, size) else "with entries that are not finite"
        raise InvalidPose(f"{what} is {size} finite numbers, and here there are {count}: not an array {given}")
    if count is None and (array.shape != (size,) or not np.isfinite(array).all()):
        given = quoted(values)
        if all(hasattr(values, axis) for axis in "xyzw"):
            given = f"{type(values).__name__}; [q.x, q.y, q.z, q.w] are, in the order 'xyzw'"
        raise InvalidPose(f"{what} is {size} finite numbers, not {given}")
    return array
