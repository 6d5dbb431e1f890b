"""Poses as callers give them, checked and brought to plain arrays."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from srs_ik.errors import InvalidPose
from srs_ik.inputs.messages import pose_matrix
from srs_ik.inputs.numbers import FLOAT, is_plain, real_array, what_is
from srs_ik.inputs.rotations import Order, checked_order, quaternion_of
from srs_ik.kernels.entries.pose import check_pose
from srs_ik.kernels.layout.answer import FARTHEST, NOT_A_ROTATION, NOT_FINITE, TOO_FAR
from srs_ik.system.arrays import Array

PoseLike = Any
"""A `pinocchio.SE3`, anything that NumPy reads as a 4 x 4 array, or an object like a pose of geometry_msgs."""

FARTHEST_FROM_ROTATION = 0.1
"""How much a matrix may stretch to be taken for a rotation with errors."""

_OF_QUATERNION = "pose_from_xyz_quaternion(xyz, quaternion, order=...) makes one of position and quaternion"

_MAKERS = {
    (3,): "; pose_from_xyz_rpy(xyz, rpy) makes one",
    (6,): "; pose_from_xyz_rpy(xyz, rpy) makes one of two vectors",
    (7,): f"; {_OF_QUATERNION}",
    (4, 4): "; [pose] is a list of one",
    (3, 3): "; pinocchio.SE3(R, xyz) makes one of a rotation and a position",
}
"""What makes a pose of an array of another shape."""

OR_FREE = ", whose rotation free_axis='any' leaves free"
"""What `as_matrix` adds to that for a position alone, where there is an argument `free_axis`."""

_MANY_POSES = "; solve_batch, intervals_batch, reachable_batch and solve_path take many"


class PoseError(NamedTuple):
    """How far a posture is from a pose."""

    position: float
    """Metres."""
    orientation: float
    """Rad."""


def as_matrix(pose: PoseLike, of_position: str = "") -> Array:
    """A pose as a (4, 4) array of floats, C-ordered and writeable. Whether it is a rigid transform is checked later.

    Args:
        pose: the pose.
        of_position: what the message for a position alone ends with.

    Raises:
        InvalidPose: not 4 x 4, or not numbers.
    """
    if type(pose) is np.ndarray and pose.dtype is FLOAT and pose.shape == (4, 4) and pose.flags.carray:
        return pose
    if isinstance(pose, pin.SE3):
        return pose.homogeneous
    if not isinstance(pose, np.ndarray):
        T = pose_matrix(pose)
        if T is not None:
            return T
    return _floats(pose, (4, 4), "a pose is a pinocchio.SE3, a 4 x 4 array or a geometry_msgs pose", of_position)


def as_target(pose: PoseLike) -> Array:
    """The same of a target that may be lost: for a message whose figures are no pose, what is no rigid transform.

    Raises:
        InvalidPose: nothing like a pose.
    """
    if not isinstance(pose, np.ndarray | pin.SE3):
        try:
            pose_matrix(pose)
        except InvalidPose:
            return np.full((4, 4), np.nan)
    return as_matrix(pose, OR_FREE)


def as_matrices(poses: Any) -> Array:
    """Many poses as an (N, 4, 4) array; a list of `pinocchio.SE3` or of messages will do, and so will a PoseArray.

    An array of floats in C order and writeable is not copied.

    Raises:
        InvalidPose: not N x 4 x 4, or not numbers.
    """
    if not isinstance(poses, np.ndarray | memoryview | pin.SE3):
        listed = getattr(poses, "poses", poses)
        try:
            if isinstance(listed, str | bytes | Mapping):
                raise TypeError
            each = list(listed)
        except Exception:  # of the object's own making
            said = f"poses are an (N, 4, 4) array or a list of poses, not {what_is(poses)}"
            raise InvalidPose(f"{said}{_maker(poses)}") from None
        poses = each
        if any(isinstance(pose, pin.SE3) or _is_message(pose) for pose in poses):
            poses = np.stack([as_matrix(pose) for pose in poses])
        elif not poses:
            return np.empty((0, 4, 4))
    return _floats(poses, (None, 4, 4), "poses are an (N, 4, 4) array")


def _is_message(pose: Any) -> bool:
    return any(hasattr(pose, field) for field in ("position", "translation", "pose", "transform"))


def as_rigid_matrix(pose: PoseLike) -> Array:
    """A pose as a (4, 4) array; raises InvalidPose for what is no rigid transform."""
    T = as_matrix(pose)
    verdict = check_pose(T)
    if verdict:
        raise invalid_pose(verdict)
    return T


def nearest_pose(matrix: Any) -> pin.SE3:
    """The pose nearest to a matrix whose rotation is one up to rounding or noise, as in files and from sensors.

    Args:
        matrix: (4, 4) array, or anything else that is taken for a pose. The lengths of the axes in its rotation may be
            off by up to 10 %.

    Returns:
        The same position, and the rotation that is nearest in the sum of squared differences (by SVD).

    Raises:
        InvalidPose: not 4 x 4, not finite, or no pose by more than that: scaled, mirrored, or of another last row.

    Source: P. H. Schoenemann, A generalized solution of the orthogonal Procrustes problem, Psychometrika 31, 1966.
    """
    T = as_matrix(matrix)
    if not np.isfinite(T).all():
        raise invalid_pose(NOT_FINITE)
    if np.abs(T[3] - (0.0, 0.0, 0.0, 1.0)).max() > NOT_A_ROTATION:
        raise InvalidPose(f"the last row of a pose is 0 0 0 1, not {' '.join(f'{x:.6g}' for x in T[3])}")
    U, stretch, V = np.linalg.svd(T[:3, :3])
    if np.linalg.det(U @ V) < 0.0:
        raise InvalidPose("the matrix mirrors: its axes are left-handed")
    if np.abs(stretch - 1.0).max() > FARTHEST_FROM_ROTATION:
        lengths = ", ".join(f"{x:.4g}" for x in stretch)
        raise InvalidPose(f"the matrix is far from a rotation: it stretches by {lengths}, where a pose has 1, 1, 1")
    return pin.SE3(U @ V, T[:3, 3].copy())


def _floats(values: Any, shape: tuple[int | None, ...], what: str, of_position: str = "") -> Array:
    try:
        array = values if is_plain(values) else real_array(values)
    except (TypeError, ValueError):
        raise InvalidPose(f"{what}, not {what_is(values)}{_maker(values)}") from None
    if array.ndim != len(shape) or any(n is not None and n != m for n, m in zip(shape, array.shape, strict=True)):
        end = of_position if array.shape == (3,) else ""
        raise InvalidPose(f"{what}, not {what_is(values)}{_maker(values, array.shape)}{end}")
    return array


def _maker(values: Any, shape: tuple[int, ...] = ()) -> str:
    """What makes a pose of what was given, or takes it, as the end of a message."""
    if isinstance(values, list | tuple) and any(isinstance(each, pin.SE3) or _is_message(each) for each in values):
        return _MANY_POSES
    if shape[1:] == (4, 4):
        return _MANY_POSES
    if isinstance(values, pin.SE3):
        return _MAKERS[4, 4]
    if isinstance(values, Mapping) or all(hasattr(values, axis) for axis in "xyzw"):
        return f"; {_OF_QUATERNION}"
    return _MAKERS.get(shape, "")


def invalid_pose(verdict: int, where: str = "") -> InvalidPose:
    """The error for a verdict of `kernels.entries.read_pose`; `where` names the pose among many."""
    if verdict == NOT_FINITE:
        return InvalidPose(f"the pose{where} has entries that are not finite numbers")
    if verdict == TOO_FAR:
        return InvalidPose(f"the pose{where} is farther away than {FARTHEST:g} m")
    return InvalidPose(
        f"the pose{where} is no rigid transform: R'R must be the identity to 1e-6, det R positive, the last row 0 0 0 1"
        "; srs_ik.nearest_pose(matrix) makes one of a matrix that is nearly one"
    )


def refuse_bad_poses(verdicts: NDArray[np.signedinteger]) -> None:
    """Raise InvalidPose for the first of many poses that is no finite rigid transform."""
    if verdicts.any():
        bad = int((verdicts != 0).argmax())
        raise invalid_pose(int(verdicts[bad]), f" {bad} of {len(verdicts)}")


def xyz_quaternion(pose: Any, *, order: Order) -> tuple[Array, Array]:
    """Position and unit quaternion of a pose, the scalar part not negative.

    Args:
        pose: a `pinocchio.SE3` or a (4, 4) array.
        order: as for `pose_from_xyz_quaternion`.

    Returns:
        (3,) metres and (4,).

    Raises:
        InvalidPose: the pose is no finite rigid transform, or another order.
    """
    order = checked_order(order)
    T = as_rigid_matrix(pose)
    return T[:3, 3].copy(), quaternion_of(T[:3, :3], order)
