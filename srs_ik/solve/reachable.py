"""Whether poses are reached, and what a map tells of a pose: many poses at once, each answered on its own."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from srs_ik.inputs.poses import as_matrices, refuse_bad_poses
from srs_ik.kernels.entries import maps as entries
from srs_ik.kernels.entries.pose import pack_limits
from srs_ik.kernels.layout.limb import INVERSE_HALF_RANGE, LIMITED, LOOSE, MIDDLE
from srs_ik.kernels.layout.maps import CELL_ARCS, CELL_MARGIN, CELL_PIECES, REACHED, UNSURE
from srs_ik.solve.pose import solve_batch
from srs_ik.solve.threads import run_in_threads
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.packed import PackedArm


def reachable_batch(arm: PackedArm, poses: Any, threads: int | None = None) -> NDArray[np.bool_]:
    """See `Arm.reachable_batch`."""
    T = as_matrices(poses)
    found = np.zeros(len(T), np.int64)

    def work(first: int, last: int) -> None:
        entries.reachable_range(arm.family, T, first, last, found)

    run_in_threads(work, len(T), threads)
    refuse_bad_poses(np.maximum(-found, 0))
    reached = found == REACHED
    unsure = np.flatnonzero(found == UNSURE)
    if len(unsure):
        reached[unsure] = solve_batch(arm, T[unsure], None, None, None, False, True, threads).ok
    return reached


def measured(arm: PackedArm, poses: Array, *, arcs: int = 0, margin: bool = False, threads: int | None = None) -> Array:
    """What a map tells of poses (N, 4, 4): rows of a cell, as in `kernels.layout.maps`.

    They have room for `arcs` of yaw; with any, all other measures are those with joint 1 free. Threads are all
    processors if not given.
    """
    rows = np.zeros((len(poses), CELL_ARCS + 2 * arcs))
    family = free_first_joint(arm) if arcs else arm.family
    first_limits = np.array([arm.lower[0], arm.upper[0]])

    def work(first: int, last: int) -> None:
        entries.measure_range(family, poses, first, last, first_limits, int(margin), rows)

    run_in_threads(work, len(poses), threads)
    if margin and not arm.closed:
        met = np.flatnonzero(rows[:, CELL_PIECES])
        rows[met, CELL_MARGIN] = _margins(arm, family, poses[met], threads)
    return rows


def largest_margins(arm: PackedArm, poses: Array, threads: int | None = None) -> Array:
    """(N,) margin to the limits of the posture farthest from them, 0 to 1; 0 where a pose is not reached."""
    if not arm.closed:
        return _margins(arm, arm.family, poses, threads)
    found = np.zeros(len(poses))

    def work(first: int, last: int) -> None:
        entries.margin_range(arm.family, poses, first, last, found)

    run_in_threads(work, len(poses), threads)
    return found


def _margins(arm: PackedArm, family: Array, poses: Array, threads: int | None) -> Array:
    """(N,) margin of the posture farthest from the limits, 0 to 1; joints without limits have all room."""
    found = solve_batch(replace(arm, family=family), poses, None, None, None, False, True, threads)
    limits = family[LIMITED]
    share = limits[INVERSE_HALF_RANGE : INVERSE_HALF_RANGE + 7]
    margins: Array = 1.0 - np.abs(found.q - limits[MIDDLE : MIDDLE + 7]) * share
    return np.where(found.ok, np.maximum(margins.min(axis=1), 0.0), 0.0)


def free_first_joint(arm: PackedArm) -> Array:
    """The packed limb of an arm without limits of joint 1, read-only."""
    family = arm.family.copy()
    lower, upper = arm.lower.copy(), arm.upper.copy()
    lower[0], upper[0] = -np.inf, np.inf
    for row in (LIMITED, LOOSE):
        packed = family[row].copy()
        pack_limits(packed, lower, upper)
        family[row] = packed
    family.flags.writeable = False
    return family
