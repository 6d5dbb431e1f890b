"""One task of a map: all cells of a block of positions, computed and written."""

from __future__ import annotations

from concurrent.futures import CancelledError
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.entries import maps as entries
from srs_ik.kernels.layout import maps as at
from srs_ik.maps.extras import Around, Asked, around_of, needs_postures, of_postures
from srs_ik.maps.orientations import Orientations
from srs_ik.maps.plan import MEASURES, YAW, Plan
from srs_ik.maps.store import Store, identity_of, refuse_other
from srs_ik.solve.reachable import free_first_joint, measured
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.collision.scenes.scene import Scene
    from srs_ik.solve.packed import PackedArm

AT_ONCE = 2_000
"""Cells whose figures are held in full precision, and after which a task can be stopped."""

_COLUMNS = {
    "reached": at.CELL_PIECES,
    "branches": at.CELL_BRANCHES,
    "pieces": at.CELL_PIECES,
    "width": at.CELL_WIDTH,
    "widest": at.CELL_WIDEST,
    "margin": at.CELL_MARGIN,
}


@dataclass(frozen=True, eq=False)
class Job:
    """All that a worker needs to know, some ten kilobytes."""

    packed: PackedArm  # the arm
    plan: Plan  # the map
    around: Around | None = None  # the arm in the scene of the map, where it has one


def job_of(arm: Arm, plan: Plan, scene: Scene | None = None) -> Job:
    """The job of mapping an arm."""
    return Job(arm.packed, plan, around_of(arm, scene))


def run_task(job: Job, path: str, task: int, stop: Event | None = None) -> tuple[int, int]:
    """Compute a task and write it; the task and its record. Done twice, it writes the same.

    Raises:
        CancelledError: it was told to stop before it was done; nothing is written then.
        InvalidMap: the folder holds no map any more, or another one.
    """
    block = job.plan.block(task)
    values = compute(job, block, stop)
    store = _opened(path, identity_of(Path(path)))
    refuse_other(store, job.plan)
    return task, store.write(task, block, values)


@lru_cache(maxsize=4)
def _opened(path: str, _identity: tuple[int, int]) -> Store:
    return Store(Path(path), writable=True)


@lru_cache(maxsize=2)
def _rotations(orientations: Orientations) -> Array:
    return np.ascontiguousarray(orientations.matrices().reshape(-1, 9))


def compute(job: Job, block: tuple[slice, ...], stop: Event | None = None) -> dict[str, NDArray]:
    """The measures of all cells of a block of positions, by name; `CancelledError` once it is told to stop."""
    points, rotations = job.plan.grid.points(block), in_base(job.plan)
    n = len(rotations)
    shape = (*(part.stop - part.start for part in block), n)
    values = _room(job.plan, len(points) * n)
    some = max(1, AT_ONCE // n)
    for first in range(0, len(points), some):
        if stop is not None and stop.is_set():
            raise CancelledError
        for name, each in measures_at(job, points[first : first + some], rotations).items():
            values[name][first * n : first * n + len(each)] = each
    return {name: each.reshape(*shape, *each.shape[1:]) for name, each in values.items()}


def _room(plan: Plan, count: int) -> dict[str, NDArray]:
    """Zeros for the measures of so many cells."""
    values: dict[str, NDArray] = {name: np.zeros(count, MEASURES[name][0]) for name in plan.measures}
    if plan.arcs:
        values[YAW] = np.zeros((count, plan.arcs, 2))
    return values


def measures_at(job: Job, points: Array, rotations: Array) -> dict[str, NDArray]:
    """The measures of every point (n, 3) with every rotation (m, 9), both in the base frame, (n m,) by name."""
    plan = job.plan
    rows = cells(job, points, rotations)
    values = _room(plan, len(rows))
    for name, column in _COLUMNS.items():
        if name in values:
            values[name][:] = rows[:, column] > 0.0 if name == "reached" else rows[:, column]
    if plan.arcs:
        values[YAW][:] = rows[:, at.CELL_ARCS :].reshape(-1, plan.arcs, 2)
    if needs_postures(plan.measures):
        met = np.flatnonzero(values["reached"])
        poses = poses_of(points, rotations)[met]
        asked = Asked(job.packed, plan.measures, job.around, plan.task, any_yaw=plan.arcs > 0)
        for name, each in of_postures(asked, poses).items():
            values[name][met] = each
    return values


def in_base(plan: Plan) -> Array:
    """(n, 9) rotations of the tip in the base frame."""
    rotations = _rotations(plan.orientations)
    if plan.grid.kind == "box":
        return rotations
    turned = plan.grid.pose[:3, :3] @ rotations.reshape(-1, 3, 3)
    return np.ascontiguousarray(turned.reshape(-1, 9))


def cells(job: Job, points: Array, rotations: Array) -> Array:
    """Rows of every point (n, 3) with every rotation (m, 9), both in the base frame."""
    packed, plan = job.packed, job.plan
    margin = "margin" in plan.measures
    if not packed.closed:
        return measured(packed, poses_of(points, rotations), arcs=plan.arcs, margin=margin, threads=1)
    rows = np.empty((len(points) * len(rotations), at.CELL_ARCS + 2 * plan.arcs))
    family = free_first_joint(packed) if plan.arcs else packed.family
    first_limits = np.array([packed.lower[0], packed.upper[0]])
    entries.measure_cells(family, np.ascontiguousarray(points), rotations, first_limits, int(margin), rows)
    return rows


def poses_of(points: Array, rotations: Array) -> Array:
    """(n m, 4, 4) poses of every point with every rotation."""
    T = np.zeros((len(points), len(rotations), 4, 4))
    T[:, :, :3, :3] = rotations.reshape(1, -1, 3, 3)
    T[:, :, :3, 3] = points[:, None]
    T[:, :, 3, 3] = 1.0
    return T.reshape(-1, 4, 4)
