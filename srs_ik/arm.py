"""The arm: one robot limb, ready to be asked."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from srs_ik.errors import InvalidConfiguration
from srs_ik.inputs.poses import (
    PoseLike,
    as_arm_angle,
    as_branch,
    as_matrices,
    as_matrix,
    as_seed,
    as_seeds,
    invalid_pose,
    per_pose,
    refuse_bad_poses,
)
from srs_ik.kernels.entries import pose as entries
from srs_ik.kernels.exact.intervals import MAX_PIECES
from srs_ik.kernels.layout import IS_CLOSED, LIMITED, ROW, STRAIGHT
from srs_ik.redundancy import RedundantLimb
from srs_ik.robot.chain import Chain
from srs_ik.robot.limb import Hand, SrsLimb
from srs_ik.solve.packed import pack_hand
from srs_ik.solve.solution import BatchSolution, ElbowRange, Interval, Solution, Solutions
from srs_ik.solve.threads import run_in_threads

if TYPE_CHECKING:
    from srs_ik.robot.description.model import Drawing
    from srs_ik.solve.intervals import IntervalsBatch
    from srs_ik.solve.objectives import Objective
    from srs_ik.solve.optimise import Optimum
    from srs_ik.solve.path import PathSolution
    from srs_ik.solve.posture import Posture, Side, Task, Tie
    from srs_ik.solve.self_motion import SelfMotion
    from srs_ik.solve.task import BatchTaskSolution, TaskSolution

Array = NDArray[np.float64]


class Arm(RedundantLimb):
    """A 7-joint arm with a spherical shoulder, one elbow and a spherical wrist.

    Made by `srs_ik.load`. Joint vectors `q` are always 7 plain angles in radians; poses are those of the tip frame in
    the base frame, as `pinocchio.SE3` or (4, 4) arrays, metres.

    Attributes:
        name: name of the robot.
        base: name of the base frame.
        tip: name of the tip frame.
        joint_names: the 7 joint names, from shoulder to wrist.
        lower: (7,) lower joint limits, rad; -inf where continuous.
        upper: (7,) upper joint limits, rad; inf where continuous.
        velocity_limit: (7,) rad/s; inf where the description gives none.
        effort_limit: (7,) N m; inf where the description gives none.
        model: `pinocchio.Model` of the 7 joints.
        limb: the recognised limb.
        hand: axes of the hand, where known.
        drawing: where the shapes of the robot are; None if it was loaded from a ``pinocchio.Model`` or MJCF.
    """

    def __init__(
        self, chain: Chain, limb: SrsLimb, name: str, hand: Hand | None = None, drawing: Drawing | None = None
    ) -> None:
        super().__init__(chain, limb, name, hand, drawing)
        self._no_work = (None, None) if self._family[LIMITED, IS_CLOSED] else None
        straight = float(self._family[LIMITED, STRAIGHT])
        self._elbow = ElbowRange(straight, float(chain.lower[3]), float(chain.upper[3]))

    # Inverse kinematics -----------------------------------------------------------------------------------------

    def solve(
        self,
        pose: PoseLike,
        arm_angle: float | None = None,
        seed: ArrayLike | None = None,
        branch: int | None = None,
        respect_limits: bool = True,
    ) -> Solution:
        """One posture for a pose.

        With an arm angle, the best branch there; else the best of all arm angles. Best is nearest to the seed (least
        sum of squared differences) if there is one, else farthest from the joint limits, relative to their ranges.

        Args:
            pose: wanted pose of the tip frame in the base frame.
            arm_angle: rad; any if not given.
            seed: (7,) posture to stay near, rad; no joint of it more than 300 rad outside its limits.
            branch: 0 to 7; any if not given.
            respect_limits: whether q has to keep the joint limits.

        Raises:
            InvalidPose: the pose is no finite rigid transform, or farther away than 1e300 m.
            InvalidConfiguration: seed, arm angle or branch are malformed, or one of the angles beyond 1e6 rad.
        """
        row = np.empty(ROW)
        T = as_matrix(pose)
        chosen = -1 if branch is None else as_branch(branch)
        near = None if seed is None else as_seed(seed, self.lower, self.upper)
        respect_limits = bool(respect_limits)
        J, A = self._no_work or self._work()
        if arm_angle is None:
            verdict = entries.solve(self._family, T, chosen, near, respect_limits, J, A, row)
        else:
            psi = as_arm_angle(arm_angle)
            verdict = entries.solve_at(self._family, T, psi, chosen, near, respect_limits, J, A, row)
        if verdict:
            raise invalid_pose(verdict)
        return Solution(row, self.joint_names, self._elbow)

    def solve_all(self, pose: PoseLike, arm_angle: float | None = None, respect_limits: bool = True) -> Solutions:
        """All postures for a pose: every branch at an arm angle, or one posture for every interval of `intervals`.

        Args:
            pose: wanted pose of the tip frame in the base frame.
            arm_angle: rad; without it, each posture is the one farthest from the limits in its interval.
            respect_limits: whether to leave out postures outside the joint limits.

        Returns:
            The solutions, in the order of branches; empty if there is none, with a message that says why.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
            InvalidConfiguration: the arm angle is not a finite number.
        """
        T = as_matrix(pose)
        respect_limits = bool(respect_limits)
        if arm_angle is None:
            rows = np.empty((8 * MAX_PIECES, ROW))
            count = entries.solve_intervals(self._family, T, respect_limits, *self._work(), rows)
            if count < 0:
                raise invalid_pose(-count)
            solved = Solutions(rows[:count], self.joint_names, elbow=self._elbow)
            ok = solved.ok
            if not ok.all():
                solved = Solutions(rows[:count][ok], self.joint_names, elbow=self._elbow)
        else:
            rows = np.empty((8, ROW))
            psi = as_arm_angle(arm_angle)
            J, A = self._no_work or self._work()
            count = entries.solve_all(self._family, T, psi, respect_limits, J, A, rows)
            if count < 0:
                raise invalid_pose(-count)
            solved = Solutions(rows if count == 8 else rows[:count], self.joint_names, None, self._elbow)
        if not len(solved._rows):
            best = self.solve(T, arm_angle=arm_angle, respect_limits=respect_limits)
            if best:
                # Where only rounding leaves room for a posture, the looser search for one alone may still find it.
                return Solutions.of_one(best)
            solved.failure = best
        return solved

    def solve_batch(
        self,
        poses: Any,
        arm_angle: ArrayLike | None = None,
        seed: ArrayLike | None = None,
        branch: int | None = None,
        all_branches: bool = False,
        respect_limits: bool = True,
        threads: int | None = None,
    ) -> BatchSolution:
        """`solve` for N poses at once, in compiled code on several threads; the answers are the same.

        Args:
            poses: (N, 4, 4) array, or a list of poses. Arrays of floats, in C order and writeable, are not copied.
            arm_angle: one for all, or (N,), rad.
            seed: (7,) for all, or (N, 7), rad.
            branch: 0 to 7 for all; any if not given.
            all_branches: give all 8 branches at the arm angle (which is then required) as (N, 8) arrays; those that are
                no solution say so in their status.
            respect_limits: whether q has to keep the joint limits.
            threads: at most so many; all processors if not given.

        Raises:
            InvalidPose: a pose is no finite rigid transform; the message names the first one.
            InvalidConfiguration: seed, arm angle or branch are malformed, or all branches are asked for without an arm
                angle.
        """
        T = as_matrices(poses)
        n = len(T)
        psis = None if arm_angle is None else per_pose(arm_angle, (), n, "arm_angle")
        seeds = None if seed is None else as_seeds(seed, n, self.lower, self.upper)
        chosen = as_branch(branch)
        respect_limits = bool(respect_limits)
        if all_branches and psis is None:
            raise InvalidConfiguration("all_branches needs an arm_angle; without one, see solve_all and intervals")
        limb, verdicts = self._family, np.zeros(n, np.int8)
        out = np.empty((8 * n if all_branches else n, ROW))

        def work(first: int, last: int) -> None:
            J, A = self._work()
            answer = (respect_limits, J, A, out, verdicts)
            if psis is None:
                entries.solve_range(limb, T, first, last, chosen, seeds, *answer)
            elif all_branches:
                entries.solve_all_range(limb, T, first, last, psis, *answer)
            else:
                entries.solve_at_range(limb, T, first, last, psis, chosen, seeds, *answer)

        run_in_threads(work, n, threads)
        refuse_bad_poses(verdicts)
        return BatchSolution(out.reshape(n, 8, ROW) if all_branches else out, self.joint_names, self._elbow)

    def solve_path(
        self,
        poses: Any,
        seed: ArrayLike | None = None,
        dt: float | None = None,
        longest_step: float = 0.5,
        objective: str = "sum_of_squares",
        known: Mapping[int, ArrayLike] | None = None,
        closed: bool = False,
    ) -> PathSolution:
        """A continuous joint path through N poses, inside the limits, chosen over the whole path and not step by step.

        Branches and arm angles of all poses are chosen together (fewest breaks, then least sum of squared joint steps),
        from all postures between the limits and in all turns. A path through a singular pose does not flip there; where
        nothing continues it, the answer says at which sample and why, and between which samples it has to break.

        Args:
            poses: (N, 4, 4) array, or a list of poses.
            seed: (7,) posture to start from, rad.
            dt: time between two poses, seconds; with it, steps beyond the velocity limits are avoided where possible.
            longest_step: a joint step beyond this, rad, is a break.
            objective: what is least among the paths with the fewest breaks: "sum_of_squares" of the joint steps, the
                "largest_step" of a joint, or the "time" at the velocity limits.
            known: postures that the path has to take, (7,) by the index of their pose.
            closed: whether the path has to end in the posture in which it begins (but for whole turns of joints without
                end); its last pose is its first one.

        Raises:
            InvalidPose: a pose is no finite rigid transform; the message names the first one.
            InvalidConfiguration: seed, dt, longest_step or objective are malformed, a known posture is outside the
                limits or not on its pose, or a closed path ends at another pose.
            MissingLimits: the least time is asked for, and a joint has no velocity limit.
        """
        from srs_ik.solve.path import solve_path

        return solve_path(self, poses, seed, dt, longest_step, objective, known, closed)

    def intervals(self, pose: PoseLike, respect_limits: bool = True) -> list[Interval]:
        """Feasible arm angles of every branch, exactly, in the order of branches.

        They are the roots of linear forms in cosine and sine of the arm angle, not samples. On a near limb, where there
        are no such forms, each branch is followed around the circle and every end bisected on the true chain.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
        """
        out = np.empty((8 * MAX_PIECES, 3))
        count = entries.intervals(self._family, as_matrix(pose), bool(respect_limits), *self._work(), out)
        if count < 0:
            raise invalid_pose(-count)
        return [Interval(int(b), float(lower), float(upper)) for b, lower, upper in out[:count]]

    def intervals_batch(self, poses: Any, respect_limits: bool = True, threads: int | None = None) -> IntervalsBatch:
        """`intervals` for N poses at once, in compiled code on several threads; the answers are the same.

        Args:
            poses: (N, 4, 4) array, or a list of poses. Arrays of floats, in C order and writeable, are not copied.
            respect_limits: whether the joint limits have to be kept.
            threads: at most so many; all processors if not given.

        Returns:
            The intervals of all poses in flat arrays; `[i]` lists those of one pose.

        Raises:
            InvalidPose: a pose is no finite rigid transform; the message names the first one.
        """
        from srs_ik.solve.intervals import intervals_batch

        return intervals_batch(self, poses, bool(respect_limits), threads)

    def self_motion(
        self, pose: PoseLike, branch: int | None = None, count: int = 91, respect_limits: bool = True
    ) -> list[SelfMotion]:
        """How the arm can move while its tip stays: postures evenly spaced in arm angle through every interval.

        Args:
            pose: pose of the tip frame in the base frame.
            branch: 0 to 7 for the intervals of that branch alone.
            count: postures an interval, from end to end; at least 2. Those of a whole circle end where they begin.
            respect_limits: whether to stay inside the joint limits.

        Returns:
            One `SelfMotion` for each of `intervals`, in their order; empty where no posture reaches the pose.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
            InvalidConfiguration: no branch, or no count.
        """
        from srs_ik.solve.self_motion import self_motion

        return self_motion(self, pose, branch, count, bool(respect_limits))

    def optimise(
        self,
        pose: PoseLike,
        objective: str | Callable[[Array], float] | Objective,
        respect_limits: bool = True,
        **parameters: Any,
    ) -> Optimum:
        """The best posture of all that reach a pose: the global optimum over branches and arm angles.

        Args:
            pose: wanted pose of the tip frame in the base frame.
            objective: name of a built-in objective (see `Objective`), an `Objective`, or a function of 7 joint
                angles, rad, to be minimised (with `maximise=True`, maximised).
            respect_limits: whether q has to keep the joint limits.
            **parameters: what the objective takes, such as force=, velocity=, twist=, wrench=, reference=, tolerance=.

        Returns:
            The posture, its value and the interval in which it lies; where no posture reaches the pose, the one that
            `solve` gives, with the same status.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
            InvalidTask: unknown objective, missing or malformed parameter, or a function that gave no finite number.
        """
        from srs_ik.solve.optimise import optimise

        return optimise(self, pose, objective, respect_limits, **parameters)

    # Tasks ------------------------------------------------------------------------------------------------------

    def posture(self, task: Task, side: Side = "left", tie: Tie = "lower", threads: int | None = None) -> Posture:
        """Where shoulder, elbow, wrist and hand go for a task: the paper's posture, in closed form, without limits.

        It aligns the plane of the arm with that of the task, and is not the optimum of the paper's cost C (erratum 11);
        that is what `optimise` finds.

        Args:
            task: one task, or N of them.
            side: "left" for the elbow towards +y of the base, "right" for -y.
            tie: which elbow to take where one is above the other: "lower" or "upper".
            threads: at most so many for N tasks; all processors if not given.

        Returns:
            Points (3,) in the base frame; for N tasks arrays (N, 3).

        Raises:
            InvalidTask: no `Task`, or another side or tie.
        """
        from srs_ik.solve.posture import posture

        return posture(self, task, side, tie, threads)

    def solve_task(
        self,
        task: Task,
        side: Side = "left",
        respect_limits: bool = True,
        tie: Tie = "lower",
        threads: int | None = None,
        seed: ArrayLike | None = None,
    ) -> TaskSolution | BatchTaskSolution:
        """Joint angles for a task: its posture, on this arm's own axes and within its limits.

        The pose of the tip follows from the task and the axes of the hand. With the elbow where `posture` puts it, the
        branch nearest to the seed is taken, or the one farthest from the limits; where they forbid all, the elbow goes
        to the nearest feasible arm angle, and `angle_lost` says how far. Without a grasp direction the hand lines up
        with the forearm; without a pronosupination its roll is that of the seed, or leaves the wrist most room.

        Args:
            task: one task, or N of them, for a `BatchTaskSolution`.
            side: "left" for the elbow towards +y of the base, "right" for -y.
            respect_limits: whether q has to keep the joint limits.
            tie: which elbow to take where one is above the other: "lower" or "upper".
            threads: at most so many for N tasks; all processors if not given.
            seed: (7,) posture to stay near, for all, or (N, 7), rad.

        Raises:
            InvalidTask: no `Task`, another side or tie, or an arm whose hand is not known (see `load`).
            InvalidConfiguration: a malformed seed.
        """
        from srs_ik.solve.task import solve_task

        return solve_task(self, task, side, bool(respect_limits), tie, threads, seed)

    # ------------------------------------------------------------------------------------------------------------

    @cached_property
    def _packed_hand(self) -> Array:
        """What the kernels of tasks know of the hand."""
        return pack_hand(self.limb, self.hand)

    def _work(self) -> tuple[Array | None, Array | None]:
        """Work space that the kernels of a near limb need in one call; none on a limb that the closed form answers."""
        return self._no_work or (np.empty((6, 7)), np.empty((16, 9)))

    def __getstate__(self) -> dict[str, Any]:
        # A yourdfpy.URDF holds functions that cannot be pickled; such a copy of the arm is drawn as a skeleton.
        lasting = self.drawing is not None and isinstance(self.drawing.content, str | None)
        return {**super().__getstate__(), "drawing": self.drawing if lasting else None}

    def __repr__(self) -> str:
        kind = self.limb.kind
        return f"<Arm {self.name}: {self.base} to {self.tip}, {kind} S-R-S, wrist {self.limb.wrist_kind}>"
