"""Joint paths that hit nothing: free intervals at each pose, and straight lines between postures that are certified.

The best path without the scene is the answer if it hits nothing. Else a path is planned in free intervals. Then each of
its lines is looked along; where something is in the way between two poses, more room is asked for at both of them, by
as much as was missing, and the path is planned again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from srs_ik.collision.reaches import TOUCH
from srs_ik.errors import InvalidConfiguration
from srs_ik.kernels.layout.answer import ROW_STATUS
from srs_ik.kernels.layout.path import BY_CONTINUITY
from srs_ik.solve.in_scene.edges import Edges
from srs_ik.solve.path.breaks import PathBreak, breaks_of
from srs_ik.solve.path.problem import JUST_ABOVE, Problem, Way, steps_of
from srs_ik.solve.path.rows import joint_steps, rows_of
from srs_ik.solve.path.search.free_curves import curves_of, on_free_curves
from srs_ik.solve.path.solution import PathSolution
from srs_ik.solve.path.turns import unwound
from srs_ik.solve.solution import Status
from srs_ik.system.arrays import Array

ROOM = 1e-3
"""What is asked for beyond the margin at each pose, m: right on the margin nothing can be certified."""

ROUNDS = 8
"""A path is planned again so often at most."""

AMPLE = 1.5
"""More room is asked for than was missing, by this factor."""


def keep_clear(
    problem: Problem, plan_alone: Callable[[], PathSolution], find: Callable[[Problem], Way]
) -> PathSolution:
    """See `Arm.solve_path`, with a scene.

    `plan_alone` gives the path without the scene, `find` is the search for one through given intervals.
    """
    around = problem.around
    assert around is not None
    _refuse_hits(problem)
    alone = plan_alone()
    clear = if_clear(problem, alone)
    return _through_free(problem, alone, find) if clear is None else clear


def if_clear(problem: Problem, alone: PathSolution) -> PathSolution | None:
    """A path without the scene, if it has no break and certainly hits nothing."""
    around = problem.around
    assert around is not None
    if not alone:
        return None
    found = with_breaks(problem, alone._rows)
    # Lines are certified with both their ends.
    return found if found and (len(found) > 1 or around.is_clear(found.q[0])) else None


def _through_free(problem: Problem, alone: PathSolution, find: Callable[[Problem], Way]) -> PathSolution:
    """A path through free intervals whose lines are certified, by real shapes where the spheres leave too little.

    At poses where they leave nothing, they could be told no more than postures one by one, which do not go on from
    each other. The same goes for postures that are given, and that spheres alone hit.
    """
    around, room = problem.around, _Room(problem)
    assert around is not None
    paths = []
    if not around.is_exact and (
        any(around.hit_at(q) for q in problem.known[problem.has_known])
        or any(len(around.by_shapes(problem.T[i], True)[0]) for i in room.shut)
    ):
        exact = replace(problem, around=around.with_shapes())
        clear = if_clear(exact, alone)
        paths = [_planned(exact, _Room(exact), find) if clear is None else clear]
    if not any(paths):
        paths.append(_planned(problem, room, find))
    return min(paths, key=lambda path: len(path.breaks))


def _planned(problem: Problem, room: _Room, find: Callable[[Problem], Way]) -> PathSolution:
    """A path through free intervals, planned again with more room where its lines are not certified."""
    around = problem.around
    assert around is not None
    tight = around.tight[True]
    arm = problem.arm
    if tight is not None and around.jammed is None:
        # So that no line between two postures leaves the ranges of joints that keep bodies apart.
        arm = replace(arm, family=tight.family, lower=tight.lower, upper=tight.upper)
    curves = None if arm.closed else curves_of(replace(problem, arm=arm))
    best = None
    for _ in range(ROUNDS):
        asked = replace(problem, arm=arm, free=room.free)
        if curves is not None:
            asked = on_free_curves(asked, curves)
        way = find(asked)
        rows = rows_of(asked, way)
        rows[:, :7] = unwound(asked, rows)
        edges = Edges(around, rows[:, :7], _lines(asked, rows), around.is_exact)
        found = len(edges.hits), way, rows, edges, asked
        jumps = int((~way.reached).sum()) + _jumps(asked, rows)
        if best is None or (jumps, found[0]) < best[0]:
            best = (jumps, found[0]), found
        if not edges.hits or not room.more(edges):
            break
    assert best is not None
    _, way, rows, edges, asked = best[1]
    return _path(problem, rows, breaks_of(asked, way, rows, joint_steps(rows)), edges)


def with_breaks(problem: Problem, rows: Array) -> PathSolution:
    """The path of these rows, with its breaks at postures and on lines between them."""
    around = problem.around
    assert around is not None
    edges = Edges(around, rows[:, :7], _lines(problem, rows), around.is_exact)
    return _path(problem, rows, breaks_of(problem, None, rows, joint_steps(rows)), edges)


def _path(problem: Problem, rows: Array, at_poses: Sequence[PathBreak], edges: Edges) -> PathSolution:
    """The path of these rows, with its breaks at poses and those of its lines."""
    arm, around, steps = problem.arm, problem.around, joint_steps(rows)
    assert around is not None
    breaks = sorted([*at_poses, *_blocked(edges, steps, arm.joint_names)], key=lambda each: each.sample)
    return PathSolution(rows, arm.joint_names, steps, breaks, arm.elbow, around.hits_of(problem.T, rows), problem)


class _Room:
    """The free intervals of the poses of a path, with more room than the margin where that is asked for."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._asked = np.full(len(problem.T), ROOM)
        self.free = [self._intervals(i) for i in range(len(problem.T))]

    @property
    def shut(self) -> list[int]:
        """Poses without any."""
        return [i for i, free in enumerate(self.free) if not len(free)]

    def _intervals(self, i: int) -> Array:
        """Those of one pose, with less room where there is not as much."""
        around = self._problem.around
        assert around is not None
        free = np.empty((0, 3))
        for part in (1.0, 0.5, 0.0):
            free = around.all_free(self._problem.T[i], True, part * float(self._asked[i]))
            if len(free):
                break
        return free.copy()

    def more(self, edges: Edges) -> bool:
        """Ask for more room at both ends of lines that something is in the way of; whether any is to be had."""
        wanted = self._asked.copy()
        for hit in edges.hits:
            for i in (hit.sample, hit.sample + 1):
                wanted[i] = max(wanted[i], self._asked[i] + AMPLE * hit.collision.depth + ROOM)
        changed = False
        for i in np.flatnonzero((wanted > self._asked) & ~self._problem.has_known).tolist():
            before, self._asked[i] = self.free[i], wanted[i]
            self.free[i] = self._intervals(i)
            changed = changed or not np.array_equal(before, self.free[i])
        return changed


