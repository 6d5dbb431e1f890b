"""What an arm is asked in a scene: every question takes its intervals from `Surroundings`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from srs_ik.collision.scenes.scene import Scene
from srs_ik.inputs.angles import as_arm_angle, as_bounded_joint_vector, as_branch, as_joint_vectors, as_seed
from srs_ik.inputs.freedom import as_free_axis
from srs_ik.inputs.poses import OR_FREE, PoseLike, as_matrix
from srs_ik.solve.in_scene import pose as pose_solver
from srs_ik.solve.in_scene.surroundings import Surroundings
from srs_ik.solve.intervals import Interval

if TYPE_CHECKING:
    from srs_ik.collision.owner import BodyOwner
    from srs_ik.inputs.task import Task
    from srs_ik.solve.in_scene.edges import PathCollision
    from srs_ik.solve.intervals import IntervalsBatch
    from srs_ik.solve.optimise import Optimum
    from srs_ik.solve.packed import PackedArm
    from srs_ik.solve.path.solution import PathSolution
    from srs_ik.solve.solution import Collision, Solution
    from srs_ik.solve.solutions import BatchSolution, Solutions
    from srs_ik.solve.task import BatchTaskSolution, TaskSolution


def in_scene(arm: BodyOwner, packed: PackedArm, scene: Scene, margin: Any) -> InScene:
    """Who answers questions in a scene: whoever did so last, if nothing has changed since.

    Raises:
        InvalidScene: no `Scene`, or no margin.
        NoBodies: no shapes of the arm are at hand.
    """
    state = arm.__dict__
    # What is not told apart by these is made anew.
    plain = type(scene) is Scene and type(margin) is float
    now = (scene, scene.version, scene.moves, scene.margin, scene.exact, margin) if plain else None
    # Read once: another thread may put another scene there.
    last: tuple[Any, InScene] | None = state.get("_in_scene")
    if last is not None and now is not None and last[0] == now:
        return last[1]
    asked = InScene(arm, packed, scene, margin)
    if now is not None:
        state["_in_scene"] = now, asked
    return asked


class FreeIntervals(list[Interval]):
    """Intervals that keep clear of a scene."""

    # with real shapes, width of what is forbidden for not having been decided, rad, of all branches
    undecided: float = 0.0


class InScene:
    """The questions of `in_limits.InLimits`, with bodies that must not meet.

    Raises:
        InvalidScene: no `Scene`, or no margin.
        NoBodies: no shapes of the arm are at hand.
    """

    def __init__(self, arm: BodyOwner, packed: PackedArm, scene: Scene, margin: Any) -> None:
        self.around = Surroundings(arm, packed, scene, margin)
        self.packed = packed

    def intervals(self, pose: PoseLike, respect: bool) -> list[Interval]:
        """See `Arm.intervals`."""
        rows, undecided = pose_solver.free_intervals(self.around, as_matrix(pose), respect)
        found = FreeIntervals(Interval(int(b), lower, upper) for b, lower, upper in rows.tolist())
        found.undecided = undecided
        return found

    def intervals_batch(self, poses: Any, respect: bool, threads: int | None) -> IntervalsBatch:
        """See `Arm.intervals_batch`."""
        return pose_solver.intervals_batch(self.around, poses, respect, threads)

    def solve(
        self, pose: PoseLike, arm_angle: float | None, seed: ArrayLike | None, branch: int | None, respect: bool
    ) -> Solution:
        """See `Arm.solve`."""
        near = None if seed is None else as_seed(seed, self.packed.lower, self.packed.upper)
        psi = None if arm_angle is None else as_arm_angle(arm_angle)
        return pose_solver.solve(
            self.around, as_matrix(pose, OR_FREE), psi, near, -1 if branch is None else as_branch(branch), respect
        )

    def solve_all(self, pose: PoseLike, arm_angle: float | None, respect: bool) -> Solutions:
        """See `Arm.solve_all`."""
        psi = None if arm_angle is None else as_arm_angle(arm_angle)
        return pose_solver.solve_all(self.around, as_matrix(pose), psi, respect)

    def solve_batch(self, poses: Any, *question: Any) -> BatchSolution:
        """See `Arm.solve_batch`."""
        return pose_solver.solve_batch(self.around, poses, *question)

    def solve_near(
        self, pose: PoseLike, elbow: Any, seed: ArrayLike | None, branch: int | None, respect: bool
    ) -> Solution:
        """See `Arm.solve`, with a wanted elbow."""
        from srs_ik.solve.elbow import wanted_angles
        from srs_ik.solve.in_scene.elbow import solve_near

        T = as_matrix(pose)
        near = None if seed is None else as_seed(seed, self.packed.lower, self.packed.upper)
        psi = float(wanted_angles(self.packed, T[None], elbow)[0])
        return solve_near(self.around, T, psi, near, as_branch(branch), respect)

    def solve_near_batch(self, poses: Any, *question: Any) -> BatchSolution:
        """See `Arm.solve_batch`, with wanted elbows."""
        from srs_ik.solve.in_scene.elbow import solve_near_batch

        return solve_near_batch(self.around, poses, *question)

    def solve_free(self, pose: PoseLike, free_axis: Any, seed: ArrayLike | None, respect: bool) -> Solution:
        """See `Arm.solve`, with a free axis."""
        from srs_ik.solve.in_scene import freedom

        near = None if seed is None else as_seed(seed, self.packed.lower, self.packed.upper)
        return freedom.solve(self.around, as_matrix(pose), as_free_axis(free_axis), near, respect)

    def solve_free_batch(self, poses: Any, *question: Any) -> BatchSolution:
        """See `Arm.solve_batch`, with a free axis."""
        from srs_ik.solve.in_scene import freedom

        return freedom.solve_batch(self.around, poses, *question)

    def solve_path(self, poses: Any, *question: Any) -> PathSolution:
        """See `Arm.solve_path`."""
        from srs_ik.solve.path.ask import solve_path

        return solve_path(self.packed, poses, *question, around=self.around)

    def solve_task(self, task: Task, *question: Any) -> TaskSolution | BatchTaskSolution:
        """See `Arm.solve_task`."""
        from srs_ik.solve.in_scene.task import solve_task

        return solve_task(self.around, task, *question)

    def optimise(self, pose: PoseLike, objective: Any, respect: bool, **parameters: Any) -> Optimum:
        """See `Arm.optimise`."""
        from srs_ik.solve.in_scene.optimise import optimise

        return optimise(self.around, as_matrix(pose), objective, respect, **parameters)

    def collision(self, q: ArrayLike) -> Collision | None:
        """See `Arm.collision`."""
        from srs_ik.solve.in_scene.postures import collision

        return collision(self.around, as_bounded_joint_vector(q))

    def path_collisions(self, q: ArrayLike) -> list[PathCollision]:
        """See `Arm.path_collisions`."""
        from srs_ik.solve.in_scene.postures import path_collisions

        return path_collisions(self.around, as_joint_vectors(q))
