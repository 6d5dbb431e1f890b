"""The arm: one robot limb, ready to be asked."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from srs_ik.collision.owner import BodyOwner, BodyPlan
from srs_ik.collision.scenes.figures import refuse_margin
from srs_ik.errors import InvalidConfiguration, NotAnSrsLimb
from srs_ik.inputs.angles import as_bounded_joint_vector
from srs_ik.inputs.elbow import refuse_beside
from srs_ik.inputs.numbers import as_flag, as_gravity
from srs_ik.inputs.poses import PoseLike, as_rigid_matrix
from srs_ik.kernels.entries import kinematics as entries
from srs_ik.robot import changes
from srs_ik.robot.chain import Chain
from srs_ik.robot.limb import Hand, SrsLimb
from srs_ik.robot.recognition import recognise
from srs_ik.solve import kinematics
from srs_ik.solve.in_limits import InLimits
from srs_ik.solve.intervals import Interval
from srs_ik.solve.kinematics import Centres
from srs_ik.solve.packed import pack_arm
from srs_ik.solve.solution import Collision, Solution
from srs_ik.solve.solutions import BatchSolution, Solutions
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.collision.scenes.scene import Scene
    from srs_ik.inputs.freedom import FreeAxis
    from srs_ik.inputs.task import Task
    from srs_ik.robot.description.model import Drawing
    from srs_ik.solve.derivatives import SolutionDerivatives
    from srs_ik.solve.free_splits import FreeSplit
    from srs_ik.solve.in_scene.edges import PathCollision
    from srs_ik.solve.in_scene.questions import InScene
    from srs_ik.solve.intervals import IntervalsBatch
    from srs_ik.solve.objectives import Objective
    from srs_ik.solve.optimise import Optimum
    from srs_ik.solve.path.solution import PathSolution
    from srs_ik.solve.posture import Posture, Side, Tie
    from srs_ik.solve.self_motion import SelfMotion
    from srs_ik.solve.task import BatchTaskSolution, TaskSolution
    from srs_ik.solve.tracker.tracker import Tracker


class Arm(BodyOwner):
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
        acceleration_limit: (7,) rad/s^2; inf where none is given, by `load` or `with_limits`: descriptions have none.
        model: `pinocchio.Model` of the 7 joints.
        held_mass: mass of what the hand holds, which `model` has with joint 7, kg; 0 where none was given.
        locked: where other joints of the robot stand that were not locked at zero, by name, rad or m.
        limb: the recognised limb.
        hand: axes of the hand, where known.
        drawing: where the shapes of the robot are; None if it was loaded from a ``pinocchio.Model`` or MJCF.
        plan: how its bodies are found.
        packed: what the kernels know of the arm.
    """

    _fixed = BodyOwner._fixed | {"limb", "hand", "drawing", "plan", "packed"}
    _closed = True
    _instead = "with_tool and with_base give another arm, and load(limits={...}) one with other limits"

    def __init__(
        self,
        chain: Chain,
        limb: SrsLimb,
        name: str,
        hand: Hand | None = None,
        drawing: Drawing | None = None,
        plan: BodyPlan | None = None,
    ) -> None:
        super().__init__(chain, name)
        self._chain = chain
        self.limb = limb
        self.hand = hand
        self.drawing = drawing
        self.plan = plan or BodyPlan()
        self.packed = pack_arm(self, limb, hand)
        self._in_limits = InLimits(self, self.packed)

    # Inverse kinematics -----------------------------------------------------------------------------------------

    def solve(
        self,
        pose: PoseLike,
        arm_angle: float | None = None,
        seed: ArrayLike | None = None,
        branch: int | None = None,
        respect_limits: bool = True,
        *,
        elbow: ArrayLike | None = None,
        free_axis: ArrayLike | FreeAxis | str | None = None,
        scene: Scene | None = None,
        margin: float = 0.0,
    ) -> Solution:
        """One posture for a pose.

        With an arm angle, the best branch there; else the best of all arm angles. Best is nearest to the seed (least
        sum of squared differences) if there is one, else farthest from the joint limits, relative to their ranges.

        Args:
            pose: wanted pose of the tip frame in the base frame.
            arm_angle: rad; any if not given.
            seed: (7,) posture to stay near, rad; no joint of it more than 300 rad outside its limits, and a warning
                from a turn on: it looks like degrees.
            branch: 0 to 7; any if not given. A posture on the border between two branches, the sine of a middle angle
                from its singularity below 1e-5, counts for both where the one that is asked for has no other.
            respect_limits: whether q has to keep the joint limits.
            elbow: where the elbow is wanted: a point (3,) in the base frame, m, such as a measured elbow, or an arm
                angle, rad. The feasible arm angle nearest to it is taken, where the elbow is nearest to the point (on
                a near limb to within what its axes miss), and of the branches there the best. It goes with neither
                arm_angle nor free_axis.
            free_axis: what of the rotation is free: a direction in the tip frame for the roll about it, a
                `FreeAxis` for a cone, "any" for a position alone; errors are those that are left then. It goes with a
                seed or without, and with neither arm angle nor branch. With a scene, the best of a sample of turns is
                closed in on wherever the best posture of all hits something.
            scene: what must not be touched, the arm's own bodies included; nothing is looked at if not given.
            margin: what is to be left between any two bodies, m; it goes with a scene.

        Raises:
            InvalidPose: the pose is no finite rigid transform, or farther away than 1e300 m.
            InvalidConfiguration: seed, arm angle, elbow or branch are malformed, or one of the angles beyond 1e6 rad.
            InvalidTask: no free axis, or one beside what it does not go with.
            InvalidScene: no `Scene`, or no margin.
            NoBodies: no shapes of the arm are at hand.
        """
        respect = as_flag(respect_limits, "respect_limits")
        if elbow is not None:
            refuse_beside(arm_angle=arm_angle, free_axis=free_axis)
            return self._asked(scene, margin).solve_near(pose, elbow, seed, branch, respect)
        if free_axis is not None:
            from srs_ik.solve import freedom

            freedom.refuse_beside(free_axis, arm_angle=arm_angle, branch=branch)
            return self._asked(scene, margin).solve_free(pose, free_axis, seed, respect)
        return self._asked(scene, margin).solve(pose, arm_angle, seed, branch, respect)

    def solve_all(
        self,
        pose: PoseLike,
        arm_angle: float | None = None,
        respect_limits: bool = True,
        *,
        seed: ArrayLike | None = None,
        scene: Scene | None = None,
        margin: float = 0.0,
    ) -> Solutions:
        """All postures for a pose: every branch at an arm angle, or one posture for every interval of `intervals`.

        With a seed, the nearest posture of every branch.

        Args:
            pose: wanted pose of the tip frame in the base frame.
            arm_angle: rad; without it, each posture is the one farthest from the limits in its interval.
            respect_limits: whether to leave out postures outside the joint limits.
            seed: (7,) rad. Joints are in the turns nearest to it, and the nearest posture comes first.
            scene: what must not be touched, the arm's own bodies included; nothing is looked at if not given.
            margin: what is to be left between any two bodies, m; it goes with a scene.

        Returns:
            The solutions, by branch or by distance; empty if there is none, with a message that says why.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
            InvalidConfiguration: the arm angle is not a finite number, or the seed not seven.
            InvalidScene: no `Scene`, or no margin.
            NoBodies: no shapes of the arm are at hand.
        """
        asked, respect = self._asked(scene, margin), as_flag(respect_limits, "respect_limits")
        if seed is None:
            return asked.solve_all(pose, arm_angle, respect)
        from srs_ik.solve.by_branch import nearest_of_each

        return nearest_of_each(self.packed, asked, pose, arm_angle, seed, respect)

    def solve_batch(
        self,
        poses: Any,
        arm_angle: ArrayLike | None = None,
        seed: ArrayLike | None = None,
        branch: int | ArrayLike | None = None,
        all_branches: bool = False,
        respect_limits: bool = True,
        threads: int | None = None,
        *,
        elbow: ArrayLike | None = None,
        free_axis: ArrayLike | FreeAxis | str | None = None,
        scene: Scene | None = None,
        margin: float = 0.0,
    ) -> BatchSolution:
        """`solve` for N poses at once, in compiled code on several threads; the answers are the same.

        Args:
            poses: (N, 4, 4) array, or a list of poses. Arrays of floats, in C order and writeable, are not copied.
            arm_angle: one for all, or (N,), rad.
            seed: (7,) for all, or (N, 7), rad.
            branch: 0 to 7 for all, or (N,), such as those of `intervals_batch`; any if not given.
            all_branches: give all 8 branches at the arm angle (which is then required) as (N, 8) arrays; those that are
                no solution say so in their status. Seed and branch choose nothing then, and are warned of.
            respect_limits: whether q has to keep the joint limits.
            threads: at most so many; all processors if not given.
            elbow: as for `solve`; a point (3,) or an arm angle for all, or (N, 3) points.
            free_axis: as for `solve`, for all.
            scene: what must not be touched, the arm's own bodies included; nothing is looked at if not given.
            margin: what is to be left between any two bodies, m; it goes with a scene.

        Raises:
            InvalidPose: a pose is no finite rigid transform; the message names the first one.
            InvalidConfiguration: seed, arm angle, elbow, branch or threads are malformed, or all branches are asked for
                without an arm angle.
            InvalidTask: no free axis, or one beside what it does not go with.
            InvalidScene: no `Scene`, or no margin.
            NoBodies: no shapes of the arm are at hand.
        """
        respect, every = as_flag(respect_limits, "respect_limits"), as_flag(all_branches, "all_branches")
        if every and (seed is not None or branch is not None):
            words = "all_branches=True gives every branch: seed and branch choose nothing"
            warnings.warn(words, UserWarning, stacklevel=2)
        if elbow is not None:
            refuse_beside(arm_angle=arm_angle, free_axis=free_axis, all_branches=every)
            if isinstance(branch, list | tuple | np.ndarray):
                raise InvalidConfiguration("elbow goes with one branch for all poses, or with none")
            return self._asked(scene, margin).solve_near_batch(poses, elbow, seed, branch, respect, threads)
        if free_axis is not None:
            from srs_ik.solve import freedom

            freedom.refuse_beside(free_axis, arm_angle=arm_angle, branch=branch, all_branches=every)
            return self._asked(scene, margin).solve_free_batch(poses, free_axis, seed, respect, threads)
        ask, others = self._asked(scene, margin).solve_batch, (every, respect, threads)
        branch = None if every else branch
        if isinstance(branch, list | tuple | np.ndarray):
            from srs_ik.solve import by_branch

            return by_branch.solve_batch(self.packed, ask, poses, arm_angle, seed, branch, *others)
        return ask(poses, arm_angle, seed, branch, *others)

    def solve_path(
        self,
        poses: Any,
        seed: ArrayLike | None = None,
        dt: float | None = None,
        longest_step: float = 0.5,
        objective: str = "sum_of_squares",
        known: Mapping[int, ArrayLike] | None = None,
        closed: bool = False,
        acceleration_limit: ArrayLike | None = None,
        *,
        free_axis: ArrayLike | FreeAxis | str | None = None,
        scene: Scene | None = None,
        margin: float = 0.0,
    ) -> PathSolution:
        """A continuous joint path through N poses, inside the limits, chosen over the whole path and not step by step.

        Branches and arm angles of all poses are chosen together (fewest breaks, then least sum of squared joint steps),
        from all postures between the limits and in all turns. A path through a singular pose does not flip there; where
        nothing continues it, the answer says at which sample and why, and between which samples it has to break.

        With a scene, the straight lines of joint angles from posture to posture are certified too: between two poses no
        body comes closer to another than the margin. Where no path is found that keeps clear, a break names the bodies.

        Args:
            poses: (N, 4, 4) array, or a list of poses.
            seed: (7,) posture to start from, rad.
            dt: time between two poses, seconds; with it, velocity limits are kept where a path is found that does, and
                else `velocity_use` of the answer is above 1.
            longest_step: a joint step beyond this, rad, is a break. One from the seed counts like a break where paths
                are compared, and is none of `breaks`.
            objective: what is least among the paths with the fewest breaks: "sum_of_squares" of the joint steps, the
                "largest_step" of a joint, or the "time" at the velocity limits.
            known: postures that the path has to take, (7,) by the index of their pose. Joints without end come back in
                the turns that are given, and are counted on from there, whatever the seed. Where no break lies between
                two of them, the second one is in the turns in which the path arrives.
            closed: whether the path has to end in the posture in which it begins (but for whole turns of joints without
                end); its last pose is its first one.
            acceleration_limit: one for all joints, or (7,), rad/s^2, for the objective "time": the path is then passed
                from rest to rest within both limits, at the `times` of the answer. That is the least time along the
                path, and the path the best one of those that are best by each objective. If not given, those of the
                arm, where it has any.
            free_axis: what of the rotation is free, as for `solve`; turns are chosen on samples, along the whole path,
                and then each for its neighbours. It goes with neither known postures nor a closed path.
            scene: what must not be touched, the arm's own bodies included; nothing is looked at if not given.
            margin: what is to be left between any two bodies, m; it goes with a scene.

        Raises:
            InvalidPose: a pose is no finite rigid transform; the message names the first one.
            InvalidConfiguration: seed, dt, longest_step or objective are malformed, a known posture is outside the
                limits, not on its pose or hits something, or a closed path ends at another pose.
            MissingLimits: the least time is asked for, and a joint has no velocity limit.
            InvalidScene: no `Scene`, or no margin.
            NoBodies: no shapes of the arm are at hand.
        """
        from srs_ik.solve.path.ask import Terms

        round_trip = as_flag(closed, "closed")
        terms = Terms(seed, dt, longest_step, objective, acceleration_limit)
        return self._asked(scene, margin).solve_path(poses, terms, known, round_trip, free_axis)

    def tracker(
        self,
        q0: ArrayLike,
        dt: float,
        velocity: ArrayLike | None = None,
        acceleration: ArrayLike | None = None,
        elbow: Any = "keep",
        smoothing: float | None = None,
        jerk: ArrayLike | None = None,
        *,
        free_axis: ArrayLike | FreeAxis | str | None = None,
        scene: Scene | None = None,
        margin: float = 0.0,
    ) -> Tracker:
        """A follower of a target pose that moves: `update(pose)` gives the joint angles for the end of each period.

        Args:
            q0: (7,) joint angles to begin with, at rest, rad.
            dt: seconds between two updates, 1e-6 to 100.
            velocity: the largest, one for all joints, or (7,), rad/s; those of the description if not given.
            acceleration: the largest, one for all joints, or (7,), rad/s^2; inf for none, where a
                joint still takes 0.05 s to its largest velocity; if not given, `acceleration_limit` of the arm, and for
                joints without one, what brings it there in 0.1 s.
            elbow: "keep" (it moves as little as the target and the limits allow), an arm angle, rad, a point (3,) in
                the base frame, m, such as a measured elbow, to which it comes as near as it can, a built-in `Objective`
                of one value (no lexicographic one, no function of one's own) or its name ("limit_margin" for farthest
                from the limits) that it follows downhill, a `Task`, whose force and velocity it serves, or a `Scene`,
                from whose bodies it keeps away, and which then counts as `scene`.
            smoothing: time constant of a filter that takes jitter from the target, seconds, 0 for none; if not given,
                as long as the noise of the target asks for, which is measured: none where there is none.
            jerk: the largest, one for all joints, or (7,), rad/s^3; by Ruckig (extra `jerk`), which follows what comes
                out without it.
            free_axis: what of the targets' rotation is free, as for `solve`.
            scene: what must not be touched, the arm's own bodies included: the arm stops before it, within its limits.
                Objects may be moved between updates; those that come towards the arm are not evaded.
            margin: what is to be left between any two bodies, m; it goes with a scene.

        Raises:
            InvalidConfiguration: a malformed argument, or q0 outside the joint limits.
            InvalidTask: no such objective, or a lexicographic one, or a function; several tasks; no free axis.
            InvalidScene: no `Scene`, or no margin.
            MissingExtra: a limit of the jerk is given, and ruckig is not installed.
            MissingLimits: the description gives a joint no velocity limit, and none is given here.
            NoBodies: with a scene, no shapes of the arm are at hand.
        """
        from srs_ik.solve.tracker.tracker import Tracker

        bounds = velocity, acceleration, jerk
        return Tracker((self.packed, self), q0, dt, bounds, elbow, smoothing, free_axis, scene, margin)

    def intervals(
        self, pose: PoseLike, respect_limits: bool = True, *, scene: Scene | None = None, margin: float = 0.0
    ) -> list[Interval]:
        """Feasible arm angles of every branch, exactly, in the order of branches.

        They are the roots of linear forms in cosine and sine of the arm angle, not samples. On a near limb those of its
        nearest exact limb are corrected on the true chain, and its curves followed next to singular postures.

        With a scene, they are what bodies leave of that: arcs that spheres forbid, exactly (see `Scene`); where spheres
        leave nothing, by the real shapes. The list then has an attribute `undecided`: with real shapes, the width of
        what is forbidden for not having been decided, rad.

        Args:
            pose: wanted pose of the tip frame in the base frame.
            respect_limits: whether the joint limits have to be kept.
            scene: what must not be touched, the arm's own bodies included; nothing is looked at if not given.
            margin: what is to be left between any two bodies, m; it goes with a scene.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
            InvalidScene: no `Scene`, or no margin.
            NoBodies: no shapes of the arm are at hand.
        """
        return self._asked(scene, margin).intervals(pose, as_flag(respect_limits, "respect_limits"))

    def intervals_batch(
        self,
        poses: Any,
        threads: int | None = None,
        respect_limits: bool = True,
        *,
        scene: Scene | None = None,
        margin: float = 0.0,
    ) -> IntervalsBatch:
        """`intervals` for N poses at once, in compiled code on several threads; the answers are the same.

        Args:
            poses: (N, 4, 4) array, or a list of poses. Arrays of floats, in C order and writeable, are not copied.
            threads: at most so many; all processors if not given.
            respect_limits: whether the joint limits have to be kept.
            scene: what must not be touched, the arm's own bodies included; nothing is looked at if not given.
            margin: what is to be left between any two bodies, m; it goes with a scene.

        Returns:
            The intervals of all poses in flat arrays; `[i]` lists those of one pose.

        Raises:
            InvalidPose: a pose is no finite rigid transform; the message names the first one.
            InvalidConfiguration: `threads` is no positive integer.
            InvalidScene: no `Scene`, or no margin.
            NoBodies: no shapes of the arm are at hand.
        """
        return self._asked(scene, margin).intervals_batch(poses, as_flag(respect_limits, "respect_limits"), threads)

    def reachable_batch(self, poses: Any, threads: int | None = None) -> NDArray[np.bool_]:
        """Whether a posture inside the joint limits meets each of N poses: `intervals_batch` cut short at the first.

        Args:
            poses: (N, 4, 4) array, or a list of poses. Arrays of floats, in C order and writeable, are not copied.
            threads: at most so many; all processors if not given.

        Returns:
            (N,) true where there is one.

        Raises:
            InvalidPose: a pose is no finite rigid transform; the message names the first one.
            InvalidConfiguration: `threads` is no positive integer.
        """
        from srs_ik.solve.reachable import reachable_batch

        return reachable_batch(self.packed, poses, threads)

    def self_motion(
        self, pose: PoseLike, branch: int | None = None, count: int = 91, respect_limits: bool = True
    ) -> list[SelfMotion]:
        """How the arm can move while its tip stays: postures evenly spaced in arm angle through every interval.

        Args:
            pose: pose of the tip frame in the base frame.
            branch: 0 to 7 for the intervals of that branch alone.
            count: postures an interval, from end to end; 2 to 1,000,000. Those of a whole circle end where they begin.
            respect_limits: whether to stay inside the joint limits.

        Returns:
            One `SelfMotion` for each of `intervals`, in their order; empty where no posture reaches the pose.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
            InvalidConfiguration: no branch, or no count.
        """
        from srs_ik.solve.self_motion import self_motion

        return self_motion(self.packed, pose, branch, count, as_flag(respect_limits, "respect_limits"))

    def free_splits(self, pose: PoseLike, respect_limits: bool = True) -> list[FreeSplit]:
        """Where a singular pose fixes only the sum or the difference of two joints: the segments of postures there.

        They hang at single arm angles, at which the outer axes of the shoulder or of the wrist lie in one line within
        3e-11 rad. `intervals` and `self_motion` go past them with one split; `solve` and `optimise` choose the best.
        Where shoulder and wrist are singular at once, a segment of each is listed, and any two of them combine.

        Args:
            pose: pose of the tip frame in the base frame.
            respect_limits: whether to stay inside the joint limits; else each segment is a whole turn.

        Returns:
            The segments, of every turn of the sum that the limits allow; empty at ordinary poses, and on near limbs.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
        """
        from srs_ik.solve.free_splits import free_splits

        return free_splits(self.packed, pose, as_flag(respect_limits, "respect_limits"))

    def optimise(
        self,
        pose: PoseLike,
        objective: str | Callable[[Array], float] | Objective,
        respect_limits: bool = True,
        *,
        scene: Scene | None = None,
        margin: float = 0.0,
        **parameters: Any,
    ) -> Optimum:
        """The best posture of all that reach a pose: the global optimum over branches and arm angles.

        Args:
            pose: wanted pose of the tip frame in the base frame.
            objective: name of a built-in objective (see `Objective`), an `Objective`, or a function of 7 joint
                angles, rad, to be minimised (with `maximise=True`, maximised); joints that have several turns
                between their limits, 16 at most, are turned one after another to the best. With a scene also
                "clearance", the least distance of all pairs that are watched, m, which is maximised: by the spheres,
                and for pairs that the range of a joint watches by the bound that is known of their distance there.
            respect_limits: whether q has to keep the joint limits.
            scene: what must not be touched, the arm's own bodies included; nothing is looked at if not given.
            margin: what is to be left between any two bodies, m; it goes with a scene.
            **parameters: what the objective takes, such as force=, velocity=, twist=, wrench=, reference=, tolerance=.

        Returns:
            The posture, its value and the interval in which it lies; where no posture reaches the pose, the one that
            `solve` gives, with the same status.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
            InvalidTask: unknown objective, missing or malformed parameter, or a function that gave no finite number.
            InvalidScene: no `Scene`, or no margin.
            NoBodies: no shapes of the arm are at hand.
        """
        respect = as_flag(respect_limits, "respect_limits")
        return self._asked(scene, margin).optimise(pose, objective, respect, **parameters)

    # Tasks ------------------------------------------------------------------------------------------------------

    def collision(self, q: ArrayLike, scene: Scene, margin: float = 0.0) -> Collision | None:
        """Which two bodies meet, or come closer than a margin, at given joint angles, by their real shapes.

        Pairs that are not watched (see `pairs`) do not count, but for those that never meet inside the joint limits:
        outside of these, they may.

        Args:
            q: (7,) joint angles, rad, whether they keep the joint limits or not.
            scene: what stands around the arm; ``srs_ik.Scene()`` is the arm alone.
            margin: what is to be left between two bodies, m; added to the scene's own.

        Returns:
            The two that are closest, and how much is missing to the margin; None where nothing is.

        Raises:
            InvalidConfiguration: not 7 finite angles, or one beyond 1e6 rad.
            InvalidScene: no `Scene`, or no margin.
            NoBodies: no shapes of the arm are at hand.
        """
        return self._around(scene, margin).collision(q)

    def path_collisions(self, q: ArrayLike, scene: Scene, margin: float = 0.0) -> list[PathCollision]:
        """What is in the way of postures, and of the straight lines of joint angles from each to the next.

        A line that is not told of is free all along, proved on spheres or real shapes; one that is told of may yet be
        free where bodies come within the last thousandth of it as near as the margin.

        Args:
            q: (N, 7) joint angles, rad, as they are followed: no joint is turned by whole turns.
            scene: as for `collision`.
            margin: as for `collision`.

        Returns:
            The first thing found on each line, in order; empty where all is free.

        Raises:
            InvalidConfiguration: not N times 7 finite angles, or one beyond 1e6 rad.
            InvalidScene: no `Scene`, or no margin.
            NoBodies: no shapes of the arm are at hand.
        """
        return self._around(scene, margin).path_collisions(q)

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
            InvalidConfiguration: `threads` is no positive integer.
        """
        from srs_ik.solve.posture import posture

        return posture(self.packed, task, side, tie, threads)

    def solve_task(
        self,
        task: Task,
        side: Side = "left",
        respect_limits: bool = True,
        tie: Tie = "lower",
        threads: int | None = None,
        seed: ArrayLike | None = None,
        *,
        free_axis: ArrayLike | FreeAxis | str | None = None,
        scene: Scene | None = None,
        margin: float = 0.0,
    ) -> TaskSolution | BatchTaskSolution:
        """Joint angles for a task: its posture, on this arm's own axes and within its limits.

        The pose of the tip follows from the task and the axes of the hand. With the elbow where `posture` puts it, the
        branch nearest to the seed is taken, or the one farthest from the limits; where they forbid all, the elbow goes
        to the nearest feasible arm angle, and `angle_lost` says how far. Without a grasp direction the hand lines up
        with the forearm; without a pronosupination its roll is that of the seed, or leaves the wrist most room.

        In a scene the elbow goes to the nearest arm angle that is free, and where there is none a roll that was left
        free to another one.

        Args:
            task: one task, or N of them, for a `BatchTaskSolution`.
            side: "left" for the elbow towards +y of the base, "right" for -y.
            respect_limits: whether q has to keep the joint limits.
            tie: which elbow to take where one is above the other: "lower" or "upper".
            threads: at most so many for N tasks; all processors if not given.
            seed: (7,) posture to stay near, for all, or (N, 7), rad.
            free_axis: what of the hand's rotation is free, as for `solve`, if the task has grasp and pronosupination:
                the turn at which the plane of the arm comes closest to that of the task, `angle_lost` on top.
            scene: what must not be touched, the arm's own bodies included; nothing is looked at if not given.
            margin: what is to be left between any two bodies, m; it goes with a scene.

        Raises:
            InvalidTask: no `Task`, another side or tie, an arm whose hand is not known (see `load`), or a free axis and
                a hand whose rotation the task does not say.
            InvalidConfiguration: a malformed seed or number of threads.
            InvalidScene: no `Scene`, or no margin.
            NoBodies: no shapes of the arm are at hand.
        """
        asked, respect = self._asked(scene, margin), as_flag(respect_limits, "respect_limits")
        if free_axis is None:
            return asked.solve_task(task, side, respect, tie, threads, seed)
        from srs_ik.solve import free_task

        return free_task.solve_task(self.packed, asked, task, (side, respect, tie, threads), free_axis, seed)

    # Many configurations ----------------------------------------------------------------------------------------

    def forward_kinematics_batch(self, q: ArrayLike, threads: int | None = None) -> Array:
        """Poses (N, 4, 4) of the tip frame in the base frame, in compiled code on several threads.

        Args:
            q: (N, 7) joint angles, rad; an array of floats, in C order and writeable, is not copied.
            threads: at most so many; all processors if not given.

        Raises:
            InvalidConfiguration: not N times 7 finite angles, one beyond 1e6 rad, or a malformed number of threads.
        """
        return kinematics.forward_kinematics_batch(self.packed, q, threads)

    def jacobian_batch(self, q: ArrayLike, threads: int | None = None) -> Array:
        """Geometric Jacobians (N, 6, 7) of the tip point in base axes, as `jacobian` gives them one by one.

        Args:
            q: (N, 7) joint angles, rad; an array of floats, in C order and writeable, is not copied.
            threads: at most so many; all processors if not given.

        Raises:
            InvalidConfiguration: not N times 7 finite angles, one beyond 1e6 rad, or a malformed number of threads.
        """
        return kinematics.jacobian_batch(self.packed, q, threads)

    # Redundancy -------------------------------------------------------------------------------------------------

    def centres(self, q: ArrayLike) -> Centres:
        """Where the centres of shoulder, elbow and wrist are, in the base frame, m.

        The arm angle is the angle of their plane. On a near limb they are the points nearest to the joint axes that
        should meet there.

        Args:
            q: (7,) joint angles, rad, or (N, 7).

        Returns:
            Three points (3,), or arrays of them (N, 3).

        Raises:
            InvalidConfiguration: not 7 finite angles or N times 7, or one beyond 1e6 rad.
        """
        return kinematics.centres(self.packed, q)

    def arm_angle(self, q: ArrayLike) -> Any:
        """Arm angle, in [-pi, pi), rad, of a configuration (7,), rad; (N,) of N times 7.

        It is right-handed about the line from shoulder to wrist, and zero at `limb.reference`.

        Raises:
            InvalidConfiguration: not 7 finite angles or N times 7, or one beyond 1e6 rad.
        """
        return kinematics.arm_angle(self.packed, q)

    def branch(self, q: ArrayLike) -> Any:
        """Branch, 0 to 7, of a configuration (7,), rad; (N,) of N times 7.

        Raises:
            InvalidConfiguration: not 7 finite angles or N times 7, or one beyond 1e6 rad.
        """
        return kinematics.branch(self.packed, q)

    def arm_angle_jacobian(self, q: ArrayLike) -> Array:
        """Derivatives of the arm angle by the joint angles, (7,), rad/rad: its rate is ``arm_angle_jacobian(q) @ dq``.

        Below `jacobian` it makes a square matrix, ``np.vstack([arm.jacobian(q), arm.arm_angle_jacobian(q)])``, that is
        regular where the tip pose and the arm angle together determine the joint rates. All are zero where the arm
        angle has no derivative: with shoulder to wrist along `limb.reference` (to 1e-8 rad), with the wrist on the
        shoulder, and, on a near limb alone, with the elbow on the line between them (to a micrometre). Close to
        these places they grow without bound.

        Raises:
            InvalidConfiguration: not 7 finite angles, or one beyond 1e6 rad.

        Source: the derivative of the definition, for any axes; for perpendicular ones see K. Kreutz-Delgado, M. Long,
        H. Seraji, Kinematic Analysis of 7-DOF Manipulators, IJRR 11(5), 1992.
        """
        derivatives = np.empty(7)
        entries.arm_angle_jacobian(self.packed.family, as_bounded_joint_vector(q), derivatives)
        return derivatives

    def self_motion_tangent(self, q: ArrayLike) -> Array:
        """How the joints move with the arm angle while the tip stands still: dq/d(arm angle), (7,), rad/rad.

        Where `jacobian` with `arm_angle_jacobian` below it is regular, it is the last column of the inverse of that
        matrix; on an exact limb with a straight elbow, it is the motion that keeps that straight. All are zero where
        the arm angle has no derivative, and where the joints would have to move infinitely fast: with the outer axes of
        the shoulder or of the wrist in line. Close to these places they grow without bound.

        Raises:
            InvalidConfiguration: not 7 finite angles, or one beyond 1e6 rad.
        """
        derivatives = np.empty(7)
        entries.self_motion_tangent(self.packed.family, as_bounded_joint_vector(q), derivatives)
        return derivatives

    def solution_derivatives(self, q: ArrayLike) -> SolutionDerivatives:
        """How a solution changes with its pose and its arm angle: dq/d(pose) and dq/d(arm angle), analytic.

        They are the inverse of `jacobian` with `arm_angle_jacobian` below it, and do not exist where that is singular.

        Args:
            q: (7,) joint angles of a solution, inside its limits, rad.

        Returns:
            (7, 6) by a small motion of the tip, linear part first, the tip point in base axes; (7,) by the arm angle.

        Raises:
            InvalidConfiguration: not 7 finite angles, or one beyond 1e6 rad.
        """
        from srs_ik.solve.derivatives import solution_derivatives

        return solution_derivatives(self.jacobian(q), self.arm_angle_jacobian(q))

    # Tools and surroundings -------------------------------------------------------------------------------------

    def with_tool(self, T_tip_tool: PoseLike, name: str | None = None) -> Self:
        """This arm with a tool: poses are those of the tool's frame from then on. The arm itself stays as it is.

        Args:
            T_tip_tool: pose of the tool in the tip frame.
            name: name of the tool's frame; by default "tool", numbered where that is taken.

        Raises:
            InvalidPose: no finite rigid transform.
            InvalidRobot: the robot has a frame of that name already, or the transform leads farther away than 1e6 m.
        """
        T = as_rigid_matrix(T_tip_tool)
        hand = self.hand and Hand(*(tuple((T[:3, :3].T @ axis).tolist()) for axis in self.hand))
        return self._again(changes.with_tool(self._chain, T, name), self.limb.reference, hand)

    def with_base(self, T_newbase_base: PoseLike, name: str | None = None, gravity: ArrayLike | None = None) -> Self:
        """This arm in other surroundings: poses are given in their frame from then on. The arm itself stays as it is.

        The reference of the arm angle turns with the arm, so that every posture keeps its arm angle.

        Args:
            T_newbase_base: pose of the base frame in the new base frame, such as that of a table or a room.
            name: name of the new base frame; by default "world", numbered where that is taken.
            gravity: (3,) its acceleration in the new base frame, m/s^2. If not given, it turns with the arm: for one
                that hangs from the ceiling of a room, it is [0, 0, -9.81].

        Raises:
            InvalidPose: no finite rigid transform.
            InvalidRobot: the robot has a frame of that name already, or the transform leads farther away than 1e6 m.
            InvalidConfiguration: gravity is not 3 finite numbers.
        """
        T = as_rigid_matrix(T_newbase_base)
        g = None if gravity is None else as_gravity(gravity)
        return self._again(changes.on_base(self._chain, T, name, g), T[:3, :3] @ self.limb.reference, self.hand)

    def with_limits(
        self,
        lower: ArrayLike | None = None,
        upper: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        effort: ArrayLike | None = None,
        acceleration: ArrayLike | None = None,
    ) -> Self:
        """This arm with other limits, tighter or wider; those not given stay. The arm itself stays as it is.

        For limits of software, postures near a seed alone, or one branch of the elbow. Tools, bodies and what is held
        stay, too.

        Args:
            lower: (7,) lower limits of the joints, rad; -inf where there is none.
            upper: (7,) upper ones; inf where there is none.
            velocity: (7,) limits of velocity, rad/s; inf where there is none.
            effort: (7,) limits of torque, N m; inf where there is none.
            acceleration: (7,) limits of acceleration, rad/s^2, for trackers and paths of the least time that get no
                others; inf where there is none.

        Raises:
            InvalidRobot: limits are not seven numbers, a lower limit is above the upper one, or a velocity, effort or
                acceleration is not positive.
        """
        given = {"lower": lower, "upper": upper, "velocity": velocity, "effort": effort, "acceleration": acceleration}
        chain = changes.within_limits(self._chain, changes.by_joint(self.joint_names, given))
        return type(self)(chain, self.limb, self.name, self.hand, self.drawing, self.plan)

    def _again(self, chain: Chain, reference: Array, hand: Hand | None) -> Self:
        """This arm, made anew from a chain with the same joints."""
        found = recognise(chain.axes, chain.points, chain.T_base_tip_zero, reference)
        if found.limb is None:
            raise NotAnSrsLimb(f"moved, {self.name} is no S-R-S limb: {found.reason}", self.joint_names)
        return type(self)(chain, found.limb, self.name, hand, self.drawing, self.plan)

    def _planned(self, plan: BodyPlan, load: Any = None) -> Self:
        chain = self._chain if load is None else changes.with_load(self._chain, load)
        return type(self)(chain, self.limb, self.name, self.hand, self.drawing, plan)

    def _asked(self, scene: Scene | None, margin: float) -> InLimits | InScene:
        """Who answers questions: within the limits alone, or in a scene."""
        if scene is None:
            if type(margin) is not float or margin != 0.0:
                refuse_margin(margin)
            return self._in_limits
        return self._around(scene, margin)

    def _around(self, scene: Scene, margin: float) -> InScene:
        from srs_ik.solve.in_scene.questions import in_scene

        return in_scene(self, self.packed, scene, margin)

    def __reduce__(self) -> tuple[Any, ...]:
        # A copy is made anew, and packed anew: its arrays are read-only like the first ones, as its kernels want them.
        # A yourdfpy.URDF holds functions that cannot be pickled; such a copy of the arm is drawn as a skeleton.
        lasting = self.drawing is not None and isinstance(self.drawing.content, str | None)
        drawing = self.drawing if lasting else None
        return type(self), (self._chain, self.limb, self.name, self.hand, drawing, self.plan)

    def __repr__(self) -> str:
        kind = self.limb.kind
        return f"<Arm {self.name}: {self.base} to {self.tip}, {kind} S-R-S, wrist {self.limb.wrist_kind}>"
