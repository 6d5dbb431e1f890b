"""Polytopes: every velocity and every force of the tip that the arm's own joint limits leave, corners and all.

The half-spaces and a point inside them are pycapacity's (A. Skuric, V. Padois, D. Daney, Pycapacity: a real-time
task-space capacity calculation package for robotics and biomechanics, JOSS 8(89), 2023), the corners Qhull's. They are
given each problem in the principal axes of the Jacobian, with joint limits of -1 and 1: there a posture next to a
singularity is as well conditioned as any other, and one at a singularity is a problem of fewer dimensions.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from srs_ik.analysis.ellipsoids import RANK_TOLERANCE, UNITS, limits_of, rows_of
from srs_ik.analysis.gravity import gravity_torque
from srs_ik.errors import InvalidConfiguration, InvalidTask, MissingExtra, quoted
from srs_ik.inputs.angles import as_joint_vector
from srs_ik.inputs.numbers import array_or_empty, as_flag, as_positive
from srs_ik.kinematics import ChainKinematics, check_arm
from srs_ik.system.arrays import Array

SAME = 1e-9
"""Corners nearer than this are one, and a polytope thinner than this is empty, in units of the joints' half ranges."""


@dataclass(frozen=True, eq=False)
class Polytope:
    """What the tip can do within the joint limits, in base axes.

    Attributes:
        kind: "velocity" or "force".
        part: "linear" or "angular".
        vertices: (n, 3) corners, in `unit`.
        faces: (m, 3) triangles as indices of vertices, counter-clockwise seen from outside. A polytope with two
            dimensions is one polygon, cut into triangles; one with a single dimension is a line without any.
        rank: number of dimensions that are not singular, 0 to 3.
        singular: (3, 3 - rank) unit directions in columns. A velocity polytope is flat across them. A force polytope is
            unbounded along them, and what is given is its section perpendicular to them.
        normals: (m, 3) unit vectors, and
        offsets: (m,) in `unit`: every point x of the polytope has normals @ x <= offsets; those of no face may be among
            them.

    A force polytope without vertices is empty: the joint torques do not suffice to hold the arm itself up.
    """

    kind: Literal["velocity", "force"]
    part: Literal["linear", "angular"]
    vertices: Array
    faces: NDArray[np.int64]
    rank: int
    singular: Array
    normals: Array
    offsets: Array

    @property
    def flat(self) -> bool:
        """Whether it is a velocity polytope with a direction of zero extent."""
        return self.kind == "velocity" and self.rank < 3

    @property
    def unbounded(self) -> bool:
        """Whether it is a force polytope with a direction in which the structure holds any force."""
        return self.kind == "force" and self.rank < 3

    @property
    def empty(self) -> bool:
        """Whether there is no force at all at which the joint torques are within their limits."""
        return len(self.vertices) == 0

    @property
    def unit(self) -> str:
        """Unit of the vertices: m/s, rad/s, N or N m."""
        return UNITS[self.kind][self.part]

    def extent_along(self, direction: ArrayLike) -> float:
        """The largest component along a direction, (3,) of any length, in `unit`; inf where unbounded, -inf if empty.

        Parts across the direction are free: as a pure force or velocity along it, it may be too large; see
        `radius_along`.

        Raises:
            InvalidTask: not 3 finite numbers, or all zero.
        """
        u = _unit(direction)
        if self.empty:
            return -np.inf
        if self.unbounded and np.linalg.norm(u @ self.singular) > RANK_TOLERANCE:
            return np.inf
        return float((self.vertices @ u).max())

    def radius_along(self, direction: ArrayLike) -> float:
        """The largest pure force, or velocity, along a direction, (3,) of any length: one without any part across it.

        Returns:
            In `unit`; 0 along a direction that leaves a flat polytope, inf along a singular direction of a force
            polytope, -inf where no multiple of the direction is within the polytope. Limits that leave out zero may
            leave negative multiples alone: the answer is that nearest zero.

        Raises:
            InvalidTask: not 3 finite numbers, or all zero.
        """
        u = _unit(direction)
        if self.empty:
            return -np.inf
        slack = SAME * np.abs(self.vertices).max()
        least, most = -np.inf, np.inf
        off = u @ self.singular
        if self.kind == "velocity":
            # Of a flat polytope the line meets the plane once, unless it lies in the plane; or it never does.
            lifted = self.vertices[0] @ self.singular
            if np.linalg.norm(off) > RANK_TOLERANCE:
                least = most = float(lifted @ off / (off @ off))
                lifted = lifted - most * off
            if np.linalg.norm(lifted) > slack:
                return -np.inf
        elif np.linalg.norm(u - self.singular @ off) <= RANK_TOLERANCE:
            return np.inf if (self.offsets >= -slack).all() else -np.inf
        slope = self.normals @ u
        beside = np.abs(slope) <= RANK_TOLERANCE
        if (self.offsets[beside] < -slack).any():
            return -np.inf
        ends = self.offsets / np.where(beside, 1.0, slope)
        most = min(most, ends[~beside & (slope > 0.0)].min(initial=np.inf))
        least = max(least, ends[~beside & (slope < 0.0)].max(initial=-np.inf))
        return float(most) if least <= most + slack else -np.inf

    def __repr__(self) -> str:
        note = ", empty" if self.empty else ", flat" if self.flat else ", unbounded" if self.unbounded else ""
        return f"<Polytope of {self.part} {self.kind}{note}: {len(self.vertices)} vertices, {len(self.faces)} faces>"


