"""Positions of a map: a half-plane through axis 1, or a box in the base frame; and the chunks that tasks work on."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from srs_ik.errors import InvalidMap, quoted
from srs_ik.inputs.numbers import real_number
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.arm import Arm

Kind = Literal["half-plane", "box"]

CELLS_A_TASK = 100_000
"""Cells of a task at most, but for those of one position: some 5 MB while it is at work."""

SIDE = {"half-plane": 16, "box": 6}
"""Positions of a task along each direction at most."""

MOST_POSITIONS = 10**9


@dataclass(frozen=True)
class Grid:
    """Centres of cells, evenly spaced."""

    kind: Kind  # "half-plane" (rho, z) or "box" (x, y, z)
    step: float  # distance between neighbours, metres
    lower: tuple[float, ...]  # edges of the first cell, metres, in the frame of the map
    shape: tuple[int, ...]  # cells along each direction
    # pose of the frame of the map in the base frame, row by row. For a half-plane its z axis is axis 1.
    T_base_map: tuple[tuple[float, ...], ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the directions."""
        return ("rho", "z") if self.kind == "half-plane" else ("x", "y", "z")

    @property
    def pose(self) -> Array:
        """(4, 4) pose of the frame of the map in the base frame."""
        return np.array(self.T_base_map)

    def centres(self, direction: int) -> Array:
        """Coordinates of the centres along one direction, metres."""
        centres: Array = self.lower[direction] + self.step * np.arange(0.5, self.shape[direction])
        return centres

    def points(self, block: Sequence[slice]) -> Array:
        """(n, 3) centres of a block of cells in the base frame, the last direction fastest."""
        lines = [self.centres(k)[part] for k, part in enumerate(block)]
        flat = np.stack([each.ravel() for each in np.meshgrid(*lines, indexing="ij")], axis=1)
        if self.kind == "half-plane":
            flat = np.stack([flat[:, 0], np.zeros(len(flat)), flat[:, 1]], axis=1)
        T = self.pose
        points: Array = flat @ T[:3, :3].T + T[:3, 3]
        return points

    def side(self, orientations: int) -> int:
        """Positions of a task along each direction."""
        fitting = int((CELLS_A_TASK / orientations) ** (1.0 / len(self.shape)) + 1e-9)
        return max(1, min(SIDE[self.kind], fitting))

    def blocks(self, orientations: int) -> list[tuple[slice, ...]]:
        """The positions of each task."""
        side = self.side(orientations)
        parts = [[slice(i, min(i + side, n)) for i in range(0, n, side)] for n in self.shape]
        return list(itertools.product(*parts))


def half_plane(arm: Arm, step: float) -> Grid:
    """All that the arm can reach, in the half-plane on one side of its axis 1."""
    step = checked_step(step)
    a1, reach = arm.limb.axes[0], reach_of(arm)
    on_axis = arm.limb.points[0]
    origin = on_axis + a1 * (a1 @ (arm.limb.shoulder - on_axis))
    across = np.eye(3)[np.argmin(np.abs(a1))]
    across = across - a1 * (a1 @ across)
    across /= np.linalg.norm(across)
    T = np.eye(4)
    T[:3, :3] = np.stack([across, np.cross(a1, across), a1], axis=1)
    T[:3, 3] = origin
    n = math.ceil(reach / step)
    return _of_size(Grid("half-plane", step, (0.0, -n * step), (n, 2 * n), _rows(T)))


def box(arm: Arm, step: float, bounds: object = None) -> Grid:
    """A box in the base frame, `bounds` (3, 2) lower and upper x, y and z, metres: all that the arm can reach if None.

    Raises:
        InvalidMap: the step or the bounds are none.
    """
    step = checked_step(step)
    if bounds is None:
        centre, reach = arm.limb.shoulder, reach_of(arm)
        limits = np.stack([centre - reach, centre + reach], axis=1)
    else:
        try:
            limits = np.array(bounds, dtype=float)
        except (TypeError, ValueError, OverflowError):
            limits = np.empty(0)
        if limits.shape != (3, 2) or not np.isfinite(limits).all() or not (limits[:, 0] < limits[:, 1]).all():
            raise InvalidMap(
                "a box is (3, 2) metres: rows of x, y and z, each a lower and an upper figure, the lower one less"
            )
    first, last = np.floor(limits[:, 0] / step + 1e-9), np.ceil(limits[:, 1] / step - 1e-9)
    shape = tuple(int(n) for n in last - first)
    return _of_size(Grid("box", step, tuple((first * step).tolist()), shape, _rows(np.eye(4))))


def reach_of(arm: Arm) -> float:
    """No pose of the tip is farther from the shoulder than this, metres."""
    limb = arm.limb
    return limb.upper_arm + limb.forearm + limb.hand + 2.0 * float(np.sum(limb.offsets))


def checked_step(step: float, what: str = "the step of a map") -> float:
    """A distance between positions, m; raises InvalidMap for what is none."""
    metres = real_number(step)
    if not 1e-4 <= metres <= 1e3:
        raise InvalidMap(f"{what} is a length from 0.0001 to 1000 m, not {quoted(step)}")
    return metres


def _of_size(grid: Grid) -> Grid:
    if math.prod(grid.shape) > MOST_POSITIONS:
        raise InvalidMap(f"at {grid.step:g} m the map has {math.prod(grid.shape):,} positions; make the step larger")
    return grid


def _rows(T: Array) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(float(x) for x in row) for row in T)
