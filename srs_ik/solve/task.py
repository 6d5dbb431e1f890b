"""Answers of `Arm.solve_task`: joint angles, and how near they come to the posture that the task asks for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.errors import InvalidTask
from srs_ik.inputs.angles import as_seeds
from srs_ik.inputs.task import Task
from srs_ik.kernels.entries import task as entries
from srs_ik.kernels.layout import task as at
from srs_ik.solve.packed import PackedArm
from srs_ik.solve.posture import Posture, Side, Tie, signs
from srs_ik.solve.solution import ElbowRange, Solution, Status
from srs_ik.solve.solutions import BatchSolution
from srs_ik.solve.threads import checked_threads, run_in_threads
from srs_ik.system.arrays import Array, rows_at

_POSTURE = slice(at.TASK_POSTURE, at.TASK_ROTATION)


class TaskSolution(Solution):
    """Joint angles for one task.

    A `Solution` of the pose that the task asks of the tip, and with it the figures below. Where the target is out of
    reach its status is `UNREACHABLE`, and q that of the stretched or folded posture.
    """

    __slots__ = ("_shoulder", "_side")

    def __init__(
        self, row: Array, joint_names: Sequence[str], elbow: ElbowRange | None, shoulder: Array, side: Side
    ) -> None:
        super().__init__(row, joint_names, elbow)
        self._shoulder = shoulder
        self._side = side

    @property
    def posture(self) -> Posture:
        """The posture that the task asks for."""
        return Posture(self._row[_POSTURE], self._shoulder, self._side)

    @property
    def T_base_tip(self) -> Array:
        """(4, 4) pose of the tip that the task asks for; a roll of the hand that was left free is chosen in it."""
        return poses_of(self._row)

    @property
    def angle_lost(self) -> float:
        """How far the arm angle of q is from that of the posture, rad; 0 where the elbow is where the task wants it."""
        return float(self._row[at.ANGLE_LOST])

    @property
    def message(self) -> str:
        """One sentence for a person."""
        if self.status is Status.OK and self.angle_lost > 0.0:
            lost = f"{np.rad2deg(self.angle_lost):.3g} deg"
            return f"Solved, but the joint limits keep the elbow {lost} from where the task wants it."
        return super().message

    def __repr__(self) -> str:
        return f"TaskSolution(angle_lost={self.angle_lost:.6g}, {super().__repr__()})"


class BatchTaskSolution(BatchSolution):
    """Joint angles for N tasks: every field of `TaskSolution` as an array over N."""

    def __init__(
        self, rows: Array, joint_names: Sequence[str], elbow: ElbowRange | None, shoulder: Array, side: Side
    ) -> None:
        super().__init__(rows, joint_names, elbow)
        self._shoulder = shoulder
        self._side = side

    @property
    def posture(self) -> Posture:
        """The postures that the tasks ask for, its fields arrays over N."""
        return Posture(self._rows[:, _POSTURE], self._shoulder, self._side)

    @property
    def T_base_tip(self) -> Array:
        """(N, 4, 4) poses of the tip that the tasks ask for."""
        return poses_of(self._rows)

    @property
    def angle_lost(self) -> Array:
        """(N,) how far the arm angles are from those of the postures, rad."""
        return self._rows[:, at.ANGLE_LOST]

    def __getitem__(self, index: Any) -> Any:
        row = rows_at(self._rows, index)
        kind = TaskSolution if row.ndim == 1 else BatchTaskSolution
        part = kind(row, self._joint_names, self._elbow, self._shoulder, self._side)
        if isinstance(part, TaskSolution):
            part.collision = self.collisions.get((int(np.arange(len(self))[index]),))
        else:
            part.collisions = self._collisions_of(index)
        return part

    def __repr__(self) -> str:
        return f"BatchTaskSolution({self.solved} of {self.ok.size} solved)"


def solve_task(
    arm: PackedArm, task: Task, side: Side, respect_limits: bool, tie: Tie, threads: int | None, seed: ArrayLike | None
) -> TaskSolution | BatchTaskSolution:
    """See `Arm.solve_task`."""
    sides, ties = signs(task, side, tie)
    if not arm.hand[at.HAND_KNOWN]:
        raise InvalidTask(
            f"how the hand of {arm.name} lies in its frame {arm.tip!r} is not known: load it with "
            "hand=(grasp, pronosupination), two directions in that frame"
        )
    rows, given = task._rows, task._given
    seeds = as_seeds(seed, len(rows), arm.lower, arm.upper)
    out = np.empty((len(rows), at.TASK_SOLUTION))

    def work(first: int, last: int) -> None:
        entries.solve_tasks(arm.family, arm.hand, rows, first, last, given, sides, ties, seeds, respect_limits, out)

    if threads is not None:
        checked_threads(threads)
    if task.count is None:
        work(0, 1)
        return TaskSolution(out[0], arm.joint_names, arm.elbow, arm.shoulder, side)
    run_in_threads(work, task.count, threads)
    return BatchTaskSolution(out, arm.joint_names, arm.elbow, arm.shoulder, side)


def poses_of(rows: Array) -> Array:
    """(..., 4, 4) poses of the tip in rows of answers."""
    T = np.zeros((*rows.shape[:-1], 4, 4))
    T[..., :3, :3] = rows[..., at.TASK_ROTATION : at.TASK_TIP].reshape(*rows.shape[:-1], 3, 3)
    T[..., :3, 3] = rows[..., at.TASK_TIP : at.ANGLE_LOST]
    T[..., 3, 3] = 1.0
    return T
