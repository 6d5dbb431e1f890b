"""The one source of free arm angles: limit intervals less what bodies forbid; and who is near to whom at a posture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from srs_ik.collision.links.ranges import loosened, tightened
from srs_ik.collision.reaches import TOUCH
from srs_ik.collision.scenes.figures import as_margin
from srs_ik.collision.scenes.scene import Scene, check_scene
from srs_ik.inputs.poses import invalid_pose
from srs_ik.kernels.entries import collision as entries
from srs_ik.kernels.entries import pose as pose_entries
from srs_ik.kernels.layout import collision as at
from srs_ik.kernels.layout.answer import MOST_INTERVALS, ROW_STATUS
from srs_ik.solve import pose as pose_solver
from srs_ik.solve.in_scene.certified import Shapes, certified_free, marched
from srs_ik.solve.in_scene.limits import Cut, Limits, cut_limits
from srs_ik.solve.in_scene.ranged import kept_apart
from srs_ik.solve.solution import Collision, Status
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.collision.clouds import Clouds
    from srs_ik.collision.owner import BodyOwner
    from srs_ik.collision.real_world import RealWorld
    from srs_ik.collision.tables import Tables
    from srs_ik.solve.packed import PackedArm


_LITTLE = 1e-3
"""Where links of a near limb are no farther from those of its nearest exact limb, m, spheres grown by it will do."""


_ROUNDING = 1e-9
"""A joint angle may be out of a range so far, rad."""


class Surroundings:
    """An arm in a scene, with the margin that is to be kept.

    Attributes:
        arm: the arm.
        packed: what kernels know of it.
        scene: what stands around it.
        margin: m, of the scene and of the question together.
        tables: what kernels know of the bodies.
        tight: limits that keep apart bodies which the range of a joint watches, without and with those of the arm.
        jammed: the pair that no range of a joint keeps apart, if there is one.
        is_exact: whether real shapes count.

    Raises:
        InvalidScene: no `Scene`, or no margin.
        NoBodies: no shapes of the arm are at hand.
    """

    def __init__(self, arm: BodyOwner, packed: PackedArm, scene: Scene, margin: Any, by_shapes: bool = False) -> None:
        check_scene(scene)
        self.arm = arm
        self.packed = packed
        self.scene = scene
        self.is_exact = by_shapes or scene.exact
        self.asked_margin = as_margin(margin)
        self.margin = scene.margin + self.asked_margin
        self.tables: Tables = arm.tables(scene)
        self.slack = self.tables.with_margin(self.margin)
        self.tight, self.jammed = self._cut_limits(tightened, self.margin)

    def __reduce__(self) -> tuple[Any, ...]:
        return Surroundings, (self.arm, self.packed, self.scene, self.asked_margin, self.is_exact)

    def with_shapes(self) -> Surroundings:
        """The same where real shapes count, whatever the scene says."""
        return Surroundings(self.arm, self.packed, self.scene, self.asked_margin, True)

    # Intervals ----------------------------------------------------------------------------------------------------

    def feasible(self, T: Array, respect: bool) -> Array:
        """(n, 3) intervals of a pose that keep the limits, whatever they hit: branch, lower, upper."""
        return self._intervals(self.packed.family, T, respect)

    def in_range(self, T: Array, found: Array, respect: bool) -> Array:
        """(n, 3) intervals in which bodies that ranges of joints watch do not meet; `found` are those in the limits."""
        return self.within((self.tight, self.jammed), T, found, respect)

    def not_meeting(self, T: Array, found: Array, respect: bool) -> Array:
        """(n, 3) the same where the margin is too much to ask of them, and they need only not meet."""
        return self.within(self._cut_limits(tightened, 0.0), T, found, respect)

    def not_out_of_range(self, T: Array, found: Array, respect: bool) -> Array:
        """(n, 3) intervals outside of which some of these bodies are nearer than the margin for certain."""
        return self.within(self._cut_limits(loosened, self.margin), T, found, respect)

    def keeps_range(self, q: Array) -> bool:
        """Whether a posture is in the ranges of joints that keep apart the bodies which they watch."""
        if not self._in_limits(q):
            return False
        tight = self.tight[True]
        if tight is None or self.jammed is not None:
            return tight is None
        return bool((q >= tight.lower - _ROUNDING).all() and (q <= tight.upper + _ROUNDING).all())

    def _in_limits(self, q: Array) -> bool:
        """Whether postures (..., 7) keep the joint limits; beyond these, ranges of joints tell nothing."""
        return bool(((q >= self.packed.lower - _ROUNDING) & (q <= self.packed.upper + _ROUNDING)).all())

    def _cut_limits(self, cut: Cut, margin: float) -> Limits:
        return cut_limits(self.arm, self.packed, self.tables.ranges, cut, margin)

    def within(self, cut: Limits, T: Array, found: Array, respect: bool) -> Array:
        """(n, 3) intervals of a pose within limits; `found` are those in the limits of the arm."""
        both, jammed = cut
        limits = both[bool(respect)]
        if limits is None:
            return found
        if jammed is not None or not len(found):
            return found[:0]
        return self._intervals(limits.family, T, True)

    def all_free(self, T: Array, respect: bool, more: float = 0.0) -> Array:
        """(n, 3) all free intervals of a pose, with so much more than the margin left, m."""
        return self.free_and_undecided(T, respect, more)[0]

    def free_and_undecided(self, T: Array, respect: bool, more: float = 0.0) -> tuple[Array, float]:
        """The same, and the width of what is counted as forbidden without having been decided, rad."""
        if self.is_exact:
            return self.by_shapes(T, respect, more)
        if not self.packed.closed:
            return self.along_curves(T, self.in_range(T, self.feasible(T, respect), respect), more), 0.0
        rows, counts, verdicts = np.empty((MOST_INTERVALS, 3)), np.empty(1, np.int64), np.empty(1, np.int8)
        self.free_range(T[None], 0, 1, respect, rows, counts, verdicts, more)
        if verdicts[0]:
            raise invalid_pose(int(verdicts[0]))
        return rows[: counts[0]], 0.0

    def by_shapes(
        self, T: Array, respect: bool, more: float = 0.0, branch: int = -1, psi: float | None = None
    ) -> tuple[Array, float]:
        """The same on the real shapes, of one branch or of all (-1), at one arm angle or at all."""
        found = self.feasible(T, respect)
        shapes = Shapes(self.arm, self.packed, self.real_world(), self.tables, self.margin + more)
        if not self.packed.closed:
            possible, in_range = (find(T, found, respect) for find in (self.not_out_of_range, self.in_range))
            free = marched(shapes, T, chosen(possible, branch, None))
            if in_range is not possible:
                free = kept_apart(shapes, T, free, in_range)
            return chosen(free, -1, psi), 0.0
        possible = chosen(self.not_out_of_range(T, found, respect), branch, psi)
        # Clouds have no shapes.
        possible = self._cut(T, possible, self.tables.formless, more)
        return certified_free(shapes, T, possible, self.in_range(T, found, respect))

    def free_range(
        self,
        T: Array,
        first: int,
        last: int,
        respect: bool,
        rows: Array,
        counts: NDArray[np.int64],
        verdicts: NDArray[np.int8],
        more: float = 0.0,
    ) -> tuple[int, int]:
        """Write the free intervals of poses of an exact limb, as rows suffice: the next pose, and the rows used."""
        tight, tables = self.tight[bool(respect)], self.tables
        limits = self.packed.family if tight is None else tight.family
        slack = self.slack if more == 0.0 else tables.with_margin(self.margin + more)
        bodies = tables.bodies, tables.groups, tables.pairs, slack, *tables.work()
        out = rows, counts, verdicts
        asked = self.packed.family, limits, T, first, last, respect or tight is not None
        following, used = entries.free_range(*asked, *bodies, *out)
        if self.jammed is not None:
            counts[first:following], used = 0, 0
        return following, used

    def solve_range(
        self,
        T: Array,
        first: int,
        last: int,
        branch: int,
        seeds: Array,
        respect: bool,
        rows: Array,
        verdicts: NDArray[np.int8],
    ) -> None:
        """Write the best free postures of poses of an exact limb, of one branch or of all (-1)."""
        if self.jammed is not None:
            rows[first:last, ROW_STATUS] = at.NOTHING_FREE
            return
        tight, tables = self.tight[bool(respect)], self.tables
        limits = self.packed.family if tight is None else tight.family
        asked = T, first, last, branch, seeds, respect, respect or tight is not None
        bodies = tables.bodies, tables.groups, tables.pairs, self.slack, *tables.work()
        entries.solve_range(self.packed.family, limits, *asked, *bodies, rows, verdicts)

    def along_curves(self, T: Array, found: Array, more: float) -> Array:
        """(n, 3) what the spheres leave of some intervals of a near limb."""
        tables = self.tables
        if tables.slack[at.DRIFT] < _LITTLE or not (len(found) and len(tables.pairs)):
            return self._cut(T, found, tables.pairs, more)
        out = np.empty((MOST_INTERVALS, 3))
        slack = tables.with_margin(self.margin + more)
        bodies = tables.bodies, tables.groups, tables.pairs, slack, *tables.work()
        count = entries.march(self.packed.family, T, found, len(found), *bodies, out)
        return out[:count]

    @property
    def in_closed_form(self) -> bool:
        """Whether the spheres of an exact limb count."""
        return self.packed.closed and not self.is_exact

    def _intervals(self, family: Array, T: Array, respect: bool) -> Array:
        found = np.empty((MOST_INTERVALS, 3))
        count = pose_entries.intervals(family, T, respect, found)
        if count < 0:
            raise invalid_pose(-count)
        return found[:count]

    def _cut(self, T: Array, found: Array, pairs: NDArray[np.int64], more: float) -> Array:
        """(n, 3) what the spheres of some pairs of bodies leave of some intervals, with so much more margin, m."""
        if not (len(found) and len(pairs)):
            return found
        tables = self.tables
        out = np.empty((MOST_INTERVALS, 3))
        slack = self.slack if more == 0.0 else tables.with_margin(self.margin + more)
        count = entries.free_intervals(
            self.packed.family, T, tables.bodies, tables.groups, pairs, slack, *tables.work(), found, len(found), out
        )
        return out[:count]

    # Who is near to whom ------------------------------------------------------------------------------------------

    def real_world(self) -> RealWorld:
        """The real forms, for coal."""
        from srs_ik.collision.real_world import RealWorld

        state = self.arm.__dict__
        world: RealWorld | None = state.get("_real_world")
        still = self.tables.scene
        if world is None or world.scene is not still:
            world = state["_real_world"] = RealWorld(self.arm, still, self.tables.ranges)
        return world

    def clouds(self) -> Clouds:
        """The clouds around the real forms."""
        from srs_ik.collision.clouds import Clouds

        return Clouds(self.real_world(), self.tables)

    def widest(self, T: Array, found: Array, tolerance: float = 1e-6) -> Array:
        """(WIDE,) the arm angle of largest clearance, within a tolerance, m, over some intervals of a pose."""
        tables, out = self.tables, np.empty(at.WIDE)
        bodies = tables.bodies, tables.groups, tables.pairs, *tables.work()
        entries.widest(self.packed.family, T, *bodies, found, len(found), tolerance, out)
        return out

    def clearance(self, T: Array, elbow: int, psi: float) -> Array:
        """(WIDE,) clearance at one arm angle of an elbow."""
        tables, out = self.tables, np.empty(at.WIDE)
        bodies = tables.bodies, tables.groups, tables.pairs, *tables.work()
        entries.clearance(self.packed.family, T, *bodies, elbow, psi, out)
        return out

    def along(self, starts: Array, ends: Array, margins: Array, pairs: NDArray[np.int64] | None = None) -> Array:
        """(n, EDGE) what is in the way on straight lines of joint angles, on the true chain, by the spheres."""
        tables = self.tables
        slack = np.repeat(tables.slack[None], len(starts), axis=0)
        slack[:, at.MARGIN] = margins
        out = np.empty((len(starts), at.EDGE))
        bodies = tables.bodies, tables.groups, tables.pairs if pairs is None else pairs
        lines = np.ascontiguousarray(starts), np.ascontiguousarray(ends)
        entries.edges(self.packed.family, *lines, *bodies, slack, *tables.work(), out)
        return out

    def collision_of(self, edge: Array, pairs: NDArray[np.int64] | None = None) -> Collision | None:
        """Which bodies are in the way on a line, and how much is missing to the margin."""
        pair = int(edge[at.EDGE_PAIR])
        if pair < 0:
            return None
        first, second = (self.tables.names[k] for k in (self.tables.pairs if pairs is None else pairs)[pair])
        return Collision(first, second, max(self.margin - float(edge[at.EDGE_CLEARANCE]), 0.0))

    def hit_at(self, q: Array) -> Collision | None:
        """Which bodies are too close at a posture, by spheres, and those that ranges watch by shapes; None for none."""
        hit = self.collision_of(self.along(q[None], q[None], np.array([self.margin]))[0])
        return hit if hit is not None else self._hit_by_range(q)

    def is_clear(self, q: Array, by_shapes: bool | None = None) -> bool:
        """Whether a posture certainly keeps the margin, by spheres or, where real shapes count, by these."""
        if self.hit_at(q) is None:
            return True
        return (self.is_exact if by_shapes is None else by_shapes) and self.deepest_at(q, TOUCH) is None

    def watched(self, q: Array, more: float = 0.0) -> list[tuple[int, int]]:
        """Pairs of bodies that may come within the margin, and so much more, m, at postures (..., 7)."""
        return self.real_world().watched(self.margin + more if self._in_limits(q) else np.inf)

    def deepest_at(self, q: Array, more: float = 0.0) -> Collision | None:
        """Which bodies are too close at a posture, the closest of them, by their real shapes; None for none.

        Those also count that come no closer than the margin, but so much more, m.
        """
        hit = self._nearest(q, self.watched(q, more), more)
        hits = [] if hit is None else [hit]
        formless = self.tables.formless
        if len(formless):
            edge = self.along(q[None], q[None], np.array([self.margin]), formless)[0]
            hit = self.collision_of(edge, formless)
            hits += [] if hit is None else [hit]
        return max(hits, key=lambda hit: hit.depth, default=None)

    def closest_at(self, q: Array) -> Collision | None:
        """The same where clouds, too, are asked for by the real shapes, which no set of arm angles does."""
        hits = [self._nearest(q, self.watched(q)), self.told(self.clouds().nearest(q, self.margin))]
        return max(filter(None, hits), key=lambda hit: hit.depth, default=None)

    def hits_of(self, T: Array, rows: Array) -> dict[tuple[int, ...], Collision]:
        """What hits what in answers that say so, by their index."""
        hits: dict[tuple[int, ...], Collision] = {}
        for i in np.flatnonzero(rows[:, ROW_STATUS] == Status.COLLISION).tolist():
            hit = self.hit_at(rows[i, :7])
            if hit is not None:
                hits[(i,)] = hit
        return hits

    def in_the_way(self, T: Array, postures: Array, longest: float) -> Collision | None:
        """What the postures of a pose hit that some others reach without a jump; None for nothing."""
        for q in postures:
            there = pose_solver.solve(self.packed, T, seed=q)
            if there and np.abs(there.q - q).max() <= longest:
                hit = self.hit_at(there.q)
                if hit is not None:
                    return hit
        return None

    def _hit_by_range(self, q: Array) -> Collision | None:
        """Which bodies are too close of those that ranges of joints watch, the closest by their real shapes."""
        known = self._in_limits(q)
        doubtful = [
            (each.first, each.second)
            for each in self.tables.ranges
            if not known or each.bound_at(float(q[each.joint])) <= self.margin
        ]
        return self._nearest(q, doubtful) if doubtful else None

    def _nearest(self, q: Array, pairs: Sequence[tuple[int, int]], more: float = 0.0) -> Collision | None:
        """Which of some pairs of bodies are too close at a posture, the closest of them by their real shapes."""
        return self.told(self.real_world().nearest(q, self.margin + more, pairs))

    def told(self, near: tuple[str, str, float] | None) -> Collision | None:
        """Two bodies and how near they are, m, as what is missing to the margin."""
        return None if near is None else Collision(near[0], near[1], max(self.margin - near[2], 0.0))

    def collision(self, wide: Array) -> Collision | None:
        """Who is nearest to whom at an arm angle, and how much is missing to the margin."""
        if wide[at.WIDE_FIRST] < 0:
            return None
        names = self.tables.names
        first, second = names[int(wide[at.WIDE_FIRST])], names[int(wide[at.WIDE_SECOND])]
        return Collision(first, second, max(self.margin - float(wide[at.WIDE_CLEARANCE]), 0.0))


def chosen(found: Array, branch: int, psi: float | None) -> Array:
    """Those of some intervals that are of a branch (-1: any), and hold an arm angle, if there is one."""
    if branch >= 0:
        found = found[found[:, 0] == branch]
    return found if psi is None else narrowed(found, psi)


def narrowed(found: Array, psi: float) -> Array:
    """Those of some intervals that an arm angle lies in, each narrowed to it."""
    turn = 2.0 * np.pi
    inside = (psi - found[:, 1]) % turn <= found[:, 2] - found[:, 1]
    point = found[inside]
    point[:, 1:] = psi
    return point
