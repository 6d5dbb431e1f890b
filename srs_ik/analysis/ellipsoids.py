"""Ellipsoids of velocity and force at the tip, and the figures of merit that come from the same Jacobian.

All of them are singular values in disguise: with J = U S V', the velocities that joint velocities of norm 1 give the
tip fill the ellipsoid with semi-axes S along U, and the forces that joint torques of norm 1 hold the one with their
reciprocals. See T. Yoshikawa, Manipulability of Robotic Mechanisms, IJRR 4(2), 1985, and S. L. Chiu, Task Compatibility
of Manipulator Postures, IJRR 7(5), 1988.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from srs_ik.errors import InvalidTask, MissingLimits, quoted
from srs_ik.inputs.numbers import array_or_empty, real_array, what_is
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.kinematics import ChainKinematics

Part = Literal["linear", "angular", "full"]

RANK_TOLERANCE = 1e-10
"""A direction counts as singular where its singular value is below this share of the largest one: the Jacobian itself
is known to some 1e-15, and an arm that is stretched to 1e-10 rad is stretched."""

SMALLEST = 1e-300
"""Stands for a denominator of zero."""

_ROWS = {"linear": slice(0, 3), "angular": slice(3, 6), "full": slice(0, 6)}
UNITS: dict[str, dict[str, str]] = {
    "velocity": {"linear": "m/s", "angular": "rad/s", "full": "m/s, rad/s"},
    "force": {"linear": "N", "angular": "N m", "full": "N, N m"},
}


@dataclass(frozen=True, eq=False)
class Ellipsoid:
    """What the tip can do with joint velocities, or joint torques, of norm 1; with N Jacobians, N ellipsoids in arrays.

    Its points are axes @ (radii * u) for unit vectors u. The axes are ordered by ease of motion: the first is the one
    along which the tip moves fastest, and holds least. d is 3, or 6 for the part "full".

    Attributes:
        kind: "velocity" or "force".
        part: "linear", "angular" or "full" (six rows, linear first, metres and radians mixed).
        axes: (d, d) or (N, d, d) unit directions in columns; with d = 3 a rotation.
        radii: (d,) or (N, d) semi-axes, in `unit`: velocities from largest to smallest and exactly 0 along singular
            directions, forces from smallest to largest and inf along singular directions.
        rank: number of directions that are not singular; (N,) for N ellipsoids.
    """

    kind: Literal["velocity", "force"]
    part: Part
    axes: Array
    radii: Array
    rank: int | NDArray[np.int64]

    @property
    def singular(self) -> NDArray[np.bool_]:
        """(d,) or (N, d): which axes are singular, so that the tip cannot move along them at all."""
        return np.arange(self.radii.shape[-1]) >= np.expand_dims(self.rank, -1)

    @property
    def flat(self) -> bool | NDArray[np.bool_]:
        """Whether it is a velocity ellipsoid with a direction of zero extent."""
        return _plain(self.singular.any(axis=-1) & (self.kind == "velocity"))

    @property
    def unbounded(self) -> bool | NDArray[np.bool_]:
        """Whether it is a force ellipsoid with a direction in which the structure holds any force, without a torque."""
        return _plain(self.singular.any(axis=-1) & (self.kind == "force"))

    @property
    def unit(self) -> str:
        """Unit of the radii: m/s, rad/s, N or N m, for joint velocities of 1 rad/s, torques of 1 N m, or the limits."""
        return UNITS[self.kind][self.part]

    def radius_along(self, direction: ArrayLike) -> Any:
        """Distance from the centre to the surface along a direction: the transmission ratio of S. L. Chiu.

        Args:
            direction: (d,) or (N, d), of any length, in the axes of the ellipsoid.

        Returns:
            In `unit`; (N,) for N ellipsoids. Along a direction that leaves a flat ellipsoid it is 0, along a singular
            direction of a force ellipsoid it is inf.

        Raises:
            InvalidTask: not d finite numbers, or all zero.
        """
        u = _directions(direction, self.radii.shape[-1], "direction", self.radii.shape[:-1])
        components = np.einsum("...ji,...j->...i", self.axes, u)
        off, within = np.where(self.singular, components, 0.0), np.where(self.singular, 0.0, components)
        shares = np.divide(within, self.radii, out=np.zeros_like(within), where=~self.singular)
        length = np.linalg.norm(shares, axis=-1)
        if self.kind == "velocity":
            reached = (np.abs(off) <= RANK_TOLERANCE).all(axis=-1)
            return _plain(np.divide(1.0, length, out=np.zeros_like(length), where=reached))
        held = (np.abs(within) <= RANK_TOLERANCE).all(axis=-1)
        return _plain(np.divide(1.0, length, out=np.full_like(length, np.inf), where=~held))

    def in_axes(self, R_base_frame: ArrayLike) -> Ellipsoid:
        """The same ellipsoid with its axes written in another frame.

        Args:
            R_base_frame: (3, 3) or (N, 3, 3) rotation of that frame in the one that the axes are in now. With
                `arm.forward_kinematics(q).rotation`, an ellipsoid in base axes comes out in tip axes.

        Raises:
            InvalidTask: no rotation.
        """
        R = _numbers(R_base_frame, "R_base_frame must be a rotation, 3 x 3")
        if R.shape[-2:] != (3, 3) or R.ndim not in (2, 3) or (R.ndim == 3 and R.shape[:-2] != self.axes.shape[:-2]):
            raise InvalidTask(f"R_base_frame must be a rotation, 3 x 3, not an array of shape {R.shape}")
        if np.abs(R @ R.swapaxes(-1, -2) - np.eye(3)).max(initial=0.0) > 1e-6 or (np.linalg.det(R) < 0.0).any():
            raise InvalidTask("R_base_frame must be a rotation: R'R the identity to 1e-6, det R positive")
        blocks = [R.swapaxes(-1, -2) @ self.axes[..., rows, :] for rows in _halves(self.axes.shape[-1])]
        return replace(self, axes=np.concatenate(blocks, axis=-2))

    def __bool__(self) -> bool:
        return self.radii.ndim == 1 or len(self) > 0

    def __len__(self) -> int:
        if self.radii.ndim == 1:
            raise TypeError("this is one ellipsoid, not a sequence of them")
        return len(self.radii)

    def __getitem__(self, index: int) -> Ellipsoid:
        if self.radii.ndim == 1:
            raise TypeError("this is one ellipsoid, not a sequence of them")
        rank = np.asarray(self.rank)[index]
        return replace(self, axes=self.axes[index], radii=self.radii[index], rank=_plain(rank))

    def __iter__(self) -> Iterator[Ellipsoid]:
        return (self[i] for i in range(len(self)))

    def __repr__(self) -> str:
        what = f"{self.part} {self.kind}"
        if self.radii.ndim > 1:
            return f"<{len(self)} Ellipsoids of {what}>"
        note = " flat," if self.flat else " unbounded," if self.unbounded else ""
        return f"<Ellipsoid of {what},{note} radii {np.array2string(self.radii, precision=4)} {self.unit}>"


def velocity_ellipsoid(J: ArrayLike, limit: ArrayLike | None = None, part: Part = "linear") -> Ellipsoid:
    """Velocities of the tip for joint velocities of norm 1: xdot'(JJ')^-1 xdot = 1.

    Args:
        J: (6, 7) Jacobian, linear rows first, as of `Arm.jacobian`, or (N, 6, 7) of them.
        limit: (7,) joint velocity limits, rad/s, as in `arm.velocity_limit`. The joint velocities are then those with
            sum (qdot_i / limit_i)^2 = 1, which no joint passes its limit by.
        part: "linear" (tip point, m/s), "angular" (rad/s) or "full".

    Raises:
        MissingLimits: a limit is infinite, which means that the robot's description does not give it.
        InvalidTask: J, limit or part are malformed.
    """
    rows = _jacobian(J)[..., rows_of(part), :]
    axes, values, rank = _principal(rows * (np.ones(7) if limit is None else _limit(limit, "velocity")))
    return Ellipsoid("velocity", part, axes, values, rank)


def force_ellipsoid(J: ArrayLike, limit: ArrayLike | None = None, part: Part = "linear") -> Ellipsoid:
    """Forces that joint torques of norm 1 hold at the tip: h'(JJ')h = 1. Gravity is left out.

    Args:
        J: (6, 7) Jacobian, linear rows first, as of `Arm.jacobian`, or (N, 6, 7) of them.
        limit: (7,) joint torque limits, N m, as in `arm.effort_limit`. The torques are then those with
            sum (tau_i / limit_i)^2 = 1, which no joint passes its limit by.
        part: "linear" (force at the tip point without a moment, N), "angular" (moment alone, N m) or "full".

    Raises:
        MissingLimits: a limit is infinite, which means that the robot's description does not give it.
        InvalidTask: J, limit or part are malformed.
    """
    rows = _jacobian(J)[..., rows_of(part), :]
    axes, values, rank = _principal(rows / (np.ones(7) if limit is None else _limit(limit, "effort")))
    reciprocals = np.divide(1.0, values, out=np.full_like(values, np.inf), where=values > 0.0)
    return Ellipsoid("force", part, axes, reciprocals, rank)


def velocity_transmission(
    J: ArrayLike, direction: ArrayLike, limit: ArrayLike | None = None, part: Part = "linear"
) -> Any:
    """Velocity transmission ratio along a direction: (u'(JJ')^-1 u)^-1/2, in m/s or rad/s.

    Arguments, errors and the treatment of singular directions are those of `velocity_ellipsoid` and
    `Ellipsoid.radius_along`.
    """
    return velocity_ellipsoid(J, limit, part).radius_along(direction)


def force_transmission(
    J: ArrayLike, direction: ArrayLike, limit: ArrayLike | None = None, part: Part = "linear"
) -> Any:
    """Force transmission ratio along a direction: (u'JJ'u)^-1/2, in N or N m.

    Arguments, errors and the treatment of singular directions are those of `force_ellipsoid` and
    `Ellipsoid.radius_along`.
    """
    return force_ellipsoid(J, limit, part).radius_along(direction)


def manipulability(J: ArrayLike, part: Part = "full") -> Any:
    """Manipulability sqrt(det JJ') of T. Yoshikawa: the product of the semi-axes of the ellipsoid without limits.

    That is of `velocity_ellipsoid` of joint velocities of norm 1 rad/s; with limits the product is ``radii.prod()``.

    Args:
        J: (6, 7) Jacobian, or (N, 6, 7) of them.
        part: "full" (m^3), "linear" (m^3) or "angular" (1).

    Returns:
        A number, or (N,); exactly 0 at a singular posture.

    Raises:
        InvalidTask: J or part are malformed.
    """
    return _plain(np.prod(velocity_ellipsoid(J, None, part).radii, axis=-1))


def isotropy(J: ArrayLike, part: Part = "linear") -> Any:
    """Smallest semi-axis of the velocity ellipsoid without limits over the largest: 1 for a sphere, 0 where singular.

    Args:
        J: (6, 7) Jacobian, or (N, 6, 7) of them.
        part: "linear", "angular" or "full" (which depends on the unit of length).

    Returns:
        A number, or (N,).

    Raises:
        InvalidTask: J or part are malformed.
    """
    radii = velocity_ellipsoid(J, None, part).radii
    return _plain(radii[..., -1] / np.maximum(radii[..., 0], SMALLEST))


def force_velocity_ratio(J: ArrayLike, force: ArrayLike, velocity: ArrayLike) -> Any:
    """The paper's C = (f'JpJp'f) / (v'JpJp'v), with Jp the linear rows of J: low is good.

    Args:
        J: (6, 7) Jacobian, or (N, 6, 7) of them.
        force: (3,) or (N, 3) direction of the force, of any length, in the axes of J.
        velocity: (3,) or (N, 3) direction of the velocity, likewise.

    Returns:
        A number, or (N,); huge, or inf, where the tip cannot move along the velocity, and inf where it can move along
        neither, up to rounding.

    Raises:
        InvalidTask: J, force or velocity are malformed, or a direction is zero.

    Source: C. Tiseo, S. R. Charitos, M. Mistry, Geometrical Postural Optimisation of 7-DoF Limb-Like Manipulators.
    """
    Jp = _jacobian(J)[..., :3, :]
    # The ratio is that of any multiple of J; of this one, no square is too large or too small for a number.
    Jp /= np.maximum(np.abs(Jp).max(axis=(-2, -1), keepdims=True), SMALLEST)
    f, v = _directions(force, 3, "force", Jp.shape[:-2]), _directions(velocity, 3, "velocity", Jp.shape[:-2])
    effort, ease = (np.sum(np.einsum("...i,...ij->...j", u, Jp) ** 2, axis=-1) for u in (f, v))
    # Where both are rounding, so is their ratio.
    neither = np.maximum(effort, ease) <= RANK_TOLERANCE**2 * np.sum(Jp**2, axis=(-2, -1))
    with np.errstate(over="ignore"):
        return _plain(np.where(neither, np.inf, effort / np.maximum(ease, SMALLEST)))


def rows_of(part: str) -> slice:
    """The rows of a Jacobian that a part is made of; raises InvalidTask where there is no such part."""
    if not isinstance(part, str) or part not in _ROWS:
        raise InvalidTask(f"part is 'linear', 'angular' or 'full', not {quoted(part)}")
    return _ROWS[part]


def limits_of(arm: ChainKinematics, kind: Literal["velocity", "effort"]) -> Array:
    """The (7,) velocity limits, rad/s, or effort limits, N m, of an arm whose description gives all of them.

    Raises:
        MissingLimits: it does not; the error has the names of the joints.
    """
    given = arm.velocity_limit if kind == "velocity" else arm.effort_limit
    missing = [name for name, limit in zip(arm.joint_names, given, strict=True) if not np.isfinite(limit)]
    if missing:
        raise MissingLimits(kind, missing, arm.name)
    return given


def _principal(J: Array) -> tuple[Array, Array, int | NDArray[np.int64]]:
    """Left singular vectors in columns, singular values (exactly 0 beyond the rank), and the rank."""
    axes, values, _ = np.linalg.svd(J, full_matrices=False)
    values[values <= RANK_TOLERANCE * values[..., :1]] = 0.0
    # An axis and its negative are the same: the largest component is positive, and three axes are right-handed.
    largest = np.take_along_axis(axes, np.abs(axes).argmax(axis=-2)[..., None, :], axis=-2)
    axes = axes * np.where(largest < 0.0, -1.0, 1.0)
    if axes.shape[-1] == 3:
        axes[..., 2] *= np.where(np.linalg.det(axes) < 0.0, -1.0, 1.0)[..., None]
    return axes, values, _plain(np.count_nonzero(values, axis=-1))


def _halves(size: int) -> list[slice]:
    """The rows that turn together: the three of a vector, or the two threes of a twist or wrench."""
    return [slice(i, i + 3) for i in range(0, size, 3)]


def _jacobian(J: ArrayLike) -> Array:
    expected = "J must be a Jacobian, 6 x 7, or N of them"
    if hasattr(J, "jacobian"):
        raise InvalidTask(f"{expected}, not {type(J).__name__}; arm.jacobian(q) gives it")
    array = _numbers(J, expected)
    if array.ndim not in (2, 3) or array.shape[-2:] != (6, 7):
        raise InvalidTask(f"{expected}, not an array of shape {array.shape}")
    return array


def _limit(limit: ArrayLike, kind: str) -> Array:
    array = array_or_empty(limit)
    if array.shape != (7,) or not (array > 0.0).all():
        raise InvalidTask(f"limit must be 7 positive numbers, one for each joint, not {quoted(limit)}")
    if not np.isfinite(array).all():
        raise MissingLimits(kind, [f"joint {i}" for i in np.flatnonzero(np.isinf(array)) + 1])
    return array


def _directions(value: ArrayLike, size: int, what: str, many: tuple[int, ...]) -> Array:
    """Vectors of any length, scaled to length 1: one, or as many as there are Jacobians."""
    expected = f"{what} must be {size} numbers" + (f", or {many[0]} times {size}" if many else f", or N times {size}")
    vectors = _numbers(value, expected)
    if vectors.ndim not in (1, 2) or vectors.shape[-1] != size or (many and vectors.shape[:-1] not in ((), many)):
        raise InvalidTask(f"{expected}, not an array of shape {vectors.shape}")
    largest = np.abs(vectors).max(axis=-1, keepdims=True)
    if (largest == 0.0).any():
        raise InvalidTask(f"{what} must not be zero: it gives a direction")
    vectors /= largest
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def _numbers(value: ArrayLike, expected: str) -> Array:
    try:
        array = real_array(value)
    except (TypeError, ValueError):
        raise InvalidTask(f"{expected}, not {what_is(value)}") from None
    if not np.isfinite(array).all():
        raise InvalidTask(f"{expected}, but has entries that are not finite numbers")
    return array


def _plain(value: Any) -> Any:
    """A Python number for one, an array for many."""
    array = np.asarray(value)
    return array.item() if array.ndim == 0 else array
