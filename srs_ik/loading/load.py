"""`load` and `find_limbs`: the way from a robot to its arms."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from srs_ik.chain import (
    Chain,
    build_chain,
    carries,
    default_base,
    default_tip,
    find_frame,
    is_revolute,
    joints_between,
    windows,
)
from srs_ik.errors import AmbiguousLimb, InvalidTask, NotAnSrsLimb, listed
from srs_ik.limb import Vector
from srs_ik.loading.limbs import Candidate, LimbReport, examine, explained, weigh
from srs_ik.loading.sources import Description, describe
from srs_ik.recognition import recognise

if TYPE_CHECKING:
    from srs_ik.arm import Arm


def load(
    source: Any,
    base: str | None = None,
    tip: str | None = None,
    *,
    name: str | None = None,
    reference: Any = None,
    hand: Any = None,
) -> Arm:
    """Load an S-R-S arm.

    Seven consecutive revolute joints are taken, every other joint of the robot is locked at its neutral position. With
    `base` and `tip` they are sought on the way between them, with `tip` alone on the way to it from the root of the
    robot, with `base` alone in what hangs on it, without either in the whole robot.

    Args:
        source: a name (see `robots`; a name of robot_descriptions; "human_left" or "human_right"), the path of a URDF
            file, URDF text, a ``pinocchio.Model``, or a ``yourdfpy.URDF``. It is not changed; meshes are not needed.
        base: name of the base frame, any frame that the arm does not move; by default the link that carries joint 1.
        tip: name of the tip frame, anything that joint 7 moves; by default the outermost link fixed to it, up to where
            links fork or move.
        name: name of the arm; by default the name under which it was loaded, or that of the robot.
        reference: (3,) direction in the base frame towards which the elbow lies at arm angle zero, of any length; by
            default that of the built-in robot, or axis 1.
        hand: (2, 3) grasp direction and pronosupination direction in the tip frame, of any length, not parallel; the
            second is taken perpendicular to the first. By default those of the built-in robot.

    Returns:
        The arm.

    Raises:
        InvalidRobot: the description is missing or faulty.
        FrameNotFound: the robot has no frame `base` or `tip`.
        NotAnSrsLimb: there are no seven such joints, or their axes miss common points by too much.
        AmbiguousLimb: several arms fit.
        MissingExtra: `source` needs a package that is not installed.
        InvalidTask: `reference` or `hand` is no direction.
    """
    from srs_ik.arm import Arm

    asked_reference = None if reference is None else _direction(reference, "reference")
    asked_hand = None if hand is None else _hand(hand)
    description = describe(source)
    joints, base, tip = _choose(description, base, tip)
    chain = build_chain(description.robot.model, joints, base, tip)
    if asked_reference is None:
        asked_reference = _meant_reference(description, chain)
    if asked_hand is None:
        asked_hand = _meant_hand(description, chain)
    found = recognise(chain.axes, chain.points, chain.T_base_tip_zero, asked_reference)
    if found.limb is None:
        raise NotAnSrsLimb(
            f"{base} -> {tip} is no S-R-S limb: {explained(found.reason, chain.joint_names, 1e3 * found.misses)}",
            chain.joint_names,
            1e3 * found.misses,
        )
    return Arm(chain, found.limb, name or description.name, hand=asked_hand)


def find_limbs(source: Any) -> list[LimbReport]:
    """Every chain of seven consecutive revolute joints in a robot, classified and measured.

    S-R-S limbs come first, then chains that are none. Of chains that share joints only the best is reported: see `note`
    of the report.

    Args:
        source: as for `load`.

    Raises:
        InvalidRobot: the description is missing or faulty.
        MissingExtra: `source` needs a package that is not installed.
    """
    description = describe(source)
    robot = description.robot
    candidates = [examine(description, joints) for joints in windows(robot.model, robot.mimic_joints)]
    return [candidate.report for candidate in weigh(candidates, robot.model)]


def _choose(description: Description, base: str | None, tip: str | None) -> tuple[tuple[int, ...], str, str]:
    """Joints and frames of the one limb that fits."""
    model = description.robot.model
    base, tip = base or description.base, tip or description.tip
    for frame in (base, tip):
        if frame is not None:
            find_frame(model, frame)
    every = windows(model, description.robot.mimic_joints)
    fitting = [joints for joints in every if _fits(model, joints, base, tip)]
    if not fitting and base is not None and tip is None:
        fitting = [joints for joints in every if not _moves(model, joints, base)]
    if not fitting:
        raise _no_chain(description, base, tip)
    candidates = weigh([examine(description, joints, base, tip) for joints in fitting], model)
    limbs = [candidate for candidate in candidates if candidate.report.limb is not None]
    if not limbs:
        raise _refused(candidates)
    if len(limbs) > 1:
        raise _ambiguous(model, description.name, limbs)
    return limbs[0].joints, limbs[0].report.base, limbs[0].report.tip


def _fits(model: Any, joints: Sequence[int], base: str | None, tip: str | None) -> bool:
    if tip is not None:
        return set(joints) <= set(joints_between(model, base or "universe", tip))
    return base is None or carries(model, find_frame(model, base), joints[0])


def _moves(model: Any, joints: Sequence[int], frame: str) -> bool:
    return not set(joints).isdisjoint(model.supports[model.frames[find_frame(model, frame)].parentJoint])


def _no_chain(description: Description, base: str | None, tip: str | None) -> NotAnSrsLimb:
    """The error for a robot or a way through it that has no seven consecutive revolute joints."""
    model, mimic = description.robot.model, description.robot.mimic_joints
    if tip is None:
        where = f"{description.name!r}" if base is None else f"what hangs on {base!r}"
        return NotAnSrsLimb(f"{where} has no chain of 7 consecutive revolute joints")
    joints = joints_between(model, base or "universe", tip)
    names = [model.names[joint] for joint in joints]
    where = f"between base {base!r} and tip {tip!r}" if base is not None else f"on the way to the tip {tip!r}"
    found = f"{len(names)} moving joint{'s' if len(names) != 1 else ''}" if names else "no moving joint"
    message = f"{where} there are no 7 consecutive revolute joints, but {found}"
    others = [
        f"{name} mimics another joint" if name in mimic else f"{name} is not revolute"
        for name, joint in zip(names, joints, strict=True)
        if name in mimic or not is_revolute(model, joint)
    ]
    if names:
        message += f": {listed(names)}" + (f" ({', '.join(others)})" if others else "")
    if base is not None and len(joints_between(model, tip, base)) >= 7:
        message += "; base and tip are perhaps swapped"
    return NotAnSrsLimb(message, names)


def _refused(candidates: Sequence[Candidate]) -> NotAnSrsLimb:
    """The error for chains that are all no limbs; it speaks of the one that is nearest to being one."""
    worst = [float(np.nan_to_num(candidate.report.misses_mm, nan=np.inf).max()) for candidate in candidates]
    report = candidates[int(np.argmin(worst))].report
    message = report.describe().removesuffix(".")
    if len(candidates) > 1:
        message = f"none of {len(candidates)} chains of 7 revolute joints is an S-R-S limb; the nearest, {message}"
    return NotAnSrsLimb(message, report.joint_names, report.misses_mm)


def _ambiguous(model: Any, name: str, limbs: Sequence[Candidate]) -> AmbiguousLimb:
    ends = [(default_base(model, limb.joints[0]), default_tip(model, limb.joints[-1])) for limb in limbs]
    choices = ", ".join(f"base={base!r} tip={tip!r}" for base, tip in ends)
    return AmbiguousLimb(f"{len(ends)} arms of {name!r} fit, choose one by its base and tip: {choices}", ends)


def _meant_reference(description: Description, chain: Chain) -> Vector | None:
    """The reference of the description, turned from its own base frame into that of the chain."""
    if description.reference is None or description.base is None:
        return None
    return _rotation(chain, chain.base, description.base) @ description.reference


def _meant_hand(description: Description, chain: Chain) -> Vector | None:
    """The hand of the description, turned from its own tip frame into that of the chain; None if apart from it."""
    if description.hand is None or description.tip is None:
        return None
    model = chain.model
    if model.frames[find_frame(model, description.tip)].parentJoint != 7:
        return None
    return description.hand @ _rotation(chain, chain.tip, description.tip).T


def _rotation(chain: Chain, to: str, frame: str) -> Vector:
    """Rotation from one frame's axes to another's, at the zero configuration; exactly one if they are the same."""
    if to == frame:
        return np.eye(3)
    data = chain.model.createData()
    pin.framesForwardKinematics(chain.model, data, pin.neutral(chain.model))
    R_world_to, R_world_frame = (data.oMf[find_frame(chain.model, name)].rotation for name in (to, frame))
    return R_world_to.T @ R_world_frame


def _direction(value: Any, what: str) -> Vector:
    try:
        vector = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise InvalidTask(f"{what} is not an array of 3 numbers") from None
    if vector.shape != (3,):
        raise InvalidTask(f"{what} has the shape {vector.shape}, not (3,)")
    length = float(np.linalg.norm(vector))
    if not (np.isfinite(length) and length > 1e-9):
        raise InvalidTask(f"{what} is {vector.tolist()}, which has no direction")
    return vector / length


def _hand(value: Any) -> Vector:
    try:
        grasp, pronosupination = value
    except (TypeError, ValueError):
        raise InvalidTask("hand is not a pair of directions, grasp and pronosupination") from None
    g, phi = _direction(grasp, "grasp direction of hand"), _direction(pronosupination, "pronosupination of hand")
    across = phi - g * (g @ phi)
    if np.linalg.norm(across) < 1e-6:
        raise InvalidTask("grasp and pronosupination direction of hand are parallel")
    return np.array([g, across / np.linalg.norm(across)])
