"""Joint paths: continuous joint motions through a sequence of poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from srs_ik.inputs.poses import as_matrices, as_positive, as_seed, refuse_bad_poses
from srs_ik.kernels.entries import path as path_entries
from srs_ik.kernels.layout.answer import ROW, ROW_ARM_ANGLE, ROW_BRANCH, ROW_STATUS
from srs_ik.solve.packed import PackedArm
from srs_ik.solve.pose import solve
from srs_ik.solve.solution import BatchSolution, ElbowRange, Status
from srs_ik.solve.threads import Stop, interruptible

Array = NDArray[np.float64]

LONGEST_STEP = 0.5
"""Default of the longest joint step that counts as continuous, rad."""

SHORT = 200
"""Paths of so many poses at most are done before anybody could interrupt them."""


@dataclass(frozen=True, slots=True)
class PathBreak:
    """A place where a path is not continuous, or not on its pose.

    Attributes:
        sample: index of the pose at which it happens.
        jump: largest joint step from the sample before, rad; 0 at a pose that is not reached.
        joint: name of the joint that makes it.
        message: one sentence that says why.
    """

    sample: int
    jump: float
    joint: str
    message: str


class PathSolution(BatchSolution):
    """Postures for the poses of a path, as arrays over N; true in a boolean test if there is no break.

    Attributes:
        breaks: where the path had to break, and why; empty for a continuous path through all poses.
        steps: (N - 1, 7) joint steps, rad; joints that turn without end go the shorter way round.
    """

    def __init__(
        self,
        rows: Array,
        joint_names: Sequence[str],
        steps: Array,
        breaks: list[PathBreak],
        elbow: ElbowRange | None = None,
    ) -> None:
        super().__init__(rows, joint_names, elbow)
        self.steps = steps
        self.breaks = breaks

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
) -> PathSolution:
    """See `Arm.solve_path`."""
    T = as_matrices(poses)
    n = len(T)
    longest = _longest_steps(arm, dt, longest_step)
    start = None if seed is None else as_seed(seed, arm.lower, arm.upper)
    if not n:
        return PathSolution(np.empty((0, ROW)), arm.joint_names, np.empty((0, 7)), [])
    keys, verdicts = np.zeros(n, np.bool_), np.zeros(n, np.int64)
    path_entries.choose_keys(arm.family, T, keys, verdicts)
    refuse_bad_poses(verdicts)
    if n > SHORT:
        # What has to be compiled is compiled here: in another thread nobody could interrupt it.
        _best(arm, T[:1], keys[:1], start, longest, np.zeros(1, np.int8))
    rows = interruptible(lambda stop: _best(arm, T, keys, start, longest, stop), worth_it=n > SHORT)
    rows[:, :7] = _unwound(arm, rows[:, :7], start)
    steps = np.diff(rows[:, :7], axis=0)
    return PathSolution(rows, arm.joint_names, steps, _breaks(arm, rows, steps, longest[1]), arm.elbow)


def _best(arm: PackedArm, T: Array, keys: NDArray[np.bool_], start: Array | None, longest: Array, stop: Stop) -> Array:
    """Rows of the better one of a planned path and a path that goes on to the nearest posture each time."""
    planned = _planned(arm, T, keys, start, longest, stop)
    candidates = [planned, *_tracked(arm, T, planned[0, :7] if start is None else start, longest, stop)]
    return min(candidates, key=lambda candidate: _cost(arm, candidate, start, longest))


def _planned(
    arm: PackedArm, T: Array, keys: NDArray[np.bool_], start: Array | None, longest: Array, stop: Stop
) -> Array:
    """Rows of the path that dynamic programming finds, and smoothing makes even."""
    n = len(T)
    psis, branches = np.empty(n), np.empty(n, np.int64)
    seed = np.zeros(7) if start is None else start
    path_entries.plan(arm.family, T, keys, start is not None, seed, longest, psis, branches, stop)
    if not keys.all() and (branches < 0).any():
        # Between two planned poses the path changes branches, or ends: there, every pose is planned.
        keys = keys.copy()
        keys[_widened(branches < 0)] = True
        path_entries.plan(arm.family, T, keys, start is not None, seed, longest, psis, branches, stop)
    return _smoothed(arm, T, start, longest, psis, branches, stop)


def _widened(where: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The marked samples and their neighbours."""
    wide = where.copy()
    wide[1:] |= where[:-1]
    wide[:-1] |= where[1:]
    return wide


