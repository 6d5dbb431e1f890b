"""Joint angles for tasks that hit nothing: the free arm angle nearest to the one that the task asks for.

The pose of the tip is the one that the task asks for without a scene. Where a roll of the hand was left free and that
pose has no free posture, others are tried, evenly spaced about the direction of the hand.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from srs_ik.inputs.angles import as_seeds, seed_of
from srs_ik.kernels.layout import task as at
from srs_ik.kernels.layout.answer import ROW, ROW_STATUS
from srs_ik.solve import rolled_task
from srs_ik.solve.in_scene.elbow import nearest_free
from srs_ik.solve.in_scene.pose import solve
from srs_ik.solve.solution import Collision, Status
from srs_ik.solve.task import BatchTaskSolution, TaskSolution, poses_of
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.inputs.task import Task
    from srs_ik.solve.in_scene.surroundings import Surroundings
    from srs_ik.solve.posture import Side, Tie

ROLLS = 24
"""Rolls of the hand that are tried where one is free."""

_OFF_AXIS = 1e-9
"""A wrist this far from the line about which the hand rolls, m, moves with the roll."""


def solve_task(
    around: Surroundings, task: Task, side: Side, respect: bool, tie: Tie, threads: int | None, seed: ArrayLike | None
) -> TaskSolution | BatchTaskSolution:
    """See `Arm.solve_task`."""
    arm = around.packed
    wanted = rolled_task.solve_task(arm, task, side, respect, tie, threads, seed)
    rows = np.atleast_2d(wanted._row if isinstance(wanted, TaskSolution) else wanted._rows)
    seeds = as_seeds(seed, len(rows), arm.lower, arm.upper)
    rolls = not task._given & at.PRONOSUPINATION
    hits: dict[tuple[int, ...], Collision] = {}
    for i, row in enumerate(rows):
        near = seed_of(seeds, i)
        hit = _keep_clear(around, row, near, respect, rolls)
        if hit is not None:
            hits[(i,)] = hit
    if isinstance(wanted, TaskSolution):
        wanted.collision = hits.get((0,))
    else:
        wanted.collisions = hits
    return wanted


def _keep_clear(around: Surroundings, row: Array, near: Array | None, respect: bool, rolls: bool) -> Collision | None:
    """Put the free posture nearest to the one of a task into its row; what hits what where there is none."""
    if row[ROW_STATUS] != Status.OK:
        return None
    psi = float(row[at.TASK_POSTURE + at.ARM_ANGLE])
    T = poses_of(row)
    found = nearest_free(around, T, psi, near, respect)
    if found is None and rolls:
        direction = row[at.TASK_POSTURE + at.DIRECTION : at.TASK_POSTURE + at.DIRECTION + 3]
        others = [
            (turned, nearest_free(around, turned, psi, near, respect)) for turned in _rolled(around, T, direction)
        ]
        met = [(turned, other) for turned, other in others if other is not None]
        if met:
            turned, found = min(met, key=lambda each: each[1][0])
            row[at.TASK_ROTATION : at.TASK_TIP] = turned[:3, :3].ravel()
    answer = solve(around, T, None, near, -1, respect) if found is None else found[1]
    row[:ROW] = answer._row
    row[at.ANGLE_LOST] = abs(math.remainder(answer.arm_angle - psi, 2.0 * math.pi)) if found is None else found[0]
    return answer.collision


def _rolled(around: Surroundings, T: Array, direction: Array) -> list[Array]:
    """The pose with the hand rolled about a direction through its tip; none where that moves the wrist."""
    limb = around.arm.limb
    wrist = (T @ np.linalg.inv(limb.T_base_tip_zero) @ [*limb.wrist, 1.0])[:3]
    if np.linalg.norm(np.cross(wrist - T[:3, 3], direction)) > _OFF_AXIS:
        return []
    turned = []
    for k in range(1, ROLLS):
        pose = T.copy()
        pose[:3, :3] = Rotation.from_rotvec(2.0 * math.pi * k / ROLLS * direction).as_matrix() @ T[:3, :3]
        turned.append(pose)
    return turned
