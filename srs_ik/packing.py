"""From a limb and its joint limits to the flat array that the kernels read."""

from __future__ import annotations

import numpy as np

from srs_ik.kernels import layout as at
from srs_ik.limb import SrsLimb, Vector

ALIGNED = 1e-9
"""Relative size under which a component that should vanish by design is taken as rounding in the robot description."""


CLOSED_MISS = 1e-12
"""Axes that pass their centres within this distance, metres, leave nothing for Newton's method to do."""


STRICT = (1e-13, 1e-14, 1e-12, 0.0)
LOOSE = (3e-11, 3e-11, 1e-11, 1e-10)
"""Tolerances `SLACK_*` of the layout: those of rounding, and those that still close to 1e-10."""


def pack_family(limb: SrsLimb, lower: Vector, upper: Vector) -> Vector:
    """The limb packed four times, (4, SIZE), read-only: with limits and without, with strict and with loose tolerances.

    Args:
        limb: the recognised limb.
        lower: (7,) lower joint limits, rad; -inf where there is none.
        upper: (7,) upper joint limits, rad; inf where there is none.
    """
    none = np.full(7, np.inf)
    family = np.array([_pack(limb, lo, hi, slack) for slack in (STRICT, LOOSE) for lo, hi in ((lower, upper), (-none, none))])
    family.flags.writeable = False
    return family


def _pack(limb: SrsLimb, lower: Vector, upper: Vector, slack: tuple[float, ...]) -> Vector:
    P = np.zeros(at.SIZE)
    T = limb.T_base_tip_zero
    _put(P, at.AXES, limb.axes)
    _put(P, at.POINTS, limb.points)
    _put(P, at.TIP_ROTATION, T[:3, :3])
    _put(P, at.TIP_POSITION, T[:3, 3])
    P[at.IS_CLOSED] = float(limb.misses.max() < CLOSED_MISS)

    _put(P, at.LOWER, lower)
    _put(P, at.UPPER, upper)
    width = np.asarray(upper) - np.asarray(lower)
    middle = np.array([_middle(lo, hi) for lo, hi in zip(lower, upper, strict=True)])
    _put(P, at.MIDDLE, middle)
    _put(P, at.INVERSE_HALF_RANGE, 2.0 / np.maximum(width, 1e-9))

    _put(P, at.SLACK_SINGULAR, np.array(slack))
    _put(P, at.SHOULDER_CENTRE, limb.shoulder)
    _put(P, at.WRIST_IN_TIP, T[:3, :3].T @ (limb.wrist - T[:3, 3]))
    _put(P, at.ELBOW_CENTRE, limb.elbow)
    _put(P, at.REFERENCE, limb.reference)
    _put(P, at.REFERENCE_2, _second_reference(limb))

    _pack_elbow(P, limb)
    for block, first in ((at.SHOULDER, 0), (at.WRIST, 4)):
        _pack_spherical(P, block, first, limb.axes[first : first + 3], lower, upper, middle, width)
    return P


def _middle(lower: float, upper: float) -> float:
    """Middle of a range; half a turn from the one limit there is, so that the turn nearest to it keeps that limit."""
    if np.isfinite(lower) and np.isfinite(upper):
        return 0.5 * (lower + upper)
    if np.isfinite(lower):
        return lower + np.pi
    return upper - np.pi if np.isfinite(upper) else 0.0


def _put(P: Vector, offset: int, values: Vector) -> None:
    flat = np.ravel(values)
    P[offset : offset + flat.size] = flat


def _second_reference(limb: SrsLimb) -> Vector:
    """A direction across the reference: of axes 2 and 3 the one farther from it, projected."""
    across = [a - limb.reference * (limb.reference @ a) for a in limb.axes[1:3]]
    best = max(across, key=lambda a: float(np.linalg.norm(a)))
    return best / np.linalg.norm(best)


