"""One object of a scene: groups of spheres or planes in its own frame, and where it is."""

from __future__ import annotations

import copy
from collections.abc import Sequence

import numpy as np

from srs_ik.collision.forms import Form
from srs_ik.kernels.layout import collision as at
from srs_ik.system.arrays import Array

CELL = 32
"""Points of a cloud that are looked at together."""


class Thing:
    """One object: groups of rows in its own frame, and where it is.

    Attributes:
        name: of the object.
        forms: its real forms, in its own frame; empty for clouds.
        T: (4, 4) pose in the base frame.
        labels: of each group, the name that messages give.
        replaces: links of the arm's own robot that this object stands for.
    """

    def __init__(self, name: str, T: Array, forms: Sequence[Form] = ()) -> None:
        self.name = name
        self.T = T
        self.forms = tuple(forms)
        self.labels: list[str] = []
        self.replaces: frozenset[str] = frozenset()
        self.kinds: list[int] = []
        self.rows: list[Array] = []
        self.balls: list[Array] = []
        self.parts: list[tuple[str, tuple[Form, ...]]] = []

    def __repr__(self) -> str:
        shapes = ", ".join(str(form) for form in self.forms[:3]) or f"{sum(map(len, self.rows))} spheres"
        more = f" and {len(self.forms) - 3} more" if len(self.forms) > 3 else ""
        x, y, z = self.T[:3, 3]
        return f"<{self.name!r} at ({x:.4g}, {y:.4g}, {z:.4g}) m: {shapes}{more}>"

    def add(self, kind: int, rows: Array, ball: Array, label: str = "") -> None:
        """Add a group of rows, with a sphere (4,) that contains it."""
        self.kinds.append(kind)
        self.rows.append(np.ascontiguousarray(rows, dtype=float))
        self.balls.append(np.asarray(ball, dtype=float))
        self.labels.append(label or self.name)

    def moved(self, T: Array) -> Thing:
        """This object somewhere else; itself it stays, for a question that another thread is at."""
        other = copy.copy(self)
        other.T = T
        return other

    def placed(self) -> tuple[Array, Array]:
        """Balls (G, 4) and rows (n, 4) in the base frame."""
        R, p = self.T[:3, :3], self.T[:3, 3]
        balls = np.array(self.balls)
        balls[:, :3] = balls[:, :3] @ R.T + p
        rows = np.concatenate(self.rows)
        flat = np.repeat(self.kinds, [len(group) for group in self.rows]) == at.PLANES
        turned = rows[:, :3] @ R.T
        rows[:, :3] = np.where(flat[:, None], turned, turned + p)
        rows[:, 3] += np.where(flat, turned @ p, 0.0)
        return balls, rows


def ball_of(rows: Array) -> Array:
    """(4,) a sphere that contains spheres (n, 4)."""
    low, high = (rows[:, :3] - rows[:, 3:]).min(axis=0), (rows[:, :3] + rows[:, 3:]).max(axis=0)
    centre = 0.5 * (low + high)
    radius = float((np.linalg.norm(rows[:, :3] - centre, axis=1) + rows[:, 3]).max())
    return np.array([*centre, radius * (1.0 + 1e-12) + 1e-12])


def cells_of(rows: Array) -> list[Array]:
    """Spheres in cells of at most `CELL`, halved along their longest side."""
    cells, waiting = [], [rows]
    while waiting:
        cell = waiting.pop()
        if len(cell) <= CELL:
            cells.append(cell)
            continue
        axis = int(np.ptp(cell[:, :3], axis=0).argmax())
        half = len(cell) // 2
        order = np.argpartition(cell[:, axis], half)
        waiting += [cell[order[:half]], cell[order[half:]]]
    return cells
