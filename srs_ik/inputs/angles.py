"""Joint angles, arm angles and branches as callers give them, checked and brought to plain arrays."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from srs_ik.errors import InvalidConfiguration, quoted, warn_caller
from srs_ik.inputs.numbers import is_plain, real_array, real_number, what_is
from srs_ik.system.arrays import Array

LARGEST_ANGLE = 1e6
"""Largest arm angle, and joint angle of a seed, rad: beyond it, rounding alone passes what an answer may be off."""

FARTHEST_SEED = 300.0
"""So far outside its limits a joint of a seed may be, rad; one that is farther was hardly meant in radians."""

TURN = 2.0 * math.pi

FAR = 4.0 * TURN
"""Arm angles beyond four turns, rad, are probably degrees; of joint angles whose norm is more, each is looked at."""

_TURNS = "the arm angle is in radians, and is more than four turns: are these degrees?"

_MANY = {
    "q": "; forward_kinematics_batch and jacobian_batch take many",
    "seed": "; solve_batch takes one for each pose",
}
"""What takes N times 7 joint angles where one argument takes 7."""


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


def as_joint_vectors(q: Any) -> Array:
    """Many configurations as an (N, 7) array of floats in C order; a plain array is not copied.

    Raises:
        InvalidConfiguration: not N x 7, not numbers, not finite, or beyond `LARGEST_ANGLE`.
    """
    try:
        whole = isinstance(q, np.ndarray | memoryview | str | Mapping)
        array = q if is_plain(q) else real_array(q if whole else list(q))
    except Exception:  # of the object's own making
        raise _no_angles("q must be N times 7 joint angles", q) from None
    if array.shape == (0,):
        return np.empty((0, 7))
    if array.ndim != 2 or array.shape[1] != 7:
        raise _no_angles("q must be N times 7 joint angles", q)
    refuse_bad_angles(array, "q")
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
        array = value if is_plain(value) else real_array(value)
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
