"""Figures of a scene as callers give them, checked."""

from __future__ import annotations

import contextlib
import math
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from srs_ik.errors import InvalidPose, InvalidScene, quoted, warn_caller
from srs_ik.inputs.numbers import real_array, real_number, vector_of
from srs_ik.inputs.poses import PoseLike, as_rigid_matrix
from srs_ik.system.arrays import Array

LARGEST = 1e4
"""Largest size and coordinate of an object, m."""

MOST_POINTS = 2_000_000
MOST_TRIANGLES = 1_000_000

_WIDE = 30.0
"""A mesh that is wider than this, m, is taken for one in millimetres: a hall is no larger, a cup is 80 mm."""

_THICK = 1.0
"""A box that is wider than that and nowhere thinner than this, m, is no floor."""


def as_margin(value: Any) -> float:
    """A margin, m; raises InvalidScene for what is no number from 0 to 1e4."""
    return as_size(value, "margin")


def refuse_margin(value: Any) -> None:
    """Raise InvalidScene for a margin that has no scene; zero is none."""
    if as_margin(value) != 0.0:
        raise InvalidScene("margin= goes with scene=; scene=srs_ik.Scene() is the arm alone")


def as_name(name: Any) -> str:
    """A name of an object."""
    if not isinstance(name, str) or not name.strip() or len(name) > 200:
        raise InvalidScene(f"an object has a name, a text of up to 200 characters, not {quoted(name)}")
    return name


def as_pose(pose: PoseLike, name: str) -> Array:
    """(4, 4) pose of an object."""
    try:
        T = np.array(as_rigid_matrix(pose))
    except InvalidPose as error:
        raise InvalidScene(f"pose of {quoted(name)}: {error}") from None
    if np.abs(T[:3, 3]).max() > LARGEST:
        raise InvalidScene(f"pose of {quoted(name)} is farther away than {LARGEST:g} m")
    return T


def as_vector(value: Any, count: int, what: str) -> Array:
    """(count,) numbers."""
    vector = vector_of(value, count, what, InvalidScene)
    if not (np.abs(vector) <= LARGEST).all():
        raise InvalidScene(f"{what} must be finite and no larger than {LARGEST:g} m, not {vector.tolist()}")
    return vector


def as_positive(value: Any, what: str) -> float:
    """A positive number."""
    number = real_number(value)
    if not (0.0 < number <= LARGEST and math.isfinite(number)):
        raise InvalidScene(f"{what} must be a positive number up to {LARGEST:g} m, not {quoted(value)}")
    return number


def as_size(value: Any, what: str) -> float:
    """A number from 0 on."""
    number = real_number(value)
    if not 0.0 <= number <= LARGEST:
        raise InvalidScene(f"{what} must be a number from 0 to {LARGEST:g} m, not {quoted(value)}")
    return number


def as_points(points: Any, name: str) -> Array:
    """(n, 3) points."""
    try:
        cloud = real_array(points)
    except (TypeError, ValueError):
        raise InvalidScene(f"points of {quoted(name)} are an (N, 3) array, not {type(points).__name__}") from None
    if cloud.ndim != 2 or cloud.shape[1] != 3 or not 0 < len(cloud) <= MOST_POINTS:
        raise InvalidScene(
            f"points of {quoted(name)} are an (N, 3) array of 1 to {MOST_POINTS} points, not one of shape {cloud.shape}"
        )
    if not (np.abs(cloud) <= LARGEST).all():
        raise InvalidScene(f"points of {quoted(name)} must be finite and no farther away than {LARGEST:g} m")
    return cloud


def as_faces(faces: Any, count: int, name: str) -> NDArray[np.int64]:
    """(m, 3) triangles, each by three of `count` vertices."""
    try:
        triangles = np.asarray(faces)
    except ValueError:
        triangles = np.empty(0)
    fits = triangles.ndim == 2 and triangles.shape[1:] == (3,) and 0 < len(triangles) <= MOST_TRIANGLES
    if not (fits and triangles.dtype.kind in "iu" and triangles.min() >= 0 and triangles.max() < count):
        raise InvalidScene(
            f"faces of {quoted(name)} are (m, 3) places in its vertices, at least one and at most {MOST_TRIANGLES}"
        )
    return triangles.astype(np.int64)


def triangles_of(file: Any, scale: Any, name: str) -> tuple[Array, NDArray[np.int64]]:
    """Vertices (n, 3) and faces (m, 3) of a mesh file, by one factor or by one for each axis."""
    from srs_ik.meshes.files import FORMATS, MeshMissing, file_size, read_mesh

    if not isinstance(file, str | Path):
        raise InvalidScene(f"the file of {quoted(name)} is a path, not {quoted(file)}")
    path = Path(file)
    factors = np.zeros(3)
    with contextlib.suppress(TypeError, ValueError):
        factors = np.broadcast_to(real_array(scale), 3)
    if not (np.isfinite(factors).all() and factors.all()):
        raise InvalidScene(f"scale of {quoted(name)} must be one number or three, not zero")
    if path.suffix.lower() not in FORMATS:
        raise InvalidScene(f"{quoted(str(file))} is none of {', '.join(sorted(FORMATS))}")
    try:
        if path.exists() and not path.is_file():
            raise MeshMissing(f"{quoted(str(path))} is not a regular file")
        file_size(path)
        meshes = [mesh for mesh, _ in read_mesh(path)]
    except (MeshMissing, ValueError) as error:
        raise InvalidScene(f"the mesh of {quoted(name)} is not at hand: {error}") from None
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts[:-1], strict=True)])
    return np.concatenate([mesh.vertices for mesh in meshes]) * factors, faces


def warn_of_a_large_box(edges: Sequence[float], name: str) -> None:
    """Warn, naming it, of a box with these edges, m, that looks like one in millimetres."""
    if max(edges) > _WIDE and min(edges) >= _THICK:
        warn_caller(f"the box {quoted(name)} is in metres, and {max(edges):.4g} m long: are these millimetres?")


def warn_of_millimetres(vertices: Array, name: str) -> None:
    """Warn, naming its object, where a mesh (n, 3), which is in metres, is wider than what stands around an arm."""
    extent = float(np.ptp(vertices, axis=0).max())
    if extent > _WIDE:
        said = f"the mesh of {quoted(name)} is in metres, and {extent:.4g} m wide: are these millimetres?"
        warnings.warn(f"{said} A scale of 0.001 makes metres of them", UserWarning, stacklevel=2)
