"""Poses and joint vectors as callers give them, checked and brought to plain arrays."""

from __future__ import annotations

import math
from typing import Any, NamedTuple, TypeGuard

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from srs_ik.errors import InvalidConfiguration, InvalidPose, SrsIkError, quoted
from srs_ik.inputs.messages import pose_matrix
from srs_ik.inputs.numbers import real_array, real_number
from srs_ik.inputs.rotations import Order, checked_order, quaternion_of
from srs_ik.kernels.entries.pose import check_pose
from srs_ik.kernels.layout.answer import FARTHEST, NOT_A_ROTATION, NOT_FINITE, TOO_FAR
from srs_ik.system.arrays import Array

PoseLike = Any
"""A `pinocchio.SE3`, anything that NumPy reads as a 4 x 4 array, or an object like a pose of geometry_msgs."""

_FLOAT = np.dtype(np.float64)

LARGEST_ANGLE = 1e6
"""Largest arm angle, and joint angle of a seed, rad: beyond it, rounding alone passes what an answer may be off."""

LARGEST_GRAVITY = 1e6
"""m/s^2; torques of larger ones are no figures of an arm."""

FARTHEST_SEED = 300.0
"""So far outside its limits a joint of a seed may be, rad; one that is farther was hardly meant in radians."""

FARTHEST_FROM_ROTATION = 0.1
"""How much a matrix may stretch to be taken for a rotation with errors."""

_MAKERS = {
    (3,): "; pose_from_xyz_rpy(xyz, [0, 0, 0]) makes one of a position",
    (6,): "; pose_from_xyz_rpy(xyz, rpy) makes one of two vectors",
    (7,): "; pose_from_xyz_quaternion(xyz, quaternion, order=...) makes one of two vectors",
}
"""What makes a pose of an array of another shape."""


class PoseError(NamedTuple):
    """How far a posture is from a pose."""

    position: float
    """Metres."""
    orientation: float
    """Rad."""


def as_matrix(pose: PoseLike) -> Array:
    """A pose as a (4, 4) array of floats, C-ordered and writeable. Whether it is a rigid transform is checked later.

    Raises:
        InvalidPose: not 4 x 4, or not numbers.
    """
    if type(pose) is np.ndarray and pose.dtype is _FLOAT and pose.shape == (4, 4) and pose.flags.carray:
        return pose
    if isinstance(pose, pin.SE3):
        return pose.homogeneous
    if not isinstance(pose, np.ndarray):
        T = pose_matrix(pose)
        if T is not None:
            return T
    return _floats(pose, (4, 4), "a pose is a pinocchio.SE3, a 4 x 4 array or a geometry_msgs pose")


def as_matrices(poses: Any) -> Array:
    """Many poses as an (N, 4, 4) array; a list of `pinocchio.SE3` or of messages will do, and so will a PoseArray.

    An array of floats in C order and writeable is not copied.

    Raises:
        InvalidPose: not N x 4 x 4, or not numbers.
    """
    if not isinstance(poses, np.ndarray) and not isinstance(poses, pin.SE3):
        listed = getattr(poses, "poses", poses)
        try:
            if isinstance(listed, str | bytes):
                raise TypeError
            each = iter(listed)
        except TypeError:
            raise InvalidPose(f"poses are an (N, 4, 4) array or a list of poses, not {type(poses).__name__}") from None
        poses = list(each)
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


def _is_plain(values: Any) -> TypeGuard[Array]:
    """Whether a kernel can read an array as it is: floats in C order, in writeable memory."""
    return type(values) is np.ndarray and values.dtype is _FLOAT and values.flags.carray


def _floats(values: Any, shape: tuple[int | None, ...], what: str) -> Array:
    try:
        array = values if _is_plain(values) else real_array(values)
    except (TypeError, ValueError):
        raise InvalidPose(f"{what}, not {type(values).__name__}") from None
    if array.ndim != len(shape) or any(n is not None and n != m for n, m in zip(shape, array.shape, strict=True)):
        hint = _MAKERS.get(array.shape, "")
        raise InvalidPose(f"{what}, not an array of shape {array.shape}{hint}")
    return array


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


def as_joint_vector(q: ArrayLike, what: str = "q") -> Array:
    """Seven finite joint angles as a (7,) array of floats; raises InvalidConfiguration for anything else."""
    try:
        array = real_array(q)
    except (TypeError, ValueError):
        raise InvalidConfiguration(f"{what} must be 7 joint angles, not {type(q).__name__}") from None
    if array.shape != (7,):
        raise InvalidConfiguration(f"{what} must be 7 joint angles, not an array of shape {array.shape}")
    if not math.isfinite(math.hypot(*array.tolist())):
        raise InvalidConfiguration(f"{what} has entries that are not finite numbers")
    return array


def as_bounded_joint_vector(q: ArrayLike) -> Array:
    """`as_joint_vector` for kernels, whose sines and cosines end at `LARGEST_ANGLE`."""
    array = as_joint_vector(q)
    refuse_bad_angles(array, "q")
    return array


def as_joint_vectors(q: Any, what: str = "q") -> Array:
    """Many configurations as an (N, 7) array of floats in C order; a plain array is not copied.

    Raises:
        InvalidConfiguration: not N x 7, not numbers, not finite, or beyond `LARGEST_ANGLE`.
    """
    try:
        array = q if _is_plain(q) else real_array(q if isinstance(q, np.ndarray | str) else list(q))
    except (TypeError, ValueError):
        raise InvalidConfiguration(f"{what} must be N times 7 joint angles, not {type(q).__name__}") from None
    if array.shape == (0,):
        return np.empty((0, 7))
    if array.ndim != 2 or array.shape[1] != 7:
        raise InvalidConfiguration(f"{what} must be N times 7 joint angles, not an array of shape {array.shape}")
    refuse_bad_angles(array, what)
    return array


