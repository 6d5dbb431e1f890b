"""Bodies of a near limb that ranges of joints watch, where these ranges alone do not keep them a margin apart.

The range of one joint tells how near two bodies come at the worst angles of the others. Elsewhere on a curve of
postures they may be farther apart: there the real shapes are looked at, step by step, as `kernels.collision.march` does
it for all other bodies.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from srs_ik.collision.reaches import TOUCH
from srs_ik.solve import pose as pose_solver
from srs_ik.solve.in_scene.spans import FINEST, certify, merged, turned, without
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.in_scene.certified import Shapes

LONGEST = 0.25
"""Longest step, rad."""

BEYOND = 1.25
"""How much farther than at the ends of a step bodies are taken to move within it."""

AGAIN = 0.9
"""Of a step that is as short as the room of bodies allows, the part that is looked at next."""

_LEAST = 1e-9


def kept_apart(shapes: Shapes, T: Array, free: Array, in_range: Array) -> Array:
    """(n, 3) where these bodies keep the margin, of free intervals (m, 3) of a pose, sorted by branch.

    In `in_range` (k, 3), the ranges of joints keep the bodies apart.
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


class _Spot(NamedTuple):
    """The arm at one arm angle."""

    frames: Array  # (8, 4, 4) of its joints
    second: Array  # (n, 4, 4) where the second body of each pair is for the first one


class _Curve:
    """The postures of a branch, and how far these bodies are apart at them."""

    def __init__(self, shapes: Shapes, T: Array, branch: int) -> None:
        self._shapes, self._T, self._branch = shapes, T, branch
        world = shapes.world
        self._pairs = world.ranged(shapes.margin)
        self._joints = np.array([(world.joints[a], world.joints[b]) for a, b in self._pairs]).reshape(-1, 2)
        self._balls = np.array([world.ball(b) for _, b in self._pairs]).reshape(-1, 4)
        self._known: dict[float, _Spot | None] = {}

    def look(self, psi: float, half: float) -> float:
        """What `spans.certify` asks."""
        margin = self._shapes.margin + TOUCH
        half = min(half, 0.5 * LONGEST)
        spot = self._spot(psi)
        while spot is not None and half >= 0.5 * FINEST:
            moved = self._moved(spot, psi, half)
            if moved is None:
                half *= 0.5
                continue
            # Where a pair is too close already, it stays so for as long as it does not move by what is missing.
            room = self._shapes.world.rooms(spot.frames, self._pairs, margin + moved) - margin
            if (room > moved).all():
                return half
            if (room <= 0.0).any():
                return -half * min(float((-room / np.maximum(moved, _LEAST)).max()), 1.0)
            half *= min(AGAIN * float((room / np.maximum(moved, _LEAST)).min()), 0.5)
        return 0.0

    def _moved(self, spot: _Spot, psi: float, half: float) -> Array | None:
        """(n,) how far the bodies of each pair move against each other from the middle of a step on, at most, m."""
        most = np.zeros(len(self._pairs))
        centres = self._balls[:, :3, None]
        for angle in (psi - half, psi + half):
            end = self._spot(angle)
            if end is None:
                return None
            by = end.second - spot.second
            shift = np.linalg.norm((by[:, :3, :3] @ centres)[:, :, 0] + by[:, :3, 3], axis=1)
            # The matrices of two rotations differ by the square root of two times what they move the farthest point by.
            turn = np.linalg.norm(by[:, :3, :3], axis=(1, 2)) / np.sqrt(2.0)
            most = np.maximum(most, shift + self._balls[:, 3] * turn)
        return BEYOND * most

    def _spot(self, psi: float) -> _Spot | None:
        if psi not in self._known:
            answer = pose_solver.solve(self._shapes.packed, self._T, psi, None, self._branch, False)
            self._known[psi] = None
            if answer:
                frames = self._shapes.arm.joint_frames(answer.q)
                first, second = frames[self._joints[:, 0]], frames[self._joints[:, 1]]
                self._known[psi] = _Spot(frames, np.linalg.inv(first) @ second)
        return self._known[psi]
