"""Recognition: is a chain of seven revolute joints an S-R-S limb, and which one?

Only the joint axes count, taken as lines. Where a description puts the joint origins along them, and what it calls the
joints, plays no part.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from srs_ik.robot.limb import CLOSED_MISS, EXACT_MISS, SrsLimb, Vector, WristKind, line_distance, line_foot

NEAR_MISS_RATIO = 0.025
"""Largest miss of an axis that is still near, as a part of the length shoulder-elbow-wrist."""

ROUNDED_LEAN = 1e-5
"""An elbow axis that leans by less than this, rad, is across the arm, written with six digits or so."""

MIN_SINE = 0.05
"""Smallest sine of the angle between consecutive axes of a spherical joint (about 3 degrees)."""


@dataclass(frozen=True, eq=False)
class Recognition:
    """What seven axes amount to."""

    kind: Literal["exact", "near", "refused"]  # "exact" (all misses under 1e-6 m), "near", or "refused"
    misses: Vector  # (7,) distance of each axis from its centre, metres; zero for axis 4
    elbow_offset: float  # larger distance of the elbow centre from axes 3 and 5 where these run along the arm, metres
    limb: SrsLimb | None  # the limb, or None if refused
    allowed: float  # largest miss that would still be accepted, metres
    reason: str  # one clause that says why it is refused, empty otherwise. Axes are numbered from 1.


def recognise(axes: Vector, points: Vector, T_base_tip_zero: Vector, reference: Vector | None = None) -> Recognition:
    """Classify seven joint axes at the zero configuration, all in the base frame.

    Misses are measured from the points nearest to axes 1 to 3, and 5 to 7, in the least-squares sense. The centres are
    the feet of these points on axes 1 and 7: so the shoulder centre rests in the base and the wrist centre in the hand,
    whatever axes miss. The elbow may lie anywhere on axis 4 (an elbow offset is no obstacle), and directions are
    arbitrary.

    Args:
        axes: (7, 3) directions, of any length.
        points: (7, 3) a point on each axis, metres.
        T_base_tip_zero: (4, 4) pose of the tip frame.
        reference: (3,) direction for the zero of the arm angle; axis 1 if not given.

    Returns:
        The recognition, with the limb unless refused. Never raises for a chain that is no S-R-S limb.
    """
    points = np.array(points, dtype=float)
    lengths = np.linalg.norm(axes, axis=1)
    if not (np.isfinite(points).all() and np.isfinite(lengths).all() and lengths.min() > 0.0):
        return _refused("an axis has no direction")
    axes = np.asarray(axes, dtype=float) / lengths[:, None]

    for i, j in ((0, 1), (1, 2), (4, 5), (5, 6)):
        if np.linalg.norm(np.cross(axes[i], axes[j])) < MIN_SINE:
            return _refused(f"axes {i + 1} and {j + 1} are parallel")

    inner, outer = _nearest_point(axes[:3], points[:3]), _nearest_point(axes[4:], points[4:])
    shoulder, wrist = line_foot(inner, points[0], axes[0]), line_foot(outer, points[6], axes[6])
    misses = np.zeros(7)
    for i in range(7):
        if i != 3:
            misses[i] = line_distance(inner if i < 3 else outer, points[i], axes[i])
    elbow = _elbow_centre(axes, points, shoulder, wrist)
    if misses.max() < CLOSED_MISS:
        elbow = _on_the_line(elbow, axes[3], shoulder, wrist)

    direction = default_reference(axes[0]) if reference is None else np.asarray(reference, dtype=float)
    limb = SrsLimb(
        axes=axes,
        points=points,
        T_base_tip_zero=np.array(T_base_tip_zero, dtype=float),
        shoulder=shoulder,
        elbow=elbow,
        wrist=wrist,
        reference=direction / np.linalg.norm(direction),
        misses=misses,
        wrist_kind=_wrist_kind(axes),
    )
    reach = limb.upper_arm + limb.forearm
    worst = int(misses.argmax())
    allowed = max(EXACT_MISS, NEAR_MISS_RATIO * reach)
    if misses[worst] >= allowed:
        centre = "shoulder" if worst < 3 else "wrist"
        reason = f"axis {worst + 1} misses the {centre} centre by {1e3 * misses[worst]:.1f} mm"
        return Recognition("refused", misses, limb.elbow_offset, None, allowed, reason)
    if min(line_distance(shoulder, points[3], axes[3]), line_distance(wrist, points[3], axes[3])) < 1e-3 * max(
        reach, 1e-9
    ):
        reason = "axis 4 passes through the shoulder or wrist centre"
        return Recognition("refused", misses, limb.elbow_offset, None, allowed, reason)
    return Recognition(limb.kind, misses, limb.elbow_offset, limb, allowed, "")


def _refused(reason: str) -> Recognition:
    return Recognition("refused", np.full(7, np.nan), math.nan, None, math.nan, reason)


def _nearest_point(axes: Vector, points: Vector) -> Vector:
    """Least-squares common point of lines."""
    projectors = np.eye(3) - axes[:, :, None] * axes[:, None, :]
    origin = points.mean(axis=0)
    rhs = np.einsum("kij,kj->i", projectors, points - origin)
    return origin + np.linalg.solve(projectors.sum(axis=0), rhs)


def _elbow_centre(axes: Vector, points: Vector, shoulder: Vector, wrist: Vector) -> Vector:
    """Point of axis 4 nearest to axes 3 and 5; midway between the feet of S and W where those are parallel to it."""
    axis, origin = axes[3], points[3]
    numerator = denominator = 0.0
    for k in (2, 4):
        across = axis - axes[k] * (axes[k] @ axis)
        numerator -= across @ (origin - points[k])
        denominator += across @ across
    if denominator < MIN_SINE**2:
        return origin + axis * (axis @ (0.5 * (shoulder + wrist) - origin))
    return origin + axis * (numerator / denominator)


def _on_the_line(elbow: Vector, axis: Vector, shoulder: Vector, wrist: Vector) -> Vector:
    """The elbow centre; where rounding in the description leans its axis, on the line S-W of the arm stretched out.

    An elbow beside that line, be it by a micrometre, would go around it while the arm is stretched.
    """
    inner, outer = elbow - shoulder, wrist - elbow
    inner_along, outer_along = float(axis @ inner), float(axis @ outer)
    inner_across = float(np.linalg.norm(inner - axis * inner_along))
    outer_across = float(np.linalg.norm(outer - axis * outer_along))
    reach = inner_across + outer_across
    shift = inner_across * outer_along - outer_across * inner_along
    moved: Vector = elbow + axis * (shift / reach) if abs(shift) < ROUNDED_LEAN * reach * reach else elbow
    return moved


def default_reference(axis: Vector) -> Vector:
    """Where the elbow lies at arm angle zero unless it is said otherwise: along axis 1, its largest part positive."""
    largest = axis[np.abs(axis).argmax()]
    return axis * np.sign(largest)


def _wrist_kind(axes: Vector) -> WristKind:
    return "XYX" if abs(float(axes[4] @ axes[6])) > np.sqrt(0.5) else "XYZ"
