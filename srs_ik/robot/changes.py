"""A chain as it is used: with a tool, on another base, within other limits."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from srs_ik.errors import InvalidRobot, did_you_mean, listed, quoted, warn_caller
from srs_ik.inputs.numbers import real_number, vector_of
from srs_ik.robot.chain import Chain, unlimited_if_huge
from srs_ik.robot.limb import Vector
from srs_ik.system import bounds

_LIMITS = {
    "lower": "lower",
    "upper": "upper",
    "velocity": "velocity_limit",
    "effort": "effort_limit",
    "acceleration": "acceleration_limit",
}
"""What a limit is called in an adapter, and in a chain."""

_OF_MOVEIT = {
    "min_position": ("lower", "has_position_limits"),
    "max_position": ("upper", "has_position_limits"),
    "max_velocity": ("velocity", "has_velocity_limits"),
    "max_effort": ("effort", "has_effort_limits"),
    "max_acceleration": ("acceleration", "has_acceleration_limits"),
}
"""What MoveIt's joint_limits.yaml calls them, and what says there whether they count."""

_LEFT_OUT = {
    f"{prefix}_{what}{end}"
    for what in ("deceleration", "jerk")
    for prefix, end in (("has", "_limits"), ("min", ""), ("max", ""))
} | {"min_acceleration", "angle_wraparound"}
"""What else stands there: joints slow down as fast as they speed up, and trackers are given jerks themselves."""

FASTEST = 30.0
"""Faster joints, rad/s, get a warning: theirs may be degrees."""

Array = Vector


def with_tool(chain: Chain, T_tip_tool: Array, name: str | None = None) -> Chain:
    """The chain with a tool's frame for its tip; by default it is named "tool", numbered where that is taken.

    Raises:
        InvalidRobot: a frame of that name exists, or the name is no text.
    """
    T_tip_tool = _rigid(T_tip_tool)
    model = pin.Model(chain.model)
    tip = model.frames[chain.tip_id]
    name, index = _add_frame(model, tip.parentJoint, chain.tip_id, tip.placement * _se3(T_tip_tool), name, "tool")
    return replace(chain, model=model, tip=name, tip_id=index, T_base_tip_zero=chain.T_base_tip_zero @ T_tip_tool)


def on_base(chain: Chain, T_newbase_base: Array, name: str | None = None, gravity: Array | None = None) -> Chain:
    """The chain with a frame of its surroundings for its base; by default named "world", numbered where that is taken.

    Its gravity (3,), m/s^2, is as it is in the chain if not given.

    Raises:
        InvalidRobot: a frame of that name exists, or the name is no text.
    """
    T_newbase_base = _rigid(T_newbase_base)
    model = pin.Model(chain.model)
    base = model.frames[chain.base_id]
    placement = base.placement * _se3(T_newbase_base).inverse()
    name, index = _add_frame(model, base.parentJoint, chain.base_id, placement, name, "world")
    if gravity is not None:
        model.gravity.linear = placement.rotation @ gravity
    R, p = T_newbase_base[:3, :3], T_newbase_base[:3, 3]
    return replace(
        chain,
        model=model,
        base=name,
        base_id=index,
        axes=chain.axes @ R.T,
        points=chain.points @ R.T + p,
        T_base_tip_zero=T_newbase_base @ chain.T_base_tip_zero,
    )


def with_load(chain: Chain, load: Any) -> Chain:
    """The chain with a ``pinocchio.Inertia``, in its tip frame, in its hand.

    Raises:
        InvalidRobot: no joint of the chain has a mass: the weight of the load alone would be taken for that of all.
    """
    if not any(inertia.mass > 0.0 for inertia in chain.model.inertias):
        raise InvalidRobot(f"the description of {chain.model.name!r} has no masses: what it holds has none, either")
    model = pin.Model(chain.model)
    model.appendBodyToJoint(7, load, model.frames[chain.tip_id].placement)
    return replace(chain, model=model, load=chain.load + load.mass)


