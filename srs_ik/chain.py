"""Seven revolute joints out of a robot: which chains there are, and one of them as axes between a base and a tip."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from srs_ik.errors import FrameNotFound, InvalidRobot, NotAnSrsLimb
from srs_ik.limb import Vector

_REVOLUTE = ("JointModelRX", "JointModelRY", "JointModelRZ", "JointModelRevoluteUnaligned")
_CONTINUOUS = ("JointModelRUBX", "JointModelRUBY", "JointModelRUBZ", "JointModelRevoluteUnboundedUnaligned")

_FRAME_PREFERENCE = (
    pin.FrameType.BODY,
    pin.FrameType.OP_FRAME,
    pin.FrameType.FIXED_JOINT,
    pin.FrameType.SENSOR,
    pin.FrameType.JOINT,
)
"""Which frame a name means where several kinds bear it: links first, as links and joints often share names."""

_UNLIMITED = 1e300
"""A limit of this size is Pinocchio's way to say that there is none."""


@dataclass(frozen=True, eq=False)
class Chain:
    """Seven revolute joints from a base frame to a tip frame, at the zero configuration, in the base frame.

    The arrays are read-only.

    Attributes:
        model: ``pinocchio.Model`` of exactly these joints; every other joint of the robot is locked at its neutral
            position. Its nq is 7, and one more for each continuous joint.
        base: name of the base frame; the seven joints do not move it.
        tip: name of the tip frame, moved by joint 7.
        joint_names: the seven names, from the base outwards.
        axes: (7, 3) unit directions of the joint axes.
        points: (7, 3) a point on each joint axis, metres.
        T_base_tip_zero: (4, 4) pose of the tip frame.
        lower: (7,) lower joint limits, rad; -inf where continuous.
        upper: (7,) upper joint limits, rad; inf where continuous.
        velocity_limit: (7,) rad/s; inf where not given, which a URDF also says by 0 or a negative figure.
        effort_limit: (7,) N m; inf where not given.
    """

    model: Any
    base: str
    tip: str
    joint_names: tuple[str, ...]
    axes: Vector
    points: Vector
    T_base_tip_zero: Vector
    lower: Vector
    upper: Vector
    velocity_limit: Vector
    effort_limit: Vector


@dataclass(frozen=True, eq=False)
class Lines:
    """Joint axes as lines, and the tip, at the zero configuration in the base frame; shapes as in `Chain`."""

    axes: Vector
    points: Vector
    T_base_tip_zero: Vector


def windows(model: Any, excluded: Collection[str] = ()) -> list[tuple[int, ...]]:
    """Every run of seven revolute joints of which each is the parent of the next.

    Args:
        model: a ``pinocchio.Model``.
        excluded: names of joints that cannot take part, such as those that mimic another one.

    Returns:
        Joint indices of each run, from the base outwards, ordered by the last one.
    """
    found = []
    for last in range(1, model.njoints):
        joints: list[int] = []
        joint = last
        while len(joints) < 7 and joint > 0 and is_revolute(model, joint) and model.names[joint] not in excluded:
            joints.append(joint)
            joint = int(model.parents[joint])
        if len(joints) == 7:
            found.append(tuple(reversed(joints)))
    return found


def is_revolute(model: Any, joint: int) -> bool:
    """True if a joint turns about one fixed axis, with or without stops."""
    return model.joints[joint].shortname() in _REVOLUTE + _CONTINUOUS


def joints_between(model: Any, base: str, tip: str) -> list[int]:
    """Joints that move the tip frame but not the base frame, from the base outwards.

    Raises:
        FrameNotFound: one of the frames does not exist.
    """
    ends = [model.frames[find_frame(model, name)].parentJoint for name in (base, tip)]
    base_path, tip_path = (list(model.supports[joint]) for joint in ends)
    return [int(joint) for joint in tip_path if joint not in base_path]


