"""Postures for poses that leave a turn free: roll about an axis of the tip, a cone around it, or all turns."""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from srs_ik.errors import InvalidTask
from srs_ik.inputs.angles import NO_SEEDS, as_seed, as_seeds, seed_of
from srs_ik.inputs.freedom import FreeAxis, as_free_axis
from srs_ik.inputs.poses import PoseLike, as_matrices, as_matrix, invalid_pose, refuse_bad_poses
from srs_ik.kernels.entries import freedom as entries
from srs_ik.kernels.layout.answer import ROW, ROW_ORIENTATION_ERROR, ROW_POSITION_ERROR, ROW_STATUS
from srs_ik.kernels.layout.freedom import MOST_STARTS, START, WORK
from srs_ik.solve import pose
from srs_ik.solve.kinematics import forward_kinematics_batch
from srs_ik.solve.packed import PackedArm
from srs_ik.solve.solution import Solution, Status
from srs_ik.solve.solutions import BatchSolution
from srs_ik.solve.threads import run_in_threads
from srs_ik.system.arrays import Array

BESIDE = 0.2
"""A posture that misses its pose by less, m and rad, may lead onto it."""

_OK = float(Status.OK)

CLOSEST_OF = 24
"""Turns at which the closest posture is looked for where none meets the pose."""


class _Question(NamedTuple):
    """Poses, what they leave free, near which seeds postures should be, inside the limits or anywhere.

    Of turns of a cone, a few are tried first, or all at once.
    """

    arm: PackedArm
    poses: Array
    free: FreeAxis
    seeds: Array
    respect: bool
    all_turns: bool = False


def solve(arm: PackedArm, wanted: PoseLike, free_axis: Any, seed: ArrayLike | None, respect: bool) -> Solution:
    """See `Arm.solve`."""
    free, T = as_free_axis(free_axis), as_matrix(wanted)
    seeds = NO_SEEDS if seed is None else as_seed(seed, arm.lower, arm.upper)[None]
    row, verdict = _searched_once(_Question(arm, T[None], free, seeds, respect))
    if verdict:
        raise invalid_pose(verdict)
    if row[ROW_STATUS] != _OK:
        row = _found_otherwise(arm, T, free, seed_of(seeds, 0), respect)
    return Solution(row, arm.joint_names, arm.elbow)


def solve_batch(
    arm: PackedArm, poses: Any, free_axis: Any, seed: ArrayLike | None, respect: bool, threads: int | None
) -> BatchSolution:
    """See `Arm.solve_batch`."""
    free, T = as_free_axis(free_axis), as_matrices(poses)
    seeds = as_seeds(seed, len(T), arm.lower, arm.upper)
    rows, verdicts = _searched(_Question(arm, T, free, seeds, respect), threads)
    refuse_bad_poses(verdicts)
    for i in np.flatnonzero(rows[:, ROW_STATUS] != _OK).tolist():
        rows[i] = _found_otherwise(arm, T[i], free, seed_of(seeds, i), respect)
    return BatchSolution(rows, arm.joint_names, arm.elbow)


def met_batch(
    arm: PackedArm, T: Array, free: FreeAxis, seeds: Array, respect: bool = True, threads: int | None = 1
) -> tuple[Array, NDArray[np.bool_]]:
    """(n, 7) postures near seeds and (n,) which poses these meet, by searches from the seeds alone.

    `solve_batch` looks on where these meet nothing, which takes milliseconds.
    """
    rows, _ = _searched(_Question(arm, T, free, seeds, respect), threads)
    return rows[:, :7], rows[:, ROW_STATUS] == _OK


def refuse_beside(free_axis: Any, **others: Any) -> None:
    """Raise InvalidTask for what does not go with a free axis."""
    given = [name for name, value in others.items() if value is not None and value is not False]
    if free_axis is not None and given:
        raise InvalidTask(f"free_axis does not go with {given[0]}: give one of the two")


