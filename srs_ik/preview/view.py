"""`Preview`: an arm and what its answers mean, in a browser or in one file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from srs_ik.errors import InvalidScene, quoted
from srs_ik.inputs.angles import as_joint_vector
from srs_ik.inputs.poses import PoseLike, as_rigid_matrix
from srs_ik.kinematics import check_arm
from srs_ik.preview import marks, palette, solids, words
from srs_ik.preview.circle import arc_solids, circle_solids
from srs_ik.preview.document import Caption
from srs_ik.preview.motion import FPS, film, self_motion
from srs_ik.preview.robot import Part, Stage, limb, look, reach, resting
from srs_ik.preview.still import StillPage
from srs_ik.preview.surroundings import body_solids, forbidden, object_solids
from srs_ik.preview.words import Entry
from srs_ik.solve.in_scene.surroundings import Surroundings
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.collision.scenes.scene import Scene
    from srs_ik.inputs.task import Task
    from srs_ik.solve.intervals import Interval
    from srs_ik.solve.posture import Posture

_GHOST_OPACITY = 0.22


class Preview(StillPage):
    """An arm in Meshcat, served to the browsers of this machine alone.

    Every `show` method draws its own part of the scene, in place of what it drew before, and leaves the rest. The page
    lives as long as the object, at most as long as the program; `close`, or a `with` block, ends it earlier.

    Args:
        arm: the arm; it is shown in the middle of its ranges, the elbow bent, until `show` says otherwise.
        package_dirs: a folder, or several, to search for meshes first: packages, or folders that hold packages.
        port: of the page; 0 for any that is free.

    Attributes:
        arm: the arm.
        missing: one clause for every shape of the robot that could not be drawn, such as a mesh that is not found.

    Raises:
        InvalidRobot: the file that the arm was loaded from is gone, or is no URDF any more; or there is no such folder.
        PreviewError: the port is taken, or there is none of this number.
    """

    def __init__(self, arm: Arm, package_dirs: str | Path | Sequence[str | Path] = (), port: int = 0) -> None:
        check_arm(arm)
        parts, self.missing = look(arm, package_dirs)
        super().__init__(arm, port)
        self._size = reach(arm)
        self._robot = parts
        self._q = resting(arm)
        self._draw_robot("robot", parts)
        self._draw_robot("limb", limb(arm))
        for k in range(8):
            self._canvas.place(f"tip/joint {k}", np.eye(4))
        self._canvas.draw("base frame", solids.triad(0.16 * self._size))
        self._canvas.draw("tip/joint 7/frame", solids.triad(0.12 * self._size), self._T_joint7_tip())
        self._stage = Stage.of(arm, parts)
        self._legend: dict[str, list[Entry]] = {}
        self._around: tuple[Scene, float] | None = None
        self.show(self._q)

    @property
    def q(self) -> Array:
        """(7,) the configuration that is shown, rad; of a motion, its first."""
        return self._q.copy()

    # The arm -----------------------------------------------------------------------------------------------------

    def show(self, q: ArrayLike) -> None:
        """Show the arm at a configuration, with the circle of its elbow; a motion ends.

        Args:
            q: (7,) joint angles, rad; inside the limits or not.

        Raises:
            InvalidConfiguration: not 7 finite angles.
            PreviewError: the preview is closed.
        """
        self._q = as_joint_vector(q)
        self._canvas.halt()
        for k, T_base_joint in enumerate(self.arm.joint_frames(self._q)):
            for group in ("robot", "limb", "tip"):
                self._canvas.place(f"{group}/joint {k}", T_base_joint)
        self._canvas.draw("elbow circle", circle_solids(self.arm, self._q))
        self._draw_bodies()
        self._posture = f"arm angle {words.degrees(self.arm.arm_angle(self._q))} deg, branch {self.arm.branch(self._q)}"
        self._settle()

    def show_target(self, pose: PoseLike) -> None:
        """Show a pose of the tip as a frame.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
            PreviewError: the preview is closed.
        """
        self._canvas.draw("target", solids.triad(0.18 * self._size), as_rigid_matrix(pose))
        self._settle()

    def show_intervals(
        self, pose: PoseLike, respect_limits: bool = True, *, scene: Scene | None = None, margin: float = 0.0
    ) -> list[Interval]:
        """Show the feasible arm angles of a pose as arcs around the circle of the elbow, a colour for each branch.

        With a scene, they are the free ones, and those at which bodies meet are thin dark arcs.

        Args:
            pose: pose of the tip frame in the base frame.
            respect_limits: whether the joint limits have to be kept.
            scene: what must not be touched, the arm's own bodies included; nothing is looked at if not given.
            margin: what is to be left between any two bodies, m.

        Returns:
            The intervals; none, and nothing is drawn, where no posture reaches the pose.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
            InvalidScene: no `Scene`, or no margin.
            NoBodies: no shapes of the arm are at hand.
            PreviewError: the preview is closed.
        """
        T = as_rigid_matrix(pose)
        intervals = self.arm.intervals(T, respect_limits, scene=scene, margin=margin)
        taken = [] if scene is None else forbidden(self.arm.intervals(T, respect_limits), intervals)
        self._canvas.erase("intervals")
        self.show_target(T)
        if intervals or taken:
            q = self.arm.solve(T, respect_limits=False).q
            for branch, arcs in arc_solids(self.arm, q, intervals, taken).items():
                self._canvas.draw(f"intervals/branch {branch}", arcs)
        legend = words.branches(interval.branch for interval in intervals)
        self._settle("intervals", [*legend, words.TAKEN] if taken else legend)
        return intervals

    def show_scene(self, scene: Scene, margin: float = 0.0) -> None:
        """Show the objects of a scene, and the arm's bodies in the colour of their clearance, also as the arm moves.

        Red bodies are at the margin or beyond it, green ones 0.1 m and more away from it. Half-spaces are not drawn.

        Args:
            scene: what must not be touched.
            margin: what is to be left between any two bodies, m.

        Raises:
            InvalidScene: no `Scene`, or no margin.
            NoBodies: no shapes of the arm are at hand.
            PreviewError: the preview is closed.
        """
        Surroundings(self.arm, self.arm.packed, scene, margin)
        self._around = scene, scene.margin + margin
        self._canvas.erase("scene")
        for name, found in object_solids(scene).items():
            self._canvas.draw(f"scene/{name}", found)
        self._draw_bodies()
        self._settle("scene", words.CLEARANCES)

    def _draw_bodies(self) -> None:
        """The bodies in the colour of their clearance, where a scene is shown."""
        if self._around is not None:
            scene, margin = self._around
            self._canvas.erase("bodies")
            for name, found in body_solids(self.arm, scene, self._q, margin).items():
                self._canvas.draw(f"bodies/{name}", found)

    def show_ghosts(self, pose: PoseLike, respect_limits: bool = True) -> int:
        """Show one posture of every other branch that reaches a pose, as pale copies of the arm.

        Returns:
            How many.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
            PreviewError: the preview is closed.
        """
        T = as_rigid_matrix(pose)
        shown = self.arm.branch(self._q)
        others = {s.branch: s.q for s in self.arm.solve_all(T, respect_limits=respect_limits) if s.branch != shown}
        self._canvas.erase("ghosts")
        pale = [
            Part(part.joint, part.solid.faded(palette.GHOST, _GHOST_OPACITY)) for part in self._robot if part.joint > 0
        ]
        for branch, q in others.items():
            self._draw_robot(f"ghosts/branch {branch}", pale)
            for k, T_base_joint in enumerate(self.arm.joint_frames(q)):
                self._canvas.place(f"ghosts/branch {branch}/joint {k}", T_base_joint)
        self._settle("ghosts", [(palette.GHOST, f"{len(others)} other branches")] if others else [])
        return len(others)

    # Motion ------------------------------------------------------------------------------------------------------

    def show_self_motion(self, pose: PoseLike, branch: int | None = None, respect_limits: bool = True) -> bool:
        """Show how the arm can move while its tip stays: through its widest interval of arm angles, and back.

        Args:
            pose: pose of the tip in the base frame.
            branch: 0 to 7 to stay in that branch; by default the one with the widest interval.
            respect_limits: whether to stay inside the joint limits.

        Returns:
            Whether there is any posture to show; the intervals are drawn in any case.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
            InvalidConfiguration: no branch.
            PreviewError: the preview is closed.
        """
        T = as_rigid_matrix(pose)
        intervals = self.show_intervals(T, respect_limits)
        found = self_motion(self.arm, T, intervals, branch, respect_limits)
        if found is None:
            return False
        frames, widest = found
        self.show(frames[0])
        self._posture = f"arm angle in {words.span(widest)}"
        self._play(frames, FPS, repeat=True)
        return True

    def animate(self, path: Any, dt: float | None = None, repeat: bool = True) -> None:
        """Show a joint path as a motion.

        Args:
            path: (N, 7) joint angles, rad, the `PathSolution` of `Arm.solve_path`, or its `Trajectory`.
            dt: time between two samples, seconds. Without it, a path is shown at its own times, those of
                `objective="time"` or of its `dt`; a trajectory always is.
            repeat: whether it starts again at its end.

        Raises:
            InvalidConfiguration: not N x 7 finite angles with N > 0, dt is no positive number, or missing where the
                path has no times of its own, or there beside a trajectory.
            PreviewError: the preview is closed.
        """
        frames, fps = film(path, dt)
        self.show(frames[0])
        if len(frames) > 1:
            self._canvas.erase("elbow circle")
            self._posture = f"a path of {len(frames) / fps:.1f} s"
            self._play(frames, fps, repeat)

    # What an answer means ----------------------------------------------------------------------------------------

    def show_obstacles(self, meshes: Sequence[trimesh.Trimesh]) -> None:
        """Show what stands around the arm.

        Args:
            meshes: triangles in the base frame, m; none to show nothing.

        Raises:
            InvalidScene: it is no list of meshes.
            PreviewError: the preview is closed.
        """
        if not isinstance(meshes, Sequence) or not all(isinstance(mesh, trimesh.Trimesh) for mesh in meshes):
            raise InvalidScene(f"obstacles are a list of trimesh.Trimesh, not {quoted(meshes)}")
        self._canvas.draw("obstacles", [solids.Solid(mesh, palette.OBSTACLE, 0.75) for mesh in meshes])
        self._settle()

    def show_posture(self, posture: Posture, task: Task | None = None) -> None:
        """Show a posture of `Arm.posture` as sticks, and the task that it is for.

        Args:
            posture: one posture, not N of them.
            task: its task, shown as a plane with velocity (blue), force (red), grasp (green) and the normal (violet).

        Raises:
            InvalidTask: it is N postures or tasks, or none.
            PreviewError: the preview is closed.
        """
        marks.check_single(posture, task)
        self._canvas.draw("posture", marks.posture_solids(posture, 0.012 * self._size))
        self._canvas.erase("task")
        if task is not None:
            self._canvas.draw("task", marks.task_solids(task, posture.task_normal, 0.25 * self._size))
        self._settle("posture", [(palette.POSTURE, "posture")])
        self._settle("task", marks.TASK_LEGEND if task is not None else [])

    def show_ellipsoids(
        self, q: ArrayLike, part: Literal["linear", "angular"] = "linear", limits: bool = False
    ) -> None:
        """Show the arm at a configuration with its velocity (blue) and force ellipsoid (red) at the tip.

        Both are scaled to the size of the arm: what their shapes and directions say is to be seen, not their units.
        A direction in which any force is held is drawn twice as long as the largest force that has a bound.

        Args:
            q: (7,) joint angles, rad.
            part: the linear or the angular ellipsoids.
            limits: weigh the joints by the velocity and effort limits of the arm.

        Raises:
            InvalidConfiguration: not 7 finite angles.
            InvalidTask: no such part.
            MissingLimits: the limits are wanted and not given.
            PreviewError: the preview is closed.
        """
        from srs_ik.analysis.ellipsoids import force_ellipsoid, velocity_ellipsoid

        marks.check_part(part)
        q = as_joint_vector(q)
        J, tip = self.arm.jacobian(q), self.arm.forward_kinematics(q).translation
        velocity = velocity_ellipsoid(J, self.arm.velocity_limit if limits else None, part)
        force = force_ellipsoid(J, self.arm.effort_limit if limits else None, part)
        self.show(q)
        size = 0.24 * self._size
        self._canvas.draw("velocity", marks.ellipsoid_solids(velocity, tip, size, palette.VELOCITY))
        self._canvas.draw("force", marks.ellipsoid_solids(force, tip, size, palette.FORCE))
        self._settle("velocity", marks.measures(part, "ellipsoid"))

    def show_polytopes(self, q: ArrayLike, part: Literal["linear", "angular"] = "linear") -> None:
        """Show the arm at a configuration with the polytopes of velocity (blue) and force (red) that its limits allow.

        Each is scaled to the size of the arm.

        Args:
            q: (7,) joint angles, rad.
            part: the linear or the angular polytopes.

        Raises:
            InvalidConfiguration: not 7 finite angles.
            InvalidTask: no such part.
            MissingLimits: the robot gives no velocity or effort limits.
            MissingExtra: the library that computes polytopes is not installed.
            PreviewError: the preview is closed.
        """
        from srs_ik.analysis.polytopes import force_polytope, velocity_polytope

        marks.check_part(part)
        q = as_joint_vector(q)
        tip = self.arm.forward_kinematics(q).translation
        found = {
            "velocity polytope": (velocity_polytope(self.arm, q, part), palette.VELOCITY),
            "force polytope": (force_polytope(self.arm, q, part), palette.FORCE),
        }
        self.show(q)
        for name, (polytope, colour) in found.items():
            self._canvas.draw(name, marks.polytope_solids(polytope, tip, 0.35 * self._size, colour))
        self._settle("velocity polytope", marks.measures(part, "polytope"))

    def clear(self) -> None:
        """Remove all but the robot."""
        self._canvas.halt()
        for name in _EXTRAS:
            self._canvas.erase(name)
        self._legend.clear()
        self._around = None
        self._canvas.fit(self._stage, closer=True)
        self._settle()

    # --------------------------------------------------------------------------------------------------------------

    def _settle(self, name: str | None = None, legend: Sequence[Entry] = ()) -> None:
        """Bring what is drawn into view and say what it is; under a name, what its colours stand for."""
        if name is not None:
            self._legend[name] = list(legend)
        self._canvas.fit(self._stage)
        entries = [entry for part in self._legend.values() for entry in part]
        self._canvas.tell(Caption(words.title(self.arm), [self._posture], entries))

    def _draw_robot(self, group: str, parts: Sequence[Part]) -> None:
        for k in range(8):
            self._canvas.draw(f"{group}/joint {k}", [part.solid for part in parts if part.joint == k])

    def _play(self, frames: Array, fps: float, repeat: bool) -> None:
        T = np.stack([self.arm.joint_frames(q) for q in frames])
        moving = {f"{group}/joint {k}": T[:, k] for group in ("robot", "limb", "tip") for k in range(1, 8)}
        self._canvas.animate(moving, fps, repeat)
        self._settle()

    def _T_joint7_tip(self) -> Array:
        T_base_joint7 = self.arm.joint_frames(np.zeros(7))[7]
        return np.linalg.inv(T_base_joint7) @ self.arm.limb.T_base_tip_zero


_EXTRAS = (
    "scene",
    "bodies",
    "target",
    "intervals",
    "ghosts",
    "posture",
    "task",
    "velocity",
    "force",
    "velocity polytope",
    "force polytope",
    "reach",
    "yaw arcs",
    "obstacles",
)
