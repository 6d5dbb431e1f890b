"""The limb: what is left of a robot description once its seven joint axes are read as lines in space."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Kind = Literal["exact", "near"]
WristKind = Literal["XYX", "XYZ"]

EXACT_MISS = 1e-6
"""An arm is *exact* when every axis passes its centre within this distance, in metres."""

CLOSED_MISS = 1e-12
"""Axes that pass their centres within this distance, metres, leave nothing for Newton's method to do."""


class Hand(NamedTuple):
    """Axes of the hand in the tip frame."""

    grasp: tuple[float, float, float]
    """Direction in which the hand reaches out, the paper's g."""
    pronosupination: tuple[float, float, float]
    """Direction across it that turns with the forearm, the paper's phi."""


class ReadOnlyArrays:
    """A dataclass whose arrays are read-only, in copies too: NumPy forgets that when an array is copied or pickled.

    Kernels are compiled for read-only arrays apart, and an array that took changes would hide that they are ignored.
    """

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def __setstate__(self, state: dict[str, object]) -> None:
        vars(self).update(state)
        self.__post_init__()


@dataclass(frozen=True, eq=False)
class SrsLimb(ReadOnlyArrays):
    """A spherical-revolute-spherical limb, in the base frame at the zero configuration; its arrays are read-only.

    Attributes:
        axes: (7, 3) unit directions of the joint axes.
        points: (7, 3) a point on each joint axis, metres.
        T_base_tip_zero: (4, 4) pose of the tip frame at the zero configuration.
        shoulder: (3,) shoulder centre S, the common point of axes 1 to 3; if they miss each other, the point of axis 1
            that is nearest to the others.
        elbow: (3,) elbow centre E, the point of axis 4 nearest to axes 3 and 5; where rounding in the description
            leans that axis, the point that is on the line S-W when the arm is stretched out.
        wrist: (3,) wrist centre W, the common point of axes 5 to 7; if they miss each other, the point of axis 7
            that is nearest to the others.
        reference: (3,) unit vector; the arm angle is zero where the elbow lies in the half-plane that starts at the
            line S-W and contains this direction. The default is the direction of axis 1, its largest component
            positive.
        misses: (7,) distance of each axis from the point that is nearest to all three of its joint, metres; zero for
            axis 4.
        wrist_kind: "XYX" if axes 5 and 7 are nearer to parallel than to perpendicular at zero, else "XYZ".
    """

    axes: Vector
    points: Vector
    T_base_tip_zero: Vector
    shoulder: Vector
    elbow: Vector
    wrist: Vector
    reference: Vector
    misses: Vector
    wrist_kind: WristKind

    @cached_property
    def offsets(self) -> Vector:
        """(7,) distance of each axis from its centre, metres; zero for axes 1, 4 and 7."""
        centres = (self.shoulder, self.shoulder, self.shoulder, None, self.wrist, self.wrist, self.wrist)
        lines = zip(centres, self.points, self.axes, strict=True)
        offsets = np.array([0.0 if c is None else line_distance(c, p, a) for c, p, a in lines])
        offsets.flags.writeable = False
        return offsets

    @cached_property
    def kind(self) -> Kind:
        """Either "exact", if all axes pass their centres within 1e-6 m, or "near", solved on the true axes."""
        return "exact" if float(self.misses.max()) < EXACT_MISS else "near"

    @cached_property
    def upper_arm(self) -> float:
        """Distance from the shoulder to the elbow centre, metres."""
        return float(np.linalg.norm(self.elbow - self.shoulder))

    @cached_property
    def forearm(self) -> float:
        """Distance from the elbow to the wrist centre, metres."""
        return float(np.linalg.norm(self.wrist - self.elbow))

    @cached_property
    def hand(self) -> float:
        """Distance from the wrist centre to the origin of the tip frame, metres."""
        return float(np.linalg.norm(self.T_base_tip_zero[:3, 3] - self.wrist))

    @cached_property
    def elbow_offset(self) -> float:
        """Larger distance of the elbow centre from axis 3 and from axis 5, metres; zero where all three axes meet.

        An axis counts where it runs along its segment, within 45 degrees: one across it, such as axis 5 of a wrist
        without forearm roll, does not pass the elbow at all.
        """
        lengths = {2: self.upper_arm, 4: self.forearm}
        offsets = {i: line_distance(self.elbow, self.points[i], self.axes[i]) for i in lengths}
        return max((offset for i, offset in offsets.items() if offset < math.sqrt(0.5) * lengths[i]), default=0.0)


def line_distance(point: Vector, line_point: Vector, line_direction: Vector) -> float:
    """Distance of a point from a line given by a point and a unit direction, in the unit of the points."""
    return float(np.linalg.norm(point - line_foot(point, line_point, line_direction)))


def line_foot(point: Vector, line_point: Vector, line_direction: Vector) -> Vector:
    """The point of a line, given by a point and a unit direction, that is nearest to a point."""
    foot: Vector = line_point + line_direction * float(line_direction @ (point - line_point))
    return foot
