"""Joint paths: continuous joint motions through a sequence of poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from srs_ik.errors import InvalidConfiguration
from srs_ik.kernels import path_entries
from srs_ik.kernels.layout import ROW, ROW_STATUS
from srs_ik.pose import as_joint_vector, as_matrices, invalid_pose
from srs_ik.solution import BatchSolution, Status

Array = NDArray[np.float64]

LONGEST_STEP = 0.5
"""Default of the longest joint step that counts as continuous, rad."""


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

    def __init__(self, rows: Array, joint_names: Sequence[str], steps: Array, breaks: list[PathBreak]) -> None:
        super().__init__(rows, joint_names)
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
    arm: Any,
    poses: Any,
    seed: ArrayLike | None = None,
    dt: float | None = None,
    longest_step: float = LONGEST_STEP,
) -> PathSolution:
    """See `Arm.solve_path`."""
    T = as_matrices(poses)
    n = len(T)
    longest = _longest_steps(arm, dt, longest_step)
    start = np.zeros(7) if seed is None else as_joint_vector(seed, "seed")
    psis, q = np.zeros(n), np.zeros((n, 7))
    branches, verdicts = np.full(n, -1), np.zeros(n, np.int64)
    rows = np.full((n, ROW), np.nan)
    if n:
        family, seeded = arm._family, seed is not None
        path_entries.plan(family, T, seeded, start, longest, psis, branches, verdicts)
        if verdicts.any():
            bad = int(np.flatnonzero(verdicts)[0])
            raise invalid_pose(int(verdicts[bad]), f" {bad} of {n}")
        path_entries.smooth(family, T, seeded, start, longest, psis, branches, q)
        path_entries.finish(family, T, psis, branches, q, rows)
    previous: Array | None = start if seed is not None else None
    for i in np.flatnonzero((branches < 0) | (rows[:, ROW_STATUS] != Status.OK)):
        # No posture was found on the nearest exact limb: the full search has the last word, near the sample before.
        near = rows[i - 1, :7] if i else previous
        rows[i] = arm.solve(T[i], seed=near)._row
    q = _unwound(arm, rows[:, :7], previous)
    rows[:, :7] = q
    steps = np.diff(q, axis=0)
    return PathSolution(rows, arm.joint_names, steps, _breaks(arm, rows, steps, longest[1]))


def _longest_steps(arm: Any, dt: float | None, longest_step: float) -> Array:
    """(2, 7) joint steps by velocity and by continuity."""
    if not (np.isscalar(longest_step) and np.isfinite(longest_step) and longest_step > 0.0):
        raise InvalidConfiguration(f"longest_step must be a positive number of radians, not {longest_step!r}")
    by_velocity = np.full(7, np.inf)
    if dt is not None:
        if not (np.isscalar(dt) and np.isfinite(dt) and dt > 0.0):
            raise InvalidConfiguration(f"dt must be a positive number of seconds, not {dt!r}")
        by_velocity = arm.velocity_limit * float(dt)
    return np.vstack([by_velocity, np.full(7, float(longest_step))])


def _unwound(arm: Any, q: Array, start: Array | None) -> Array:
    """The same postures with joints that turn without end counted on from sample to sample."""
    q = q.copy()
    endless = np.isinf(arm.lower) & np.isinf(arm.upper)
    if len(q) and endless.any():
        q[:, endless] = np.unwrap(q[:, endless], axis=0)
        if start is not None:
            q[:, endless] += 2.0 * np.pi * np.round((start - q[0])[endless] / (2.0 * np.pi))
    return q


def _breaks(arm: Any, rows: Array, steps: Array, longest: Array) -> list[PathBreak]:
    breaks = []
    answers = BatchSolution(rows, arm.joint_names)
    for i in range(len(rows)):
        if not answers.ok[i]:
            breaks.append(PathBreak(i, 0.0, "", f"Pose {i} is not reached: {answers.message(i)}"))
        elif i and (np.abs(steps[i - 1]) > longest).any():
            joint = int(np.abs(steps[i - 1]).argmax())
            jump, name = float(abs(steps[i - 1, joint])), arm.joint_names[joint]
            why = f"No posture inside the limits continues the path at pose {i}: joint {name} has to jump {jump:.3f} rad."
            breaks.append(PathBreak(i, jump, name, why))
    return breaks