def velocity_polytope(
    arm: ChainKinematics,
    q: ArrayLike,
    part: Literal["linear", "angular"] = "linear",
    lower: ArrayLike | None = None,
    upper: ArrayLike | None = None,
    horizon: float | None = None,
) -> Polytope:
    """Every velocity of the tip that the joint velocity limits allow: {J qdot : lower <= qdot <= upper}.

    Args:
        arm: the arm.
        q: (7,) joint angles, rad.
        part: "linear" (of the tip point, m/s) or "angular" (rad/s).
        lower: (7,) least joint velocities, rad/s; -`upper` if not given.
        upper: (7,) largest joint velocities, rad/s; `arm.velocity_limit` if not given.
        horizon: seconds that every joint has to keep its velocity for, without passing a joint limit; a joint at its
            limit can only go back. Without it, joint limits do not count.

    Raises:
        MissingLimits: the arm's description does not give the velocity limits of all joints, nor does the caller.
        InvalidConfiguration: not 7 finite angles, or, with a horizon, outside the joint limits.
        InvalidTask: part, limits or horizon are malformed.
        MissingExtra: pycapacity is not installed.
    """
    check_arm(arm)
    q = as_joint_vector(q)
    least, most = _bounds(arm, "velocity", lower, upper)
    if horizon is not None:
        least, most = _within_horizon(arm, q, least, most, horizon)
    J = arm.jacobian(q)[_rows_of(part)]
    middle, half = 0.5 * (most + least), 0.5 * (most - least)
    U, stretch, V, rank = _principal(J * half)
    H, d = _image_of_the_cube(V)
    return _lifted("velocity", part, H, d, U, stretch, rank, J @ middle)