def refuse_bad_angles(angles: Array, what: str) -> None:
    """Raise InvalidConfiguration for angles of any shape of which one is not finite, or beyond `LARGEST_ANGLE`."""
    largest = float(np.abs(angles).max(initial=0.0))
    if not math.isfinite(largest):
        raise InvalidConfiguration(f"{what} has entries that are not finite numbers")
    if largest > LARGEST_ANGLE:
        raise InvalidConfiguration(f"{what} has an angle of {largest:g} rad; they end at {LARGEST_ANGLE:g} rad")


def refuse_far_seeds(seeds: Array, lower: Array, upper: Array) -> None:
    """Raise the error for seeds (..., 7) that are nowhere near the joint limits (7,), rad.

    Raises:
        InvalidConfiguration: a joint is outside them by more than `FARTHEST_SEED`, or beyond `LARGEST_ANGLE`.
    """
    refuse_bad_angles(seeds, "seed")
    outside = np.maximum(lower - seeds, seeds - upper).reshape(-1, 7).max(axis=0, initial=0.0)
    if outside.max() > FARTHEST_SEED:
        joint = int(outside.argmax())
        raise InvalidConfiguration(
            f"seed has joint {joint + 1} {outside[joint]:.6g} rad outside its limits; angles are in radians"
        )


def as_seed(seed: ArrayLike, lower: Array, upper: Array) -> Array:
    """A posture to stay near, as a (7,) array of floats; `lower` and `upper` are the joint limits (7,), rad.

    Raises:
        InvalidConfiguration: not seven finite angles, or nowhere near the limits.
    """
    array = as_joint_vector(seed, "seed")
    if math.hypot(*array.tolist()) > FARTHEST_SEED:
        refuse_far_seeds(array, lower, upper)
    return array


NO_SEED, NO_SEEDS = np.zeros(7), np.empty((0, 7))
"""What kernels get that ask for a seed, or for seeds, where there is none."""


def as_seeds(seeds: ArrayLike | None, n: int, lower: Array, upper: Array) -> Array:
    """`as_seed` for n poses: (0, 7), (1, 7) or (n, 7), of none, one for all or one a pose; plain arrays are not copied.

    Raises:
        InvalidConfiguration: of another shape, not finite angles, or nowhere near the limits.
    """
    if seeds is None:
        return NO_SEEDS
    array = per_pose(seeds, (7,), n, "seed")
    if array.size and max(-array.min(), array.max()) > FARTHEST_SEED:
        refuse_far_seeds(array, lower, upper)
    return array


def seed_of(seeds: Array, i: int) -> Array | None:
    """The seed of pose i among those of `as_seeds`."""
    return seeds[i if len(seeds) > 1 else 0] if len(seeds) else None


def as_positive(value: Any, what: str, unit: str, error: type[SrsIkError] = InvalidConfiguration) -> float:
    """A finite number above zero; raises the error, in which `what` names it, for anything else, True among it."""
    number = math.nan if isinstance(value, bool | np.bool_) else real_number(value)
    if not 0.0 < number < math.inf:
        raise error(f"{what} must be a positive number of {unit}, not {quoted(value)}")
    return number


def as_gravity(gravity: ArrayLike) -> Array:
    """The acceleration of gravity as a (3,) array of floats.

    Raises:
        InvalidConfiguration: not three finite numbers, or one beyond `LARGEST_GRAVITY`.
    """
    try:
        array = real_array(gravity)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != (3,) or not np.abs(array).max() <= LARGEST_GRAVITY:
        usual = f"m/s^2, up to {LARGEST_GRAVITY:g}, such as [0, 0, -9.81]"
        raise InvalidConfiguration(f"gravity must be 3 numbers, {usual}, not {quoted(gravity)}")
    return array


def as_arm_angle(arm_angle: float) -> float:
    """A finite arm angle up to `LARGEST_ANGLE`; raises InvalidConfiguration for anything else."""
    value = real_number(arm_angle)
    if not abs(value) <= LARGEST_ANGLE:
        given = quoted(arm_angle)
        raise InvalidConfiguration(
            f"the arm angle must be a finite number of radians, up to {LARGEST_ANGLE:g}, not {given}"
        )
    return value


def as_branch(branch: int | None) -> int:
    """A branch number from 0 to 7, or -1 for any; raises InvalidConfiguration for anything else."""
    if branch is None:
        return -1
    if isinstance(branch, bool | np.timedelta64) or not isinstance(branch, int | np.integer) or not 0 <= branch <= 7:
        raise InvalidConfiguration(f"a branch is an integer from 0 to 7, not {quoted(branch)}")
    return int(branch)


def per_pose(value: ArrayLike, shape: tuple[int, ...], n: int, what: str) -> Array:
    """One angle, or array of them, for all poses as an array of length 1, or one a pose; plain arrays are not copied.

    Raises:
        InvalidConfiguration: of another shape, not numbers, not finite, or beyond `LARGEST_ANGLE`; `what` names the
            argument.
    """
    try:
        array = value if _is_plain(value) else real_array(value)
    except (TypeError, ValueError):
        array = np.full((), np.nan)
    if array.shape == shape:
        array = array[None]
    if array.shape not in ((1, *shape), (n, *shape)):
        expected = f"{shape} or {(n, *shape)}" if shape else f"a number or an array of {n}"
        raise InvalidConfiguration(f"{what} must be finite, {expected}, not of shape {array.shape}")
    # Two passes, and no other array of its size; a NaN is neither.
    if array.size and not (array.min() >= -LARGEST_ANGLE and array.max() <= LARGEST_ANGLE):
        refuse_bad_angles(array, what)
    return array


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
