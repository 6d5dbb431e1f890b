"""`InteractivePreview`: a page on which a person moves the target and the elbow, and sees the arm follow."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from srs_ik.inputs.angles import as_arm_angle, as_joint_vector, as_seed
from srs_ik.inputs.poses import PoseLike, as_rigid_matrix
from srs_ik.preview.circle import arc_solids, circle_solids
from srs_ik.preview.live.inbox import FARTHEST, number, numbers
from srs_ik.preview.live.live_page import LivePage
from srs_ik.preview.live.page import wxyz
from srs_ik.preview.words import report, span
from srs_ik.robot.description.from_yourdfpy import roll_pitch_yaw
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.solve.intervals import Interval
    from srs_ik.solve.solution import Solution

_NOTHING = "no posture"
_PALE = 0.3
"""Opacity of the arcs of the branches that are not chosen."""


class InteractivePreview(LivePage):
    """A page with the target, the branch and the arm angle of an arm to play with, served to this machine alone.

    The target is moved by its handles or its figures; the list holds every interval of feasible arm angles, and the
    slider runs from one end of the chosen one to the other, so the posture keeps the joint limits. Where the target
    cannot be reached, the closest posture is shown, and the page says why.

    Args:
        arm: the arm.
        q: (7,) joint angles to begin with, rad; by default the arm is bent in the middle of its ranges.
        package_dirs: a folder, or several, to search for meshes before all others.
        port: of the page; 0 for any that is free.

    Attributes:
        arm: the arm.
        missing: one clause for every shape of the robot that could not be drawn.

    Raises:
        InvalidConfiguration: q is not 7 finite angles.
        InvalidRobot: the file that the arm was loaded from is gone, or is no URDF any more; or there is no such folder.
        MissingExtra: viser is not installed.
        PreviewError: the port is taken, or there is none of this number.
    """

    def __init__(
        self, arm: Arm, q: ArrayLike | None = None, package_dirs: str | Path | Sequence[str | Path] = (), port: int = 0
    ) -> None:
        start = None if q is None else as_joint_vector(q)
        super().__init__(arm, package_dirs, port)
        self._intervals: list[Interval] = []
        self._shown: tuple[bytes, int] | None = None
        self._add_controls()
        start = self._start(start)
        self.show(arm.forward_kinematics(start), seed=start)
        self._look_at_all()
        # What has to be compiled for the slider is compiled now, and not when somebody moves it.
        arm.solve(self.target, arm_angle=0.0, branch=0)

    @property
    def solution(self) -> Solution:
        """The posture that is shown."""
        return self._solution

    def show(self, pose: PoseLike, arm_angle: float | None = None, seed: ArrayLike | None = None) -> Solution:
        """Put the target somewhere, and show a posture there.

        Args:
            pose: of the tip in the base frame.
            arm_angle: of the posture, rad; any if not given.
            seed: (7,) posture to stay near, rad; by default the one that is shown.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
            InvalidConfiguration: the arm angle or the seed are malformed.
            PreviewError: the preview is closed.
        """
        T = as_rigid_matrix(pose)
        psi = None if arm_angle is None else as_arm_angle(arm_angle)
        near = self._solution.q if seed is None else as_seed(seed, self.arm.lower, self.arm.upper)
        with self._lock:
            self._refuse_closed()
            self._aim(T, psi, near)
            return self._solution

    # --------------------------------------------------------------------------------------------------------------

    def _add_controls(self) -> None:
        gui = self._gui
        self._list = gui.add_dropdown("interval", (_NOTHING,))
        self._slider = gui.add_slider("arm angle (deg)", -180.0, 180.0, 0.01, 0.0)
        ends: Any = {"min": (-FARTHEST,) * 3, "max": (FARTHEST,) * 3}
        self._xyz = gui.add_vector3("target (m)", (0.0, 0.0, 0.0), step=0.005, **ends)
        self._rpy = gui.add_vector3("rpy (deg)", (0.0, 0.0, 0.0), step=1.0)
        self._text = gui.add_html("")
        self._handles.on_update(self._answer(self._target_dragged))
        self._list.on_update(self._answer(self._interval_chosen))
        self._slider.on_update(self._answer(self._turn))
        for figures in (self._xyz, self._rpy):
            figures.on_update(self._answer(self._figures_typed))
        self._inbox.expect(self._list._impl.uuid, lambda value: value in self._list.options)
        self._inbox.expect(self._slider._impl.uuid, number)
        self._inbox.expect(self._xyz._impl.uuid, lambda value: numbers(value, 3, FARTHEST))
        self._inbox.expect(self._rpy._impl.uuid, lambda value: numbers(value, 3))

    def _target_dragged(self) -> None:
        self._aim(self.target, None, self._solution.q)

    def _figures_typed(self) -> None:
        T = np.eye(4)
        T[:3, :3] = pin.rpy.rpyToMatrix(np.deg2rad(self._rpy.value))
        T[:3, 3] = self._xyz.value
        self._aim(T, None, self._solution.q)

    def _aim(self, T: Array, psi: float | None, near: Array) -> None:
        """Take a target: its intervals, and the posture nearest to another one."""
        self._intervals = self.arm.intervals(T)
        self._solution = self.arm.solve(T, arm_angle=psi, seed=near)
        # Any posture of the pose says where the circle is.
        self._anywhere = self.arm.solve(T, respect_limits=False).q
        self._settle(T)

    def _interval_chosen(self) -> None:
        interval = self._chosen()
        if interval is not None:
            self._solve(interval, 0.5 * (interval.lower + interval.upper))

    def _turn(self) -> None:
        interval = self._chosen()
        if interval is not None:
            self._solve(interval, np.deg2rad(self._slider.value))

    def _chosen(self) -> Interval | None:
        """The interval that the list names; none if it was one of another target."""
        return next(
            (i for i, name in zip(self._intervals, self._names(), strict=False) if name == self._list.value), None
        )

    def _solve(self, interval: Interval, psi: float) -> None:
        # Just inside: the slider's ends are rounded, and at the very end a joint is on its limit.
        margin = min(1e-9, 0.25 * interval.width)
        inside = min(max(psi, interval.lower + margin), interval.upper - margin)
        # In the turns of the posture that is shown: a robot may follow.
        before = self._solution.q
        self._solution = self.arm.solve(self.target, arm_angle=inside, branch=interval.branch, seed=before)
        self._settle(self.target)

    def _settle(self, T: Array) -> None:
        """Bring the page in line with the target, its intervals and the posture."""
        self._settling = True
        try:
            with self._server.atomic():
                self._settle_controls(T)
                self._draw()
        finally:
            self._settling = False

    def _settle_controls(self, T: Array) -> None:
        # What is as it should be is left alone: it may be in somebody's hand.
        if np.abs(self.target - T).max() > 1e-9:
            self._handles.position, self._handles.wxyz = T[:3, 3], wxyz(T[:3, :3])
        _turn_to(self._xyz, T[:3, 3])
        _turn_to(self._rpy, np.rad2deg(roll_pitch_yaw(T[:3, :3])))
        names = self._names()
        if self._list.options != names:
            self._list.options = names
        solution = self._solution
        chosen = next((k for k, interval in enumerate(self._intervals) if _holds(interval, solution)), None)
        self._slider.disabled = self._list.disabled = chosen is None
        if chosen is not None:
            interval = self._intervals[chosen]
            self._list.value = names[chosen]
            lower, upper = (float(angle) for angle in np.rad2deg([interval.lower, interval.upper]))
            turn = interval.lower + (solution.arm_angle - interval.lower) % (2.0 * np.pi)
            if (self._slider.min, self._slider.max) != (lower, upper):
                self._slider.min, self._slider.max = lower, upper
                self._slider.step = float(np.clip((upper - lower) / 400.0, 1e-6, 0.5))
            if abs(self._slider.value - np.rad2deg(turn)) > 1e-3:
                self._slider.value = float(min(np.rad2deg(turn), upper))
        self._text.content = report(solution, self._intervals)

    def _names(self) -> tuple[str, ...]:
        return tuple(map(span, self._intervals)) or (_NOTHING,)

    def _draw(self) -> None:
        q = self._solution.q
        self._place_joints(q)
        shown = (self.target.tobytes(), self._solution.branch)
        if shown != self._shown:
            self._shown = shown
            self._draw_circle()

    def _draw_circle(self) -> None:
        self._canvas.draw("elbow circle", circle_solids(self.arm, self._anywhere))
        arcs = arc_solids(self.arm, self._anywhere, self._intervals)
        for branch in range(8):
            pieces = arcs.get(branch, [])
            if branch != self._solution.branch:
                pieces = [piece.faded(piece.colour, _PALE) for piece in pieces]
            self._canvas.draw(f"branch {branch}", pieces)


def _turn_to(figures: Any, values: Array) -> None:
    """Write figures into their fields if they say something else."""
    if np.abs(np.asarray(figures.value) - values).max() > 1e-6:
        figures.value = tuple(float(value) for value in values)


def _holds(interval: Interval, solution: Solution) -> bool:
    return bool(solution) and interval.branch == solution.branch and solution.arm_angle in interval
