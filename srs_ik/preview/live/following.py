"""`FollowingPreview`: a page on which a person drags the target, and the arm follows through a tracker."""

from __future__ import annotations

import html
import threading
import time
import weakref
from collections import deque
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.inputs.numbers import as_positive
from srs_ik.inputs.poses import PoseLike, as_rigid_matrix
from srs_ik.kinematics import check_arm
from srs_ik.preview import palette
from srs_ik.preview.live.live_page import LivePage
from srs_ik.preview.live.page import wxyz
from srs_ik.preview.surroundings import object_solids
from srs_ik.preview.words import STYLE, css, degrees
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.solve.tracker.step import TrackerStep
    from srs_ik.solve.tracker.tracker import Tracker

SHOWN = 8.0
"""Seconds that the strip chart shows."""

DRAWN_EVERY = 0.03
CHARTED_EVERY = 0.2
"""Seconds between two pictures of the arm, and of the chart."""


class FollowingPreview(LivePage):
    """A page with a target to drag, which the arm follows within its limits, served to this machine alone.

    A strip chart shows each joint's velocity as a share of its limit over the last 8 s, a text the tracker's status.
    The objects of a scene are drawn where they are at first.

    Args:
        arm: the arm.
        q: (7,) joint angles to begin with, rad; by default the arm is bent in the middle of its ranges.
        dt: seconds between two updates of the tracker.
        package_dirs: a folder, or several, to search for meshes before all others.
        port: of the page; 0 for any that is free.
        **options: of `Arm.tracker`, such as `scene`, before which the arm stops.

    Attributes:
        arm: the arm.
        tracker: what follows.
        missing: one clause for every shape of the robot that could not be drawn.

    Raises:
        InvalidConfiguration: q is not 7 finite angles, or an option is malformed.
        InvalidRobot: the file that the arm was loaded from is gone, or is no URDF any more; or there is no such folder.
        MissingExtra: viser is not installed.
        MissingLimits: a joint has no velocity limit.
        PreviewError: the port is taken, or there is none of this number.
    """

    def __init__(
        self,
        arm: Arm,
        q: ArrayLike | None = None,
        dt: float = 0.01,
        package_dirs: str | Path | Sequence[str | Path] = (),
        port: int = 0,
        **options: Any,
    ) -> None:
        check_arm(arm)
        start = _resting(arm) if q is None else q
        as_positive(dt, "dt", "seconds")
        self.tracker: Tracker = arm.tracker(start, dt, **options)
        super().__init__(arm, package_dirs, port)
        if self.tracker.scene is not None:
            for name, found in object_solids(self.tracker.scene).items():
                self._canvas.draw(f"scene/{name}", found)
        self._times: deque[float] = deque(maxlen=max(round(SHOWN / CHARTED_EVERY), 2))
        self._shares: deque[Array] = deque(maxlen=self._times.maxlen)
        self._peak = np.zeros(7)
        self._ended = threading.Event()
        T = arm.forward_kinematics(self.tracker.q).homogeneous
        self._handles.position, self._handles.wxyz = T[:3, 3], wxyz(T[:3, :3])
        self._step = self.tracker.update(T)
        self._place_joints(self._step.q)
        self._add_controls()
        self._look_at_all()
        self._thread = threading.Thread(target=_follow, args=(weakref.ref(self),), daemon=True)
        self._thread.start()

    @property
    def step(self) -> TrackerStep:
        """The tracker's last answer."""
        return self._step

    def show(self, pose: PoseLike) -> None:
        """Put the target somewhere.

        Args:
            pose: of the tip in the base frame.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
            PreviewError: the preview is closed.
        """
        T = as_rigid_matrix(pose)
        with self._lock:
            self._refuse_closed()
            self._handles.position, self._handles.wxyz = T[:3, 3], wxyz(T[:3, :3])

    def close(self) -> None:
        """End the page and free its port; a second time does nothing."""
        self._ended.set()
        self._thread.join(timeout=2.0)
        super().close()

    # --------------------------------------------------------------------------------------------------------------

    def _add_controls(self) -> None:
        import viser.uplot as uplot

        self._text = self._gui.add_html("")
        series = [uplot.Series(label="s")]
        series += [
            uplot.Series(label=name, stroke=css(palette.BRANCHES[k]), width=2)
            for k, name in enumerate(self.arm.joint_names)
        ]
        self._chart = self._gui.add_uplot(
            self._table(),
            tuple(series),
            title="joint velocity / limit",
            scales={"x": uplot.Scale(time=False), "y": uplot.Scale(range=(-1.05, 1.05))},
            aspect=1.4,
            legend=uplot.Legend(show=False),
        )
        self._button = self._gui.add_button("reconfigure")
        self._button.on_click(self._answer(self._reconfigure))
        self._inbox.expect(self._button._impl.uuid, lambda value: value is True)
        self._say()

    def _table(self) -> tuple[Array, ...]:
        """Columns of the chart: seconds, and the share that each joint uses."""
        if not self._times:
            return tuple(np.zeros(2) for _ in range(8))
        shares = np.array(self._shares)
        return np.array(self._times), *np.ascontiguousarray(shares.T)

    def _reconfigure(self) -> None:
        self.tracker.reconfigure(self.target)

    def _advance(self) -> None:
        """One period of the tracker."""
        with self._lock:
            self._step = self.tracker.update(self.target)
        share = self._step.velocity / self.tracker.velocity_limit
        self._peak = np.where(np.abs(share) > np.abs(self._peak), share, self._peak)

    def _chart_on(self, now: float) -> None:
        """The chart and the text, a while on."""
        self._times.append(now)
        self._shares.append(self._peak)
        self._peak = np.zeros(7)
        with self._server.atomic():
            self._chart.data = self._table()
            self._say()

    def _say(self) -> None:
        step = self._step
        rows = "".join(
            f"<tr><td><span style='color: {css(palette.BRANCHES[k])}'>&#9679;</span> {html.escape(name)}</td>"
            f"<td align=right>{degrees(angle)}</td></tr>"
            for k, (name, angle) in enumerate(step.as_dict().items())
        )
        self._text.content = (
            f"<div style='{STYLE}'><p><b>{step.status}</b></p><p>{html.escape(step.message)}</p>"
            f"<table width='100%'><tr><th align=left>joint</th><th align=right>deg</th></tr>{rows}</table></div>"
        )


def _resting(arm: Arm) -> Array:
    from srs_ik.preview.robot import resting

    return resting(arm)


def _follow(page: weakref.ref[FollowingPreview]) -> None:
    """Take the tracker of a page on, a period at a time, while there is that page."""
    began = due = time.perf_counter()
    drawn = charted = -1.0
    while True:
        follower = page()
        if follower is None or follower._ended.is_set() or follower.closed:
            return
        follower._advance()
        now = time.perf_counter()
        if now - drawn > DRAWN_EVERY:
            drawn = now
            with follower._server.atomic():
                follower._place_joints(follower.step.q)
        if now - charted > CHARTED_EVERY:
            charted = now
            follower._chart_on(now - began)
        due = max(due + follower.tracker.dt, now - 1.0)
        del follower
        time.sleep(max(due - time.perf_counter(), 0.0))