def force_polytope(
    arm: ChainKinematics,
    q: ArrayLike,
    part: Literal["linear", "angular"] = "linear",
    lower: ArrayLike | None = None,
    upper: ArrayLike | None = None,
    gravity: bool = True,
) -> Polytope:
    """Every force that the tip can exert at rest within the joint torque limits: {h : lower <= J'h + g(q) <= upper}.

    Args:
        arm: the arm.
        q: (7,) joint angles, rad.
        part: "linear" (force at the tip point without a moment, N) or "angular" (moment without a force, N m).
        lower: (7,) least joint torques, N m; -`upper` if not given.
        upper: (7,) largest joint torques, N m; `arm.effort_limit` if not given.
        gravity: whether the torques have to carry the arm as well, g(q) by Pinocchio.

    Raises:
        MissingLimits: the arm's description does not give the torque limits of all joints, nor does the caller.
        InvalidConfiguration: not 7 finite angles.
        InvalidTask: part or limits are malformed, the description has no masses, or the arm cannot hold itself up
            whatever the force.
    """
    check_arm(arm)
    q = as_joint_vector(q)
    least, most = _bounds(arm, "effort", lower, upper)
    if (least == most).any():
        raise InvalidTask("a force polytope needs lower torque limits that are below the upper ones")
    weighs = as_flag(gravity, "gravity", InvalidTask)
    load = gravity_torque(arm, "gravity=False leaves its weight out")(q) if weighs else np.zeros(7)
    J = arm.jacobian(q)[_rows_of(part)]
    middle, half = 0.5 * (most + least), 0.5 * (most - least)
    U, stretch, V, rank = _principal(J / half)
    bias = (load - middle) / half
    H, d = np.vstack([V.T, -V.T]), np.concatenate([1.0 - bias, 1.0 + bias])
    return _lifted("force", part, H, d, U, 1.0 / stretch, rank, np.zeros(3))


def _unit(direction: ArrayLike) -> Array:
    """A direction of length 1; raises InvalidTask where it is none."""
    u = array_or_empty(direction)
    if u.shape != (3,) or not np.isfinite(u).all() or not u.any():
        raise InvalidTask("direction must be 3 finite numbers that are not all zero")
    u /= np.abs(u).max()
    return np.asarray(u / np.linalg.norm(u))


def _principal(J: Array) -> tuple[Array, Array, Array, int]:
    """U (3, 3), and the r singular values and r rows of V' (r, 7) that are not those of singular directions."""
    U, values, V = np.linalg.svd(J, full_matrices=False)
    rank = int(np.count_nonzero(values > RANK_TOLERANCE * values[0]))
    return U, values[:rank], V[:rank], rank


def _image_of_the_cube(V: Array) -> tuple[Array, Array]:
    """Half-spaces H (m, r), d (m,), H y <= d, of all V u with components of u in [-1, 1]."""
    if len(V) < 2:
        return np.vstack([np.eye(len(V)), -np.eye(len(V))]), np.tile(np.abs(V).sum(axis=1), 2)
    limit = np.ones(V.shape[1])
    H, d = _pycapacity().hyper_plane_shift_method(V, -limit, limit)
    return np.asarray(H), np.ravel(d)


def _corners(H: Array, d: Array) -> Array:
    """Corners (n, r) of the bounded set H y <= d; none if it is empty."""
    size = H.shape[1]
    # A joint that no direction loads, as joint 7 by a force on its axis, is kept everywhere or nowhere.
    idle = np.linalg.norm(H, axis=1) < SAME
    if (d[idle] < -SAME).any():
        return np.empty((0, size))
    H, d = H[~idle], d[~idle]
    if size == 0:
        return np.zeros((1, 0))
    if size == 1:
        ends = d / H[:, 0]
        first, last = ends[H[:, 0] < 0.0].max(), ends[H[:, 0] > 0.0].min()
        return np.array([[first], [last]]) if last - first > SAME else np.empty((0, 1))
    from scipy.spatial import HalfspaceIntersection, QhullError

    inside = _middle(H, d)
    if inside is None:
        return np.empty((0, size))
    half_spaces = np.column_stack([H, -d])
    try:
        found = HalfspaceIntersection(half_spaces, inside).intersections
    except QhullError:
        # Faces that are parallel but for rounding: moved apart by as much, they have corners.
        found = HalfspaceIntersection(half_spaces, inside, qhull_options="QJ").intersections
    # Where more faces than necessary meet in a corner, it comes several times.
    distance = np.linalg.norm(found[:, None] - found[None], axis=-1)
    return found[np.unique((distance < SAME).argmax(axis=1))]


