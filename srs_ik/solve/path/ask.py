"""Joint paths: continuous joint motions through a sequence of poses."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from srs_ik.errors import InvalidConfiguration, InvalidPose, MissingLimits, quoted
from srs_ik.inputs.angles import as_joint_vector, as_seed
from srs_ik.inputs.numbers import as_positive, per_joint
from srs_ik.inputs.poses import as_matrices
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
from srs_ik.solve.path.breaks import breaks_of
from srs_ik.solve.path.many_turns import in_fewest_turns
from srs_ik.solve.path.problem import OBJECTIVES, SUM_OF_SQUARES, TIME, Problem, Way, copy, stands, worth
from srs_ik.solve.path.rows import joint_steps, off_poses, on_straight_lines, rows_of
from srs_ik.solve.path.search.aims import best
from srs_ik.solve.path.search.aims import closed as closed_way
from srs_ik.solve.path.search.limited import keeps_limits
from srs_ik.solve.path.search.missed import searched_beside
from srs_ik.solve.path.search.polish import FINE, improve, keep_limits
from srs_ik.solve.path.solution import PathSolution
from srs_ik.solve.path.turns import unwound
from srs_ik.solve.pose import solve
from srs_ik.solve.solution import Status
from srs_ik.solve.threads import interruptible
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.in_scene.surroundings import Surroundings
    from srs_ik.solve.packed import PackedArm

LONGEST_STEP = 0.5
"""Default of the longest joint step that counts as continuous, rad."""

SHORT = 200
"""Paths of so many poses at most are done before anybody could interrupt them."""

MOVED = 1e-3
"""Where a posture has to be moved farther than this to meet its pose, rad, a path may be better elsewhere."""

CLOSING_ROOM = 0.0, 1e-6, 1e-4
"""Parts of the velocity limits that are left, one after the other, to what takes postures to their poses."""

MOST_ACCELERATION = 1e9
"""rad/s^2; as for trackers."""

LEAST_STEP = 1e-300
"""What velocity limits leave a joint from pose to pose at the least, rad: shares of less are no floats."""

ON_POSE = 1e-6
"""A posture that is given may miss its pose by so much, m and rad."""


@dataclass(frozen=True)
class Terms:
    """What is asked of a path but for its poses; see `Arm.solve_path`."""

    seed: ArrayLike | None = None  # (7,) posture to start from, rad
    dt: float | None = None  # between two poses, s
    longest_step: float = LONGEST_STEP  # that counts as continuous, rad
    objective: str = SUM_OF_SQUARES
    acceleration_limit: ArrayLike | None = None  # rad/s^2


def solve_path(
    arm: PackedArm,
    poses: Any,
    terms: Terms,
    known: Mapping[int, ArrayLike] | None = None,
    closed: bool = False,
    free_axis: Any = None,
    *,
    around: Surroundings | None = None,
) -> PathSolution:
    """See `Arm.solve_path`; `around` is what must not be touched."""
    T = as_matrices(poses)
    if free_axis is not None:
        from srs_ik.solve.freedom import refuse_beside

        refuse_beside(free_axis, known=known, closed=closed)
        return _free(arm, T, terms, free_axis, around)
    n = len(T)
    problem = problem_of(arm, T, terms)
    given, has_given = _known(arm, T, {} if known is None else known)
    if not n:
        return _of_no_poses(arm)
    problem.known, problem.has_known = given, has_given
    if closed and np.abs(T[0] - T[-1]).max() > ON_POSE:
        raise InvalidConfiguration("a closed path ends at its first pose, and the last pose is another one")
    if problem.seed is None and not has_given.any() and stands(T).all():
        _hold_roomiest(problem, around)
    find = closed_way if closed else best
    if around is None:
        return _alone(problem, find)
    from srs_ik.solve.in_scene.path import keep_clear

    return keep_clear(replace(problem, around=around), lambda: _alone(problem, find), find)


def _hold_roomiest(problem: Problem, around: Surroundings | None) -> None:
    """Begin a path of one pose alone, where all postures cost the same, in the one farthest from its limits."""
    try:
        if around is None:
            found = solve(problem.arm, problem.T[0])
        else:
            from srs_ik.solve.in_scene.pose import solve as solve_clear

            found = solve_clear(around, problem.T[0], None, None, -1, True)
    except InvalidPose:
        return  # the search says which pose it is
    if found:
        problem.known[0], problem.has_known[0] = found.q, True


def _alone(problem: Problem, find: Callable[[Problem], Way]) -> PathSolution:
    """The best path where nothing is in the way."""
    arm, n = problem.arm, len(problem.T)
    asked = on_straight_lines(problem)
    if n > SHORT:
        # What has to be compiled is compiled here: in another thread nobody could interrupt it.
        given = problem.known[:1], problem.has_known[:1]
        one = replace(problem, T=problem.T[:1], known=given[0], has_known=given[1], near=problem.near[:1])
        rows_of(one, find(one))
    way, rows, planned = interruptible(
        lambda stop: in_fewest_turns(replace(asked, stop=stop), lambda each: _found(find, each), find is closed_way),
        worth_it=n > SHORT,
    )
    rows[:, :7] = unwound(problem, rows)
    steps = joint_steps(rows)
    return PathSolution(rows, arm.joint_names, steps, breaks_of(planned, way, rows, steps), arm.elbow, problem=planned)


def _acceleration(arm: PackedArm, limit: ArrayLike | None, objective: str) -> Array | None:
    """(7,) limits of joint accelerations, if any are given, here or with the arm."""
    if limit is None:
        known = objective == TIME and np.isfinite(arm.acceleration_limit).any()
        return np.minimum(arm.acceleration_limit, MOST_ACCELERATION) if known else None
    if objective != TIME:
        raise InvalidConfiguration(f"acceleration_limit goes with objective={TIME!r}, not with {objective!r}")
    return per_joint(limit, "acceleration_limit", MOST_ACCELERATION)


def problem_of(arm: PackedArm, T: Array, terms: Terms) -> Problem:
    """The path that is asked for, without postures that are given."""
    objective = terms.objective
    if not isinstance(objective, str) or objective not in OBJECTIVES:
        raise InvalidConfiguration(f"objective is one of {', '.join(OBJECTIVES)}, not {quoted(objective)}")
    n = len(T)
    settings = _settings(arm, terms)
    start = None if terms.seed is None else as_seed(terms.seed, arm.lower, arm.upper)
    none = np.zeros((n, 7)), np.zeros(n, np.bool_), np.zeros((n, 7))
    problem = Problem(arm, T, start, settings, terms.dt is not None, *none, objective=objective)
    problem.dt = terms.dt
    problem.acceleration = _acceleration(arm, terms.acceleration_limit, objective)
    return problem


def _free(arm: PackedArm, T: Array, terms: Terms, free_axis: Any, around: Surroundings | None) -> PathSolution:
    """A path through poses that leave a turn free."""
    from srs_ik.inputs.freedom import as_free_axis
    from srs_ik.solve.freedom import solve as solve_alone
    from srs_ik.solve.path.free.sampled import solve_free_path

    problem, free = problem_of(arm, T, terms), as_free_axis(free_axis)
    if not len(T):
        return _of_no_poses(arm)
    if problem.seed is None and around is None and stands(T).all():
        still = solve_alone(arm, T[0], free, None, True)
        problem.seed = still.q if still else None
    found = solve_free_path(problem, free, lambda whole: solve_path(arm, whole, terms))
    if around is not None:
        from srs_ik.solve.in_scene.free_path import keep_clear

        problem.around = around
        found = keep_clear(problem, free, found, lambda whole: solve_path(arm, whole, terms, around=around))
    told = found._rows, arm.joint_names, found.steps, found.breaks, arm.elbow, found.collisions
    return PathSolution(*told, problem=problem, bounded=False)


def _of_no_poses(arm: PackedArm) -> PathSolution:
    return PathSolution(np.empty((0, ROW)), arm.joint_names, np.empty((0, 7)), [])


def _found(find: Callable[[Problem], Way], problem: Problem) -> tuple[Way, Array]:
    """A path, and the rows of its postures."""
    way = find(problem)
    held = _with_held_splits(problem)
    if held is not None:
        way = min(way, find(held), key=lambda way: worth(problem, way))
    slow = problem.limited and problem.even and keeps_limits(problem, way)
    free, planned = way.branch >= 0, way.q.copy()
    rows = rows_of(problem, way)
    alone = ~way.reached & (rows[:, ROW_STATUS] == Status.OK)
    if alone.any() and not problem.has_known[alone].any():
        # Postures that no strip holds, as rounding leaves them alone, are where the others have to pass.
        return _found(find, held_at(problem, alone, rows[:, :7]))
    if find is closed_way and way.reached[[0, -1]].all():
        ends = np.zeros(len(problem.T), np.bool_)
        ends[[0, -1]] = True
        problem = held_at(problem, ends, way.q)
    # Taken to their poses, postures next to limits may have moved, farther even than was left of the velocity limits;
    # they stay now, and those beside them make room. Near limbs move again then, so that limits are drawn in for them.
    if slow and not keeps_limits(problem, way):
        for room in CLOSING_ROOM:
            keep_limits(within(problem, 1.0 - room), way, copy(way))
            rows = rows_of(problem, way)
            if keeps_limits(problem, way):
                break
    elif problem.even and (free & (way.branch < 0)).any():
        moved = way.reached & (np.abs(way.q - planned).max(axis=1) > MOVED)
        if moved.any() and way.reached.all() and not problem.is_near:
            way = searched_beside(problem, way, moved)
        improve(problem, way, FINE)
        rows = rows_of(problem, way)
    return way, rows


def held_at(problem: Problem, some: NDArray[np.bool_], q: Array) -> Problem:
    """The problem with some postures of a path (n, 7) given."""
    known = problem.known.copy()
    known[some] = q[some]
    return replace(problem, known=known, has_known=problem.has_known | some)


def within(problem: Problem, part: float) -> Problem:
    """The problem with velocity limits that are a part of what they are."""
    settings = problem.settings.copy()
    settings[BY_VELOCITY] *= part
    return replace(problem, settings=settings)


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
    for named, posture in known.items():
        index = _index(named, len(T))
        q = as_joint_vector(posture, f"the posture of pose {index}")
        if (q < arm.lower).any() or (q > arm.upper).any():
            raise InvalidConfiguration(f"known: the posture of pose {index} is outside the joint limits")
        off = off_poses(arm, T[index][None], q[None])[0]
        if off > ON_POSE:
            raise InvalidConfiguration(
                f"known: the posture given for pose {index} does not meet it: it is {off:.3g} (m or rad) away; seed= "
                "takes one nearby"
            )
        given[index], has_given[index] = q, True
    return given, has_given


def _index(named: Any, count: int) -> int:
    """The index of a pose by which a posture is given, from 0 on."""
    try:
        index = count if isinstance(named, bool) else operator.index(named)
    except TypeError:
        index = count
    if not -count <= index < count:
        raise InvalidConfiguration(f"known: there is no pose {quoted(named)}; the path has {count}")
    return index % count


def _settings(arm: PackedArm, terms: Terms) -> Array:
    """(SETTINGS, 7) of the programme: longest joint steps by velocity and by continuity, turns of endless joints."""
    settings = np.zeros((SETTINGS, 7))
    settings[BY_VELOCITY] = np.inf
    if terms.dt is not None:
        settings[BY_VELOCITY] = np.maximum(arm.velocity_limit * as_positive(terms.dt, "dt", "seconds"), LEAST_STEP)
    settings[BY_CONTINUITY] = as_positive(terms.longest_step, "longest_step", "radians")
    if terms.objective == TIME:
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
