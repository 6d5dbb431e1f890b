"""A joint path, and what it comes to beside what no path undercuts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from srs_ik.errors import InvalidConfiguration, warn_caller
from srs_ik.kernels.layout.path import BY_VELOCITY
from srs_ik.solve.path.bound import least_largest, least_sum
from srs_ik.solve.path.breaks import PathBreak
from srs_ik.solve.path.problem import JUST_ABOVE, LARGEST_STEP, Problem, objective_of, stands, steps_of
from srs_ik.solve.path.timing import passing_times
from srs_ik.solve.solution import Collision, ElbowRange
from srs_ik.solve.solutions import BatchSolution
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.path.trajectory import Trajectory


ELSEWHERE = 1e-3
"""A motion that begins farther than this from the seed, rad, gets a warning."""


class PathSolution(BatchSolution):
    """Postures for the poses of a path, as arrays over N; true in a boolean test if there is no break.

    Attributes:
        breaks: where the path had to break, and why; empty for a continuous path through all poses.
        steps: (N - 1, 7) joint steps, rad; joints that turn without end go the shorter way round. Over poses that are
            not reached the path goes straight on: even parts of the step from the last one that is reached to the next.
        times: (N,) when it passes its poses, s, from rest to rest within limits of velocity and acceleration; None
            where no acceleration limit was given.
        value: what the path was asked to make least, the step from the seed included: the sum of squared joint steps
            (rad^2), the largest joint step (rad), or the time at the velocity limits (s); with limits of acceleration,
            the last of `times`. Breaks count as steps, and postures of poses that are not reached do not count.
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
        self.times: Array | None = None
        self.value = 0.0 if problem is None else value_of(problem, self.q[self.ok], steps)
        if problem is not None and problem.acceleration is not None:
            self.times = passing_times(steps, problem.arm.velocity_limit, problem.acceleration, stands(problem.T))
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
        value = value_of(problem, self.q[:1][met[:1]], self.steps[met[:-1] & met[1:]])
        if problem.objective == LARGEST_STEP:
            return least_largest(problem, q, value, bool(self.breaks))
        return least_sum(problem, q, value, bool(self.breaks))

    @cached_property
    def velocity_use(self) -> Array | None:
        """(N - 1,) what part of its velocity limit a joint takes in each step at most; None without dt.

        Above 1 a limit is passed, as in breaks, or since no path was found that keeps it.
        """
        problem = self._problem
        if problem is None or not problem.limited:
            return None
        moved = np.abs(self.steps)
        shares = np.zeros_like(moved)
        with np.errstate(divide="ignore"):
            np.divide(moved, problem.settings[BY_VELOCITY], out=shares, where=moved > 0.0)
        use = shares.max(axis=1, initial=0.0)
        return np.where((use > 1.0) & (use <= JUST_ABOVE), 1.0, use)

    @property
    def passes(self) -> Array | None:
        """(N,) when it passes its poses, s: `times`, or `dt` apart; None where nothing says how fast it is passed."""
        if self.times is None and self._problem is not None and self._problem.dt is not None:
            return float(self._problem.dt) * np.arange(len(self), dtype=float)
        return self.times

    def as_table(self) -> dict[str, NDArray[Any]]:
        """Columns (N,) as of all answers, and first "t", when the path passes its poses, s, where `passes` knows it."""
        first = {} if self.passes is None else {"t": self.passes}
        return {**first, **super().as_table()}

    def trajectory(self) -> Trajectory:
        """A motion through all postures, from rest to rest, that keeps the limits at all times, to be sampled.

        It passes the postures at `times`, or `dt` apart, or more slowly (`Trajectory.stretch`), within the velocity
        limits of the arm, and those of acceleration that the path was given. Between two postures it bends away from
        the straight line of joint angles, for which a scene is certified, as splines do. It begins in the first
        posture, not in the seed: a warning says how far apart they are.

        Raises:
            InvalidConfiguration: the path has a break or a pose that is not reached, or was given neither `dt` nor
                limits of acceleration, which say how fast it is passed.
        """
        from srs_ik.solve.path.trajectory import Trajectory

        if not self:
            at = self.breaks[0].sample if self.breaks else int(np.argmin(self.ok))
            raise InvalidConfiguration(f"there is no motion through all postures: the path breaks at pose {at}")
        if not len(self):
            raise InvalidConfiguration("the path has no poses")
        problem, times = self._problem, self.passes
        if times is None or problem is None:
            raise InvalidConfiguration(
                "nothing says how fast the path is passed: "
                "give solve_path dt=, or objective='time' with acceleration_limit="
            )
        _warn_of_a_start_elsewhere(problem, self.q[0])
        arm = problem.arm
        pushes = arm.acceleration_limit if problem.acceleration is None else problem.acceleration
        q = np.vstack([self.q[:1], self.q[0] + np.cumsum(self.steps, axis=0)])
        return Trajectory(q, times, stands(problem.T), (arm.lower, arm.upper), (arm.velocity_limit, pushes))

    @property
    def largest_step(self) -> float:
        """Largest joint step of the path, breaks included, rad."""
        return float(np.abs(self.steps).max(initial=0.0))

    def __bool__(self) -> bool:
        return not self.breaks and bool(self.ok.all())

    def __repr__(self) -> str:
        most = 0.0 if self.velocity_use is None else float(self.velocity_use.max(initial=0.0))
        passed = f", up to {most:.4g} times the velocity limits" if most > 1.0 else ""
        return f"PathSolution({self.solved} of {len(self)} solved, {len(self.breaks)} breaks{passed})"


def value_of(problem: Problem, q: Array, steps: Array) -> float:
    """What a path was asked to make least, the step from the seed to the first of its postures (k, 7) included."""
    if problem.seed is not None and len(q):
        steps = np.vstack([steps_of(problem, np.vstack([problem.seed, q[:1]])), steps])
    return objective_of(problem, steps)


def _warn_of_a_start_elsewhere(problem: Problem, q: Array) -> None:
    """Warn where a motion does not begin in the seed: a robot that stands there would jump."""
    if problem.seed is None:
        return
    away = np.abs(q - problem.seed)
    joint = int(away.argmax())
    if away[joint] > ELSEWHERE:
        warn_caller(
            f"the motion begins {away[joint]:.3g} rad from the seed (joint {problem.arm.joint_names[joint]!r}): "
            "bring the joints there first, or give known={0: q} (--start) where the robot stands at the first pose"
        )