def _found_otherwise(arm: PackedArm, T: Array, free: FreeAxis, near: Array | None, respect: bool) -> Array:
    """The answer where searches from starts that are good by their costs have all led beside the pose.

    Few turns may meet it. So more are tried: without the seed, and from the closest posture of all.
    """
    met = _met_at_all(arm, T, free, NO_SEEDS, near, respect)
    if met is not None:
        return met
    closest = _closest(arm, T, free, near, respect)
    if closest[ROW_STATUS] != _OK and max(closest[ROW_POSITION_ERROR], closest[ROW_ORIENTATION_ERROR]) < BESIDE:
        met = _met_at_all(arm, T, free, closest[None, :ROW_POSITION_ERROR], near, respect)
    return closest if met is None else met


def _searched(asked: _Question, threads: int | None) -> tuple[Array, NDArray[np.int8]]:
    """What searches find for poses, and what is said of these."""
    n = len(asked.poses)
    out, verdicts = np.empty((n, ROW)), np.zeros(n, np.int8)
    run_in_threads(partial(_search, asked, out, verdicts), n, threads)
    return out, verdicts


def _searched_once(asked: _Question) -> tuple[Array, int]:
    """What searches find for one pose, and what is said of it: without what a batch needs, which takes as long."""
    out, verdicts = np.empty((1, ROW)), np.zeros(1, np.int8)
    _search(asked, out, verdicts, 0, 1)
    return out[0], int(verdicts[0])


def _search(asked: _Question, out: Array, verdicts: NDArray[np.int8], first: int, last: int) -> None:
    arm, poses, free, seeds, respect, all_turns = asked
    turns = free.turns, len(free.turns) if all_turns else free.few
    space = np.empty(WORK), np.empty((MOST_STARTS, START))
    entries.solve_range(arm.family, poses, first, last, free.packed, *turns, seeds, respect, *space, out, verdicts)


def _met_at_all(
    arm: PackedArm, T: Array, free: FreeAxis, starts: Array, seed: Array | None, respect: bool
) -> Array | None:
    """The answer nearest to a seed at the turn that searches from a start, or from none, lead to; None without one."""
    row, _ = _searched_once(_Question(arm, T[None], free, starts, respect, True))
    if row[ROW_STATUS] != _OK or seed is None:
        return row if row[ROW_STATUS] == _OK else None
    turned = T.copy()
    turned[:3, :3] = forward_kinematics_batch(arm, row[None, :ROW_POSITION_ERROR], 1)[0, :3, :3]
    nearest = pose.solve(arm, turned, seed=seed, respect_limits=respect)
    return nearest._row.copy() if nearest else row


def _closest(arm: PackedArm, T: Array, free: FreeAxis, seed: Array | None, respect: bool) -> Array:
    """The answer at the turn at which a posture comes closest to a pose that searches have not met, or meets it."""
    poses = np.repeat(T[None], CLOSEST_OF, axis=0)
    poses[:, :3, :3] = T[:3, :3] @ free.sampled(CLOSEST_OF)
    at_turns = pose.solve_batch(arm, poses, None, seed, None, False, respect, 1)
    tips = forward_kinematics_batch(arm, at_turns.q, 1)
    off = np.linalg.norm(tips[:, :3, 3] - T[:3, 3], axis=1)
    lean = np.array([free.lean(tip[:3, :3], T[:3, :3]) for tip in tips])
    miss = off + lean
    if at_turns.ok.any():
        # Next to singularities a single turn may have what searches over the turns miss.
        miss = np.zeros(CLOSEST_OF) if seed is None else np.linalg.norm(at_turns.q - seed, axis=1)
        miss[~at_turns.ok] = np.inf
    best = int(miss.argmin())
    row: Array = at_turns[best]._row.copy()
    row[ROW_POSITION_ERROR], row[ROW_ORIENTATION_ERROR] = off[best], lean[best]
    return row