def _middle(H: Array, d: Array) -> Array | None:
    """(r,) the centre of the largest ball in the bounded set H y <= d; None if there is none, or a tiny one."""
    from scipy.optimize import linprog

    size = H.shape[1]
    lengths = np.linalg.norm(H, axis=1)
    cost = np.r_[np.zeros(size), -1.0]
    found = linprog(cost, np.column_stack([H, lengths]), d, bounds=[(None, None)] * (size + 1), method="highs")
    if found.x is None:
        return None
    centre: Array = found.x[:size]
    # The radius as it is, not as the solver has it: that may be off by its tolerance.
    return centre if ((d - H @ centre) / lengths).min() > SAME else None


def _lifted(
    kind: Literal["velocity", "force"],
    part: Literal["linear", "angular"],
    H: Array,
    d: Array,
    U: Array,
    stretch: Array,
    rank: int,
    centre: Array,
) -> Polytope:
    """The polytope H y <= d of principal axes, brought to base axes."""
    from scipy.spatial import ConvexHull

    corners = _corners(H, d)
    used, faces = np.arange(len(corners)), np.empty((0, 3), np.int64)
    if rank > 1 and len(corners):
        hull = ConvexHull(corners)
        used = np.sort(hull.vertices)
        if rank == 2:
            first, *rest = hull.vertices
            faces = np.array([(first, b, c) for b, c in pairwise(rest)])
        else:
            faces = hull.simplices.astype(np.int64)
            a, b, c = (corners[faces[:, k]] for k in range(3))
            outwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) > 0.0
            turned = outwards != (np.linalg.det(U) > 0.0)
            faces[turned] = faces[turned][:, ::-1]
        faces = np.searchsorted(used, faces)
    vertices = centre + (corners[used] * stretch) @ U[:, :rank].T
    normals = (H / stretch) @ U[:, :rank].T
    lengths = np.linalg.norm(H / stretch, axis=1)
    loaded = np.linalg.norm(H, axis=1) >= SAME
    normals = normals[loaded] / lengths[loaded, None]
    offsets = d[loaded] / lengths[loaded] + normals @ centre
    return Polytope(kind, part, vertices, faces, rank, U[:, rank:], normals, offsets)


def _bounds(arm: ChainKinematics, kind: Literal["velocity", "effort"], lower: Any, upper: Any) -> tuple[Array, Array]:
    """(7,) least and (7,) largest joint velocities or torques."""
    most = limits_of(arm, kind) if upper is None else _seven(upper, "upper")
    least = -most if lower is None else _seven(lower, "lower")
    if (least > most).any():
        raise InvalidTask("lower must not be above upper, for any joint")
    return least, most


def _seven(values: Any, what: str) -> Array:
    array = array_or_empty(values)
    if array.shape != (7,) or not np.isfinite(array).all():
        raise InvalidTask(f"{what} must be 7 finite numbers, one for each joint, not {quoted(values)}")
    return array


def _within_horizon(arm: ChainKinematics, q: Array, least: Array, most: Array, horizon: Any) -> tuple[Array, Array]:
    """The joint velocities of these that pass no joint limit in that time."""
    horizon = as_positive(horizon, "horizon", "seconds", InvalidTask)
    below, above = q - arm.lower, arm.upper - q
    for name, room in zip(arm.joint_names, np.minimum(below, above), strict=True):
        if room < -SAME:
            raise InvalidConfiguration(f"{name} is outside its limits by {-room:.3g} rad: no velocity is within them")
    least, most = (
        np.maximum(least, -np.maximum(below, 0.0) / horizon),
        np.minimum(most, np.maximum(above, 0.0) / horizon),
    )
    if (least > most).any():
        raise InvalidTask("lower must not be above what the horizon leaves of upper, for any joint")
    return least, most


def _rows_of(part: str) -> slice:
    rows = rows_of(part)
    if part == "full":
        raise InvalidTask("part of a polytope is 'linear' or 'angular'; 'full' is for ellipsoids")
    return rows


def _pycapacity() -> Any:
    try:
        from pycapacity import algorithms
    except ImportError:
        raise MissingExtra("polytopes", "a polytope") from None
    return algorithms
