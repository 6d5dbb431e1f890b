"""Where the meshes of a robot file lie, and what is in them."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlparse

import numpy as np
import trimesh
from trimesh.resolvers import FilePathResolver

from srs_ik.meshes import bounds, check
from srs_ik.robot.description.packages import find_package

FORMATS = frozenset({".dae", ".glb", ".gltf", ".obj", ".off", ".ply", ".stl"})
"""Endings of the files that are read, in lower case; whatever else a robot file names is not opened."""

_BESIDE = frozenset({".bin", ".mtl"})

_PACKAGE_SCHEMES = ("package", "model")


class MeshMissing(Exception):
    """A mesh that cannot be shown; the message is a clause that says why."""


class MeshFinder:
    """Finds the mesh files that a robot file names, and never one outside of the folders it may read.

    These are, for `package://NAME/...`: the folder NAME that is or lies in one of the given folders, or in a folder
    above the robot file, and the package of that name where `find_package` finds it (``AMENT_PREFIX_PATH`` and
    ``ROS_PACKAGE_PATH``). For any other path: the given folders, and the folder of the robot file, or that of the
    package that it belongs to (the nearest one above it with a ``package.xml``). Paths are compared as they are
    written: a link inside of a folder may lead out of it.

    Args:
        urdf: path of the robot file, if it is one.
        folders: more folders to search, before all others.
    """

    def __init__(self, urdf: Path | None, folders: Sequence[str | Path] = ()) -> None:
        self._urdf = urdf
        self._found: dict[str, Path | None] = {}
        self._given = [Path(folder).absolute() for folder in folders]
        self._above = list(urdf.absolute().parents)[:-1] if urdf is not None else []
        own = next((folder for folder in self._above if (folder / "package.xml").is_file()), None)
        self._own = [own or self._above[0]] if self._above else []

    def find(self, name: str) -> Path:
        """The file of a mesh by its name in the robot file: `package://`, `file://`, absolute, or relative to that.

        Raises:
            MeshMissing: there is no such file where it may be, or it is no mesh.
        """
        # The doubled scheme is what some converters of xacro files write.
        url = urlparse(name.removeprefix("file:///") if name.startswith("file:///package://") else name)
        if Path(name).suffix.lower() not in FORMATS:
            raise MeshMissing(f"{name!r} is none of {', '.join(sorted(FORMATS))}")
        if url.scheme in _PACKAGE_SCHEMES:
            # Neither scheme nor host are percent-encoded by those who write such names, and some paths hold a "#".
            package, _, rest = name.partition(f"{url.scheme}://")[2].partition("/")
            return self._first(name, [(folder, rest) for folder in self._packages(package)])
        if url.scheme not in ("", "file") or url.netloc not in ("", "localhost"):
            raise MeshMissing(f"{name!r} is not a file of this machine")
        path = unquote(url.path) if url.scheme else name
        roots = self._given + self._own
        if os.path.isabs(path):
            return self._first(name, [(root, os.path.relpath(path, root)) for root in roots])
        if self._above:
            inside = [(root, os.path.relpath(self._above[0] / path, root)) for root in roots]
            return self._first(name, inside + [(root, path) for root in self._given])
        return self._first(name, [(root, path) for root in roots])

    def _packages(self, package: str) -> Iterator[Path]:
        if package in ("", ".", ".."):
            return
        for folder in [*self._given, *self._above]:
            if folder.name == package:
                yield folder
            yield folder / package
        if package not in self._found:
            self._found[package] = find_package(package, self._urdf)
        elsewhere = self._found[package]
        if elsewhere is not None:
            yield elsewhere

    def _first(self, name: str, places: Sequence[tuple[Path, str]]) -> Path:
        """The first (root, path relative to it) that is a file and does not lead out of its root."""
        outside = False
        for root, relative in places:
            path = os.path.normpath(relative)
            if os.path.isabs(path) or path.split(os.sep)[0] == os.pardir:
                outside = True
            elif (root / path).is_file():
                return root / path
        if outside:
            raise MeshMissing(f"{name!r} is not inside of a folder that may be read")
        raise MeshMissing(f"{name!r} is not found")


Rgba = tuple[float, float, float, float]
Piece = tuple[trimesh.Trimesh, Rgba | None]


class MeshShelf:
    """Mesh files in memory: each is read once, however often the robot shows it, and not beyond the bounds."""

    def __init__(self, finder: MeshFinder) -> None:
        self._finder = finder
        self._left = bounds.ALL_BYTES
        self._read: dict[Path, list[Piece] | MeshMissing] = {}

    def pieces(self, name: str) -> list[Piece]:
        """The pieces of a mesh in metres, each with its colour and opacity if it has any; not to be changed.

        Raises:
            MeshMissing: it is not found, cannot be read, is beyond the bounds, or holds no triangles.
        """
        path = self._finder.find(name)
        if path not in self._read:
            try:
                self._left -= (size := file_size(path))
                if self._left < 0:
                    self._left += size
                    raise MeshMissing(
                        f"{str(path)!r} is left out: {bounds.ALL_BYTES >> 20} MiB of meshes are read in all"
                    )
                self._read[path] = read_mesh(path)
            except MeshMissing as error:
                self._read[path] = error
        found = self._read[path]
        if isinstance(found, MeshMissing):
            raise found
        return found


def file_size(path: Path) -> int:
    """Bytes of a mesh file; raises MeshMissing where they are too many, or the file is gone."""
    try:
        size = path.stat().st_size
    except OSError as error:
        raise MeshMissing(f"{str(path)!r} cannot be read ({error.strerror})") from None
    if size > bounds.MESH_BYTES:
        many, most = size / 2**20, bounds.MESH_BYTES >> 20
        raise MeshMissing(f"{str(path)!r} has {many:.0f} MiB, more than the {most} MiB that are read of a mesh")
    return size


def read_mesh(path: Path) -> list[Piece]:
    """The pieces of a mesh file in metres, each with its colour and opacity if it has any.

    Raises:
        MeshMissing: the file cannot be read, is beyond the bounds, or holds no triangles.
    """
    kind = path.suffix.lower()
    try:
        with open(path, "rb") as file:
            # It may have grown since its size was asked for.
            content = file.read(bounds.MESH_BYTES)
        options: dict[str, Any] = {"skip_materials": True} if check.check(content, kind) else {}
        scene = trimesh.load_scene(io.BytesIO(content), kind[1:], _Beside(str(path)), **options)
        scale = _metres(scene.units) if kind == ".dae" else 1.0
        pieces = [piece for piece in scene.dump() if isinstance(piece, trimesh.Trimesh) and len(piece.faces)]
        for piece in pieces:
            piece.apply_scale(scale)
        found = [(piece, _colour(piece)) for piece in pieces]
    except check.Beyond as error:
        raise MeshMissing(f"{str(path)!r} {error}") from None
    except Exception as error:
        # Readers of seven formats fail in as many ways as there are damaged files.
        raise MeshMissing(f"{str(path)!r} cannot be read ({type(error).__name__})") from error
    if not found:
        raise MeshMissing(f"{str(path)!r} holds no triangles")
    return found


class _Beside(FilePathResolver):
    """Finds the materials and numbers that a mesh names in its turn, in its own folder and those below it.

    Pictures are not opened: a shape has one colour here, and a small picture may hold gigabytes.
    """

    def get(self, name: str) -> bytes:
        path = os.path.normpath(name.strip())
        if os.path.isabs(path) or path.split(os.sep)[0] == os.pardir:
            raise ValueError(f"{name!r} is not beside the mesh")
        if Path(path).suffix.lower() not in _BESIDE:
            raise ValueError(f"{name!r} is not read")
        if not (file := Path(self.parent, path)).is_file() or file.stat().st_size > bounds.MESH_BYTES:
            raise ValueError(f"{name!r} is no file that is read")
        return super().get(name)


def _metres(units: str | None) -> float:
    """Of the units of a Collada file, "0.001 * meters" or "meters", the factor."""
    return float(units.partition("*")[0]) if units and "*" in units else 1.0


def _colour(mesh: Any) -> Rgba | None:
    visual = mesh.visual
    if visual.kind is None:
        return None
    rgba = visual.material.main_color if visual.kind == "texture" else visual.main_color
    r, g, b, a = np.asarray(rgba, dtype=float) / 255.0
    return float(r), float(g), float(b), float(a)
