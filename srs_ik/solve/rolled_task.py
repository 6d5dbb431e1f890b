"""Tasks whose hand may roll about its grasp: where the roll chosen for a fixed wrist fails, the best of all rolls.

A roll moves a wrist that is not on the line through the tip along the grasp, and with it the whole arm. Whether any
roll meets such a task is asked of the search for free axes, and from its roll and others the best one is closed in on.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from srs_ik.inputs.angles import as_seeds, seed_of
from srs_ik.inputs.freedom import FreeAxis
from srs_ik.inputs.task import Task
from srs_ik.kernels.layout import task as at
from srs_ik.kernels.layout.answer import ROW_STATUS
from srs_ik.solve import task as task_solver
from srs_ik.solve.free_task import best_turn, one_of
from srs_ik.solve.freedom import met_batch
from srs_ik.solve.kinematics import forward_kinematics_batch
from srs_ik.solve.solution import Status
from srs_ik.solve.task import BatchTaskSolution, TaskSolution
from srs_ik.solve.threads import tell
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.packed import PackedArm

BESIDE = 0.05
"""So much of its length, the reach of a near limb may differ from that of the nearest exact one at most."""


def solve_task(arm: PackedArm, task: Task, *question: Any) -> TaskSolution | BatchTaskSolution:
    """See `Arm.solve_task`; the question is that of `task.solve_task`."""
    found = task_solver.solve_task(arm, task, *question)
    if task.grasp is None or task.pronosupination is not None:
        return found
    rows = np.atleast_2d(found._row if isinstance(found, TaskSolution) else found._rows)
    missed = np.flatnonzero((rows[:, ROW_STATUS] != Status.OK) & may_reach(arm, task.position, task.grasp))
    if not len(missed):
        return found
    side, respect_limits, tie, threads, seed = question
    seeds = as_seeds(seed, len(rows), arm.lower, arm.upper)
    free = FreeAxis(arm.hand[at.HAND_GRASP : at.HAND_GRASP + 3])
    T = task_solver.poses_of(rows[missed])
    q, met = met_batch(arm, T, free, seeds[missed] if len(seeds) > 1 else seeds, respect_limits, threads)
    across = forward_kinematics_batch(arm, q[met], 1)[:, :3, :3] @ arm.hand[at.HAND_ACROSS : at.HAND_ACROSS + 3]

    def ask(each: Task, near: Any) -> Any:
        return task_solver.solve_task(arm, each, side, respect_limits, tie, threads, near)

    for done, i in enumerate(missed[met].tolist()):
        tell(done, len(across))
        one = one_of(task, i)
        rolled = Task(one.position, one.velocity, one.force, one.grasp, across[done])
        answer = best_turn(arm, ask, rolled, free, seed_of(seeds, i))
        if answer:
            rows[i] = answer._row
    return found


def may_reach(arm: PackedArm, position: Array, direction: Array) -> NDArray[np.bool_]:
    """(n,) whether some roll about the grasp brings the wrist to where the limb reaches; (1,) for a single task."""
    grasp, to_wrist = (arm.hand[k : k + 3] for k in (at.HAND_GRASP, at.HAND_WRIST))
    g = np.atleast_2d(direction)
    g = g / np.linalg.norm(g, axis=1, keepdims=True)
    # The wrist moves on a circle about the grasp.
    along = to_wrist @ grasp
    radius = np.linalg.norm(to_wrist - along * grasp)
    centre = np.atleast_2d(position) - arm.shoulder + along * g
    ahead = (centre * g).sum(axis=1)
    beside = np.linalg.norm(centre - ahead[:, None] * g, axis=1)
    nearest, farthest = np.hypot(ahead, beside - radius), np.hypot(ahead, beside + radius)
    room = BESIDE * arm.hand[at.HAND_FAR]
    return np.asarray((nearest <= arm.hand[at.HAND_FAR] + room) & (farthest >= arm.hand[at.HAND_NEAR] - room))
