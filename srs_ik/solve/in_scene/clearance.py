"""How far apart bodies are that are watched, at a posture; and the posture of a pose at which that is most."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from srs_ik.collision.links.ranges import tightened
from srs_ik.kernels.layout import collision as at
from srs_ik.solve import pose as pose_solver
from srs_ik.solve.goals import INSIDE, Search
from srs_ik.solve.in_scene.limits import cut_limits
from srs_ik.solve.in_scene.spans import turned
from srs_ik.solve.objectives import CLEARANCE
from srs_ik.solve.solution import Solution
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.in_scene.surroundings import Surroundings


class Clearance:
    """Least distance, m, of all pairs that are watched: a function of joint angles.

    By the spheres on the true chain; of pairs that the range of a joint watches, what that range tells at least.

    Attributes:
        around: the arm in its scene.
        ranges: of these pairs; not of those that never meet.
    """

    __name__ = CLEARANCE

    def __init__(self, around: Surroundings) -> None:
        self.around = around
        names, kept = around.tables.names, {frozenset((p.first, p.second)) for p in around.arm.pairs if p.kept}
        self.ranges = [r for r in around.tables.ranges if frozenset((names[r.first], names[r.second])) in kept]

    def __call__(self, q: Array) -> float:
        """Clearance at (7,) joint angles, rad."""
        return min(self.of_spheres(q), self.by_ranges(q))

    def of_spheres(self, q: Array) -> float:
        """The same of pairs that are watched by spheres."""
        return float(self.around.along(q[None], q[None], np.array([np.inf]))[0, at.EDGE_CLEARANCE])

    def by_ranges(self, q: Array) -> float:
        """The same of pairs that ranges watch."""
        return min((each.bound_at(float(q[each.joint])) for each in self.ranges), default=np.inf)

    def kept(self, T: Array, free: Array, distance: float, respect: bool) -> Array:
        """(n, 3) where, of free intervals (m, 3) of a pose, ranges tell that bodies are so far apart, m, at least."""
        around, below = self.around, float(np.nextafter(distance, -np.inf))
        limits = cut_limits(around.arm, around.packed, self.ranges, tightened, below)
        inside = [(k, a + INSIDE, b - INSIDE) for k, a, b in around.within(limits, T, free, respect).tolist()]
        rows = []
        for branch, lower, upper in free.tolist():
            own = [(a, b) for k, a, b in inside if k == branch and a < b]
            rows += [(branch, *span) for span in turned(own, lower, upper)]
        return np.array(rows).reshape(-1, 3)


def widest(clearance: Clearance, T: Array, free: Array, respect: bool) -> Solution | None:
    """The posture of largest clearance over free intervals (n, 3) of a pose, on an exact limb within a micrometre.

    Of those that are as clear by ranges of joints, the one whose spheres are farthest apart.
    """
    if not len(free):
        return None
    arm, first = clearance.around.packed, _by_spheres(clearance.around, T, free, respect)
    found: list[Solution | None] = [first]
    if arm.closed:
        found += _by_ranges(clearance, T, free, respect, first)
    else:
        # By the nearest exact limb one knows where to look, not how far bodies of a near one are apart.
        found.append(Search(arm, lambda q: -clearance(q)).over(T, free, respect))
    met = [each for each in found if each]
    return max(met, key=lambda each: (clearance(each.q), clearance.of_spheres(each.q)), default=None)


def _by_spheres(around: Surroundings, T: Array, rows: Array, respect: bool) -> Solution:
    """The posture over some intervals at which the spheres, of the nearest exact limb, are farthest apart."""
    wide = around.widest(T, rows)
    branch = int(wide[at.WIDE_BRANCH])
    return pose_solver.solve(around.packed, T, float(wide[at.WIDE_ARM_ANGLE]), None, branch, respect)


def _by_ranges(clearance: Clearance, T: Array, free: Array, respect: bool, first: Solution) -> list[Solution | None]:
    """Postures of larger clearance than one at which ranges of joints tell of a smaller distance than spheres.

    Ranges tell of steps. Up to some step, found by halving, spheres are that far apart somewhere where ranges are.
    """
    least, most = clearance.by_ranges(first.q), clearance.of_spheres(first.q)
    steps = np.unique([bound for each in clearance.ranges for bound in each.bounds if least < bound < most])
    found: list[Solution | None] = []
    lower, upper = 0, len(steps)
    while lower < upper:
        middle = (lower + upper) // 2
        rows = clearance.kept(T, free, float(steps[middle]), respect)
        answer = _by_spheres(clearance.around, T, rows, respect) if len(rows) else None
        found.append(answer)
        if answer and clearance(answer.q) >= steps[middle]:
            lower = middle + 1
        else:
            upper = middle
    return found
