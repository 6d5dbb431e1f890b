"""An answer of inverse kinematics: a posture with its status and its measured errors."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from srs_ik.kernels.layout import answer as at
from srs_ik.system.arrays import Array


class Status(IntEnum):
    """What an answer is worth.

    A status is equal to its name as text and to its number, which arrays hold: ``solution.status == "OK"`` and
    ``(batch.status == Status.OK).sum()``. It hashes as its number: `in` finds names in a list or tuple of them, and
    sets and dictionaries want members of `Status`. It has no truth value, since 0 stands for success; a `Solution` has.
    """

    OK = 0
    """The posture reaches the pose: both errors are below 1e-9 (m, rad), limits kept if they were to be."""
    UNREACHABLE = 1
    """No posture reaches the pose; the closest one is given: the arm stretched, or folded, towards the target."""
    OUT_OF_LIMITS = 2
    """Postures reach the pose, but none inside the joint limits; the least violating one is given, put on limits."""
    COLLISION = 3
    """Postures inside the limits reach the pose, but each hits something; that of largest clearance is given."""

    def __str__(self) -> str:
        return self.name

    def __format__(self, spec: str) -> str:
        return format(self.name, spec)

    def __eq__(self, other: object) -> bool:
        return self.name == other if isinstance(other, str) else super().__eq__(other)

    def __ne__(self, other: object) -> bool:
        return self.name != other if isinstance(other, str) else super().__ne__(other)

    # What an array holds and what it is compared with belong into one dictionary.
    __hash__ = IntEnum.__hash__

    def __bool__(self) -> bool:
        raise TypeError("a status has no truth value: compare it with Status.OK, or test the solution itself")


_STATUSES = tuple(Status)
_OK = float(Status.OK)
"""A float of NumPy would take 3 us to be compared with the enumeration."""


_NO_ERROR = 1e-9
"""Errors below this, m or rad, are those of a solution, and no part of what is wrong."""

_FAR = 10.0
"""Who misses a pose by more than this, metres, has probably been given it in another unit."""

_ON_THE_SPOT = 1e-6
"""A joint this near to an angle, rad, is at it."""


ASKED = "", " at the arm angle asked for", " in the branch asked for", " in the branch and at the arm angle asked for"
"""What a pose was asked with, for messages."""


class ElbowRange(NamedTuple):
    """What joint 4 can do; with it, the message of an answer out of reach says how the arm lies."""

    straight: float
    """Angle at which the wrist is farthest from the shoulder, rad."""
    lower: float
    """Lower limit, rad; -inf where continuous."""
    upper: float
    """Upper limit, rad; inf where continuous."""
    asked: str = ASKED[0]
    """What else than the pose an answer was to have."""


class Collision(NamedTuple):
    """Two bodies that meet, or come closer than the margin."""

    first: str
    """A link of the arm, or what it holds."""
    second: str
    """Another one, or an object of the scene."""
    depth: float
    """How much is missing to the margin, m, by the spheres; how deep they are in each other where that is zero."""


class Solution:
    """One posture for one pose; true in a boolean test if and only if its status is `Status.OK`."""

    __slots__ = ("_elbow", "_joint_names", "_row", "collision")

    def __init__(
        self,
        row: Array,
        joint_names: Sequence[str],
        elbow: ElbowRange | None = None,
        collision: Collision | None = None,
    ) -> None:
        self._row = row
        self._joint_names = joint_names
        self._elbow = elbow
        self.collision = collision
        """What hits what, where the status is `Status.COLLISION`; else None."""

    @property
    def q(self) -> Array:
        """(7,) joint angles, rad; finite in every status."""
        return self._row[: at.ROW_POSITION_ERROR]

    @property
    def status(self) -> Status:
        """Whether the pose is reached, and if not, why."""
        return _STATUSES[int(self._row[at.ROW_STATUS])]

    @property
    def branch(self) -> int:
        """Branch, 4 elbow + 2 shoulder + wrist, each 0 or 1: the side of its middle angle on which the joint lies."""
        return int(self._row[at.ROW_BRANCH])

    @property
    def arm_angle(self) -> float:
        """Arm angle (swivel angle, SEW angle) in [-pi, pi), rad: right-handed about shoulder-wrist."""
        return float(self._row[at.ROW_ARM_ANGLE])

    @property
    def position_error(self) -> float:
        """Distance of the tip at `q` from the pose, metres, by forward kinematics of the chain as described."""
        return float(self._row[at.ROW_POSITION_ERROR])

    @property
    def orientation_error(self) -> float:
        """Angle between the tip at `q` and the pose, rad."""
        return float(self._row[at.ROW_ORIENTATION_ERROR])

    @property
    def message(self) -> str:
        """One sentence for a person: how well the pose is met, or what is in the way and what is left of the error."""
        if self.status is Status.OK:
            errors = f"{self.position_error:.2g} m and {self.orientation_error:.2g} rad"
            return f"Solved in branch {self.branch} at arm angle {round(self.arm_angle, 9) + 0.0:.6g} rad, to {errors}."
        if self.status is Status.UNREACHABLE:
            unit = " Positions are in metres: is this one in millimetres?" if self.position_error > _FAR else ""
            none = f"No posture{self._asked()} was found that reaches the pose"
            return f"{none}; the one given{self._lie()} misses it by {self._miss()}.{unit}"
        if self.status is Status.COLLISION:
            return f"Postures inside the limits reach the pose, but each hits something{self._hit()}."
        joint = int(self._row[at.ROW_JOINT])
        stop = f" stops at {np.rad2deg(self.q[joint - 1]):.6g} deg"
        where = f"; {self._joint_names[joint - 1]}{stop}" if joint else ""
        return (
            f"The pose is within reach, but no posture{self._asked()} was found that keeps the joint limits"
            f"{where}, and the posture given misses it by {self._miss()}."
        )

    def _asked(self) -> str:
        """What else than the pose was asked for."""
        return "" if self._elbow is None else self._elbow.asked

    def _hit(self) -> str:
        """What hits what, as the end of a sentence."""
        if self.collision is None:
            return ""
        first, second, depth = self.collision
        return f": in the one given {first} and {second} are {1e3 * depth:.3g} mm too close"

    def _miss(self) -> str:
        """The errors that are more than rounding."""
        errors = (self.position_error, "m"), (self.orientation_error, "rad")
        return " and ".join(f"{error:.3g} {unit}" for error, unit in errors if error >= _NO_ERROR) or "rounding alone"

    def _lie(self) -> str:
        """How the arm lies in an answer out of reach, as far as that is known."""
        if self._elbow is None:
            return ""
        q4 = float(self.q[3])
        bend = abs((q4 - self._elbow.straight + np.pi) % (2.0 * np.pi) - np.pi)
        lie = "stretched" if bend < 0.5 * np.pi else "folded"
        if min(bend, np.pi - bend) < _ON_THE_SPOT:
            return f", with the arm {lie},"
        if min(abs(q4 - self._elbow.lower), abs(q4 - self._elbow.upper)) < _ON_THE_SPOT:
            return f", with the arm {lie} as far as {self._joint_names[3]} goes ({np.rad2deg(q4):.6g} deg),"
        return ""

    def as_dict(self) -> dict[str, float]:
        """Joint angles by joint name, rad, in the order of the joints."""
        return dict(zip(self._joint_names, self.q.tolist(), strict=True))

    def __bool__(self) -> bool:
        return bool(self._row.item(at.ROW_STATUS) == _OK)

    def __repr__(self) -> str:
        return (
            f"Solution(status={self.status.name}, q={np.array2string(self.q, precision=6)}, branch={self.branch}, "
            f"arm_angle={self.arm_angle:.6g}, position_error={self.position_error:.3g}, "
            f"orientation_error={self.orientation_error:.3g})"
        )
