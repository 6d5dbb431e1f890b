"""The posture of an arm that suits a task (the paper's postural optimisation)."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from srs_ik.errors import InvalidTask, quoted
from srs_ik.inputs.task import Task
from srs_ik.kernels.entries import task as entries
from srs_ik.kernels.layout import task as at
from srs_ik.solve.packed import PackedArm
from srs_ik.solve.threads import checked_threads, run_in_threads
from srs_ik.system.arrays import Array, rows_at

Side = Literal["left", "right"]
Tie = Literal["lower", "upper"]

SIDES = {"left": 1.0, "right": -1.0}
TIES = {"lower": -1.0, "upper": 1.0}


REACHED = 1e-9
"""A hand this near to its target, metres, has reached it."""


class Posture:
    """Where the arm goes for a task, in the base frame, metres; for N tasks every field is an array over N.

    It is what the geometry of the arm allows, joint limits apart. On a near limb that of `Arm.posture` is the nearest
    exact limb's, and that of a solved task the true chain's. That of one task is true in a boolean test if and only if
    it is `reached`; many have no truth value.
    """

    __slots__ = ("_rows", "_shoulder", "side")

    def __init__(self, rows: Array, shoulder: Array, side: Side) -> None:
        self._rows = rows
        self._shoulder = shoulder
        self.side = side
        """Side of the body for which the elbow was chosen."""

    def _point(self, first: int) -> Array:
        return self._rows[..., first : first + 3]

    def _figure(self, index: int) -> Any:
        figure = self._rows[..., index]
        return figure if figure.ndim else float(figure)

    @property
    def shoulder(self) -> Array:
        """(3,) shoulder centre."""
        return np.broadcast_to(self._shoulder, self.elbow.shape)

    @property
    def elbow(self) -> Array:
        """(3,) elbow centre."""
        return self._point(at.ELBOW)

    @property
    def wrist(self) -> Array:
        """(3,) wrist centre."""
        return self._point(at.WRIST)

    @property
    def hand(self) -> Array:
        """(3,) tip of the hand; the task's position where that is reached."""
        return self._point(at.TIP)

    @property
    def normal(self) -> Array:
        """(3,) unit normal of the plane through shoulder, elbow and wrist, on the side of `task_normal`.

        Of all planes through the line from the shoulder to the wrist (without a grasp, to the hand) it is the one whose
        normal is as parallel to `task_normal` as can be. A stretched or folded arm lies in it as it would bend into it.
        """
        return self._point(at.NORMAL)

    @property
    def task_normal(self) -> Array:
        """(3,) unit normal of the task's plane: velocity x force, the paper's n."""
        return self._point(at.TASK_NORMAL)

    @property
    def direction(self) -> Array:
        """(3,) unit vector in which the hand reaches out: the grasp direction, or without one that of the forearm."""
        return self._point(at.DIRECTION)

    @property
    def arm_angle(self) -> Any:
        """Arm angle of the elbow about the line from shoulder to wrist, in [-pi, pi], rad."""
        return self._figure(at.ARM_ANGLE)

    @property
    def miss(self) -> Any:
        """How far the hand stays from the task's position, metres: positive where that is too far, negative near."""
        return self._figure(at.MISS)

    @property
    def reached(self) -> Any:
        """Whether the hand is at the task's position, to 1e-9 m; else the arm is stretched, or folded, towards it."""
        reached = np.abs(self._rows[..., at.MISS]) < REACHED
        return reached if reached.ndim else bool(reached)

    @property
    def message(self) -> str:
        """One sentence for a person."""
        if self._rows.ndim > 1:
            return f"{int(np.sum(self.reached))} of {len(self)} targets reached."
        if self.reached:
            return "The hand reaches the target."
        lie = "stretched towards" if self.miss > 0.0 else "folded towards"
        return f"The arm is {lie} the target, and the hand stays {abs(self.miss):.3g} m from it."

    def __bool__(self) -> bool:
        if self._rows.ndim > 1:
            raise TypeError("many postures have no truth value: their reached has one for each")
        return bool(self.reached)

    def __len__(self) -> int:
        if self._rows.ndim == 1:
            raise TypeError("the posture of one task has no length")
        return len(self._rows)

    def __getitem__(self, index: int) -> Posture:
        """The posture of one task of many."""
        if self._rows.ndim == 1:
            raise TypeError("the posture of one task cannot be indexed")
        return Posture(rows_at(self._rows, index), self._shoulder, self.side)

    def __repr__(self) -> str:
        return f"Posture({self.side}, {self.message})"


def posture(arm: PackedArm, task: Task, side: Side, tie: Tie, threads: int | None) -> Posture:
    """See `Arm.posture`."""
    sides, ties = signs(task, side, tie)
    rows, given = task._rows, task._given
    if threads is not None:
        checked_threads(threads)
    if task.count is None:
        out = np.empty(at.POSTURE)
        entries.posture(arm.family, arm.hand, rows[0], given, sides, ties, out)
    else:
        out = np.empty((task.count, at.POSTURE))

        def work(first: int, last: int) -> None:
            entries.posture_range(arm.family, arm.hand, rows, first, last, given, sides, ties, out)

        run_in_threads(work, task.count, threads)
    return Posture(out, arm.shoulder, side)


def signs(task: Task, side: Side, tie: Tie) -> tuple[float, float]:
    """Side and tie as the kernels take them.

    Raises:
        InvalidTask: no task, or no such side or tie.
    """
    if not isinstance(task, Task):
        raise InvalidTask(f"a task is a srs_ik.Task, not {type(task).__name__}")
    try:
        return SIDES[side], TIES[tie]
    except (KeyError, TypeError):
        raise InvalidTask(
            f'side is "left" or "right" and tie is "lower" or "upper", not {quoted(side)} and {quoted(tie)}'
        ) from None
