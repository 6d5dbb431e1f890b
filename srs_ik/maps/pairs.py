"""Two maps: what one arm or tool reaches and the other does not, and what two arms of a robot reach together."""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass

import numpy as np

from srs_ik.errors import InvalidMap
from srs_ik.maps.plan import OF_SCENE, OF_TASK, Plan
from srs_ik.maps.reader import Map, check_map
from srs_ik.maps.store import Store, create, folder_of
from srs_ik.system.arrays import Array

_LARGEST = ("widest", "margin", "manipulability")
"""Measures that are the largest of their kind, so that two arms have the larger one."""


@dataclass(frozen=True, eq=False)
class Compared:
    """How two maps on the same cells differ.

    Attributes:
        both: share of all cells that both reach.
        first: share that the first alone reaches.
        second: share that the second alone reaches.
        width: mean difference of the width of the feasible arm angles, second minus first, where both reach, rad.
        gained: positions' share of orientations that the second reaches, minus that of the first.
    """

    both: float
    first: float
    second: float
    width: float
    gained: Array

    def __repr__(self) -> str:
        return (
            f"Compared(both={self.both:.4g}, first={self.first:.4g}, second={self.second:.4g}, width={self.width:+.4g})"
        )


def compare(first: Map, second: Map) -> Compared:
    """Compare two maps on the same cells: of two arms, two tools, or with other limits.

    Raises:
        InvalidMap: their cells differ, or one has lost files.
    """
    _check_alike(first, second)
    plan = first.plan
    counts, width, gained = np.zeros(3), 0.0, np.zeros(plan.grid.shape)
    records = [m.store.records().tolist() for m in (first, second)]
    for task, block in enumerate(plan.blocks):
        a, b = (m.part("reached", task, r[task]) > 0 for m, r in zip((first, second), records, strict=True))
        counts += [(a & b).sum(), (a & ~b).sum(), (b & ~a).sum()]
        w, v = (m.part("width", task, r[task]) for m, r in zip((first, second), records, strict=True))
        width += float((v - w)[a & b].sum(dtype=float))
        gained[block] = b.mean(axis=-1) - a.mean(axis=-1)
    both, one, other = (counts / plan.cells).tolist()
    return Compared(both, one, other, width / max(counts[0], 1.0), gained)


def combine(first: Map, second: Map, path: str | os.PathLike[str]) -> Map:
    """The map of what either of two arms reaches, as a store of its own.

    Both are boxes over the same cells, so of arms whose poses are given in the same frame (`Arm.with_base`); a warning
    tells base frames of different names. A cell has the branches, pieces and width of the arm that reaches it with the
    larger width, and the larger of each `widest`, `margin` and `manipulability`. Measures for a scene or a task stay
    out.

    Raises:
        InvalidMap: their cells differ, they are half-planes, or one is damaged.
        FileExistsError: there is something at that path.
    """
    _check_alike(first, second)
    if first.plan.arcs or second.plan.arcs:
        raise InvalidMap("two arms turn about different axes: combine boxes, not half-planes")
    folder = folder_of(path)
    if folder.exists():
        raise FileExistsError(17, "there is something already", str(folder))
    own = (*OF_SCENE, *OF_TASK)
    names = tuple(name for name in first.plan.measures if name in second.plan.measures and name not in own)
    plan = Plan(_both(first.plan, second.plan), first.plan.grid, first.plan.orientations, names, 0)
    create(folder, plan)
    _warn_of_frames(first, second)
    store = Store(folder, writable=True)
    records = [m.store.records().tolist() for m in (first, second)]
    for task, block in enumerate(plan.blocks):
        for m, r in zip((first, second), records, strict=True):
            m.store.refuse_damaged(task, r[task])
        a, b = (m.store.read(block) for m in (first, second))
        # A joint that is held leaves arm angles without width, so that width alone does not tell who reaches a cell.
        better = (b["reached"] > 0) & ((a["reached"] == 0) | (b["width"] > a["width"]))
        both = {name: np.where(better, b[name], a[name]) for name in names}
        both |= {name: np.maximum(a[name], b[name]) for name in _LARGEST if name in names}
        store.write(task, block, both)
    return Map(store)


def _warn_of_frames(first: Map, second: Map) -> None:
    a, b = (each.robot["base"] for each in (first.plan, second.plan))
    if a != b:
        said = (
            f"poses of {first.path} are given in {a!r}, those of {second.path} in {b!r}, and are taken as in one frame"
        )
        warnings.warn(f"{said}: base=, --base or with_base(name=) gives both arms one", UserWarning, stacklevel=3)


def _both(first: Plan, second: Plan) -> dict[str, object]:
    a, b = first.robot, second.robot
    return {
        "name": f"{a['name']} and {b['name']}",
        "base": a["base"] if a["base"] == b["base"] else f"{a['base']}, {b['base']}",
        "tip": f"{a['tip']}, {b['tip']}",
        "arms": [a, b],
        "fingerprint": f"{a['fingerprint']} {b['fingerprint']}",
    }


def _check_alike(first: Map, second: Map) -> None:
    check_map(first)
    check_map(second)
    a, b = first.plan, second.plan
    if a.grid != b.grid or a.orientations != b.orientations:
        raise InvalidMap(f"{first.path} and {second.path} have different cells: make both with the same step and box")
    for each in (first, second):
        if each.done < 1.0:
            raise InvalidMap(f"{each.path} is half made: make the rest first")