def _lines(problem: Problem, rows: Array) -> NDArray[np.int64]:
    """Numbers of the lines of a path: from each pose to the next where both are met and joints do not jump."""
    met = rows[:, ROW_STATUS] == Status.OK
    step = np.abs(steps_of(problem, rows[:, :7])) <= JUST_ABOVE * problem.settings[BY_CONTINUITY]
    return np.flatnonzero(met[:-1] & met[1:] & step.all(axis=1))


def _jumps(problem: Problem, rows: Array) -> int:
    return int((np.abs(joint_steps(rows)) > JUST_ABOVE * problem.settings[BY_CONTINUITY]).any(axis=1).sum())


def _refuse_hits(problem: Problem) -> None:
    """Raise InvalidConfiguration for given postures that hit something, by the real shapes."""
    around = problem.around
    assert around is not None
    for i in np.flatnonzero(problem.has_known).tolist():
        hit = None if around.is_clear(problem.known[i], True) else around.deepest_at(problem.known[i], TOUCH)
        if hit is not None:
            raise InvalidConfiguration(f"known: in the posture of pose {i}, {hit.first} meets {hit.second}")


def _blocked(edges: Edges, steps: Array, joint_names: Sequence[str]) -> list[PathBreak]:
    """What is in the way between two poses, as breaks of the path."""
    breaks = []
    for hit in edges.hits:
        first, second, depth = hit.collision
        joint = int(np.abs(steps[hit.sample]).argmax())
        message = (
            f"Between poses {hit.sample} and {hit.sample + 1}, {first} and {second} come closer than the margin "
            f"by {1e3 * depth:.3g} mm, and no path was found that does not."
        )
        jump = float(abs(steps[hit.sample, joint]))
        breaks.append(PathBreak(hit.sample + 1, jump, joint_names[joint], message, bodies=(first, second)))
    return breaks
