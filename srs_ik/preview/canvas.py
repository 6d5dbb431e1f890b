"""A tree of solids in Meshcat: groups with names, placed in the base frame."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from meshcat.animation import Animation, AnimationClip, AnimationTrack
from meshcat.geometry import MeshPhongMaterial, TriangularMeshGeometry, pack_numpy_array
from meshcat.visualizer import Visualizer
from scipy.spatial.transform import Rotation

from srs_ik.preview import palette
from srs_ik.preview.document import Caption
from srs_ik.preview.extent import Extent
from srs_ik.preview.palette import Rgb
from srs_ik.preview.robot import Stage
from srs_ik.preview.server import Window
from srs_ik.preview.solids import Solid
from srs_ik.system.arrays import Array

_FOREVER = 1_000_000

_CAMERA = np.array([0.78, -0.53, 0.33])
"""Direction from what is seen to the camera: in front, to one side and above."""

_DISTANCE = 1.6
"""From the centre of what is seen to the camera in units of its radius: at 75 degrees all of it is seen."""

_BEYOND = 1.02
"""Where something reaches beyond so many radii of what was seen, the camera steps back."""


class Canvas:
    """Draws solids in a window under names such as ``robot/joint 3``, each name with a place of its own."""

    def __init__(self, window: Window) -> None:
        self._window = window
        self._root = Visualizer(window=window)
        self._animated = False
        self._extent = Extent()
        self._centre, self._radius = np.zeros(3), 0.0
        self._root["/Background"].set_property("top_color", list(palette.BACKGROUND_TOP))
        self._root["/Background"].set_property("bottom_color", list(palette.BACKGROUND_BOTTOM))
        self._root["/Axes"].set_property("visible", False)

    def fit(self, stage: Stage, closer: bool = False) -> None:
        """Bring all that is drawn before the camera, upright, over a floor of a grid; `closer` if less is drawn, too.

        The camera turns about the origin and cannot be told otherwise, so it is the scene that moves. It stays as it is
        as long as everything is in view: it may have been turned by hand.
        """
        centre, radius = self._extent.sphere()
        if np.linalg.norm(centre - self._centre) + radius <= _BEYOND * self._radius and not (
            closer and _BEYOND * radius < self._radius
        ):
            return
        self._centre, self._radius = centre, radius
        T = np.eye(4)
        T[:3, :3] = stage.R_scene_base
        T[:3, 3] = -stage.R_scene_base @ centre
        self._root.set_transform(T)
        cells = np.diag([0.2 * radius, 0.2 * radius, 1.0, 1.0])
        cells[2, 3] = stage.floor + T[2, 3]
        self._root["/Grid"].set_transform(cells)
        # The camera's own axes have y upwards.
        x, y, z = _CAMERA / np.linalg.norm(_CAMERA) * _DISTANCE * radius
        self._root["/Cameras/default/rotated/<object>"].set_property("position", [x, z, -y])

    def draw(self, name: str, solids: Iterable[Solid], T: Array | None = None) -> None:
        """Draw solids under a name, in place of what was there."""
        self.erase(name)
        solids = list(solids)
        self._extent.draw(name, solids)
        for k, solid in enumerate(solids):
            self._root[name][str(k)].set_object(_Geometry(solid), _material(solid))
        if T is not None:
            self.place(name, T)

    def place(self, name: str, T: Array) -> None:
        """Move what a name holds."""
        self._extent.place(name, T)
        self._root[name].set_transform(np.asarray(T, dtype=float))

    def erase(self, name: str) -> None:
        """Remove a name and all below it."""
        self._extent.erase(name)
        self._root[name].delete()

    def animate(self, poses: Mapping[str, Array], fps: float, repeat: bool) -> None:
        """Move names along poses, (N, 4, 4) each, in place of any motion before."""
        clips = {}
        for name, T in poses.items():
            frames = list(range(len(T)))
            turns = Rotation.from_matrix(T[:, :3, :3]).as_quat()
            tracks = {
                "position": AnimationTrack("position", "vector3", frames, T[:, :3, 3].tolist()),
                "quaternion": AnimationTrack("quaternion", "quaternion", list(frames), turns.tolist()),
            }
            clips[self._root[name].path] = AnimationClip(tracks, fps=fps)
        self._root.set_animation(Animation(clips, default_framerate=fps), repetitions=_FOREVER if repeat else 1)
        self._animated = True

    def halt(self) -> None:
        """End the motion that `animate` began."""
        if self._animated:
            self._root.set_animation(Animation())
            self._animated = False

    def page(self) -> str:
        """The scene as one HTML page that needs nothing else."""
        return self._window.get_scene()

    def tell(self, caption: Caption) -> None:
        """Say beside the scene what it shows."""
        self._window.tell(caption)


class _Geometry(TriangularMeshGeometry):
    """Triangles with the directions of their surface, without which they would be drawn flat and dark."""

    def __init__(self, solid: Solid) -> None:
        super().__init__(solid.mesh.vertices, solid.mesh.faces)
        self._normals = np.asarray(solid.mesh.vertex_normals, dtype=np.float32)

    def lower(self, object_data: Any) -> dict[str, Any]:
        lowered: dict[str, Any] = super().lower(object_data)
        lowered["data"]["attributes"]["normal"] = pack_numpy_array(self._normals.T)
        return lowered


def _material(solid: Solid) -> MeshPhongMaterial:
    options: dict[str, Any] = {"color": _hexadecimal(solid.colour), "opacity": solid.opacity, "shininess": 40}
    if solid.overlaid:
        options |= {"transparent": True, "depthTest": False}
    elif solid.opacity < 1.0:
        # What is seen through must not hide what lies behind it.
        options |= {"transparent": True, "depthWrite": False}
    return MeshPhongMaterial(**options)


def _hexadecimal(colour: Rgb) -> int:
    r, g, b = (round(255.0 * x) for x in colour)
    return r << 16 | g << 8 | b
