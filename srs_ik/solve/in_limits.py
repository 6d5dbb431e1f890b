"""What an arm is asked with nothing in its way: feasible arm angles are those of its limits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from srs_ik.inputs.poses import PoseLike
from srs_ik.solve import intervals as feasible
from srs_ik.solve import pose as pose_solver

if TYPE_CHECKING:
    from srs_ik.inputs.task import Task
    from srs_ik.kinematics import ChainKinematics
    from srs_ik.solve.intervals import Interval, IntervalsBatch
    from srs_ik.solve.optimise import Optimum
    from srs_ik.solve.packed import PackedArm
    from srs_ik.solve.path.solution import PathSolution
    from srs_ik.solve.solution import Solution
    from srs_ik.solve.solutions import BatchSolution, Solutions
    from srs_ik.solve.task import BatchTaskSolution, TaskSolution


class InLimits:
    """Questions of `Arm` whose answers depend on what stands around it; `in_scene.questions.InScene` has the same."""

    def __init__(self, arm: ChainKinematics, packed: PackedArm) -> None:
        self.arm = arm
        self.packed = packed

    def intervals(self, pose: PoseLike, respect: bool) -> list[Interval]:
        """See `Arm.intervals`."""
        return feasible.intervals(self.packed, pose, respect)

    def intervals_batch(self, poses: Any, respect: bool, threads: int | None) -> IntervalsBatch:
        """See `Arm.intervals_batch`."""
        return feasible.intervals_batch(self.packed, poses, respect, threads)

    def solve(self, pose: PoseLike, *question: Any) -> Solution:
        """See `Arm.solve`."""
        return pose_solver.solve(self.packed, pose, *question)

    def solve_all(self, pose: PoseLike, arm_angle: float | None, respect: bool) -> Solutions:
        """See `Arm.solve_all`."""
        return pose_solver.solve_all(self.packed, pose, arm_angle, respect)

    def solve_batch(self, poses: Any, *question: Any) -> BatchSolution:
        """See `Arm.solve_batch`."""
        return pose_solver.solve_batch(self.packed, poses, *question)

    def solve_near(self, pose: PoseLike, *question: Any) -> Solution:
        """See `Arm.solve`, with a wanted elbow."""
        from srs_ik.solve import elbow

        return elbow.solve(self.packed, pose, *question)

    def solve_near_batch(self, poses: Any, *question: Any) -> BatchSolution:
        """See `Arm.solve_batch`, with wanted elbows."""
        from srs_ik.solve import elbow

        return elbow.solve_batch(self.packed, poses, *question)

    def solve_free(self, pose: PoseLike, *question: Any) -> Solution:
        """See `Arm.solve`, with a free axis."""
        from srs_ik.solve import freedom

        return freedom.solve(self.packed, pose, *question)

    def solve_free_batch(self, poses: Any, *question: Any) -> BatchSolution:
        """See `Arm.solve_batch`, with a free axis."""
        from srs_ik.solve import freedom

        return freedom.solve_batch(self.packed, poses, *question)

    def solve_path(self, poses: Any, *question: Any) -> PathSolution:
        """See `Arm.solve_path`."""
        from srs_ik.solve.path.ask import solve_path

        return solve_path(self.packed, poses, *question)

    def solve_task(self, task: Task, *question: Any) -> TaskSolution | BatchTaskSolution:
        """See `Arm.solve_task`."""
        from srs_ik.solve.rolled_task import solve_task

        return solve_task(self.packed, task, *question)

    def optimise(self, pose: PoseLike, objective: Any, respect: bool, **parameters: Any) -> Optimum:
        """See `Arm.optimise`."""
        from srs_ik.solve.optimise import optimise

        return optimise(self.packed, self.arm, pose, objective, respect, **parameters)
