"""What an arm meets in a simulation: walls, pegs, boxes, and a payload in its hand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.errors import InvalidController
from srs_ik.inputs.control import flag, positive, thing, things, vector
from srs_ik.inputs.poses import PoseLike, as_rigid_matrix

SHORTEST = 1e-9
"""A shorter normal of a wall has no direction."""


@dataclass(frozen=True)
class Wall:
    """A half-space that nothing enters, in the base frame.

    Attributes:
        point: (3,) on its surface, m.
        normal: (3,) away from the wall, of any length.
        whole: whether the whole arm meets it; else the ball at the tip alone, as an arm may stand behind a wall.

    Raises:
        InvalidController: not three finite numbers each, or a normal without direction.
    """

    point: ArrayLike
    normal: ArrayLike
    whole: bool = False

    def __post_init__(self) -> None:
        vector(self.point, "point of a wall")
        if np.linalg.norm(vector(self.normal, "normal of a wall")) < SHORTEST:
            raise InvalidController("the normal of a wall has no direction")
        flag(self.whole, "whole")


@dataclass(frozen=True)
class Peg:
    """A round bar that stands fast, in the base frame.

    Attributes:
        start: (3,) one end of its axis, m.
        end: (3,) the other one, m.
        radius: m.

    Raises:
        InvalidController: an end is not three finite numbers, or the radius not positive.
    """

    start: ArrayLike
    end: ArrayLike
    radius: float = 0.02

    def __post_init__(self) -> None:
        for end in (self.start, self.end):
            vector(end, "end of a peg")
        positive(self.radius, "radius of a peg")


@dataclass(frozen=True)
class Box:
    """A box that stands fast.

    Attributes:
        pose: of its centre in the base frame.
        size: (3,) edges, m.

    Raises:
        InvalidPose: the pose is no finite rigid transform.
        InvalidController: not three positive edges.
    """

    pose: PoseLike
    size: ArrayLike

    def __post_init__(self) -> None:
        as_rigid_matrix(self.pose)
        for edge in vector(self.size, "size of a box"):
            positive(edge, "edge of a box")


@dataclass(frozen=True)
class Payload:
    """A ball in the hand that no controller knows of.

    Attributes:
        mass: kg.
        centre: (3,) in the tip frame, m.
        radius: m; it has the inertia of a solid ball.

    Raises:
        InvalidController: a figure that is none, or not positive.
    """

    mass: float
    centre: ArrayLike = (0.0, 0.0, 0.0)
    radius: float = 0.04

    def __post_init__(self) -> None:
        positive(self.mass, "mass of a payload")
        vector(self.centre, "centre of a payload")
        positive(self.radius, "radius of a payload")


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

    Raises:
        InvalidController: a thing of another class, or a radius that is not positive.
    """

    walls: tuple[Wall, ...] = ()
    pegs: tuple[Peg, ...] = ()
    payload: Payload | None = None
    tip_radius: float = 0.02
    arm_radius: float = 0.04
    boxes: tuple[Box, ...] = ()
    shapes: bool = True

    def __post_init__(self) -> None:
        for name, kind in (("walls", Wall), ("pegs", Peg), ("boxes", Box)):
            object.__setattr__(self, name, things(getattr(self, name), kind, name))
        if self.payload is not None:
            thing(self.payload, Payload, "payload")
        for name in ("tip_radius", "arm_radius"):
            positive(getattr(self, name), name)
        flag(self.shapes, "shapes")

    @property
    def meets_the_arm(self) -> bool:
        """Whether there is anything that meets more than the tip."""
        return bool(self.pegs or self.boxes or any(wall.whole for wall in self.walls))
