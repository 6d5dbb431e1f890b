"""`LivePage`: a page that answers, with an arm and a target on it, served to this machine alone."""

from __future__ import annotations

import atexit
import threading
import weakref
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.errors import PreviewError
from srs_ik.inputs.angles import as_joint_vector
from srs_ik.kinematics import check_arm
from srs_ik.preview import solids
from srs_ik.preview.live.page import PageCanvas, rotation, serve, stop
from srs_ik.preview.robot import Stage, limb, look, reach, resting
from srs_ik.preview.words import title
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.arm import Arm

_TARGET = "/scene/target"
_CAMERA = np.array([1.4, -0.95, 0.6])
"""From the centre of what is seen to the camera, in units of its radius."""


class LivePage:
    """What all pages that answer have: the arm, a target with handles, an address, an end.

    Attributes:
        arm: the arm.
        missing: one clause for every shape of the robot that could not be drawn.
    """

    def __init__(self, arm: Arm, package_dirs: str | Path | Sequence[str | Path], port: int) -> None:
        check_arm(arm)
        self.arm = arm
        parts, self.missing = look(arm, package_dirs)
        self._lock = threading.RLock()
        self._settling = False
        self._server, self._door, self._inbox = serve(port, title(arm))
        self._close = weakref.finalize(self, stop, self._server)
        # Registered after viser's own end at exit, it comes before that, which prints.
        self._close.atexit = False
        atexit.register(self._close)
        self._stage = Stage.of(arm, parts)
        self._canvas = PageCanvas(self._server, self._stage.R_scene_base)
        for k in range(8):
            carried = [p.solid for p in parts if p.joint == k] + [p.solid for p in limb(arm) if p.joint == k]
            self._canvas.draw(f"joint {k}", carried)
        self._canvas.draw("base frame", solids.triad(0.16 * reach(arm)))
        # Without types: viser's own hide that values can be set.
        self._gui: Any = self._server.gui
        self._handles = self._server.scene.add_transform_controls(_TARGET, scale=0.3 * reach(arm))
        self._inbox.expect_pose(_TARGET)

    @property
    def url(self) -> str:
        """Address of the page, on this machine alone; whoever has it can move the target."""
        return self._door.url

    @property
    def closed(self) -> bool:
        """Whether the page is gone."""
        return not self._close.alive

    def close(self) -> None:
        """End the page and free its port, once nothing is being shown; a second time does nothing."""
        atexit.unregister(self._close)
        with self._lock:
            open_still = self._close.detach() is not None
        # Without the lock: who waits for it on the page is told that this is closed, and viser may wait for these.
        if open_still:
            stop(self._server)

    @property
    def target(self) -> Array:
        """(4, 4) pose of the target in the base frame."""
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = rotation(self._handles.wxyz), self._handles.position
        return T

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self.arm.name}, {'closed' if self.closed else 'at ' + self.url}>"

    def _start(self, q: ArrayLike | None) -> Array:
        return resting(self.arm) if q is None else as_joint_vector(q)

    def _refuse_closed(self) -> None:
        if self.closed:
            raise PreviewError("the preview is closed: make a new one")

    def _place_joints(self, q: Array) -> None:
        for k, T_base_joint in enumerate(self.arm.joint_frames(q)):
            self._canvas.place(f"joint {k}", T_base_joint)

    def _look_at_all(self) -> None:
        """Point the camera at what there is, on a floor."""
        centre, radius = self._canvas.extent.sphere()
        self._server.scene.add_grid(
            "/floor",
            4.0 * radius,
            4.0 * radius,
            cell_size=0.1,
            section_size=0.5,
            position=(0.0, 0.0, self._stage.floor),
        )
        seen = self._stage.R_scene_base @ centre
        self._server.initial_camera.position = seen + radius * _CAMERA
        self._server.initial_camera.look_at = seen

    def _answer(self, act: Callable[[], None]) -> Callable[[Any], None]:
        """A callback that acts on what the page says now, unless it is this program that has just said so."""

        def callback(event: Any) -> None:
            with self._lock:
                if not (self._settling or self.closed):
                    act()

        return callback
