"""Where the joints stand that are no part of the arm."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pinocchio as pin

from srs_ik.errors import InvalidRobot, did_you_mean, listed, quoted, warn_caller
from srs_ik.inputs.numbers import real_number
from srs_ik.robot.description.check import Follower
from srs_ik.robot.limb import Vector
from srs_ik.robot.skeleton import is_prismatic, is_revolute, limits_of

ROUNDING = 1e-9
"""How far beyond a limit, rad or m, a position may be that somebody has typed from it."""


TYPED = 1e-3
"""By how much figures that somebody has typed may differ from what follows from others, rad or m."""


def as_locked(locked: Any, model: Any, followers: Mapping[str, Follower]) -> dict[str, float]:
    """Positions of joints by name, rad or m, checked; a warning tells of those that look like degrees.

    A joint that follows another one is warned of, too, where that one is not locked: its leader may be of the arm.

    Args:
        locked: what was given, a mapping.
        model: ``pinocchio.Model`` of the whole robot.
        followers: how joints follow others.

    Raises:
        InvalidRobot: it is no mapping from joints that turn or slide to finite positions inside their limits, or a
            joint is not where it follows another one of them.
    """
    if not isinstance(locked, Mapping):
        raise InvalidRobot(f"locked is given as {{joint: position}}, not as {quoted(locked)}")
    found = {name: _position(model, name, value) for name, value in locked.items()}
    for name in found:
        follower = followers.get(name)
        if follower is None:
            continue
        leader, (_, multiplier, offset) = follower.leader, follower
        if multiplier == 0.0:
            if abs(found[name] - offset) > TYPED:
                raise InvalidRobot(
                    f"{name!r} is held at {offset:g} by the file, and cannot be locked at {found[name]:g}"
                )
        elif leader not in found:
            said = f"{name!r} is locked at {found[name]:g} and mimics {listed([leader])}, which is not locked"
            warn_caller(f"{said}: it stays there while its leader moves")
        elif abs(found[name] - (there := multiplier * found[leader] + offset)) > TYPED:
            said = f"{name!r} mimics {leader!r}, which is locked at {found[leader]:g}"
            raise InvalidRobot(f"{said}: it stands at {there:g} then, not at {found[name]:g}")
    return found


def with_followers(model: Any, locked: Mapping[str, float], followers: Mapping[str, Follower]) -> dict[str, float]:
    """Positions of joints that are locked, and of those that follow them or others at zero, rad or m.

    Those at zero that nobody has named are left out.
    """

    def position(name: str, behind: tuple[str, ...] = ()) -> float:
        if name in locked or name not in followers or name in behind:
            return locked.get(name, 0.0)
        leader, multiplier, offset = followers[name]
        return multiplier * position(leader, (*behind, name)) + offset

    led = {name: position(name) for name in followers if name not in locked and _is_single(model, name)}
    return {**{name: x for name, x in led.items() if x != 0.0}, **locked}


def _is_single(model: Any, name: str) -> bool:
    joint = model.joints[model.getJointId(name)]
    return is_revolute(joint) or is_prismatic(joint)


def _position(model: Any, name: Any, value: Any) -> float:
    names = list(model.names)[1:]
    if name not in names:
        hint = did_you_mean(name, names) if isinstance(name, str) else ""
        raise InvalidRobot(f"there is no joint {quoted(name)} to lock{hint}; the joints are {listed(names)}")
    joint = model.joints[model.getJointId(name)]
    if joint.shortname() == "JointModelMimic":
        raise InvalidRobot(f"joint {name!r} follows another joint of the model, and is where that one has it")
    if not (is_revolute(joint) or is_prismatic(joint)):
        raise InvalidRobot(f"joint {name!r} neither turns about one axis nor slides along one: it has no position")
    position = real_number(value)
    if not np.isfinite(position):
        raise InvalidRobot(f"joint {name!r} is locked at a finite number, rad or m, not at {quoted(value)}")
    lower, upper = limits_of(model, joint)
    if not lower - ROUNDING <= position <= upper + ROUNDING:
        raise InvalidRobot(f"joint {name!r} goes from {lower:g} to {upper:g} and cannot be locked at {position:g}")
    if is_revolute(joint) and abs(position) > 2.0 * np.pi:
        said = f"locked is in radians, and joint {name!r} is given {position:g}, more than a turn"
        warn_caller(f"{said}: are these degrees?")
    return position


def configuration_of(model: Any, locked: Mapping[str, float]) -> Vector:
    """(nq,) Pinocchio's neutral configuration, but for the joints that are locked elsewhere."""
    configuration = np.array(pin.neutral(model))
    for name, position in locked.items():
        joint = model.joints[model.getJointId(name)]
        if joint.nq == 0:
            continue  # follows another one in this model
        whole = [position] if joint.nq == 1 else [np.cos(position), np.sin(position)]
        configuration[joint.idx_q : joint.idx_q + joint.nq] = whole
    return configuration
