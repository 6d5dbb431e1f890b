"""What a tracker's elbow does with the freedom that the target leaves it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.errors import InvalidTask, did_you_mean, quoted
from srs_ik.inputs.elbow import as_elbow
from srs_ik.inputs.task import Task
from srs_ik.kernels.entries.kinematics import configuration_arm_angle
from srs_ik.kernels.entries.pose import angles_towards
from srs_ik.kernels.layout import track as at
from srs_ik.kernels.layout.collision import WIDE_CLEARANCE
from srs_ik.kernels.layout.objectives import PARAMS
from srs_ik.solve.intervals import intervals
from srs_ik.solve.objectives import CLEARANCE, OBJECTIVES, Objective
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.collision.owner import BodyOwner
    from srs_ik.solve.packed import PackedArm

LOOK = (-0.24, -0.12, 0.0, 0.12, 0.24)
"""Arm angles, from the present one, whose clearance is compared, rad."""

GAIN = 1e-4
"""The elbow goes elsewhere for so much more clearance, m."""

CHOICES = '"keep", an arm angle, rad, a point (3,), m, a built-in Objective or its name, a Task or a Scene'

TURN = 2.0 * math.pi

SAME = 1e-3
"""A target that has moved no more than this, m and rad, has the same intervals, for the way round in them."""

BESIDE = 0.05
"""The elbow is in an interval if it is this far outside of it, rad: intervals may be those of a moment ago."""

AHEAD = 1.0
"""The way round is told by an arm angle this far ahead at most, rad, so that the shorter way leads there."""

Chosen = tuple[float, float, Array]
"""Number of a policy, its arm angle, and the parameters of its objective."""

Choose = Callable[[Array, bool], float]
"""Tells the arm angle that is asked for, of a posture on the target, and whether that rests."""


def chosen(elbow: Any, packed: PackedArm, owner: BodyOwner) -> tuple[Chosen, Choose | None]:
    """What kernels know of a policy, and what tells the arm angle that is asked for now and then, or None.

    Raises:
        InvalidTask: no such objective, one that kernels do not compute, or more than one task.
        InvalidConfiguration: no arm angle, and no point.
        NoBodies: a scene, and no shapes of the arm are at hand.
    """
    none = np.zeros(PARAMS)
    if isinstance(elbow, str) and elbow == "keep":
        return (at.KEEP, 0.0, none), None
    if isinstance(elbow, Task):
        elbow = _ratio(elbow)
    if isinstance(elbow, str):
        if elbow not in (*OBJECTIVES, CLEARANCE):
            hint = did_you_mean(elbow, ("keep", *OBJECTIVES))
            raise InvalidTask(f"elbow must be {CHOICES}, not {quoted(elbow)}{hint}")
        elbow = Objective(elbow)
    if isinstance(elbow, Objective):
        if elbow.kind is None or elbow.second >= 0:
            raise InvalidTask(
                f"a tracker's elbow follows built-in objectives of one value, not {elbow.name!r}; for any other, "
                "elbow takes the arm_angle of what optimise finds"
            )
        return (float(elbow.kind), 0.0, elbow.packed(owner, packed.weights, True)), None
    if is_scene(elbow):
        return (at.KEEP, 0.0, none), _Clearance(packed, owner, elbow)
    psi, point = as_elbow(elbow, what=CHOICES)
    if psi is None:
        return (at.KEEP, 0.0, none), _Towards(packed, owner, point)
    return (at.ANGLE, psi, none), _Angle(packed, owner, psi)


def _ratio(task: Task) -> Objective:
    """The paper's C of a task: easy motion along its velocity, strength along its force."""
    if task.count is not None:
        raise InvalidTask(f"a tracker's elbow serves one task, not {task.count}")
    return Objective("force_velocity_ratio", force=task.force, velocity=task.velocity)


def is_scene(elbow: Any) -> bool:
    """Whether an elbow's policy is a scene."""
    # A tracker without a scene needs nothing of collisions.
    from srs_ik.collision.scenes.scene import Scene

    return isinstance(elbow, Scene)


class _Angle:
    """An arm angle; at rest, one on the way to it that the limits leave open."""

    def __init__(self, packed: PackedArm, owner: BodyOwner, psi: float) -> None:
        self._packed, self._owner, self._psi = packed, owner, psi
        self._at, self._open = np.full((4, 4), np.nan), np.empty((0, 2))

    def __call__(self, q: Array, rests: bool) -> float:
        return self._way_round(self._owner.forward_kinematics(q).homogeneous, q, self._psi) if rests else self._psi

    def _way_round(self, T: Array, q: Array, wanted: float) -> float:
        """An arm angle ahead on the shortest way, within the interval of q, to where that comes closest to another."""
        here, branch = configuration_arm_angle(self._packed.family, q.copy())
        if not np.abs(T - self._at).max() < SAME:
            own = [part for part in intervals(self._packed, T, True) if part.branch == branch]
            self._at, self._open = T, np.array([part[1:] for part in own]).reshape(-1, 2)
        up = (wanted - here) % TURN
        for lower, upper in self._open:
            back = (here - lower + BESIDE) % TURN - BESIDE
            on = upper - lower - back
            if on > -BESIDE:
                ways = [way for way in (up, up - TURN, on, -back) if -back <= way <= on]
                best = min(ways, key=lambda way: (round(abs(math.remainder(up - way, TURN)), 6), abs(way)))
                return here + min(max(best, -AHEAD), AHEAD)
        return wanted


class _Towards(_Angle):
    """The arm angle at which the elbow is nearest to a point."""

    def __init__(self, packed: PackedArm, owner: BodyOwner, point: Array) -> None:
        super().__init__(packed, owner, 0.0)
        self._point = point

    def __call__(self, q: Array, rests: bool) -> float:
        T, psi = self._owner.forward_kinematics(q).homogeneous, np.empty(1)
        angles_towards(self._packed.family, T[None], self._point, psi)
        if not np.isfinite(psi[0]):
            return float(configuration_arm_angle(self._packed.family, q.copy())[0])
        return self._way_round(T, q, float(psi[0])) if rests else float(psi[0])


class _Clearance:
    """The arm angle near the present one at which bodies are farthest from each other."""

    def __init__(self, packed: PackedArm, owner: BodyOwner, scene: Any) -> None:
        from srs_ik.solve.in_scene.surroundings import Surroundings

        self._around = Surroundings(owner, packed, scene, 0.0)

    def __call__(self, q: Array, rests: bool) -> float:
        around = self._around
        T = around.arm.forward_kinematics(q).homogeneous
        around.tables = around.arm.tables(around.scene)  # objects where they are now
        here, branch = configuration_arm_angle(around.packed.family, q.copy())
        clear = [float(around.clearance(T, int(branch) >> 2, here + ahead)[WIDE_CLEARANCE]) for ahead in LOOK]
        best = int(np.argmax(clear))
        return here + (LOOK[best] if clear[best] > clear[len(LOOK) // 2] + GAIN else 0.0)