def find_frame(model: Any, name: str) -> int:
    """Index of the frame of a name; a link is preferred to a joint or sensor of the same name.

    Raises:
        FrameNotFound: there is none.
        InvalidRobot: there are several of the same kind, so the name does not say which is meant.
    """
    for kind in _FRAME_PREFERENCE:
        matches = [k for k, frame in enumerate(model.frames) if frame.name == name and frame.type == kind]
        if len(matches) > 1:
            raise InvalidRobot(f"the robot {model.name!r} has {len(matches)} frames named {name!r}", model.name)
        if matches:
            return matches[0]
    raise FrameNotFound(name, frame_names(model), robot=model.name)


def frame_names(model: Any) -> list[str]:
    """Names that `find_frame` knows, links first, each once."""
    ranked = sorted(model.frames, key=lambda frame: _FRAME_PREFERENCE.index(frame.type))
    return list(dict.fromkeys(frame.name for frame in ranked if frame.name != "universe"))


def default_base(model: Any, joint: int) -> str:
    """Name of the link that carries a joint.

    Raises:
        InvalidRobot: the model was made without frames there, so the base frame has to be named.
    """
    own = _joint_frame(model, joint)
    if own is not None:
        return model.frames[model.frames[own].parentFrame].name
    return _frame_on(model, int(model.parents[joint]), "base")


def default_tip(model: Any, joint: int) -> str:
    """Name of the outermost link that is surely the hand of a joint.

    From the link that the joint moves, the way goes on as long as there is exactly one child link and it is attached by
    a fixed joint; it ends at a fork and before a moving joint.

    Raises:
        InvalidRobot: the model was made without frames there, so the tip frame has to be named.
    """
    start = _joint_frame(model, joint)
    if start is None:
        return _frame_on(model, joint, "tip")
    links, attached = _frame_children(model)
    if not links.get(start):
        return model.frames[start].name
    tip = links[start][0]
    while len(attached.get(tip, ())) == 1:
        (fixed,) = attached[tip]
        if model.frames[fixed].type != pin.FrameType.FIXED_JOINT or len(links.get(fixed, ())) != 1:
            break
        (tip,) = links[fixed]
    return model.frames[tip].name


def carries(model: Any, frame: int, joint: int) -> bool:
    """True if a frame lies on the way from the root of the robot to a joint, so that the joint hangs on it."""
    own = _joint_frame(model, joint)
    if own is None:
        return model.frames[frame].parentJoint in list(model.supports[model.parents[joint]])
    above = model.frames[own].parentFrame
    while above != frame and above != 0:
        above = model.frames[above].parentFrame
    return above == frame


def measure(model: Any, joints: Sequence[int], base: int, tip: int) -> Lines:
    """The axes of revolute joints as lines at the neutral configuration, by Pinocchio's Jacobian.

    Args:
        model: a ``pinocchio.Model``.
        joints: indices of the joints.
        base: index of the base frame.
        tip: index of the tip frame.
    """
    data = model.createData()
    J_world = pin.computeJointJacobians(model, data, pin.neutral(model))
    pin.updateFramePlacements(model, data)
    T_base_world = data.oMf[base].inverse()
    columns = [model.joints[joint].idx_v for joint in joints]
    axes = (T_base_world.rotation @ J_world[3:, columns]).T
    points = np.array([T_base_world.act(data.oMi[joint].translation) for joint in joints])
    return Lines(axes, points, (T_base_world * data.oMf[tip]).homogeneous)


