"""Joint paths through poses that leave a turn free: turns and postures together on samples first, and then all at once.

Frames of the poses are turned along with the path as little as can be, so that a turn that stays is as good on samples
as it is. At some poses, the strips of all sampled turns are those of one pose, and the best way through them is found
as for whole poses, on the nearest exact limb. It begins paths on the true chain, which Newton's method moves to the
best ones near them, all postures at once. What breaks so is looked for once more among postures all over what is free.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from srs_ik.inputs.freedom import FreeAxis
from srs_ik.kernels.layout.answer import ROW_STATUS
from srs_ik.kernels.layout.limb import FAR, LIMITED
from srs_ik.kernels.layout.path import BY_CONTINUITY
from srs_ik.solve.freedom import met_batch, solve, solve_batch
from srs_ik.solve.kinematics import forward_kinematics_batch
from srs_ik.solve.path.breaks import breaks_of
from srs_ik.solve.path.free.frontier import wandered
from srs_ik.solve.path.free.relaxed import relaxed
from srs_ik.solve.path.problem import JUST_ABOVE, Problem, objective_of, steps_of
from srs_ik.solve.path.rows import joint_steps
from srs_ik.solve.path.search.blocks import Block, through
from srs_ik.solve.path.turns import unwound
from srs_ik.solve.solution import Status
from srs_ik.solve.threads import tell
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.packed import PackedArm
    from srs_ik.solve.path.solution import PathSolution

Keys = NDArray[np.int64]

ROLLS, MOST_TURNS = 16, 24
"""Rolls that are sampled, and rotations where the axis may lean by more than `LITTLE`, rad."""

LITTLE = 0.5

BESIDE = np.linspace(-0.3, 0.3, 5)
RADIUS = 0.5
"""Turns beside those of a way, and how far around it postures are looked at, rad."""

WANDER_CHANGE = 0.05
"""Postures all over what poses leave free are looked for at poses this far apart, rad and reaches of the arm."""

KEY_CHANGE = 0.25
"""Turns are sampled at poses this far apart, rad and reaches of the arm."""

FEWEST = 12
"""And at so many at least."""

LONGEST = 1.0
"""From one sampled turn to another, joints may step so far, rad."""

NONE_LONG = 1e-6
"""Where strips alone are wanted, no way leads from one to another."""

SAME = 1e-6
"""A posture of a path is the nearest one to itself, rad."""


def solve_free_path(problem: Problem, free: FreeAxis, find: Callable[[Array], PathSolution]) -> PathSolution:
    """A path through poses that leave a turn free; `problem` is as if they were whole, `find` a path through such."""
    arm, T, start = problem.arm, problem.T, problem.seed
    # The first pose as the arm may meet it from where it is.
    nearest = None if start is None else solve(arm, T[0], free, start, True)
    first = nearest.q if nearest else None
    ways, moved = [find(T)], []
    for q in sampled_ways(problem, free, first):
        # Poses that are not reached stay as they are, and the others close the gap.
        met = met_batch(arm, T, free, q)[1]
        if met.any():
            ways.append(find(eased(problem, free, q, met)))
        moved += [q] if met.all() else []
    best = best_of(problem, free, first, ways, moved)
    if best and keeps_limits(problem, best.q):
        return best
    # What is not reached is not for good, unless no posture of its own meets it.
    rows = best._rows.copy()
    rows[~best.ok] = solve_batch(arm, T[~best.ok], free, best.q[~best.ok], True, 1)._rows
    can_be = rows[:, ROW_STATUS] == Status.OK
    if can_be.any():
        q, met = wandered_way(problem, free, rows[:, :7], can_be)
        ways = [best, find(eased(problem, free, q, met))]
        best = best_of(problem, free, first, ways, [q] if met.all() else [])
    return best or with_breaks(problem, free, best, rows)


def eased(problem: Problem, free: FreeAxis, q: Array, met: NDArray[np.bool_]) -> Array:
    """(n, 4, 4) the poses turned as in a path (n, 7), which is changed in place to the best one near it where met."""
    arm, turned = problem.arm, problem.T.copy()
    some = turned[met]
    q[met] = relaxed(arm, some, free, in_turns_of(arm, q[met], problem.seed), problem.seed, fastest(problem))
    turned[met] = turned_as(arm, some, free, q[met])
    return turned


def fastest(problem: Problem) -> Array:
    """(7,) the longest joint steps that are continuous and within the velocity limits."""
    return np.asarray(problem.settings[: BY_CONTINUITY + 1].min(axis=0))


def keeps_limits(problem: Problem, q: Array) -> bool:
    """Whether the steps of a path are continuous and within the velocity limits."""
    return bool((np.abs(np.diff(q, axis=0)) <= JUST_ABOVE * fastest(problem)).all())


def best_of(
    problem: Problem, free: FreeAxis, first: Array | None, ways: list[PathSolution], moved: list[Array]
) -> PathSolution:
    """The best one of some paths, of those that go on from their ends, and of those near all of these.

    One goes on from `first` (7,), a posture of the first pose, if given; `moved` (n, 7) are postures on all poses.
    """
    arm, T, start = problem.arm, problem.T, problem.seed
    best = min(ways, key=lambda way: (int((~way.ok).sum()), len(way.breaks), _value(problem, way.q[way.ok])))
    most = fastest(problem)
    begins = [] if first is None else [followed(arm, T, free, first)]
    if best:
        most = np.maximum(most, np.abs(best.steps).max(axis=0, initial=0.0))
        moved = moved + [relaxed(arm, T, free, way.q, start, most) for way in ways if way] + [best.q]
        begins += [followed(arm, T, free, best.q[0]), followed(arm, T[::-1], free, best.q[-1])[::-1]]
    moved = moved + [relaxed(arm, T, free, q, start, most) for q in begins if np.isfinite(q).all()]
    moved = [q for q in moved if (np.abs(np.diff(q, axis=0)) <= most).all()]
    if not moved:
        return best
    if not any(keeps_limits(problem, q) for q in moved):
        moved = moved + [relaxed(arm, T, free, q, start, fastest(problem)) for q in moved]
    q = min(moved, key=lambda q: (not keeps_limits(problem, q), _value(problem, q)))
    found = solve_batch(arm, T, free, q, True, 1)
    if not found.ok.all() or np.abs(found.q - q).max() > SAME:
        return best
    return type(best)(found._rows, arm.joint_names, np.diff(found.q, axis=0), [], arm.elbow)


def wandered_way(
    problem: Problem, free: FreeAxis, known: Array, can_be: NDArray[np.bool_]
) -> tuple[Array, NDArray[np.bool_]]:
    """(n, 7) a path by postures all over what poses leave free, and (n,) which of these are met.

    Where nothing meets the pose, `known` (n, 7) are its postures; where something does, `can_be` (n,) says.
    """
    arm, T, q = problem.arm, problem.T, known.copy()
    ways = change_of(turned_along(T, free), float(arm.family[LIMITED, FAR]))
    keys, some = keys_of(ways, int(np.ceil(ways[-1] / WANDER_CHANGE)) + 1), np.flatnonzero(can_be)
    keys = np.union1d(keys[can_be[keys]], some[[0, -1]])
    told = wandered(problem, free, keys)
    wanted = np.column_stack([np.interp(some, keys, told[:, j]) for j in range(7)])
    found = solve_batch(arm, T[some], free, np.clip(wanted, arm.lower, arm.upper), True, 1)
    q[some], met = found.q, can_be.copy()
    met[some] = found.ok
    return q, met


def with_breaks(problem: Problem, free: FreeAxis, found: PathSolution, alone: Array) -> PathSolution:
    """A path with its breaks as they are where a turn is free; poses that postures (n, ROW) meet alone are met."""
    arm, rows = problem.arm, found._rows.copy()
    missed = ~found.ok
    rows[missed] = alone[missed]
    again = np.flatnonzero(missed & (alone[:, ROW_STATUS] == Status.OK))
    rows[again] = solve_batch(arm, problem.T[again], free, rows[np.maximum(again - 1, 0), :7], True, 1)._rows
    rows[:, :7] = unwound(problem, rows)
    steps = joint_steps(rows)
    return type(found)(rows, arm.joint_names, steps, breaks_of(problem, None, rows, steps), arm.elbow)


def in_turns_of(arm: PackedArm, q: Array, start: Array | None) -> Array:
    """(n, 7) a path whose joints without end begin in the turns of a posture before it."""
    if start is None:
        return q
    turns = np.where(np.isinf(arm.lower) & np.isinf(arm.upper), np.round((start - q[0]) / (2.0 * np.pi)), 0.0)
    return np.asarray(q + 2.0 * np.pi * turns)


def _value(problem: Problem, q: Array) -> float:
    return objective_of(problem, steps_of(problem, np.vstack([problem.start, q])))


def sampled_ways(problem: Problem, free: FreeAxis, first: Array | None) -> list[Array]:
    """(n, 7) postures of the best ways through those of sampled turns, planned at few poses and at more.

    From one of few poses to the next, a step between sampled turns counts less, but many tell more of what is between.
    The turn of a posture `first` of the first pose is among the sampled ones.
    """
    frames = problem.T.copy()
    if first is not None:
        frames[:1] = turned_as(problem.arm, frames[:1], free, first[None])
    frames = turned_along(frames, free)
    turns = free.sampled(MOST_TURNS) if free.cone > LITTLE else FreeAxis(free.axis).sampled(ROLLS)
    ways = change_of(frames, float(problem.arm.family[LIMITED, FAR]))
    count = int(np.ceil(ways[-1] / KEY_CHANGE)) + 1
    few, more = (keys_of(ways, least) for least in (count, max(count, FEWEST)))
    every = np.union1d(few, more)
    plan = strips_of(replace(problem, T=frames, in_closed_form=True, objective="sum_of_squares"), every, turns)
    return [planned(problem, free, plan, keys) for keys in ((few, more) if len(few) < len(more) else (more,))]


def planned(problem: Problem, free: FreeAxis, plan: Problem, keys: Keys) -> Array:
    """(n, 7) the best way through strips at key poses, and what is near it at every pose."""
    way = through(plan, keys, False)[0]
    keys = keys[way.reached[keys]]
    if not len(keys):
        return np.clip(np.zeros((len(plan.T), 7)), problem.arm.lower, problem.arm.upper)
    q = way.q[keys[0]] + np.vstack([np.zeros(7), np.cumsum(steps_of(problem, way.q[keys]), axis=0)])
    poses = np.arange(len(plan.T))
    wanted = np.column_stack([np.interp(poses, keys, q[:, j]) for j in range(7)])
    return around(problem, free, taken(problem, free, wanted))


def taken(problem: Problem, free: FreeAxis, q: Array) -> Array:
    """(n, 7) postures taken to their poses, where that goes."""
    wanted = np.clip(q, problem.arm.lower, problem.arm.upper)
    found, met = met_batch(problem.arm, problem.T, free, wanted)
    return np.where(met[:, None], found, wanted)


def around(problem: Problem, free: FreeAxis, q: Array) -> Array:
    """(n, 7) the best way through what is near one at every pose, at its turns and at some beside them."""
    frames, all_poses = turned_as(problem.arm, problem.T, free, q), np.arange(len(q))
    turns = np.array([free.rolled(angle) for angle in BESIDE])
    told = replace(problem, T=frames, near=q, radius=RADIUS, objective="sum_of_squares")
    way = through(strips_of(told, all_poses, turns), all_poses, False)[0]
    return taken(problem, free, np.where(way.reached[:, None], way.q, q))


def turned_along(T: Array, free: FreeAxis) -> Array:
    """(n, 4, 4) the same poses as far as they are asked for, each turned against the one before as little as can be."""
    frames = T.copy()
    for k in range(1, len(T)):
        if free.cone < np.pi:
            frames[k, :3, :3] = T[k, :3, :3] @ free.rolled(_roll(T[k, :3, :3].T @ frames[k - 1, :3, :3], free.axis))
        else:
            frames[k, :3, :3] = T[0, :3, :3]
    return frames


def turned_as(arm: PackedArm, T: Array, free: FreeAxis, q: Array) -> Array:
    """(n, 4, 4) the same poses, each with the free turn that a posture of it has."""
    turned, tips = T.copy(), forward_kinematics_batch(arm, q, 1)
    for pose, tip in zip(turned, tips, strict=True):
        if free.cone > 0.0 and free.lean(tip[:3, :3], pose[:3, :3]) == 0.0:
            pose[:3, :3] = tip[:3, :3]
        else:
            pose[:3, :3] = pose[:3, :3] @ free.rolled(_roll(pose[:3, :3].T @ tip[:3, :3], free.axis))
    return turned


def _roll(turn: Array, axis: Array) -> float:
    """The angle about an axis of the rotation that is closest to one (3, 3)."""
    across = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    return float(np.arctan2(axis @ across, np.trace(turn) - axis @ turn @ axis))


def change_of(frames: Array, reach: float) -> Array:
    """(n,) how much poses change from the first one on, rad and reaches of the arm."""
    moved = np.linalg.norm(np.diff(frames[:, :3, 3], axis=0), axis=1) / reach
    cosines = 0.5 * (np.einsum("kij,kij->k", frames[1:, :3, :3], frames[:-1, :3, :3]) - 1.0)
    return np.append(0.0, np.cumsum(moved + np.arccos(np.clip(cosines, -1.0, 1.0))))


def keys_of(way: Array, count: int) -> Keys:
    """About so many poses, as far apart as can be, with both ends."""
    at = np.searchsorted(way, np.linspace(0.0, way[-1], count))
    return np.unique(np.append(at, [0, len(way) - 1]))


def strips_of(problem: Problem, keys: Keys, turns: Array) -> Problem:
    """The problem with the strips of all turns of the key poses known."""
    n = len(turns)
    frames = np.repeat(problem.T[keys], n, axis=0)
    frames[:, :3, :3] = frames[:, :3, :3] @ np.tile(turns, (len(keys), 1, 1))
    settings, none = problem.settings.copy(), np.zeros(len(frames), np.bool_)
    settings[BY_CONTINUITY] = NONE_LONG
    near = np.repeat(problem.near[keys], n, axis=0)
    told = replace(
        problem, T=frames, seed=None, settings=settings, limited=False, near=near, known=near, has_known=none
    )
    if problem.around is not None:
        told.free = [problem.around.all_free(frame, True) for frame in frames]
    rows, poses = [], []
    for number, key in enumerate(keys.tolist()):
        tell(number, len(keys))
        some = np.arange(number * n, (number + 1) * n)
        held, _ = Block(told, some, 0, False, None).held()
        if not (len(held) or problem.arm.closed or told.is_near):
            # The arm may reach what its nearest exact limb does not.
            held, _ = Block(replace(told, in_closed_form=False), some, 0, False, None).held()
        rows.append(held)
        poses.append(np.full(len(held), key))
    settings = problem.settings.copy()
    settings[BY_CONTINUITY] = np.maximum(settings[BY_CONTINUITY], LONGEST)
    alone = np.ones(len(problem.T), np.bool_)
    known = np.vstack(rows), np.concatenate(poses), alone
    return replace(problem, settings=settings, limited=False, held=known[0], held_of=known[1], held_alone=known[2])


def followed(arm: PackedArm, T: Array, free: FreeAxis, first: Array) -> Array:
    """(n, 7) a path from a posture of its first pose, each next one the nearest; NaN from where there is none."""
    q = np.full((len(T), 7), np.nan)
    q[0] = first
    for k in range(1, len(T)):
        found = solve(arm, T[k], free, q[k - 1], True)
        if not found:
            break
        q[k] = found.q
    return q
