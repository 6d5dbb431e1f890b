"""Joint paths: continuous joint motions through a sequence of poses."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from srs_ik.errors import InvalidConfiguration, MissingLimits, quoted
from srs_ik.inputs.poses import as_joint_vector, as_matrices, as_positive, as_seed
from srs_ik.kernels.layout.answer import ROW, ROW_STATUS
from srs_ik.kernels.layout.path import (
    BY_CONTINUITY,
    BY_VELOCITY,
    ENDLESS,
    INVERSE_PERIOD,
    INVERSE_SPEED,
    LEAST_INVERSE,
    PERIOD,
    SETTINGS,
)
from srs_ik.solve.free_splits import free_splits
from srs_ik.solve.path.aims import best
from srs_ik.solve.path.aims import closed as closed_way
from srs_ik.solve.path.bound import least_largest, least_sum
from srs_ik.solve.path.breaks import PathBreak, breaks_of
from srs_ik.solve.path.limited import keeps_limits
from srs_ik.solve.path.odd import searched_beside
from srs_ik.solve.path.polish import FINE, improve, keep_limits
from srs_ik.solve.path.problem import LARGEST_STEP, OBJECTIVES, TIME, Problem, Way, copy, objective_of, steps_of, worth
from srs_ik.solve.path.rows import off_poses, on_straight_lines, rows_of
from srs_ik.solve.path.timing import passing_times
from srs_ik.solve.pose import solve
from srs_ik.solve.solution import BatchSolution, Collision, ElbowRange, Status
from srs_ik.solve.threads import interruptible

if TYPE_CHECKING:
    from srs_ik.solve.in_scene.surroundings import Surroundings
    from srs_ik.solve.packed import PackedArm

Array = NDArray[np.float64]

LONGEST_STEP = 0.5
"""Default of the longest joint step that counts as continuous, rad."""

SHORT = 200
"""Paths of so many poses at most are done before anybody could interrupt them."""

MOVED = 1e-3
"""Where a posture has to be moved farther than this to meet its pose, rad, a path may be better elsewhere."""

ON_POSE = 1e-6
"""A posture that is given may miss its pose by so much, m and rad."""


class PathSolution(BatchSolution):
    """Postures for the poses of a path, as arrays over N; true in a boolean test if there is no break.

    Attributes:
        breaks: where the path had to break, and why; empty for a continuous path through all poses.
        steps: (N - 1, 7) joint steps, rad; joints that turn without end go the shorter way round.
        times: (N,) when it passes its poses, s, from rest to rest within limits of velocity and acceleration; None
            where no acceleration limit was given.
        value: what the path was asked to make least, the step from the seed included: the sum of squared joint steps
            (rad^2), the largest joint step (rad), or the time at the velocity limits (s); with limits of acceleration,
            the last of `times`. Breaks count as steps.
    """

    def __init__(
        self,
        rows: Array,
        joint_names: Sequence[str],
        steps: Array,
        breaks: list[PathBreak],
        elbow: ElbowRange | None = None,
        collisions: Mapping[tuple[int, ...], Collision] | None = None,
        problem: Problem | None = None,
        bounded: bool = True,
    ) -> None:
        super().__init__(rows, joint_names, elbow, collisions)
        self.steps = steps
        self.breaks = breaks
        self._problem = problem
        self._bounded = bounded
        self.times = None
        self.value = 0.0 if problem is None else _value(problem, self.q, steps)
        if problem is not None and problem.acceleration is not None:
            self.times = passing_times(steps, problem.arm.velocity_limit, problem.acceleration)
            self.value = float(self.times[-1])

    @cached_property
    def lower_bound(self) -> float:
        """What `value` comes to at least: no path through these poses from this seed has less, with or without breaks.

        If this path has none, those with breaks are left out. On an exact arm the bound is proven: all postures of all
        poses lie within a known distance of straight pieces of joint space, and each step counts its least between two
        pieces. Pieces that no better path can touch are left out and the others cut, until the bound is within a
        hundredth of `value`, or pieces are 0.01 rad long, 0.06 for the time, or would be more than some hundred a pose.
        On a near arm the distance from the pieces is measured, and
        doubled. Velocity limits within `dt`, limits of acceleration, and that a closed path closes, do not count: paths
        that keep them cost no less. Poses that leave a turn free have no bound but 0, and upright straight arms, which
        turn on the spot at every arm angle, almost none.

        Computed when it is first asked for, in some milliseconds a pose, near arms up to a tenth of a second.
        """
        problem = self._problem
        if problem is None or not (self._bounded and self.value > 0.0):
            return 0.0
        q = np.where(self.ok[:, None], self.q, np.nan)
        if problem.acceleration is not None:
            # From rest to rest, without the step from the seed; nothing is quicker than at the velocity limits.
            problem = replace(problem, seed=None)
        # A pose without a posture is passed for nothing, so that steps to it and from it are left out here, too.
        met = self.ok
        value = _value(problem, self.q[:1][met[:1]], self.steps[met[:-1] & met[1:]])
        if problem.objective == LARGEST_STEP:
            return least_largest(problem, q, value)
        return least_sum(problem, q, value, bool(self.breaks))

    @property
    def largest_step(self) -> float:
        """Largest joint step of the path, breaks included, rad."""
        return float(np.abs(self.steps).max(initial=0.0))

    def __bool__(self) -> bool:
        return not self.breaks and bool(self.ok.all())

    def __repr__(self) -> str:
        return f"PathSolution({self.solved} of {len(self)} solved, {len(self.breaks)} breaks)"


def solve_path(
    arm: PackedArm,
    poses: Any,
    seed: ArrayLike | None = None,
    dt: float | None = None,
    longest_step: float = LONGEST_STEP,
    objective: str = "sum_of_squares",
    known: Mapping[int, ArrayLike] | None = None,
    closed: bool = False,
    acceleration_limit: ArrayLike | None = None,
    free_axis: Any = None,
    *,
    around: Surroundings | None = None,
) -> PathSolution:
    """See `Arm.solve_path`; `around` is what must not be touched."""
    T = as_matrices(poses)
    if free_axis is not None and len(T):
        from srs_ik.solve.freedom import refuse_beside

        refuse_beside(free_axis, known=known, closed=closed, scene=around)
        return _free(arm, T, free_axis, (seed, dt, longest_step, objective, acceleration_limit))
    n = len(T)
    problem = _problem(arm, T, seed, dt, longest_step, objective, acceleration_limit)
    if not n:
        return PathSolution(np.empty((0, ROW)), arm.joint_names, np.empty((0, 7)), [])
    given, has_given = _known(arm, T, {} if known is None else known)
    problem.known, problem.has_known = given, has_given
    if closed and np.abs(T[0] - T[-1]).max() > ON_POSE:
        raise InvalidConfiguration("a closed path ends at its first pose, and the last pose is another one")
    find = closed_way if closed else best
    if around is not None:
        from srs_ik.solve.in_scene.path import keep_clear

        return keep_clear(replace(problem, around=around), find)
    asked = on_straight_lines(problem)
    if n > SHORT:
        # What has to be compiled is compiled here: in another thread nobody could interrupt it.
        one = replace(problem, T=T[:1], known=given[:1], has_known=has_given[:1], near=problem.near[:1])
        rows_of(one, find(one))
    way, rows = interruptible(lambda stop: _found(find, replace(asked, stop=stop)), worth_it=n > SHORT)
    rows[:, :7] = unwound(problem, rows)
    steps = np.diff(rows[:, :7], axis=0)
    return PathSolution(rows, arm.joint_names, steps, breaks_of(asked, way, rows, steps), arm.elbow, problem=asked)


def _acceleration(limit: ArrayLike | None, objective: str) -> Array | None:
    """(7,) limits of joint accelerations, if any are given."""
    if limit is None:
        return None
    if objective != TIME:
        raise InvalidConfiguration(f"acceleration_limit goes with objective={TIME!r}, not with {objective!r}")
    found = as_joint_vector(limit, "acceleration_limit")
    if not (found > 0.0).all():
        raise InvalidConfiguration("acceleration_limit takes positive figures, rad/s^2")
    return found


def _value(problem: Problem, q: Array, steps: Array) -> float:
    """What a path was asked to make least, the step from the seed included."""
    if problem.seed is not None and len(q):
        steps = np.vstack([steps_of(problem, np.vstack([problem.seed, q[:1]])), steps])
    return objective_of(problem, steps)


def _problem(
    arm: PackedArm,
    T: Array,
    seed: ArrayLike | None,
    dt: float | None,
    longest_step: float,
    objective: str,
    acceleration_limit: ArrayLike | None,
) -> Problem:
    """The path that is asked for, without postures that are given."""
    if not isinstance(objective, str) or objective not in OBJECTIVES:
        raise InvalidConfiguration(f"objective is one of {', '.join(OBJECTIVES)}, not {quoted(objective)}")
    n = len(T)
    settings = _settings(arm, dt, longest_step, objective)
    start = None if seed is None else as_seed(seed, arm.lower, arm.upper)
    none = np.zeros((n, 7)), np.zeros(n, np.bool_), np.zeros((n, 7))
    problem = Problem(arm, T, start, settings, dt is not None, *none, objective=objective)
    problem.acceleration = _acceleration(acceleration_limit, objective)
    return problem


def _free(arm: PackedArm, T: Array, free_axis: Any, asked: tuple[Any, ...]) -> PathSolution:
    """A path through poses that leave a turn free."""
    from srs_ik.inputs.freedom import as_free_axis
    from srs_ik.solve.path.freedom import solve_free_path

    problem = _problem(arm, T, *asked)
    seed, dt, longest_step, objective, acceleration = asked

    def find(whole: Array) -> PathSolution:
        return solve_path(arm, whole, seed, dt, longest_step, objective, None, False, acceleration)

    found = solve_free_path(problem, as_free_axis(free_axis), find)
    told = found._rows, arm.joint_names, found.steps, found.breaks, arm.elbow
    return PathSolution(*told, problem=problem, bounded=False)


def _found(find: Callable[[Problem], Way], problem: Problem) -> tuple[Way, Array]:
    """A path, and the rows of its postures."""
    way = find(problem)
    held = _with_held_splits(problem)
    if held is not None:
        way = min(way, find(held), key=lambda way: worth(problem, way))
    slow = problem.limited and problem.even and keeps_limits(problem, way)
    free, planned = way.branch >= 0, way.q.copy()
    rows = rows_of(problem, way)
    # Taken to their poses, postures next to limits may have moved, farther even than was left of the velocity limits;
    # they stay now, and those beside them make room.
    if slow and not keeps_limits(problem, way):
        keep_limits(problem, way, copy(way))
        rows = rows_of(problem, way)
    elif problem.even and (free & (way.branch < 0)).any():
        moved = way.reached & (np.abs(way.q - planned).max(axis=1) > MOVED)
        if moved.any() and way.reached.all() and not problem.is_near:
            way = searched_beside(problem, way, moved)
        improve(problem, way, FINE)
        rows = rows_of(problem, way)
    return way, rows


def _with_held_splits(problem: Problem) -> Problem | None:
    """The path with the first poses held nearest to the start, while they leave the split of two joints open.

    No strip holds all splits. None where the first pose leaves none open, or there is no start.
    """
    arm, before = problem.arm, problem.seed
    known, has_known = problem.known.copy(), problem.has_known.copy()
    if before is None or not arm.closed:
        return None
    for i, pose in enumerate(problem.T):
        if has_known[i] or not free_splits(arm, pose, True):
            break
        nearest = solve(arm, pose, seed=before)
        if not nearest:
            break
        known[i], has_known[i] = nearest.q, True
        before = nearest.q
    return replace(problem, known=known, has_known=has_known) if (has_known != problem.has_known).any() else None


def _known(arm: PackedArm, T: Array, known: Mapping[int, ArrayLike]) -> tuple[Array, NDArray[np.bool_]]:
    """(n, 7) postures that are given, and (n,) where they are."""
    given, has_given = np.zeros((len(T), 7)), np.zeros(len(T), np.bool_)
    if not isinstance(known, Mapping):
        raise InvalidConfiguration(f"known must be a mapping from poses to their postures, not {quoted(known)}")
    for index, posture in known.items():
        if isinstance(index, bool) or not isinstance(index, int) or not -len(T) <= index < len(T):
            raise InvalidConfiguration(f"known: there is no pose {index}; the path has {len(T)}")
        q = as_joint_vector(posture, f"the posture of pose {index}")
        if (q < arm.lower).any() or (q > arm.upper).any():
            raise InvalidConfiguration(f"known: the posture of pose {index} is outside the joint limits")
        if off_poses(arm, T[index][None], q[None])[0] > ON_POSE:
            raise InvalidConfiguration(f"known: the posture given for pose {index} does not meet it")
        given[index], has_given[index] = q, True
    return given, has_given


def _settings(arm: PackedArm, dt: float | None, longest_step: float, objective: str) -> Array:
    """(SETTINGS, 7) of the programme: longest joint steps by velocity and by continuity, turns of endless joints."""
    settings = np.zeros((SETTINGS, 7))
    settings[BY_VELOCITY] = np.inf if dt is None else arm.velocity_limit * as_positive(dt, "dt", "seconds")
    settings[BY_CONTINUITY] = as_positive(longest_step, "longest_step", "radians")
    if objective == TIME:
        missing = ~(np.isfinite(arm.velocity_limit) & (arm.velocity_limit > 0.0))
        if missing.any():
            raise MissingLimits("velocity", [arm.joint_names[j] for j in np.flatnonzero(missing)], arm.name)
        settings[INVERSE_SPEED] = 1.0 / arm.velocity_limit
        settings[LEAST_INVERSE] = settings[INVERSE_SPEED].min()
    endless = np.isinf(arm.lower) & np.isinf(arm.upper)
    settings[PERIOD, endless] = 2.0 * np.pi
    settings[INVERSE_PERIOD, endless] = 0.5 / np.pi
    settings[ENDLESS] = endless.any()
    return settings


def unwound(problem: Problem, rows: Array) -> Array:
    """(n, 7) the postures of a path's rows, joints that turn without end counted on from pose to pose.

    A posture that is given is in the turns that it is given in, and so are those that are continuous with it; else the
    path begins in the turns of the seed. A break goes the shorter way round where that leaves a choice.
    """
    q, met = rows[:, :7].copy(), np.flatnonzero(rows[:, ROW_STATUS] == Status.OK)
    endless = np.flatnonzero(np.isinf(problem.arm.lower) & np.isinf(problem.arm.upper))
    if not (len(met) and len(endless)):
        return q
    way, period = q[met][:, endless], 2.0 * np.pi
    turns = np.zeros(way.shape)
    turns[1:] = -np.cumsum(np.round(np.diff(way, axis=0) / period), axis=0)
    piece = np.cumsum(
        np.append(False, (np.abs(steps_of(problem, q[met])) > problem.settings[BY_CONTINUITY]).any(axis=1))
    )
    begin: dict[int, Array] = {}
    for k in np.flatnonzero(problem.has_known[met]).tolist():
        given = problem.known[met[k], endless]
        begin.setdefault(int(piece[k]), np.round((given - way[k]) / period) - turns[k])
    if problem.seed is not None:
        begin.setdefault(0, np.round((problem.seed[endless] - way[0]) / period))
    if begin:
        # A piece without a given posture follows the one before, and what is before the first such posture precedes it.
        pieces = np.array(sorted(begin))
        of = pieces[np.maximum(np.searchsorted(pieces, piece, side="right") - 1, 0)]
        turns += np.array([begin[k] for k in of.tolist()])
    q[met[:, None], endless] = way + period * turns
    # Postures of poses that are not met lie beside the one before, and those that begin a path beside the one behind.
    unmet = np.setdiff1d(np.arange(len(q)), met)
    for k in (*unmet[unmet > met[0]].tolist(), *unmet[unmet < met[0]][::-1].tolist()):
        beside = q[k - 1 if k > met[0] else k + 1, endless]
        q[k, endless] += period * np.round((beside - q[k, endless]) / period)
    return q
