"""Joint paths: continuous joint motions through a sequence of poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from srs_ik.inputs.poses import as_matrices, as_positive, as_seed
from srs_ik.kernels.entries.path import BY_CONTINUITY, BY_VELOCITY, INVERSE_PERIOD, PERIOD, SETTINGS
from srs_ik.kernels.layout import ROW
from srs_ik.solve.path_search import Problem, rows_of, search
from srs_ik.solve.solution import BatchSolution, ElbowRange

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
    arm: Any,
    poses: Any,
    seed: ArrayLike | None = None,
    dt: float | None = None,
    longest_step: float = LONGEST_STEP,
) -> PathSolution:
    """See `Arm.solve_path`."""
    T = as_matrices(poses)
    n = len(T)
    settings = _settings(arm, dt, longest_step)
    start = None if seed is None else as_seed(seed, arm.lower, arm.upper)
    if not n:
        return PathSolution(np.empty((0, ROW)), arm.joint_names, np.empty((0, 7)), [])
    problem = Problem(arm, T, start, settings, dt is not None, np.zeros((n, 7)), np.zeros(n, np.bool_))
    rows = rows_of(problem, search(problem))
    rows[:, :7] = _unwound(arm, rows[:, :7], start)
    steps = np.diff(rows[:, :7], axis=0)
    return PathSolution(rows, arm.joint_names, steps, _breaks(arm, rows, steps, settings[BY_CONTINUITY]), arm._elbow)


def _settings(arm: Any, dt: float | None, longest_step: float) -> Array:
    """(SETTINGS, 7) of the programme: longest joint steps by velocity and by continuity, turns of endless joints."""
    settings = np.zeros((SETTINGS, 7))
    settings[BY_VELOCITY] = np.inf if dt is None else arm.velocity_limit * as_positive(dt, "dt", "seconds")
    settings[BY_CONTINUITY] = as_positive(longest_step, "longest_step", "radians")
    endless = np.isinf(arm.lower) & np.isinf(arm.upper)
    settings[PERIOD, endless] = 2.0 * np.pi
    settings[INVERSE_PERIOD, endless] = 0.5 / np.pi
    return settings


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
    answers = BatchSolution(rows, arm.joint_names, arm._elbow)
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
