"""One task of a map: all cells of a block of positions, computed and written."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from srs_ik.kernels.entries import maps as entries
from srs_ik.kernels.layout import maps as at
from srs_ik.maps.orientations import Orientations
from srs_ik.maps.plan import MEASURES, YAW, Plan
from srs_ik.maps.store import Store
from srs_ik.solve.reachable import free_first_joint, measured

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.solve.packed import PackedArm

Array = NDArray[np.float64]

AT_ONCE = 20_000
"""Cells whose figures are held in full precision."""

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
    """All that a worker needs to know, some ten kilobytes.

    Attributes:
        packed: the arm.
        plan: the map.
    """

    packed: PackedArm
    plan: Plan


def job_of(arm: Arm, plan: Plan) -> Job:
    """The job of mapping an arm."""
    return Job(arm.packed, plan)


def run_task(job: Job, path: str, task: int) -> tuple[int, int]:
    """Compute a task and write it; the task and its record. Done twice, it writes the same."""
    block = job.plan.blocks[task]
    return task, _opened(path).write(task, block, compute(job, block))


@lru_cache(maxsize=4)
def _opened(path: str) -> Store:
    return Store(Path(path), writable=True)


@lru_cache(maxsize=2)
def _rotations(orientations: Orientations) -> Array:
    return np.ascontiguousarray(orientations.matrices().reshape(-1, 9))


def compute(job: Job, block: tuple[slice, ...]) -> dict[str, NDArray]:
    """The measures of all cells of a block of positions, by name."""
    plan = job.plan
    points, rotations = plan.grid.points(block), in_base(plan)
    n = len(rotations)
    shape = (*(part.stop - part.start for part in block), n)
    values: dict[str, NDArray] = {name: np.zeros(len(points) * n, MEASURES[name][0]) for name in plan.measures}
    if plan.arcs:
        values[YAW] = np.zeros((len(points) * n, plan.arcs, 2))
    some = max(1, AT_ONCE // n)
    for first in range(0, len(points), some):
        rows = cells(job, points[first : first + some], rotations)
        _put(plan, values, slice(first * n, first * n + len(rows)), rows)
        if "manipulability" in values:
            _put_manipulability(job, values, points[first : first + some], rotations, first * n)
    return {name: each.reshape(*shape, *each.shape[1:]) for name, each in values.items()}


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


def _put(plan: Plan, values: dict[str, NDArray], where: slice, rows: Array) -> None:
    for name, column in _COLUMNS.items():
        if name in values:
            values[name][where] = rows[:, column] > 0.0 if name == "reached" else rows[:, column]
    if plan.arcs:
        values[YAW][where] = rows[:, at.CELL_ARCS :].reshape(-1, plan.arcs, 2)


def _put_manipulability(job: Job, values: dict[str, NDArray], points: Array, rotations: Array, first: int) -> None:
    from srs_ik.solve.optimise import optimise

    packed = job.packed
    if job.plan.arcs:
        lower, upper = packed.lower.copy(), packed.upper.copy()
        lower[0], upper[0] = -np.inf, np.inf
        packed = replace(packed, family=free_first_joint(packed), lower=lower, upper=upper)
    poses = poses_of(points, rotations)
    for k in np.flatnonzero(values["reached"][first : first + len(poses)]):
        values["manipulability"][first + k] = optimise(packed, None, poses[k], "manipulability").value  # type: ignore[arg-type]