def _pack_elbow(P: Vector, limb: SrsLimb) -> None:
    axis = limb.axes[3]
    e, f = limb.elbow - limb.shoulder, limb.wrist - limb.elbow
    e_along, f_along = float(axis @ e), float(axis @ f)
    e_across, f_across = e - axis * e_along, f - axis * f_along
    straight = float(np.arctan2(axis @ np.cross(f_across, e_across), f_across @ e_across))
    c, s = np.cos(straight), np.sin(straight)
    f_straight = c * f_across + s * np.cross(axis, f_across) + axis * f_along

    P[at.STRAIGHT] = straight
    near, far = np.linalg.norm(e_across), np.linalg.norm(f_across)
    P[at.FAR] = np.hypot(near + far, e_along + f_along)
    P[at.NEAR] = np.hypot(near - far, e_along + f_along)
    _put(P, at.UPPER_ARM, e)
    _put(P, at.FOREARM, f_straight)

    sideways = np.cross(axis, f_straight)
    normal_0 = np.cross(e, f_straight)
    normal_s = np.cross(e, sideways)
    normal_c = np.cross(e, np.cross(axis, sideways))
    scale = float(np.linalg.norm(e) * np.linalg.norm(f))
    if max(abs(e_along), abs(f_along)) < ALIGNED * np.sqrt(scale):
        P[at.NORMAL_KIND] = 0.0
    elif np.linalg.norm(normal_0) < ALIGNED * scale:
        P[at.NORMAL_KIND] = 1.0
    else:
        P[at.NORMAL_KIND] = 2.0
    _put(P, at.NORMAL_0, normal_0)
    _put(P, at.NORMAL_S, normal_s)
    _put(P, at.NORMAL_C, normal_c)


def _pack_spherical(
    P: Vector, k: int, first: int, axes: Vector, lower: Vector, upper: Vector, middle: Vector, width: Vector
) -> None:
    a1, a2, a3 = axes
    _put(P, k + at.A1, a1)
    _put(P, k + at.A2, a2)
    _put(P, k + at.A3, a3)
    across = a2 - a3 * (a2 @ a3)
    across /= np.linalg.norm(across)
    _put(P, k + at.ACROSS_3, across)
    _put(P, k + at.CROSS_3, np.cross(a3, across))
    offset = (a1 @ a2) * (a2 @ a3)
    phase = np.arctan2(a1 @ np.cross(a2, a3), a1 @ a3 - offset)
    alpha, beta = _angle(a1, a2), _angle(a2, a3)
    P[k + at.PHASE], P[k + at.COS_PHASE], P[k + at.SIN_PHASE] = phase, np.cos(phase), np.sin(phase)
    P[k + at.OFFSET], P[k + at.GAIN] = offset, np.sin(alpha) * np.sin(beta)
    P[k + at.TOP_GAP] = 2.0 * np.sin(0.5 * (alpha - beta)) ** 2
    P[k + at.BOTTOM_GAP] = 2.0 * np.sin(0.5 * (np.pi - alpha - beta)) ** 2
    w1, w3 = (min(width[first + i], 2.0 * np.pi) for i in (0, 2))
    P[k + at.ANCHOR_1], P[k + at.ANCHOR_3] = middle[first], middle[first + 2]
    P[k + at.SHARE_1] = w1 / (w1 + w3) if w1 + w3 > 0.0 else 0.5
    P[k + at.A2_A3], P[k + at.A1_A2] = a2 @ a3, a1 @ a2
    _put(P, k + at.CROSS_23, np.cross(a2, a3))
    P[k + at.FIRST_JOINT] = first

    lo, hi = lower[first : first + 3], upper[first : first + 3]
    for i, offset_limited in enumerate((at.LIMITED_1, at.LIMITED_2, at.LIMITED_3)):
        P[k + offset_limited] = float(width[first + i] < 2.0 * np.pi)
    if P[k + at.LIMITED_1]:
        _put(P, k + at.BOUND_1_LOWER, _rotate(a1, lo[0], a2))
        _put(P, k + at.BOUND_1_UPPER, _rotate(a1, hi[0], a2))
    if P[k + at.LIMITED_2]:
        P[k + at.BOUND_2_LOWER] = a1 @ _rotate(a2, lo[1], a3)
        P[k + at.BOUND_2_UPPER] = a1 @ _rotate(a2, hi[1], a3)
    if P[k + at.LIMITED_3]:
        _put(P, k + at.BOUND_3_LOWER, _rotate(a3, -lo[2], a2))
        _put(P, k + at.BOUND_3_UPPER, _rotate(a3, -hi[2], a2))


def _angle(a: Vector, b: Vector) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def _rotate(axis: Vector, angle: float, v: Vector) -> Vector:
    return np.cos(angle) * v + np.sin(angle) * np.cross(axis, v) + (1.0 - np.cos(angle)) * axis * (axis @ v)
