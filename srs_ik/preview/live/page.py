"""Drawing on a page of viser, which unlike Meshcat's has sliders that answer to this program."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from srs_ik.errors import MissingExtra, PreviewError
from srs_ik.preview.door import HOST, Door, as_port
from srs_ik.preview.extent import Extent
from srs_ik.preview.solids import Solid
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    import viser

    from srs_ik.preview.live.inbox import Inbox


class Served(NamedTuple):
    """A page and who may use it."""

    server: viser.ViserServer
    door: Door
    inbox: Inbox


def serve(port: int, label: str) -> Served:
    """Viser's server on the loopback interface alone, in threads of this process and behind a door; port 0 is any free.

    Raises:
        MissingExtra: viser is not installed.
        PreviewError: the port is taken, there is none of this number, or this version of viser cannot be guarded.
    """
    port = as_port(port)
    try:
        import viser

        # It brings what the guard needs.
        from srs_ik.preview.live.guard import Guarded, guarding
        from srs_ik.preview.live.inbox import Inbox
    except ImportError:
        raise MissingExtra("interactive", "a page with sliders") from None

    class LoopbackServer(viser.ViserServer):
        """Viser's server, which does not offer its page to the world when it is asked for it."""

        def request_share_url(self, verbose: bool = True) -> str | None:
            return None

    guard = Guarded(Door(), Inbox())
    try:
        with _quiet(), guarding():
            server = LoopbackServer(host=guard, port=port, label=label, verbose=False)
    except (OSError, OverflowError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise PreviewError(f"the preview cannot be served on port {port} of {HOST}: {reason}") from None
    guard.door.port = server.get_port()
    if not guard.stands:
        stop(server)
        raise PreviewError(f"viser {viser.__version__} cannot be kept to this machine: install one that pip chooses")
    if port not in (0, guard.door.port):
        stop(server)
        raise PreviewError(f"the preview cannot be served on port {port} of {HOST}: it is in use")
    server.gui.configure_theme(show_logo=False, show_share_button=False)
    return Served(server, guard.door, guard.inbox)


def stop(server: viser.ViserServer) -> None:
    """End a page and free its port."""
    with _quiet():
        server.stop()


def _quiet() -> Any:
    """Viser prints an address when it starts and a line when it stops, whatever it is told."""
    return contextlib.redirect_stdout(io.StringIO())


class PageCanvas:
    """Draws solids under names, each name with a place of its own in the base frame.

    Args:
        server: the page.
        R_scene_base: (3, 3) rotation that sets the base frame as it stands in the world.

    Attributes:
        extent: how far what is drawn reaches.
    """

    def __init__(self, server: viser.ViserServer, R_scene_base: Array) -> None:
        self._scene = server.scene
        self._groups: dict[str, Any] = {}
        self.extent = Extent()
        self._scene.add_frame("/scene", show_axes=False, wxyz=wxyz(R_scene_base))

    def draw(self, name: str, solids: Iterable[Solid], T: Array | None = None) -> None:
        """Draw solids under a name, in place of what was there."""
        self.erase(name)
        self._groups[name] = self._scene.add_frame(f"/scene/{name}", show_axes=False)
        solids = list(solids)
        self.extent.draw(name, solids)
        for k, solid in enumerate(solids):
            self._scene.add_mesh_simple(
                f"/scene/{name}/{k}",
                np.asarray(solid.mesh.vertices),
                np.asarray(solid.mesh.faces),
                color=solid.colour,
                opacity=solid.opacity if solid.opacity < 1.0 else None,
                side="double",
                cast_shadow=False,
                receive_shadow=False,
            )
        if T is not None:
            self.place(name, T)

    def place(self, name: str, T: Array) -> None:
        """Move what a name holds."""
        self.extent.place(name, T)
        group = self._groups[name]
        group.position, group.wxyz = T[:3, 3], wxyz(T[:3, :3])

    def erase(self, name: str) -> None:
        """Remove what a name holds; nothing if it is not there."""
        self.extent.erase(name)
        group = self._groups.pop(name, None)
        if group is not None:
            group.remove()


def wxyz(R: Array) -> Array:
    """A rotation as viser's quaternion, scalar part first."""
    x, y, z, w = Rotation.from_matrix(R).as_quat()
    return np.array([w, x, y, z])


def rotation(quaternion: Any) -> Array:
    """The (3, 3) rotation of viser's quaternion."""
    w, x, y, z = np.asarray(quaternion, dtype=float)
    return Rotation.from_quat([x, y, z, w]).as_matrix()
