"""Maps for other programs: arrays of NumPy, images of VTK, and the HDF5 files of Reuleaux.

The image is that of VTK's XML format (https://docs.vtk.org, "VTK XML file formats"). The HDF5 file has the groups and
columns that Reuleaux's map_creator and base_placement read (https://github.com/ros-industrial-attic/reuleaux): spheres
with an index from 0 to 100, and the poses reached in each, which name the sphere by the very same coordinates.
"""

from __future__ import annotations

import base64
import io
import math
import os
from pathlib import Path

import numpy as np

from srs_ik.errors import InvalidMap, MissingExtra
from srs_ik.maps.grid import checked_step
from srs_ik.maps.plan import YAW
from srs_ik.maps.reader import Map, check_map
from srs_ik.system.arrays import Array
from srs_ik.system.writing import write_whole

MOST_POINTS = 20_000_000
"""Points of an even grid at most."""

AT_ONCE = 500_000
"""Points that are looked up at once, some 300 bytes each."""

MOST_POSES = 50_000_000
"""Poses that a file of Reuleaux may hold, 80 bytes each."""


def cloud(chart: Map, step: float | None = None) -> tuple[Array, Array]:
    """Points of the base frame on an even grid, and the share of orientations reached at each.

    Args:
        chart: the map.
        step: distance between points, metres; that of the map if not given.

    Returns:
        (N, 3) metres and (N,) 0 to 1, of the points at which something is reached.

    Raises:
        InvalidMap: no map, the step is none, or there would be too many points.
    """
    points, share, _ = _voxels(chart, step)
    some = share > 0.0
    return points[some], share[some]


def spacing(chart: Map, step: float | None) -> float:
    """Distance between points, m: that of the map if not given; raises InvalidMap for what is none."""
    return chart.plan.grid.step if step is None else checked_step(step, "the distance between points")


def _voxels(chart: Map, step: float | None) -> tuple[Array, Array, tuple[int, ...]]:
    """Points, shares and numbers of points along x, y and z, x slowest."""
    check_map(chart)
    grid = chart.plan.grid
    if grid.kind == "box" and step is None:
        points = grid.points(tuple(slice(0, n) for n in grid.shape))
        return points, chart.mean("reached").ravel(), grid.shape
    step = spacing(chart, step)
    if grid.kind == "box":
        lower, upper = np.array(grid.lower), np.array(grid.lower) + grid.step * np.array(grid.shape)
    else:
        reach = grid.step * grid.shape[0]
        lower, upper = grid.pose[:3, 3] - reach, grid.pose[:3, 3] + reach
    count = math.prod(np.maximum(np.ceil((upper - lower) / step - 0.5), 0.0).tolist())
    if not 1 <= count <= MOST_POINTS:
        raise InvalidMap(f"{step:g} m apart the map has {count:,.0f} points; there may be 1 to {MOST_POINTS:,}")
    lines = [np.arange(a + 0.5 * step, b, step) for a, b in zip(lower, upper, strict=True)]
    points = np.stack([each.ravel() for each in np.meshgrid(*lines, indexing="ij")], axis=1)
    parts = [points[first : first + AT_ONCE] for first in range(0, len(points), AT_ONCE)]
    share = np.concatenate([np.empty(0), *(chart.share(part) for part in parts)])
    return points, share, tuple(len(line) for line in lines)


def to_numpy(chart: Map, path: str | os.PathLike[str]) -> None:
    """Write all measures, coordinates and rotations as one compressed ``.npz`` file.

    Raises:
        InvalidMap: no map, or the file cannot be written.
    """
    check_map(chart)
    arrays = {name: chart.measure(name) for name in chart.store.names}
    grid = chart.plan.grid
    for k, name in enumerate(grid.names):
        arrays[name] = grid.centres(k)
    arrays["T_base_map"] = grid.pose
    arrays["rotation"] = chart.plan.orientations.matrices()
    content = io.BytesIO()
    np.savez_compressed(content, **arrays)  # type: ignore[arg-type]
    _write(path, content.getvalue())


