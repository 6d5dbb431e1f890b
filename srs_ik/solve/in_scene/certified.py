"""Free arm angles on the real shapes, certified by distances against a bound on how far bodies can move.

Kernels look at the convex hulls of shapes (`kernels.collision.shaped`). What hulls do not free of bodies that are not
convex is asked of coal: pairs that the arm angle turns as one, and those that it does not move, once for all branches
of an elbow; links 1, 2, 5 and 6, which spin beside, for each branch. What is not shown to be free counts as forbidden.

Source: F. Schwarzer, M. Saha, J.-C. Latombe, Adaptive Dynamic Collision Checking for Single and Multiple Articulated
Robots in Complex Environments, T-RO 21(3), 2005, with a bound for one arm angle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from srs_ik.collision.reaches import TOUCH, Hinge, Rates, Spinning
from srs_ik.kernels.entries import collision as entries
from srs_ik.kernels.layout import shapes as at
from srs_ik.kernels.layout.answer import MOST_INTERVALS
from srs_ik.solve import pose as pose_solver
from srs_ik.solve.in_scene.spans import Span, certify, common, merged, turned, width, without
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.collision.owner import BodyOwner
    from srs_ik.collision.real_world import RealWorld
    from srs_ik.collision.tables import Tables
    from srs_ik.solve.packed import PackedArm

Look = Callable[[float, float], float]

_ROOM = 256
"""Room for what is left of pairs at first."""


class Shapes(NamedTuple):
    """An arm in its scene, as real shapes and as spheres, and what is to be left between bodies, m."""

    arm: BodyOwner
    packed: PackedArm
    world: RealWorld
    tables: Tables
    margin: float


def certified_free(shapes: Shapes, T: Array, found: Array, in_range: Array) -> tuple[Array, float]:
    """(n, 3) what is certainly free of intervals (n, 3) of a pose, sorted, and the width left undecided, rad.

    In `in_range` (m, 3), the ranges of joints keep apart bodies that no sphere watches.
    """
    if not len(found):
        return found, 0.0
    _, packed, world, tables, margin = shapes
    couples, pairs = world.couples(tables, margin)
    spheres = tables.bodies, tables.groups, tables.pairs, tables.with_margin(margin), *tables.work()
    asked = T, found, in_range, margin + TOUCH, *spheres, *world.solids.tables
    out, rest = np.empty((MOST_INTERVALS, 3)), np.empty((_ROOM, at.REST))
    while True:
        told = (couples, world.solids.outer, out, rest)
        count, undecided, left = entries.free_by_solids(packed.family, *asked, *told)
        if left <= len(rest):
            break
        rest = np.empty((left, at.REST))
    if not left:
        return out[:count], undecided
    return _Rest(shapes, T, pairs, rest[:left]).of(out[:count], undecided)


def marched(shapes: Shapes, T: Array, found: Array) -> Array:
    """(n, 3) what the hulls of shapes leave of some intervals of a near limb, sorted, along its curves."""
    _, packed, world, tables, margin = shapes
    couples, _ = world.couples(tables, margin)
    if not (len(found) and len(tables.pairs)):
        return found
    spheres = tables.bodies, tables.groups, tables.pairs, tables.with_margin(margin + TOUCH), *tables.work()
    out = np.empty((MOST_INTERVALS, 3))
    solids = *world.solids.tables, couples, world.solids.outer
    count = entries.march_by_solids(packed.family, T, found, *spheres, *solids, out)
    return out[:count]


class _Rest:
    """What the hulls of bodies leave undecided at one pose."""

    def __init__(self, shapes: Shapes, T: Array, pairs: list[tuple[int, int]], rows: Array) -> None:
        self._arm, self._packed, self._world, _, self._margin = shapes
        self._T = T
        self._left: dict[int, dict[tuple[int, int], list[Span]]] = {}
        for pair, branch, lower, upper in rows.tolist():
            own = self._left.setdefault(int(branch), {})
            own.setdefault(pairs[int(pair)], []).append((lower, upper))
        limb = shapes.arm.limb
        wrist = T @ np.linalg.inv(limb.T_base_tip_zero) @ [*limb.wrist, 1.0]
        line = wrist[:3] - limb.shoulder
        self._line = limb.shoulder, line / np.linalg.norm(line)

    def of(self, free: Array, undecided: float) -> tuple[Array, float]:
        """What coal leaves of free intervals, and the width left undecided."""
        pieces = []
        for branch in np.unique(free[:, 0]).astype(int).tolist():
            own = [(lower, upper) for _, lower, upper in free[free[:, 0] == branch].tolist()]
            for part in (-1 - (branch >> 2), branch):
                taken, unsure = self._taken(part, branch, own)
                own = without(own, taken)
                undecided += width(unsure)
            pieces += [(branch, lower, upper) for lower, upper in own]
        return np.array(pieces).reshape(-1, 3), undecided

    def _taken(self, part: int, branch: int, wanted: list[Span]) -> tuple[list[Span], list[Span]]:
        """Of the arm angles wanted of a branch, those that one part of the rest forbids, and the unsure of these."""
        left = self._left.get(part)
        if not left or not wanted:
            return [], []
        lower, upper = wanted[0][0], max(span[1] for span in wanted)
        arcs = {pair: common(turned(own, lower, upper), wanted) for pair, own in left.items()}
        if part < 0:
            return self._of_elbow(branch, arcs, wanted)
        spinning = Spinning(self._world, self._postures(branch), self._rates, self._line, self._margin)
        return _blocked(((spinning.look(*pair), own) for pair, own in arcs.items() if own), wanted)

    def _of_elbow(
        self, branch: int, arcs: dict[tuple[int, int], list[Span]], wanted: list[Span]
    ) -> tuple[list[Span], list[Span]]:
        spans = [span for own in arcs.values() for span in own]
        if not spans:
            return [], []
        psi = 0.5 * sum(spans[0])
        q = self._posture(branch, psi)
        if q is None:
            return wanted, wanted
        hinge = Hinge(self._world, self._arm.joint_frames(q), psi, self._line, self._margin)
        return _blocked(((hinge.look(*pair), own) for pair, own in arcs.items() if own), wanted)

    def _postures(self, branch: int) -> Callable[[float], Array | None]:
        known: dict[float, Array | None] = {}

        def posture(psi: float) -> Array | None:
            if psi not in known:
                known[psi] = self._posture(branch, psi)
            return known[psi]

        return posture

    def _posture(self, branch: int, psi: float) -> Array | None:
        answer = pose_solver.solve(self._packed, self._T, psi, None, branch, False)
        return answer.q if answer else None

    def _rates(self, q: Array, half: float) -> Rates:
        outer = self._world.solids.outer
        shoulder, wrist = (_fastest(row, float(angle), half) for row, angle in zip(outer, (q[1], q[5]), strict=True))
        second, sixth = (
            1.0 if row[at.TO_FIRST] == row[at.TO_LAST] == 0.0 else rate
            for row, rate in zip(outer, (shoulder, wrist), strict=True)
        )
        return Rates(shoulder, second, wrist, sixth)


def _blocked(looks: Iterator[tuple[Look, list[Span]]], wanted: list[Span]) -> tuple[list[Span], list[Span]]:
    """Of the arm angles wanted, those not certified by some pair, and those left undecided."""
    blocked: list[Span] = []
    unsure: list[Span] = []
    for look, arcs in looks:
        for a, b in without(common(arcs, wanted), blocked):
            free, doubtful = certify(look, a, b)
            blocked = merged([*blocked, *without([(a, b)], free)])
            unsure += doubtful
    return blocked, merged(unsure)


def _fastest(outer: Array, q: float, half: float) -> float:
    """Largest rate of joints 1 and 3 of a spherical joint within half an arm angle, rad/rad; see the kernel's."""
    cosine = outer[at.FIXED] + outer[at.COSINE] * math.cos(q) + outer[at.SINE] * math.sin(q)
    angle = math.acos(min(max(cosine, -1.0), 1.0))
    if angle - half <= 0.0 or angle + half >= math.pi:
        return math.inf
    first, last = outer[at.TO_FIRST], outer[at.TO_LAST]
    ends = [math.cos(angle - half), math.cos(angle + half)]
    least = min(1.0 - first * first - last * last - c * c + 2.0 * first * last * c for c in ends)
    return float(1.0 / math.sqrt(least)) if least > 0.0 else math.inf
