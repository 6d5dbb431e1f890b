"""What an arm meets in a simulation: walls, pegs, boxes, and a payload in its hand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.errors import InvalidController
from srs_ik.inputs.numbers import real_array, real_number
from srs_ik.inputs.poses import PoseLike
from srs_ik.robot.limb import Vector


@dataclass(frozen=True)
class Wall:
    """A half-space that nothing enters, in the base frame.

    Attributes:
        point: (3,) on its surface, m.
        normal: (3,) away from the wall, of any length.
        whole: whether the whole arm meets it; else the ball at the tip alone, as an arm may stand behind a wall.
    """

    point: ArrayLike
    normal: ArrayLike
    whole: bool = False


@dataclass(frozen=True)
class Peg:
    """A round bar that stands fast, in the base frame.

    Attributes:
        start: (3,) one end of its axis, m.
        end: (3,) the other one, m.
        radius: m.
    """

    start: ArrayLike
    end: ArrayLike
    radius: float = 0.02


@dataclass(frozen=True)
class Box:
    """A box that stands fast.

    Attributes:
        pose: of its centre in the base frame.
        size: (3,) edges, m.
    """

    pose: PoseLike
    size: ArrayLike


@dataclass(frozen=True)
class Payload:
    """A ball in the hand that no controller knows of.

    Attributes:
        mass: kg.
        centre: (3,) in the tip frame, m.
        radius: m; it has the inertia of a solid ball.
    """

    mass: float
    centre: ArrayLike = (0.0, 0.0, 0.0)
    radius: float = 0.04


@dataclass(frozen=True)
class World:
    """What there is around the arm.

    Attributes:
        walls: half-spaces.
        pegs: round bars.
        payload: what the hand holds.
        tip_radius: radius of the ball at the tip, m.
        arm_radius: radius of the bars that stand for upper arm and forearm where there are no shapes, m.
        boxes: boxes. They, pegs and whole walls meet the ball at the tip and the whole arm.
        shapes: whether the arm is the collision shapes of its file, or else the visual ones, meshes as their convex
            hulls; where the file has none at hand, or for False, it is two bars.
    """

    walls: tuple[Wall, ...] = ()
    pegs: tuple[Peg, ...] = ()
    payload: Payload | None = None
    tip_radius: float = 0.02
    arm_radius: float = 0.04
    boxes: tuple[Box, ...] = ()
    shapes: bool = True

    @property
    def meets_the_arm(self) -> bool:
        """Whether there is anything that meets more than the tip."""
        return bool(self.pegs or self.boxes or any(wall.whole for wall in self.walls))


def vector(value: Any, what: str) -> Vector:
    """Three finite numbers.

    Raises:
        InvalidController: they are not; `what` names them.
    """
    try:
        numbers = real_array(value)
    except (TypeError, ValueError):
        numbers = np.empty(0)
    if numbers.shape != (3,) or not np.isfinite(numbers).all():
        raise InvalidController(f"the {what} is (3,) finite numbers, not {value!r}")
    return numbers


def positive(value: Any, what: str) -> float:
    """A positive number.

    Raises:
        InvalidController: it is none; `what` names it.
    """
    number = real_number(value)
    if not 0.0 < number < np.inf:
        raise InvalidController(f"the {what} is a positive number, not {value!r}")
    return number
