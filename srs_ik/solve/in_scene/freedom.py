"""Poses that leave a turn free, in a scene: the best posture of those that hit nothing, over turns.

The best posture without the scene is asked first; where it hits nothing there is no better one. Else every turn of a
sample is a pose whose free intervals are known, and the best of these turns is closed in on: the answer then is certain
to hit nothing, and the best of what was looked at.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize_scalar

from srs_ik.inputs.angles import as_seeds, seed_of
from srs_ik.inputs.freedom import FreeAxis, as_free_axis
from srs_ik.inputs.poses import as_matrices
from srs_ik.kernels.layout.answer import ROW_ORIENTATION_ERROR, ROW_POSITION_ERROR, ROW_STATUS
from srs_ik.solve import freedom, pose
from srs_ik.solve.goals import goal_of
from srs_ik.solve.in_scene import pose as in_scene
from srs_ik.solve.kinematics import forward_kinematics_batch
from srs_ik.solve.solution import Solution, Status
from srs_ik.solve.solutions import BatchSolution
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.in_scene.surroundings import Surroundings

TURNS = 48
TURNS_OF_CONE = 144
TURNS_HITTING = 6
"""Turns that are looked at, of a roll, where the axis may lean, and for what is in the way where all hit something."""

FINE = 1e-4
"""The best roll about the axis is closed in on so far, rad."""

NO_POSTURE = 1e6
"""Cost of a roll at which all postures hit something."""


def solve(around: Surroundings, T: Array, free: FreeAxis, near: Array | None, respect: bool) -> Solution:
    """The best posture that hits nothing, or why there is none.

    Of postures that all hit something, the one that is least deep in it, with the status `COLLISION`; where no turn
    has any posture, the answer without the scene.
    """
    alone = freedom.solve(around.packed, T, free, near, respect)
    if not alone or around.is_clear(alone.q):
        return alone
    turns = free.sampled(TURNS if free.cone == 0.0 else TURNS_OF_CONE)
    poses = _Turns(around, T, near, respect)
    best, found, where = None, NO_POSTURE, 0
    at_turns = [poses.alone_at(turn) for turn in turns]
    floors = np.array([floor for _, floor in at_turns])
    hits = np.array([answer is None or around.hit_at(answer.q) is not None for answer, _ in at_turns])
    # Those that hit nothing by spheres come first: to know what is free at the other turns takes much longer.
    for k in np.lexsort((floors, hits)).tolist():
        if floors[k] >= found:
            continue
        answer = poses.at(turns[k], at_turns[k][0])
        if answer is not None and poses.cost(answer.q) < found:
            best, found, where = answer, poses.cost(answer.q), k
    if best is None:
        return _measured(around, T, free, _least_deep(around, T, alone, free, near, respect))

    def price(roll: float) -> float:
        nonlocal best, found
        turn = turns[where] @ free.rolled(roll)
        known, floor = poses.alone_at(turn)
        answer = poses.at(turn, known) if floor < found else None
        value = max(floor, found) if answer is None else poses.cost(answer.q)
        if answer is not None and value < found:
            best, found = answer, value
        return value

    step = 2.0 * np.pi / TURNS
    minimize_scalar(price, bounds=(-step, step), method="bounded", options={"xatol": FINE})
    return _measured(around, T, free, best)


class _Turns:
    """A pose at turns that are free: the best posture at each, with the scene and without.

    Attributes:
        cost: what is less for the better posture (7,).
    """

    def __init__(self, around: Surroundings, T: Array, near: Array | None, respect: bool) -> None:
        self._around, self._T, self._near, self._respect = around, T, near, respect
        self.cost = goal_of(around.packed, near).cost

    def alone_at(self, turn: Array) -> tuple[Solution | None, float]:
        """The best posture at a turn (3, 3) without the scene, and what it costs: with the scene none costs less."""
        answer = pose.solve(self._around.packed, _turned(self._T, turn), seed=self._near, respect_limits=self._respect)
        return (answer, self.cost(answer.q)) if answer else (None, NO_POSTURE)

    def at(self, turn: Array, known: Solution | None) -> Solution | None:
        """The best posture at a turn: the one without the scene, where that hits nothing."""
        around = self._around
        if known is None or around.hit_at(known.q) is None:
            return known
        asked = around, _turned(self._T, turn), None, self._near, -1, self._respect
        answer = in_scene.best_free(*asked, around.is_exact)
        # Where spheres leave nothing: what do the real shapes?
        return in_scene.best_free(*asked, True) if answer is None and not around.is_exact else answer


def _turned(T: Array, turn: Array) -> Array:
    turned = T.copy()
    turned[:3, :3] = T[:3, :3] @ turn
    return turned


def _least_deep(
    around: Surroundings, T: Array, alone: Solution, free: FreeAxis, near: Array | None, respect: bool
) -> Solution:
    """Of postures that all hit something, the one that does so least, of few turns; or one that hits nothing after all.

    Real shapes, which are asked here, may leave what spheres do not.
    """
    turns = free.sampled(TURNS_HITTING)
    answers = [in_scene.solve(around, _turned(T, turn), None, near, -1, respect) for turn in turns]
    clear = [answer for answer in answers if answer]
    if clear:
        cost = goal_of(around.packed, near).cost
        return min(clear, key=lambda answer: cost(answer.q))
    hitting = [(answer.collision.depth, k) for k, answer in enumerate(answers) if answer.collision is not None]
    if hitting:
        return answers[min(hitting)[1]]
    # None of these turns has a posture, but one between them has.
    hit = around.deepest_at(alone.q)
    if hit is not None:
        alone._row[ROW_STATUS] = Status.COLLISION
        alone.collision = hit
    return alone


def _measured(around: Surroundings, T: Array, free: FreeAxis, answer: Solution) -> Solution:
    """An answer with the errors that are left of the pose itself."""
    tip = forward_kinematics_batch(around.packed, answer.q[None], 1)[0]
    answer._row[ROW_POSITION_ERROR] = np.linalg.norm(tip[:3, 3] - T[:3, 3])
    answer._row[ROW_ORIENTATION_ERROR] = free.lean(tip[:3, :3], T[:3, :3])
    return answer


def solve_batch(
    around: Surroundings, poses: Any, free_axis: Any, seed: ArrayLike | None, respect: bool, threads: int | None
) -> BatchSolution:
    """`solve` for many poses."""
    arm, T, free = around.packed, as_matrices(poses), as_free_axis(free_axis)
    seeds = as_seeds(seed, len(T), arm.lower, arm.upper)
    rows, hits = in_scene.answered(len(T), threads, lambda i: solve(around, T[i], free, seed_of(seeds, i), respect))
    return BatchSolution(rows, arm.joint_names, arm.elbow, hits)
