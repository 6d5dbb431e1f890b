"""What kernels know of an arm, and the answers made from their rows: packed once, passed to every question."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from srs_ik.analysis.gravity import torque_scales
from srs_ik.errors import InvalidRobot
from srs_ik.kernels.entries.pose import pack_limits
from srs_ik.kernels.layout import limb as at
from srs_ik.kernels.layout import task as hand_at
from srs_ik.kernels.layout import weights as weight_at
from srs_ik.kernels.native import limb_mark
from srs_ik.robot.limb import CLOSED_MISS, Hand, SrsLimb, Vector, line_foot
from srs_ik.solve.bands import put_bands
from srs_ik.solve.solution import ASKED, ElbowRange

if TYPE_CHECKING:
    from srs_ik.kinematics import ChainKinematics

ALIGNED = 1e-9
"""Relative size under which a component that should vanish by design is taken as rounding in the robot description."""


FLAT = 1e-12
"""An arm whose reach differs by less than this, metres, from that of its triangle is flat when stretched or folded."""

NO_HAND = 1e-9
"""A tip this near to the wrist centre, metres, is in it."""

NO_ROOM = 1e-9
"""A joint with a narrower range, rad, cannot move."""

STRICT = (1e-13, 1e-14, 1e-12, 1e-12)
LOOSE = (3e-11, 3e-11, 1e-11, 1e-10)
"""Tolerances `SLACK_*` of the layout: those of rounding, and those that still close to 1e-10."""

ROUNDED = 1.5e-11
"""Axes that lean by less than this, rad, are perpendicular, written with 11 digits or so: no answer is farther off."""

OBLIQUE = 1e-9
TOUCHING = 1e-13
"""Oblique axes leave this part of all directions, as a cosine, out of reach; intervals may end at single arm angles
there, with so much between two that touch, rad."""


@dataclass(frozen=True, eq=False)
class PackedArm:
    """All that drivers of kernels need of an arm; every array is read-only."""

    name: str  # name of the robot, for messages
    tip: str  # name of the tip frame, for messages
    joint_names: tuple[str, ...]  # the 7 joint names, from shoulder to wrist
    lower: Vector  # (7,) lower joint limits, rad; -inf where continuous
    upper: Vector  # (7,) upper joint limits, rad; inf where continuous
    velocity_limit: Vector  # (7,) rad/s; inf where the description gives none
    acceleration_limit: Vector  # (7,) rad/s^2; inf where nobody gives one
    family: Vector  # (4, SIZE) the packed limb, see `pack_family`
    hand: Vector  # (HAND,) the packed hand, see `pack_hand`
    weights: Vector  # (WEIGHTS,) the packed masses, see `pack_weights`
    shoulder: Vector  # (3,) shoulder centre in the base frame, metres
    told: tuple[ElbowRange, ...]  # where the elbow is straight, and its limits, with each of `ASKED`
    closed: bool  # whether the closed form of the limb is the answer, without a correction on the true chain

    @property
    def elbow(self) -> ElbowRange:
        """For answers to a pose alone."""
        return self.told[0]


def pack_arm(arm: ChainKinematics, limb: SrsLimb, hand: Hand | None) -> PackedArm:
    """What kernels know of an arm: its 7 joints, the limb recognised in them, and the axes of the hand, where known."""
    family = pack_family(limb, arm.lower, arm.upper)
    straight = float(family[at.LIMITED, at.STRAIGHT])
    return PackedArm(
        name=arm.name,
        tip=arm.tip,
        joint_names=arm.joint_names,
        lower=arm.lower,
        upper=arm.upper,
        velocity_limit=arm.velocity_limit,
        acceleration_limit=arm.acceleration_limit,
        family=family,
        hand=pack_hand(limb, hand),
        weights=pack_weights(arm),
        shoulder=limb.shoulder,
        told=tuple(ElbowRange(straight, float(arm.lower[3]), float(arm.upper[3]), asked) for asked in ASKED),
        closed=bool(family[at.LIMITED, at.IS_CLOSED]),
    )


def limb_file(arm: PackedArm) -> bytes:
    """The packed limb of an arm as a file that `srs_ik_read_limb` of the C library reads."""
    return limb_mark() + np.int64(arm.family.size).tobytes() + np.ascontiguousarray(arm.family, "<f8").tobytes()


def pack_family(limb: SrsLimb, lower: Vector, upper: Vector) -> Vector:
    """The limb packed four times, (4, SIZE), read-only: with limits and without, with strict and with loose tolerances.

    Limits (7,) are in rad, infinite where there is none.
    """
    none = np.full(7, np.inf)
    # Two joints that cannot move leave arm angles without width, which only loose tolerances find.
    first = LOOSE if np.count_nonzero(upper - lower < NO_ROOM) > 1 else STRICT
    family = np.array(
        [_pack(limb, lo, hi, slack) for slack in (first, LOOSE) for lo, hi in ((lower, upper), (-none, none))]
    )
    if family[at.LIMITED, at.IS_CLOSED] == 0.0:
        put_bands(family[at.LIMITED])
        family[:, at.SHIFT :] = family[at.LIMITED, at.SHIFT :]
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
    P[at.IS_NEAR] = 1.0 - P[at.IS_CLOSED]

    _put(P, at.SLACK_SINGULAR, np.array(slack))
    _put(P, at.SHOULDER_CENTRE, limb.shoulder)
    _put(P, at.WRIST_IN_TIP, T[:3, :3].T @ (limb.wrist - T[:3, 3]))
    _put(P, at.ELBOW_CENTRE, limb.elbow)
    P[at.MISS] = limb.offsets.max()
    _put(P, at.REFERENCE, limb.reference)
    _put(P, at.REFERENCE_2, _second_reference(limb))

    _pack_elbow(P, limb)
    for block, first in ((at.SHOULDER, 0), (at.WRIST, 4)):
        lean = _pack_spherical(P, block, first, limb.axes[first : first + 3])
        P[at.SLACK_SINGULAR] = max(P[at.SLACK_SINGULAR], 2.0 * lean)
        if max(P[block + at.TOP_GAP], P[block + at.BOTTOM_GAP]) > OBLIQUE:
            P[at.SLACK_JOIN] = max(P[at.SLACK_JOIN], TOUCHING)
    pack_limits(P, np.array(lower, dtype=float), np.array(upper, dtype=float))
    return P


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
    e, f = _segments(limb)
    e_along, f_along = float(axis @ e), float(axis @ f)
    e_across, f_across = e - axis * e_along, f - axis * f_along
    straight = float(np.arctan2(axis @ np.cross(f_across, e_across), f_across @ e_across))
    c, s = np.cos(straight), np.sin(straight)
    f_straight = c * f_across + s * np.cross(axis, f_across) + axis * f_along

    P[at.STRAIGHT], P[at.COS_STRAIGHT], P[at.SIN_STRAIGHT] = straight, c, s
    P[at.NEAR], P[at.FAR] = _reach(limb, 1.0)
    _put(P, at.UPPER_ARM, e)
    _put(P, at.FOREARM, f_straight)

    sideways = np.cross(axis, f_straight)
    normal_0 = np.cross(e, f_straight)
    normal_s = np.cross(e, sideways)
    normal_c = np.cross(e, np.cross(axis, sideways))
    scale = float(np.linalg.norm(e) * np.linalg.norm(f))
    if max(abs(e_along), abs(f_along)) < ALIGNED * np.sqrt(scale):
        P[at.NORMAL_KIND] = 0.0
        normal_s = axis * np.sign(axis @ normal_s)
    elif np.linalg.norm(normal_0) < ALIGNED * scale:
        P[at.NORMAL_KIND] = 1.0
    else:
        P[at.NORMAL_KIND] = 2.0
    _put(P, at.NORMAL_0, normal_0)
    _put(P, at.NORMAL_S, normal_s)
    _put(P, at.NORMAL_C, normal_c)


def _segments(limb: SrsLimb) -> tuple[Vector, Vector]:
    """Upper arm and forearm of the nearest exact limb: from the shoulder on axis 3, and to the wrist on axis 5."""
    inner = line_foot(limb.shoulder, limb.points[2], limb.axes[2])
    outer = line_foot(limb.wrist, limb.points[4], limb.axes[4])
    return limb.elbow - inner, outer - limb.elbow


def _cosine(a: Vector, b: Vector) -> float:
    """Cosine of the angle between two axes; exactly zero where they are perpendicular up to rounding."""
    cosine = float(a @ b)
    return 0.0 if abs(cosine) < 1e-15 else cosine


def _pack_spherical(P: Vector, k: int, first: int, axes: Vector) -> float:
    """Fill in a spherical joint; return how far apart its outer axes stay that count as coming into one line, rad."""
    a1, a2, a3 = axes
    _put(P, k + at.A1, a1)
    _put(P, k + at.A2, a2)
    _put(P, k + at.A3, a3)
    across = a2 - a3 * (a2 @ a3)
    across /= np.linalg.norm(across)
    _put(P, k + at.ACROSS_3, across)
    _put(P, k + at.CROSS_3, np.cross(a3, across))
    phase = np.arctan2(a1 @ np.cross(a2, a3), a1 @ a3 - (a1 @ a2) * (a2 @ a3))
    P[k + at.PHASE], P[k + at.COS_PHASE], P[k + at.SIN_PHASE] = phase, np.cos(phase), np.sin(phase)
    alpha, beta = _angle(a1, a2), _angle(a2, a3)
    apart = np.abs([alpha - beta, np.pi - alpha - beta])
    P[k + at.TOP_GAP], P[k + at.BOTTOM_GAP] = np.where(apart < ROUNDED, 0.0, 2.0 * np.sin(0.5 * apart) ** 2)
    P[k + at.A1_A2], P[k + at.A2_A3] = _cosine(a1, a2), _cosine(a2, a3)
    _put(P, k + at.CROSS_23, np.cross(a2, a3))
    P[k + at.FIRST_JOINT] = first
    return float(np.max(np.where(apart < ROUNDED, apart, 0.0)))


def _angle(a: Vector, b: Vector) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def pack_hand(limb: SrsLimb, hand: Hand | None) -> Vector:
    """What the posture of a task needs to know of the arm, (HAND,), read-only.

    Without axes of the hand, it is taken to reach out from the wrist straight to the tip.
    """
    T = limb.T_base_tip_zero
    wrist_in_tip = T[:3, :3].T @ (limb.wrist - T[:3, 3])
    length = limb.hand
    grasp, across = _hand_axes(wrist_in_tip, hand)
    reach = -wrist_in_tip / length if length > NO_HAND else grasp

    H = np.zeros(hand_at.HAND)
    _put(H, hand_at.HAND_GRASP, grasp)
    _put(H, hand_at.HAND_ACROSS, across)
    _put(H, hand_at.HAND_REACH, reach)
    _put(H, hand_at.HAND_WRIST, wrist_in_tip)
    H[hand_at.HAND_LENGTH], H[hand_at.HAND_ALONG] = length, -wrist_in_tip @ grasp
    H[hand_at.HAND_UPPER_ARM], H[hand_at.HAND_FOREARM] = limb.upper_arm, limb.forearm
    H[hand_at.HAND_NEAR], H[hand_at.HAND_FAR] = _flat_reach(limb, 0.0)
    H[hand_at.HAND_TIP_NEAR], H[hand_at.HAND_TIP_FAR] = _flat_reach(limb, length)
    H[hand_at.HAND_KNOWN] = float(hand is not None)
    H.flags.writeable = False
    return H


def _hand_axes(wrist_in_tip: Vector, hand: Hand | None) -> tuple[Vector, Vector]:
    if hand is not None:
        return np.array(hand.grasp), np.array(hand.pronosupination)
    length = float(np.linalg.norm(wrist_in_tip))
    grasp = -wrist_in_tip / length if length > NO_HAND else np.array([1.0, 0.0, 0.0])
    across = np.eye(3)[np.argmin(np.abs(grasp))]
    across = across - grasp * (grasp @ across)
    return grasp, across / np.linalg.norm(across)


def _flat_reach(limb: SrsLimb, length: float) -> tuple[float, float]:
    """Shortest and longest distance from the shoulder of the point `length` beyond W on the line from E.

    Where the limb lies flat at the ends of its reach, they are exactly those of its triangle.
    """
    near, far = _reach(limb, 1.0 + length / limb.forearm)
    lower = limb.forearm + length
    flat_near, flat_far = abs(limb.upper_arm - lower), limb.upper_arm + lower
    return flat_near if near - flat_near < FLAT else near, flat_far if flat_far - far < FLAT else far


def _reach(limb: SrsLimb, stretch: float) -> tuple[float, float]:
    """Shortest and longest distance from the shoulder of the point on the line E-W, `stretch` forearms from E."""
    axis = limb.axes[3]
    e, f = _segments(limb)
    f = stretch * f
    e_along, f_along = float(axis @ e), float(axis @ f)
    near, far = float(np.linalg.norm(e - axis * e_along)), float(np.linalg.norm(f - axis * f_along))
    return float(np.hypot(near - far, e_along + f_along)), float(np.hypot(near + far, e_along + f_along))


def pack_weights(arm: ChainKinematics) -> Vector:
    """The masses of an arm as the kernels of gravity read them, (WEIGHTS,), read-only; InvalidRobot beyond floats."""
    frames = arm.joint_frames(np.zeros(7))
    W = np.empty(weight_at.WEIGHTS)
    for joint in range(7):
        T_base_joint, inertia = frames[joint + 1], arm.model.inertias[joint + 1]
        if not np.isfinite((inertia.mass, *inertia.lever)).all():
            raise InvalidRobot(
                f"what joint {arm.joint_names[joint]!r} of {arm.name!r} carries has no finite mass or centre"
            )
        centre = T_base_joint[:3, :3] @ inertia.lever + T_base_joint[:3, 3]
        W[weight_at.MASSES + joint] = inertia.mass
        _put(W, weight_at.MOMENTS + 3 * joint, inertia.mass * centre)
    _put(W, weight_at.GRAVITY, frames[0, :3, :3] @ arm.model.gravity.linear)
    _put(W, weight_at.SCALES, torque_scales(arm))
    W.flags.writeable = False
    return W
