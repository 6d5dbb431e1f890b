"""Where the joints stand that are no part of the arm."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pinocchio as pin

from srs_ik.errors import InvalidRobot, did_you_mean, listed, quoted, warn_caller
from srs_ik.inputs.numbers import real_number
from srs_ik.robot.limb import Vector
from srs_ik.robot.skeleton import is_prismatic, is_revolute, limits_of

ROUNDING = 1e-9
"""How far beyond a limit, rad or m, a position may be that somebody has typed from it."""


def as_locked(locked: Any, model: Any, follows: Mapping[str, str]) -> dict[str, float]:
    """Positions of joints by name, rad or m, checked; a warning tells of those that look like degrees.

    A joint that follows another one is warned of, too, where that one is not locked: its leader may be of the arm.

    Args:
        locked: what was given, a mapping.
        model: ``pinocchio.Model`` of the whole robot.
        follows: for each joint that follows another one a clause that says so.

    Raises:
        InvalidRobot: it is no mapping from joints that turn or slide to finite positions inside their limits, or a
            joint that follows one of them is left out.
    """
    if not isinstance(locked, Mapping):
        raise InvalidRobot(f"locked is given as {{joint: position}}, not as {quoted(locked)}")
    found = {name: _position(model, name, value) for name, value in locked.items()}
    for name in found:
        left = [
            follower for follower, clause in follows.items() if clause == f"mimics {name}" and follower not in found
        ]
        if left:
            raise InvalidRobot(f"{left[0]!r} mimics {name!r}, which is locked: give its position too")
        clause = follows.get(name, "")
        if clause.startswith("mimics ") and clause not in {f"mimics {leader}" for leader in found}:
            said = f"{name!r} is locked at {found[name]:g} and {clause}, which is not locked"
            warn_caller(f"{said}: it stays there while its leader moves")
    return found


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
        whole = [position] if joint.nq == 1 else [np.cos(position), np.sin(position)]
        configuration[joint.idx_q : joint.idx_q + joint.nq] = whole
    return configuration