def build_chain(model: Any, joints: Sequence[int], base: str, tip: str) -> Chain:
    """Lock every joint but seven, and measure those between two frames.

    Args:
        model: a ``pinocchio.Model``; it is not changed.
        joints: indices of seven revolute joints, from the base outwards.
        base: name of the base frame, anywhere on the robot where the seven joints do not move it.
        tip: name of the tip frame.

    Raises:
        FrameNotFound: one of the frames does not exist.
        NotAnSrsLimb: the joints move the base, or joint 7 does not move the tip.
        InvalidRobot: Pinocchio cannot lock the other joints, or a joint limit is no number.
    """
    names = tuple(model.names[joint] for joint in joints)
    for frame in (base, tip):
        find_frame(model, frame)
    locked = [joint for joint in range(1, model.njoints) if joint not in joints]
    try:
        reduced = pin.buildReducedModel(model, locked, pin.neutral(model)) if locked else pin.Model(model)
    except ValueError as error:
        raise InvalidRobot(f"Pinocchio cannot lock the other joints of {model.name!r}: {error}", model.name) from None
    base_id, tip_id = find_frame(reduced, base), find_frame(reduced, tip)
    moved_by = reduced.frames[base_id].parentJoint
    if moved_by != 0:
        raise NotAnSrsLimb(f"the base frame {base!r} is moved by joint {names[moved_by - 1]!r} of the limb", names)
    if reduced.frames[tip_id].parentJoint != 7:
        raise NotAnSrsLimb(f"the tip frame {tip!r} is not moved by joint {names[6]!r}, the last of the limb", names)
    lines = measure(reduced, range(1, 8), base_id, tip_id)
    lower, upper = _position_limits(reduced)
    chain = Chain(
        model=reduced,
        base=base,
        tip=tip,
        joint_names=names,
        axes=lines.axes,
        points=lines.points,
        T_base_tip_zero=lines.T_base_tip_zero,
        lower=lower,
        upper=upper,
        velocity_limit=_given_or_infinite(reduced.velocityLimit),
        effort_limit=_given_or_infinite(reduced.effortLimit),
    )
    for value in vars(chain).values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
    return chain


def _position_limits(model: Any) -> tuple[Vector, Vector]:
    lower, upper = np.full(7, -np.inf), np.full(7, np.inf)
    for k in range(7):
        joint = model.joints[k + 1]
        if joint.nq == 1:
            low, high = float(model.lowerPositionLimit[joint.idx_q]), float(model.upperPositionLimit[joint.idx_q])
            if not low <= high:
                raise InvalidRobot(f"joint {model.names[k + 1]!r} has the position limits {low} and {high}", model.name)
            lower[k] = low if low > -_UNLIMITED else -np.inf
            upper[k] = high if high < _UNLIMITED else np.inf
    return lower, upper


def _given_or_infinite(limit: Vector) -> Vector:
    values = np.array(limit, dtype=float)
    return np.where((values > 0.0) & (values < _UNLIMITED), values, np.inf)


def _joint_frame(model: Any, joint: int) -> int | None:
    for k, frame in enumerate(model.frames):
        if frame.type == pin.FrameType.JOINT and frame.parentJoint == joint and frame.name == model.names[joint]:
            return k
    return None


def _frame_on(model: Any, joint: int, end: str) -> str:
    """Some frame on a joint of a model that has no frames for its joints."""
    if joint == 0:
        return "universe"
    kinds = {kind: rank for rank, kind in enumerate(_FRAME_PREFERENCE)}
    on_joint = sorted((kinds[frame.type], k) for k, frame in enumerate(model.frames) if frame.parentJoint == joint)
    if not on_joint:
        message = f"the model {model.name!r} has no frame on joint {model.names[joint]!r}; add one and give it as {end}"
        raise InvalidRobot(message, model.name)
    return model.frames[on_joint[0][1]].name


def _frame_children(model: Any) -> tuple[dict[int, list[int]], dict[int, list[int]]]:
    """For each frame, the links on it, and the joints, fixed or moving, that hang on it."""
    links: dict[int, list[int]] = {}
    attached: dict[int, list[int]] = {}
    for k, frame in enumerate(model.frames):
        if k == 0:
            continue
        if frame.type == pin.FrameType.BODY:
            links.setdefault(frame.parentFrame, []).append(k)
        elif frame.type in (pin.FrameType.JOINT, pin.FrameType.FIXED_JOINT):
            attached.setdefault(frame.parentFrame, []).append(k)
    return links, attached
