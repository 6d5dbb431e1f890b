"""Poses and joint vectors as callers give them, checked and brought to plain arrays."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple, TypeGuard

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from srs_ik.errors import InvalidConfiguration, InvalidPose, SrsIkError, quoted, warn_caller
from srs_ik.inputs.messages import pose_matrix
from srs_ik.inputs.numbers import real_array, real_number, what_is
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

TURN = 2.0 * math.pi
FAR = 4.0 * TURN
"""Arm angles beyond four turns, rad, are probably degrees; of joint angles whose norm is more, each is looked at."""

_TURNS = "the arm angle is in radians, and is more than four turns: are these degrees?"

FARTHEST_FROM_ROTATION = 0.1
"""How much a matrix may stretch to be taken for a rotation with errors."""

_OF_QUATERNION = "pose_from_xyz_quaternion(xyz, quaternion, order=...) makes one of position and quaternion"
_MAKERS = {
    (3,): "; pose_from_xyz_rpy(xyz, [0, 0, 0]) makes one of a position",
    (6,): "; pose_from_xyz_rpy(xyz, rpy) makes one of two vectors",
    (7,): f"; {_OF_QUATERNION}",
    (4, 4): "; [pose] is a list of one",
    (3, 3): "; pinocchio.SE3(R, xyz) makes one of a rotation and a position",
}
"""What makes a pose of an array of another shape."""

_MANY_POSES = "; solve_batch, intervals_batch, reachable_batch and solve_path take many"
_MANY = {
    "q": "; forward_kinematics_batch and jacobian_batch take many",
    "seed": "; solve_batch takes one for each pose",
}
"""What takes N times 7 joint angles where one argument takes 7."""


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


def _is_plain(values: Any) -> TypeGuard[Array]:
    """Whether a kernel can read an array as it is: floats in C order, in writeable memory."""
    return type(values) is np.ndarray and values.dtype is _FLOAT and values.flags.carray


def _floats(values: Any, shape: tuple[int | None, ...], what: str) -> Array:
    try:
        array = values if _is_plain(values) else real_array(values)
    except (TypeError, ValueError):
        raise InvalidPose(f"{what}, not {what_is(values)}{_maker(values)}") from None
    if array.ndim != len(shape) or any(n is not None and n != m for n, m in zip(shape, array.shape, strict=True)):
        raise InvalidPose(f"{what}, not {what_is(values)}{_maker(values, array.shape)}")
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


def as_joint_vector(q: ArrayLike, what: str = "q", limits: tuple[Array, Array] | None = None) -> Array:
    """Seven finite joint angles as a (7,) array of floats; raises InvalidConfiguration for anything else.

    With limits, (7,) lower and (7,) upper, rad, a warning says where angles look like degrees.
    """
    try:
        array = real_array(q)
    except (TypeError, ValueError):
        raise _no_angles(f"{what} must be 7 joint angles", q) from None
    if array.shape != (7,):
        many = _MANY.get(what, "") if array.ndim == 2 and array.shape[1] == 7 else ""
        raise _no_angles(f"{what} must be 7 joint angles", q, many)
    norm = math.hypot(*array.tolist())
    if not norm < FAR:
        if not math.isfinite(norm):
            raise InvalidConfiguration(f"{what} has entries that are not finite numbers")
        if limits is not None:
            _warn_of_degrees(array, what, *limits)
    return array


def _no_angles(expected: str, given: Any, many: str = "") -> InvalidConfiguration:
    """The error where joint angles are expected, with where they are in what was given."""
    hint = many
    if isinstance(given, Mapping) or (hasattr(given, "name") and hasattr(given, "position")):
        hint = "; arm.joint_vector(state) takes them out of a joint state"
    elif hasattr(given, "q"):
        hint = "; give its q"
    return InvalidConfiguration(f"{expected}, not {what_is(given)}{hint}")


def _warn_of_degrees(angles: Array, what: str, lower: Array, upper: Array) -> None:
    """Warn of joint angles (..., 7), where one is more than a turn outside the limits of its joint."""
    outside = np.maximum(lower - angles, angles - upper).reshape(-1, 7).max(axis=0)
    if outside.max() > TURN:
        joint = int(outside.argmax()) + 1
        warn_caller(f"{what} has joint {joint} more than a turn outside its limits, in radians: are these degrees?")


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
        array = q if _is_plain(q) else real_array(q if isinstance(q, np.ndarray | str | Mapping) else list(q))
    except (TypeError, ValueError):
        raise _no_angles(f"{what} must be N times 7 joint angles", q) from None
    if array.shape == (0,):
        return np.empty((0, 7))
    if array.ndim != 2 or array.shape[1] != 7:
        raise _no_angles(f"{what} must be N times 7 joint angles", q)
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
    """Raise the error for seeds (..., 7) that are nowhere near the joint limits (7,), rad, or warn of degrees.

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
    _warn_of_degrees(seeds, "seed", lower, upper)


