"""Tasks that leave a turn of the hand free: the turn at which the arm lies best for the task.

A turn costs the angle between the plane of the posture and that of the task, and `angle_lost` on top: what the limits
keep the elbow from, and a little by the distance from the seed, or by the margin to the limits: of turns that are as
good, up to thousandths of a radian, the nearest is taken. All over the free turns some are looked at, and from the best
of them a compass search closes in. Where none of these does the task, the search for a posture with a free axis tells
whether any turn does, and the compass search begins there.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.errors import InvalidTask
from srs_ik.inputs.angles import as_seeds, seed_of
from srs_ik.inputs.freedom import FreeAxis, as_free_axis
from srs_ik.inputs.task import Task
from srs_ik.solve.kinematics import forward_kinematics_batch
from srs_ik.solve.solution import Solution, Status
from srs_ik.solve.task import BatchTaskSolution, TaskSolution
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.packed import PackedArm

Ask = Callable[[Task, Any], Any]
"""Solves tasks near a seed, or without one."""

AskAny = Callable[[Array, Any], Solution]
"""Solves a pose (4, 4) at any of the free turns, near a seed or without one."""

LOOKED_AT = {True: 48, False: 192}
"""Turns that are looked at: rolls alone, and turns of a cone."""

FROM = 3
"""Turns that are closed in on from."""

FINEST = 1e-8
"""Turns are closed in on to this, rad."""

PREFERENCE = 1e-4
"""What a squared radian of distance from the seed counts, or the whole margin, rad."""

FORBIDDEN = 10.0
"""Cost of a turn at which the task cannot be done, rad."""


def solve_task(arm: PackedArm, asked: Any, task: Task, question: Any, free_axis: Any, seed: ArrayLike | None) -> Any:
    """See `Arm.solve_task`, with a free axis.

    `asked` answers within the limits alone or in a scene; the question is that of its `solve_task`, but for the seed.
    """
    free, respect = as_free_axis(free_axis), question[1]

    def ask(each: Task, near: Any) -> Any:
        return asked.solve_task(each, *question, near)

    def ask_any(T: Array, near: Any) -> Solution:
        found: Solution = asked.solve_free(T, free, near, respect)
        return found

    if task.grasp is None or task.pronosupination is None:
        raise InvalidTask("free_axis turns a hand whose rotation is known: give the task grasp and pronosupination")
    count = 1 if task.count is None else task.count
    seeds = as_seeds(seed, count, arm.lower, arm.upper)
    found = [best_turn(arm, ask, one_of(task, i), free, seed_of(seeds, i), ask_any) for i in range(count)]
    if task.count is None:
        return found[0]
    rows = np.array([each._row for each in found])
    whole = BatchTaskSolution(rows, arm.joint_names, arm.elbow, arm.shoulder, found[0].posture.side)
    whole.collisions = {(i,): each.collision for i, each in enumerate(found) if each.collision is not None}
    return whole


def one_of(task: Task, i: int) -> Task:
    """One of several tasks, or the only one."""
    fields = (task.position, task.velocity, task.force, task.grasp, task.pronosupination)
    if task.count is None:
        return task
    return Task(*(None if f is None else f[i] for f in fields))  # type: ignore[arg-type]


def best_turn(
    arm: PackedArm, ask: Ask, task: Task, free: FreeAxis, seed: Array | None, ask_any: AskAny | None = None
) -> TaskSolution:
    """The answer to one task, which gives grasp and pronosupination, at the turn that is best for it."""
    T: Array = ask(task, seed).T_base_tip
    R = T[:3, :3]
    grasp, across = R.T @ np.asarray(task.grasp), R.T @ np.asarray(task.pronosupination)

    def answers(turns: Array) -> tuple[BatchTaskSolution, Array]:
        turned = Task(task.position, task.velocity, task.force, R @ turns @ grasp, R @ turns @ across)
        found = ask(turned, seed)
        return found, _costs(arm, found, seed)

    turns = free.sampled(LOOKED_AT[free.cone == 0.0])
    found, costs = answers(turns)
    none = not (np.asarray(found.status) == Status.OK).any()
    if none and ask_any is not None and (met := ask_any(T, seed)):
        turns = R.T @ forward_kinematics_batch(arm, met.q[None], 1)[:, :3, :3]
        found, costs = answers(turns)
    best, least = found[int(costs.argmin())], float(costs.min())
    spacing = 2.0 * math.pi / LOOKED_AT[True] if free.cone == 0.0 else 0.5
    for start in np.argsort(costs, kind="stable")[:FROM].tolist():
        turn, cost, step = turns[start], float(costs[start]), spacing
        while step > FINEST:
            beside = _beside(free, turn, step)
            there, prices = answers(beside)
            k = int(prices.argmin())
            if prices[k] < cost:
                turn, cost = beside[k], float(prices[k])
                if cost < least:
                    best, least = there[k], cost
            else:
                step *= 0.5
    chosen: TaskSolution = best
    return chosen


def _beside(free: FreeAxis, turn: Array, step: float) -> Array:
    """Free turns a step away from one."""
    if free.cone == 0.0:
        return np.array([turn @ free.rolled(step), turn @ free.rolled(-step)])
    around = [turn @ FreeAxis(axis).rolled(sign * step) for axis in np.eye(3) for sign in (1.0, -1.0)]
    inside = [each for each in around if free.lean(each, np.eye(3)) == 0.0]
    return np.array([*inside, turn @ free.rolled(step), turn @ free.rolled(-step)])


def _costs(arm: PackedArm, found: BatchTaskSolution, seed: Array | None) -> Array:
    """What turns cost, of the answers at them."""
    posture = found.posture
    sine = np.linalg.norm(np.cross(posture.normal, posture.task_normal), axis=-1)
    cosine = np.abs((np.asarray(posture.normal) * posture.task_normal).sum(axis=-1))
    if seed is not None:
        like = ((found.q - seed) ** 2).sum(axis=1)
    else:
        ends = np.isfinite(arm.upper - arm.lower)
        lower, upper = arm.lower[ends], arm.upper[ends]
        room = np.minimum(found.q[:, ends] - lower, upper - found.q[:, ends]) / (0.5 * (upper - lower))
        like = -room.min(axis=1, initial=1.0)
    met = np.asarray(found.status) == Status.OK
    plane = np.arctan2(sine, cosine)
    return np.where(met, plane + found.angle_lost, FORBIDDEN + found.position_error) + PREFERENCE * like