def _tracked(arm: PackedArm, T: Array, start: Array, longest: Array, stop: Stop) -> list[Array]:
    """Rows of the path that goes on to the nearest posture each time, as it is and made even; none if it gets stuck."""
    rows = np.empty((len(T), ROW))
    if path_entries.track(arm.family, T, start, *arm.work(), rows, stop) < len(T):
        return []
    psis, branches = rows[:, ROW_ARM_ANGLE].copy(), rows[:, ROW_BRANCH].astype(np.int64)
    return [rows, _smoothed(arm, T, start, longest, psis, branches, stop)]


def _smoothed(
    arm: PackedArm, T: Array, start: Array | None, longest: Array, psis: Array, branches: NDArray[np.int64], stop: Stop
) -> Array:
    """Rows of a path given by arm angles and branches, which are moved in place."""
    q = np.zeros((len(T), 7))
    rows = np.full((len(T), ROW), np.nan)
    seed = np.zeros(7) if start is None else start
    path_entries.smooth(arm.family, T, start is not None, seed, longest, psis, branches, q, stop)
    path_entries.finish(arm.family, T, psis, branches, q, rows)
    for i in np.flatnonzero((branches < 0) | (rows[:, ROW_STATUS] != Status.OK)):
        if stop[0]:
            break
        # No posture was found on the nearest exact limb: the full search has the last word, near the sample before.
        rows[i] = solve(arm, T[i], seed=rows[i - 1, :7] if i else start)._row
    return rows


def _cost(arm: PackedArm, rows: Array, start: Array | None, longest: Array) -> tuple[int, float]:
    """Breaks of a path, then its sum of squared joint steps from the start on."""
    q = _unwound(arm, rows[:, :7], start)
    if start is not None:
        q = np.vstack([start, q])
    steps = np.diff(q, axis=0)
    unreached = int((rows[:, ROW_STATUS] != Status.OK).sum())
    return unreached + int((np.abs(steps) > longest[1]).any(axis=1).sum()), float((steps**2).sum())


def _longest_steps(arm: PackedArm, dt: float | None, longest_step: float) -> Array:
    """(3, 7) joint steps by velocity and by continuity, and the square of the shortest of all."""
    by_velocity = np.full(7, np.inf)
    if dt is not None:
        by_velocity = arm.velocity_limit * as_positive(dt, "dt", "seconds")
    longest_step = as_positive(longest_step, "longest_step", "radians")
    by_continuity = np.full(7, longest_step)
    return np.vstack([by_velocity, by_continuity, np.full(7, min(by_velocity.min(), by_continuity.min()) ** 2)])


def _unwound(arm: PackedArm, q: Array, start: Array | None) -> Array:
    """The same postures with joints that turn without end counted on from sample to sample."""
    q = q.copy()
    endless = np.isinf(arm.lower) & np.isinf(arm.upper)
    if len(q) and endless.any():
        q[:, endless] = np.unwrap(q[:, endless], axis=0)
        if start is not None:
            q[:, endless] += 2.0 * np.pi * np.round((start - q[0])[endless] / (2.0 * np.pi))
    return q


def _breaks(arm: PackedArm, rows: Array, steps: Array, longest: Array) -> list[PathBreak]:
    breaks = []
    answers = BatchSolution(rows, arm.joint_names, arm.elbow)
    jumps = np.append(False, (np.abs(steps) > longest).any(axis=1))
    for i in np.flatnonzero(jumps | ~answers.ok).tolist():
        if not answers.ok[i]:
            breaks.append(PathBreak(i, 0.0, "", f"Pose {i} is not reached: {answers.message(i)}"))
        else:
            joint = int(np.abs(steps[i - 1]).argmax())
            jump, name = float(abs(steps[i - 1, joint])), arm.joint_names[joint]
            why = (
                f"No posture inside the limits continues the path at pose {i}: joint {name} has to jump {jump:.3f} rad."
            )
            breaks.append(PathBreak(i, jump, name, why))
    return breaks
