"""Seven revolute joints of a robot, every other joint locked, as axes between a base and a tip."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from srs_ik.errors import InvalidRobot, NotAnSrsLimb, quoted
from srs_ik.robot.description import RobotModel
from srs_ik.robot.limb import ReadOnlyArrays, Vector
from srs_ik.robot.locked import configuration_of
from srs_ik.robot.skeleton import Skeleton, frame_of

_UNLIMITED = 1e6
"""A limit of this size is a way to say that there is none; Pinocchio's is the largest number, some files have 1e9."""


@dataclass(frozen=True, eq=False)
class Chain(ReadOnlyArrays):
    """Seven revolute joints from a base frame to a tip frame, at the zero configuration, in the base frame.

    The arrays are read-only.
    """

    # ``pinocchio.Model`` of exactly these joints; every other joint of the robot is locked. Its nq is 7, and one more
    # for each continuous joint.
    model: Any
    base: str  # name of the base frame; the seven joints do not move it
    tip: str  # name of the tip frame, moved by joint 7
    base_id: int  # index of the base frame in `model`, also where a joint bears the same name
    tip_id: int  # index of the tip frame in `model`
    joint_names: tuple[str, ...]  # the seven names, from the base outwards
    axes: Vector  # (7, 3) unit directions of the joint axes
    points: Vector  # (7, 3) a point on each joint axis, metres
    T_base_tip_zero: Vector  # (4, 4) pose of the tip frame
    lower: Vector  # (7,) lower joint limits, rad; -inf where continuous
    upper: Vector  # (7,) upper joint limits, rad; inf where continuous
    velocity_limit: Vector  # (7,) rad/s; inf where not given, which a URDF also says by 0 or a negative figure
    effort_limit: Vector  # (7,) N m; inf where not given
    acceleration_limit: Vector  # (7,) rad/s^2; inf where not given, which no description says
    locked: Mapping[str, float]  # other joints that are not locked at their neutral position: where they are, rad or m
    # other joints between base and tip: where they are, as in a configuration of Pinocchio
    between: Mapping[str, tuple[float, ...]]
    load: float = 0.0  # mass of what the hand holds, kg, which `model` has with joint 7


def build_chain(
    model: Any, joints: Sequence[int], base: str, tip: str, locked: Mapping[str, float] | None = None
) -> Chain:
    """Lock every joint of a ``pinocchio.Model`` but seven, and measure those between two frames.

    The model is not changed; joints are given by their indices, from the base outwards. Others are locked at their
    neutral position, or where `locked` says, which `as_locked` has checked.

    Raises:
        FrameNotFound: one of the frames does not exist.
        NotAnSrsLimb: the joints move the base, or joint 7 does not move the tip.
        InvalidRobot: the position limits of a joint are no range.
    """
    names = tuple(model.names[joint] for joint in joints)
    others = [joint for joint in range(1, model.njoints) if joint not in joints]
    configuration = configuration_of(model, locked or {})
    reduced = _locked(model, others, configuration) if others else pin.Model(model)
    skeleton = Skeleton(reduced)
    moved_by = skeleton.joint_of(base)
    if moved_by != 0:
        raise NotAnSrsLimb(f"the base frame {base!r} is moved by joint {names[moved_by - 1]!r} of the limb", names)
    if skeleton.joint_of(tip) != 7:
        raise NotAnSrsLimb(f"the tip frame {tip!r} is not moved by joint {names[6]!r}, the last of the limb", names)
    lines = skeleton.measure(range(1, 8), base, tip)
    lower, upper = _position_limits(reduced)
    between = _between(model, joints, base, tip) if others else []
    return Chain(
        model=reduced,
        base=base,
        tip=tip,
        base_id=skeleton.find_frame(base),
        tip_id=skeleton.find_frame(tip),
        joint_names=names,
        axes=lines.axes,
        points=lines.points,
        T_base_tip_zero=lines.T_base_tip_zero,
        lower=lower,
        upper=upper,
        velocity_limit=_given_or_infinite(reduced.velocityLimit),
        effort_limit=_given_or_infinite(reduced.effortLimit),
        acceleration_limit=np.full(7, np.inf),
        locked=dict(locked or {}),
        between={model.names[joint]: _part(model.joints[joint], configuration) for joint in between},
    )


def refuse_followers(robot: RobotModel, chain: Chain, held: Collection[str]) -> None:
    """Raise NotAnSrsLimb where a joint between base and tip follows one of the chain, and is not held by itself."""
    for name in chain.between:
        leader = name
        for _ in robot.followers:
            leader = robot.followers[leader].leader if leader in robot.followers and leader not in held else leader
        if leader != name and leader in chain.joint_names:
            where = f"{quoted(name)}, between base {quoted(chain.base)} and tip {quoted(chain.tip)}"
            why = f"follows {quoted(leader)}, a joint of the arm, and moves with it"
            how = f"choose a base and tip on one side of it, or hold it by locked={{{name!r}: ...}}"
            raise NotAnSrsLimb(f"{robot.source}: {where}, {why}; {how}", chain.joint_names)


def _between(model: Any, joints: Sequence[int], base: str, tip: str) -> list[int]:
    """The other joints that lie between two frames."""
    under_base, under_tip = (
        set(model.supports[model.frames[frame_of(model, name)].parentJoint]) for name in (base, tip)
    )
    return sorted((under_base ^ under_tip) - set(joints))


def _part(joint: Any, configuration: Vector) -> tuple[float, ...]:
    return tuple(configuration[joint.idx_q : joint.idx_q + joint.nq].tolist())


def _locked(model: Any, joints: Sequence[int], configuration: Vector) -> Any:
    """A model without some joints, which are locked where a configuration (nq,) has them.

    Pinocchio looks frames up by their names while it does this, and stops where a link and a fixed joint share one. So
    it works on a copy in which all names differ; the names of joints, which do, stay.
    """
    copy = pin.Model(model)
    names = {}
    for k, frame in enumerate(copy.frames):
        if k > 0 and frame.type != pin.FrameType.JOINT:
            names[f"frame {k} {frame.name}"] = frame.name
            frame.name = f"frame {k} {frame.name}"
    reduced = pin.buildReducedModel(copy, list(joints), configuration)
    for frame in reduced.frames:
        frame.name = names.get(frame.name, frame.name)
    return reduced


def _position_limits(model: Any) -> tuple[Vector, Vector]:
    lower, upper = np.full(7, -np.inf), np.full(7, np.inf)
    for k in range(7):
        joint = model.joints[k + 1]
        if joint.nq == 1:
            low, high = float(model.lowerPositionLimit[joint.idx_q]), float(model.upperPositionLimit[joint.idx_q])
            if not (low <= high and low < _UNLIMITED and high > -_UNLIMITED):
                raise InvalidRobot(f"joint {model.names[k + 1]!r} has the position limits {low} and {high}", model.name)
            lower[k], upper[k] = unlimited_if_huge(low, high)
    return lower, upper


def unlimited_if_huge(lower: float, upper: float) -> tuple[float, float]:
    """Limits of a joint, rad; infinite where their size is a way to say that there is none."""
    return (-np.inf if -np.inf < lower <= -_UNLIMITED else lower), (np.inf if _UNLIMITED <= upper < np.inf else upper)


def _given_or_infinite(limit: Vector) -> Vector:
    values = np.array(limit, dtype=float)
    return np.where((values > 0.0) & (values < _UNLIMITED), values, np.inf)
