"""Bodies of a near limb that ranges of joints watch, where these ranges alone do not keep them a margin apart.

The range of one joint tells how near two bodies come at the worst angles of the others. Elsewhere on a curve of
postures they may be farther apart: there the real shapes are looked at, step by step, as `kernels.collision.march` does
it for all other bodies.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from srs_ik.collision.reaches import TOUCH
from srs_ik.solve import pose as pose_solver
from srs_ik.solve.in_scene.spans import FINEST, certify, merged, turned, without

if TYPE_CHECKING:
    from srs_ik.solve.in_scene.certified import Shapes

Array = NDArray[np.float64]

LONGEST = 0.25
"""Longest step, rad."""

BEYOND = 1.25
"""How much farther than at the ends of a step joints are taken to turn within it."""


def kept_apart(shapes: Shapes, T: Array, free: Array, in_range: Array) -> Array:
    """(n, 3) where such bodies keep the margin, of free intervals of a pose, sorted by branch.

    Args:
        shapes: the arm in its scene.
        T: (4, 4) the pose.
        free: (m, 3) the intervals.
        in_range: (k, 3) those in which ranges of joints keep the bodies apart.
    """
    rows = []
    for branch in np.unique(free[:, 0]).astype(int).tolist():
        curve = _Curve(shapes, T, branch)
        known = [(lower, upper) for b, lower, upper in in_range.tolist() if b == branch]
        for _, lower, upper in free[free[:, 0] == branch].tolist():
            sure = turned(known, lower, upper)
            rest = without([(lower, upper)], sure)
            shown = [span for part in rest for span in certify(curve.look, *part)[0]]
            rows += [(branch, *span) for span in merged([*sure, *shown])]
    return np.array(rows).reshape(-1, 3)


class _Curve:
    """The postures of a branch, and how far such bodies are apart at them."""

    def __init__(self, shapes: Shapes, T: Array, branch: int) -> None:
        self._shapes, self._T, self._branch = shapes, T, branch
        self._pairs = shapes.world.ranged(shapes.margin)
        self._known: dict[float, Array | None] = {}

    def look(self, psi: float, half: float) -> float:
        """What `spans.certify` asks."""
        half = min(half, 0.5 * LONGEST)
        while not self._is_clear(psi, half):
            half *= 0.5
            if half < 0.5 * FINEST:
                return 0.0
        return half

    def _is_clear(self, psi: float, half: float) -> bool:
        """Whether the bodies keep apart on a step from the middle of it on."""
        q, *ends = (self._posture(angle) for angle in (psi, psi - half, psi + half))
        if q is None:
            return False
        turns = np.zeros(7)
        for end in ends:
            if end is None:
                return False
            turns = np.maximum(turns, np.abs((end - q + np.pi) % (2.0 * np.pi) - np.pi))
        return self._shapes.world.doubtful(q, BEYOND * turns, self._shapes.margin + TOUCH, self._pairs) is None

    def _posture(self, psi: float) -> Array | None:
        if psi not in self._known:
            answer = pose_solver.solve(self._shapes.packed, self._T, psi, None, self._branch, False)
            self._known[psi] = answer.q if answer else None
        return self._known[psi]