def to_vtk(chart: Map, path: str | os.PathLike[str], step: float | None = None) -> None:
    """Write the share of orientations reached at every point as a VTK image (``.vti``), in the base frame.

    Raises:
        InvalidMap: no map, the step is none, there would be too many points, or the file cannot be written.
    """
    points, share, shape = _voxels(chart, step)
    apart = spacing(chart, step)
    # VTK counts x fastest.
    values = share.reshape(shape).transpose(2, 1, 0).astype("<f4").tobytes()
    data = base64.b64encode(np.uint64(len(values)).tobytes() + values).decode()
    extent = " ".join(f"0 {n - 1}" for n in shape)
    origin = " ".join(repr(float(x)) for x in points[0])
    _write(
        path,
        f"""<?xml version="1.0"?>
<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<ImageData WholeExtent="{extent}" Origin="{origin}" Spacing="{apart!r} {apart!r} {apart!r}">
<Piece Extent="{extent}"><PointData Scalars="share">
<DataArray type="Float32" Name="share" format="binary">{data}</DataArray>
</PointData></Piece></ImageData></VTKFile>
""",
    )


def to_reuleaux(chart: Map, path: str | os.PathLike[str], step: float | None = None) -> None:
    """Write spheres and the poses reached in them as an HDF5 file of Reuleaux.

    Args:
        chart: the map.
        path: the file.
        step: distance between spheres, metres; that of the map if not given.

    Raises:
        MissingExtra: h5py is not installed.
        InvalidMap: no map, the step is none, there would be too many points or poses, or the file cannot be written.
    """
    try:
        import h5py
    except ImportError:
        raise MissingExtra("maps", "a file of Reuleaux") from None
    points, share, _ = _voxels(chart, step)
    some = share > 0.0
    points, share = points[some], share[some]
    if share.sum() * len(chart.plan.orientations) > MOST_POSES:
        raise InvalidMap(f"the file would hold more than {MOST_POSES:,} poses; make the step larger")
    content = io.BytesIO()
    with h5py.File(content, "w") as file:
        spheres = file.create_group("Spheres")
        table = spheres.create_dataset("sphere_dataset", data=np.column_stack([points, 100.0 * share]))
        table.attrs["Resolution"] = np.array([spacing(chart, step)], "f4")
        file.create_group("Poses").create_dataset("poses_dataset", data=_poses(chart, points))
    _write(path, content.getvalue())


def _write(path: str | os.PathLike[str], content: str | bytes) -> None:
    """Write a file whole; raises InvalidMap where it cannot be written."""
    try:
        write_whole(Path(path), content)
    except OSError as error:
        raise InvalidMap(f"{path} cannot be written: {error.strerror or error}") from None


def _poses(chart: Map, points: Array) -> Array:
    """(M, 10) sphere, then position and quaternion (x, y, z, w) of each pose that is reached there."""
    plan = chart.plan
    T = np.tile(np.eye(4), (len(points), 1, 1))
    T[:, :3, 3] = points
    at, yaw, _ = chart.cells_of(T)
    rows = []
    for i, cell in enumerate(at[:, :-1]):
        if plan.arcs:
            arcs = chart.store.array(YAW)[tuple(cell)]
            met = ((arcs[..., 1] > 0.0) & ((yaw[i] - arcs[..., 0]) % (2.0 * np.pi) <= arcs[..., 1])).any(axis=1)
        else:
            met = chart.store.array("reached")[tuple(cell)] > 0
        R = _turned(chart, yaw[i])[met]
        pose = np.broadcast_to(points[i], (len(R), 3))
        rows.append(np.column_stack([pose, pose, _quaternions(R)]))
    return np.concatenate(rows) if rows else np.empty((0, 10))


def _turned(chart: Map, yaw: float) -> Array:
    """(n, 3, 3) rotations of the orientations in the base frame, at a yaw."""
    from srs_ik.maps.live import turned
    from srs_ik.maps.tasks import in_base

    R = in_base(chart.plan).reshape(-1, 3, 3)
    found: Array = turned(chart.plan.grid.pose, yaw)[:3, :3] @ R if chart.plan.arcs else R
    return found


def _quaternions(R: Array) -> Array:
    from scipy.spatial.transform import Rotation

    found: Array = Rotation.from_matrix(R).as_quat() if len(R) else np.empty((0, 4))
    return found