def as_seed(seed: ArrayLike, lower: Array, upper: Array) -> Array:
    """A posture to stay near, as a (7,) array of floats; `lower` and `upper` are the joint limits (7,), rad.

    Raises:
        InvalidConfiguration: not seven finite angles, or nowhere near the limits.
    """
    array = as_joint_vector(seed, "seed")
    norm = math.hypot(*array.tolist())
    # Joints without end may be many turns away, and are not to wait for what lies far outside its limits.
    if norm > FAR and (norm > FARTHEST_SEED or max((lower - array).tolist() + (array - upper).tolist()) > TURN):
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
    if array.size and max(-array.min(), array.max()) > TURN:
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


def as_arm_angle(arm_angle: Any) -> float:
    """A finite arm angle up to `LARGEST_ANGLE`; raises InvalidConfiguration for anything else."""
    value = real_number(arm_angle)
    if not abs(value) <= FAR:
        if not abs(value) <= LARGEST_ANGLE:
            given = quoted(arm_angle)
            many = "; solve_batch takes one for each pose" if isinstance(arm_angle, list | tuple | np.ndarray) else ""
            raise InvalidConfiguration(
                f"the arm angle must be a finite number of radians, up to {LARGEST_ANGLE:g}, not {given}{many}"
            )
        warn_caller(_TURNS)
    return value


def as_branch(branch: Any) -> int:
    """A branch number from 0 to 7, or -1 for any; raises InvalidConfiguration for anything else."""
    if branch is None:
        return -1
    if isinstance(branch, bool | np.timedelta64) or not isinstance(branch, int | np.integer) or not 0 <= branch <= 7:
        many = "; solve_batch takes one for each pose" if isinstance(branch, list | tuple | np.ndarray) else ""
        raise InvalidConfiguration(f"a branch is an integer from 0 to 7, not {quoted(branch)}{many}")
    return int(branch)


def as_branches(branches: Any, n: int) -> NDArray[np.int64]:
    """Branch numbers (n,) from 0 to 7; raises InvalidConfiguration for anything else."""
    try:
        array = np.asarray(branches)
    except ValueError:
        array = np.empty(0, object)
    if array.shape != (n,) or (n and array.dtype.kind not in "iu") or not ((array >= 0) & (array <= 7)).all():
        raise InvalidConfiguration(
            f"branch is an integer from 0 to 7, or {n} of them, one for each pose, not {quoted(branches)}"
        )
    return array.astype(np.int64)


def per_pose(value: ArrayLike, shape: tuple[int, ...], n: int, what: str) -> Array:
    """One angle, or array of them, for all poses as an array of length 1, or one a pose; plain arrays are not copied.

    Raises:
        InvalidConfiguration: of another shape, not numbers, not finite, or beyond `LARGEST_ANGLE`; `what` names the
            argument.
    """
    try:
        array = value if _is_plain(value) else real_array(value)
    except (TypeError, ValueError):
        array = np.empty((0, 0))
    if array.shape == shape:
        array = array[None]
    if array.shape not in ((1, *shape), (n, *shape)):
        if shape:
            raise _no_angles(f"{what} must be 7 joint angles, or {n} times 7, one row for each pose", value)
        expected = f"a number of radians, or {n} of them, one for each pose"
        raise InvalidConfiguration(f"{what} must be {expected}, not {what_is(value)}")
    if array.size:
        # Two passes, and no other array of its size; a NaN is neither.
        lowest, highest = array.min(), array.max()
        if not (lowest >= -LARGEST_ANGLE and highest <= LARGEST_ANGLE):
            refuse_bad_angles(array, what)
        if not shape and max(-lowest, highest) > FAR:
            warn_caller(_TURNS)
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
