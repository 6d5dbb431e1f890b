"""The weight of an arm: the torques that hold it, by Pinocchio."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from srs_ik.errors import InvalidTask
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.kinematics import ChainKinematics


def gravity_torque(arm: ChainKinematics, otherwise: str) -> Callable[[Array], Array]:
    """The function of seven joint angles (7,) that gives the joint torques (7,) which hold the arm up, N m.

    Raises:
        InvalidTask: the arm's description has no masses; the message says what to do otherwise.
    """
    require_masses(arm, otherwise)
    model, data = arm.model, arm.model.createData()
    return lambda q: np.array(pin.computeGeneralizedGravity(model, data, arm.configuration(q)))


def require_masses(arm: ChainKinematics, otherwise: str) -> None:
    """Raise InvalidTask, with a word on what to do, for an arm whose description has no masses."""
    if not any(inertia.mass > 0.0 for inertia in arm.model.inertias):
        raise InvalidTask(f"the description of {arm.name} has no masses; {otherwise}")


def torque_scales(arm: ChainKinematics) -> Array:
    """(7,) factors by which torques of different joints compare: by their effort limits, if all are given."""
    return 1.0 / arm.effort_limit if np.isfinite(arm.effort_limit).all() else np.ones(7)