def within_limits(chain: Chain, limits: Mapping[str, Mapping[str, float]], others: Collection[str] = ()) -> Chain:
    """The chain with other limits; infinite ones are none.

    Args:
        chain: the chain, which stays as it is.
        limits: for each joint in question those of "lower", "upper" (rad), "velocity" (rad/s), "effort" (N m) and
            "acceleration" (rad/s^2) that change; or as MoveIt's joint_limits.yaml has them ("max_velocity" with
            "has_velocity_limits" ...), whose decelerations and jerks are left out.
        others: other joints of the robot. Limits for them are left out beside those for joints of the chain: a file has
            them for both arms, and for grippers.

    Raises:
        InvalidRobot: limits are no mapping of mappings, a joint or limit of that name does not exist, a limit is no
            number, lower is above upper, a velocity, effort or acceleration is not positive, or what MoveIt switches
            limits with is not true or false.
    """
    arrays: dict[str, Any] = {field: np.array(getattr(chain, field)) for field in _LIMITS.values()}
    if not isinstance(limits, Mapping) or not all(isinstance(changes, Mapping) for changes in limits.values()):
        raise InvalidRobot(f"limits are given as {{joint: {{limit: figure}}}}, not as {quoted(limits)}")
    own = not set(chain.joint_names).isdisjoint(limits)
    for joint, changes in limits.items():
        if own and joint in others:
            continue
        if joint not in chain.joint_names:
            hint = did_you_mean(joint, chain.joint_names) if isinstance(joint, str) else ""
            raise InvalidRobot(
                f"limits are given for {quoted(joint)}{hint}; the joints are {listed(chain.joint_names)}"
            )
        k = chain.joint_names.index(joint)
        changes = _named_as_here(joint, changes)
        for key, value in changes.items():
            if key not in _LIMITS:
                hint = did_you_mean(key, (*_LIMITS, *_OF_MOVEIT)) if isinstance(key, str) else ""
                raise InvalidRobot(
                    f"joint {joint!r} has no limit {quoted(key)}{hint}; limits are {listed(list(_LIMITS))}, "
                    "or named as in MoveIt's joint_limits.yaml"
                )
            arrays[_LIMITS[key]][k] = _figure(value, f"{key} of joint {joint!r}")
        lower, upper = unlimited_if_huge(arrays["lower"][k], arrays["upper"][k])
        _warn_of_degrees(joint, changes)
        if not (lower <= upper and lower < np.inf and upper > -np.inf):
            raise InvalidRobot(f"joint {joint!r} has the lower limit {lower} and the upper limit {upper}, no range")
        arrays["lower"][k], arrays["upper"][k] = lower, upper
        for key in ("velocity", "effort", "acceleration"):
            if not arrays[_LIMITS[key]][k] > 0.0:
                raise InvalidRobot(f"the {key} of joint {joint!r} must be positive; inf where there is no limit")
    _warn_of_fast_joints(chain, arrays["velocity_limit"])
    model = pin.Model(chain.model)
    for k in range(7):
        joint = model.joints[k + 1]
        if joint.nq == 1:
            model.lowerPositionLimit[joint.idx_q] = arrays["lower"][k]
            model.upperPositionLimit[joint.idx_q] = arrays["upper"][k]
    model.velocityLimit = arrays["velocity_limit"]
    model.effortLimit = arrays["effort_limit"]
    return replace(chain, model=model, **arrays)


def _named_as_here(joint: str, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Changes of one joint by the names of `_LIMITS`; limits that a file of MoveIt switches off are left out.

    Raises:
        InvalidRobot: what is to switch limits on or off is neither.
    """
    switches = {switch for _, switch in _OF_MOVEIT.values()}
    for switch in sorted(switches & set(changes)):
        if not isinstance(changes[switch], bool | np.bool_):
            raise InvalidRobot(f"{switch} of joint {joint!r} must be true or false, not {quoted(changes[switch])}")
    found = {}
    for key, value in changes.items():
        if key in _OF_MOVEIT:
            name, switch = _OF_MOVEIT[key]
            if changes.get(switch, True):
                found[name] = value
        elif key not in _LEFT_OUT and key not in switches:
            found[key] = value
    return found


def by_joint(joint_names: Sequence[str], given: Mapping[str, ArrayLike | None]) -> dict[str, dict[str, float]]:
    """Limits as `within_limits` takes them, from seven figures of each kind; those that are None stay.

    Raises:
        InvalidRobot: not seven numbers.
    """
    figures = {key: vector_of(values, 7, key, InvalidRobot) for key, values in given.items() if values is not None}
    return {name: {key: float(figures[key][k]) for key in figures} for k, name in enumerate(joint_names)}


def _warn_of_degrees(joint: str, changes: Mapping[str, float]) -> None:
    figures = [float(changes[key]) for key in ("lower", "upper") if key in changes]
    largest = max((abs(figure) for figure in figures if np.isfinite(figure)), default=0.0)
    if 4.0 * np.pi < largest <= 720.0:
        said = f"limits are in radians, and joint {joint!r} is given {largest:g}: are these degrees?"
        warn_caller(said)


def _warn_of_fast_joints(chain: Chain, velocity: Array) -> None:
    """Warn where velocities that change are more than joints go at: they may be degrees."""
    fast = (velocity > FASTEST) & (velocity < np.inf) & (velocity != chain.velocity_limit)
    if fast.any():
        k = int(fast.argmax())
        said = f"velocities are in rad/s, and joint {chain.joint_names[k]!r} is given {velocity[k]:g}"
        warn_caller(f"{said}: are these degrees?")


def _figure(value: Any, what: str) -> float:
    figure = real_number(value)
    if np.isnan(figure):
        raise InvalidRobot(f"{what} must be a number, not {quoted(value)}")
    return figure


def _add_frame(model: Any, joint: int, parent: int, placement: Any, name: str | None, default: str) -> tuple[str, int]:
    taken = {frame.name for frame in model.frames}
    if name is None:
        name = next(n for n in (default, *(f"{default}_{k}" for k in range(2, len(taken) + 3))) if n not in taken)
    elif not isinstance(name, str) or not name:
        raise InvalidRobot(f"the name of a frame is text, not {quoted(name)}", model.name)
    elif name in taken:
        where = "name= of with_tool or with_base, or in an adapter name of [tool] or [mount]"
        raise InvalidRobot(f"{model.name!r} has a frame {name!r} already; choose another name: {where}", model.name)
    return name, model.addFrame(pin.Frame(name, joint, parent, placement, pin.FrameType.OP_FRAME))


def _se3(T: Array) -> Any:
    return pin.SE3(T[:3, :3].copy(), T[:3, 3].copy())


def _rigid(T: Array) -> Array:
    """The transform with the rotation nearest to its own, one to a millionth; InvalidRobot beyond `bounds.FARTHEST`."""
    if np.abs(T[:3, 3]).max() > bounds.FARTHEST:
        raise InvalidRobot(f"a tool or base is no farther away than {bounds.FARTHEST:g} m, and xyz is in metres")
    U, _, V = np.linalg.svd(T[:3, :3])
    rigid = np.eye(4)
    rigid[:3, :3], rigid[:3, 3] = U @ V, T[:3, 3]
    return rigid
