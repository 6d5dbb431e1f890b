"""What an arm reaches, in a preview: the cloud of a map, and the arcs of yaw of a pose."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import trimesh

from srs_ik.errors import InvalidMap
from srs_ik.inputs.poses import PoseLike, as_rigid_matrix
from srs_ik.maps.export import cloud, spacing
from srs_ik.maps.live import yaw_arcs
from srs_ik.preview import palette, solids
from srs_ik.preview.palette import Rgb
from srs_ik.preview.solids import Solid
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.maps.reader import Map
    from srs_ik.preview.view import Preview

MOST_POINTS = 20_000
"""Points that a browser turns smoothly."""

SHADES: tuple[Rgb, ...] = (
    (0.27, 0.0, 0.33),
    (0.23, 0.32, 0.55),
    (0.13, 0.57, 0.55),
    (0.37, 0.79, 0.38),
    (0.99, 0.91, 0.14),
)
"""Of shares of the orientations up to 20, 40, 60, 80 and 100 %: those of Matplotlib's viridis."""


def show_map(view: Preview, chart: Map, step: float | None = None, cut: bool = True) -> int:
    """Show what a map calls reached as a cloud, coloured by the share of orientations.

    Args:
        view: the preview of the map's arm.
        chart: the map.
        step: distance between points, metres; that of the map if not given.
        cut: whether to leave out the half in front (y < 0 of the base), so that the inside is seen.

    Returns:
        How many points are shown.

    Raises:
        InvalidMap: there are too many.
        PreviewError: the preview is closed.
    """
    points, share = cloud(chart, step)
    if cut:
        points, share = points[points[:, 1] >= 0.0], share[points[:, 1] >= 0.0]
    if len(points) > MOST_POINTS:
        raise InvalidMap(
            f"the cloud would have {len(points):,} points, more than {MOST_POINTS:,}; make the step larger"
        )
    size = 0.3 * spacing(chart, step)
    shade = np.minimum((share * len(SHADES)).astype(int), len(SHADES) - 1)
    shown = [
        Solid(_crystals(points[shade == k], size), SHADES[k], 0.8) for k in range(len(SHADES)) if (shade == k).any()
    ]
    view._canvas.draw("reach", shown)
    view._settle("reach", [(SHADES[k], f"up to {20 * (k + 1)} % of orientations") for k in range(len(SHADES))])
    return len(points)


def show_yaw_arcs(view: Preview, pose: PoseLike) -> Array:
    """Show a pose, and where it may go, turned about axis 1, and still be reached.

    Returns:
        (n, 2) the arcs: start and width, rad.

    Raises:
        InvalidPose: the pose is no finite rigid transform.
        InvalidMap: joint 1 has so narrow a range that there may be more than 16 arcs.
        PreviewError: the preview is closed.
    """
    T, arm = as_rigid_matrix(pose), view.arm
    (arcs,) = yaw_arcs(arm, [T])
    axis, point = arm.limb.axes[0], arm.limb.points[0]
    from_axis = T[:3, 3] - point
    centre = point + axis * (axis @ from_axis)
    radius = float(np.linalg.norm(T[:3, 3] - centre))
    view.show_target(T)
    drawn = []
    if radius > 0.0:
        across = (T[:3, 3] - centre) / radius
        thickness = 0.006 * view._size
        drawn = [
            Solid(solids.ring(centre, across, axis, radius, start, start + width, thickness), palette.GRASP)
            for start, width in arcs.tolist()
        ]
        whole = solids.ring(centre, across, axis, radius, 0.0, 2.0 * np.pi, 0.4 * thickness)
        drawn.append(Solid(whole, palette.CIRCLE))
    view._canvas.draw("yaw arcs", drawn)
    view._settle("yaw arcs", [(palette.GRASP, "reached, turned about axis 1")])
    return arcs


def _crystals(points: Array, size: float) -> trimesh.Trimesh:
    """An octahedron about each point."""
    corners = size * np.vstack([np.eye(3), -np.eye(3)])
    faces = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    vertices = (points[:, None] + corners).reshape(-1, 3)
    many = (6 * np.arange(len(points))[:, None, None] + faces).reshape(-1, 3)
    return trimesh.Trimesh(vertices, many, process=False)
