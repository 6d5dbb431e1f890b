"""`TrackerStep`: what a tracker answers to one update."""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import StrEnum

import numpy as np

from srs_ik.kernels.layout import track as at
from srs_ik.solve.solution import Collision
from srs_ik.system.arrays import Array


class TrackerStatus(StrEnum):
    """How an update went; equal to its name as text. It has no truth value, since any text is true; a step has."""

    OK = "OK"
    """The tip is on the target."""
    LIMITED = "LIMITED"
    """The arm is on its way to the target, within its limits."""
    HELD = "HELD"
    """There is no target to follow, only another configuration reaches it, or bodies of a scene are in the way."""
    UNREACHABLE = "UNREACHABLE"
    """No posture reaches the target; the arm goes as close to it as it comes."""

    def __bool__(self) -> bool:
        raise TypeError("a status has no truth value: compare it with TrackerStatus.OK, or test the step itself")


_STATUSES = tuple(TrackerStatus)

RESTS = 1e-3
"""An arm all of whose joints are slower than this, rad/s, stays where it is."""

AT_LIMIT = 1e-3
"""A joint this close to its limit, rad, stands at it."""


class TrackerStep:
    """What a tracker answers to one update; the joint angles are to be sent to the robot for the end of the period."""

    __slots__ = ("_joint_names", "_limits", "_row", "collision")

    def __init__(
        self,
        row: Array,
        joint_names: Sequence[str],
        limits: tuple[Array, Array],
        collision: Collision | None = None,
    ) -> None:
        self._row = row
        self._joint_names = joint_names
        self._limits = limits
        self.collision = collision
        """Which two bodies hold the arm, with a depth of zero where they do not meet yet; None if none do."""

    @property
    def q(self) -> Array:
        """(7,) joint angles, rad."""
        return self._row[at.STEP_Q : at.STEP_V]

    @property
    def velocity(self) -> Array:
        """(7,) mean joint velocities on the way to `q`, rad/s."""
        return self._row[at.STEP_V : at.STEP_A]

    @property
    def acceleration(self) -> Array:
        """(7,) how much the velocities have changed since the update before, over the period, rad/s^2."""
        return self._row[at.STEP_A : at.STEP_STATUS]

    @property
    def status(self) -> TrackerStatus:
        """How it went."""
        return _STATUSES[int(self._row[at.STEP_STATUS])]

    @property
    def joint(self) -> str | None:
        """Name of the joint that is farthest behind, by its speed; None with the tip on the target.

        Where the arm rests off the target, no joint is behind: then the one that stands at its limit, if any does.
        """
        number = int(self._row[at.STEP_JOINT])
        if number and self._rests():
            lower, upper = self._limits
            left = np.minimum(self.q - lower, upper - self.q)
            number = 1 + int(left.argmin()) if left.min() < AT_LIMIT else 0
        return self._joint_names[number - 1] if number else None

    def _rests(self) -> bool:
        """Whether the arm stays where it is, off the target."""
        return bool(self._row[at.STEP_STATUS] >= at.HELD and np.abs(self.velocity).max() < RESTS)

    @property
    def position_error(self) -> float:
        """How far the tip is from the target at `q`, m; from where it is expected, while it is lost."""
        return float(self._row[at.STEP_POSITION_ERROR])

    @property
    def orientation_error(self) -> float:
        """How far it is turned away from it, rad."""
        return float(self._row[at.STEP_ORIENTATION_ERROR])

    @property
    def message(self) -> str:
        """One sentence for a person."""
        reason, lost = self._row[at.STEP_REASON], int(self._row[at.STEP_LOST])
        if self.collision is not None:
            return self._held(self.collision)
        if reason == at.NO_REASON:
            return "On the target."
        if reason == at.NO_TARGET_YET:
            return "Waiting for the first target."
        updates = f"{lost} update{'s' if lost != 1 else ''}"
        if reason == at.LOST_TARGET:
            return f"No target for {updates}: the arm slows down on the way that it was on."
        if reason == at.BAD_TARGET:
            return f"No pose: the target is not finite or no rigid transform, and none was for {max(lost, 1)} updates."
        away = self._away()
        if reason == at.BEHIND:
            return f"{self.joint} cannot move faster: the tip is {away} behind."
        if reason == at.ON_THE_WAY:
            return f"On the way to the target, which is {away} away."
        if reason == at.OTHER_POSTURE:
            return f"Only another configuration reaches the target, {away} away: reconfigure() goes there."
        if reason == at.OUT_OF_REACH:
            return f"The target is out of reach: the tip stays {away} away."
        stops = f", and {self.joint} stands at its limit" if self.joint and self._rests() else ""
        return f"No posture inside the joint limits reaches the target: the tip stays {away} away{stops}."

    def _away(self) -> str:
        return f"{1e3 * self.position_error:.3g} mm and {math.degrees(self.orientation_error):.3g} deg"

    def _held(self, collision: Collision) -> str:
        first, second, depth = collision
        away = f": the tip is {self._away()} away from the target" if math.isfinite(self.position_error) else ""
        if depth == 0.0:
            return f"{first} would come too close to {second}, and the arm stops before{away}."
        return f"{first} and {second} are {1e3 * depth:.3g} mm too close, and the arm only moves apart{away}."

    def as_dict(self) -> dict[str, float]:
        """Joint angles by joint name, rad, in the order of the joints."""
        return dict(zip(self._joint_names, self.q.tolist(), strict=True))

    def __bool__(self) -> bool:
        return bool(self._row[at.STEP_STATUS] == at.OK)

    def __repr__(self) -> str:
        return f"TrackerStep({self.status}, q={np.array2string(self.q, precision=6)}, {self.message!r})"
