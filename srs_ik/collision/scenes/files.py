"""Scenes from files: objects as they are described there."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from srs_ik.collision.links.sphere_files import read_tree_of
from srs_ik.collision.scenes.figures import as_vector
from srs_ik.errors import InvalidPose, InvalidRobot, InvalidScene, did_you_mean, listed, quoted
from srs_ik.inputs.rotations import pose_from_xyz_quaternion, pose_of_xyz_rpy, warn_of_degrees
from srs_ik.robot.description.files import label_of
from srs_ik.system import bounds
from srs_ik.system.arrays import Array

KINDS = ("sphere", "box", "cylinder", "capsule", "mesh", "points", "half_space")

_PLACE = ("name", "xyz", "rpy", "quat")
_MORE = {"points": ("radius",), "mesh": ("scale",)}
"""What any object may have, and those of a kind."""

_ORIGIN = (0.0, 0.0, 0.0)


class Given(NamedTuple):
    """An object as it is described."""

    kind: str  # one of `KINDS`, or "triangles": what `Scene.add_KIND` takes
    arguments: tuple[Any, ...]  # of that function
    place: Array | None = None  # (4, 4) where the object is put then; None where `arguments` say so


class SceneFile(NamedTuple):
    """What a file of a scene says; its objects are read one by one."""

    where: str
    exact: bool
    margin: Any
    objects: Iterator[Given]


def read_scene(file: str | Path) -> SceneFile:
    """The scene of a JSON or YAML file.

    The file holds ``objects``, a list, and perhaps a ``margin`` and ``exact``. Each object has a ``name``, one kind
    with its figures (``sphere: radius``, ``box: [x, y, z]``, ``cylinder: [radius, length]``, ``mesh: FILE``,
    ``capsule: [radius, length]``, ``points: FILE or list`` with ``radius``, ``half_space: normal``), and its place:
    ``xyz`` with ``rpy`` or ``quat`` (x, y, z, w), which turn the normal of a half-space too. Meshes and points are
    named relative to the file.

    Raises:
        InvalidScene: there is no such file, or it is none.
        MissingExtra: a YAML file, and no reader for it is installed.
    """
    path = Path(file)
    try:
        content = read_tree_of(path)
    except InvalidRobot as error:
        raise InvalidScene(str(error)) from None
    where = label_of(path)
    if isinstance(content, Mapping):
        _expect(content, ("objects", "margin", "exact"), where)
    if not isinstance(content, Mapping) or not isinstance(content.get("objects"), list):
        raise InvalidScene(f"{where} holds no scene: objects must be a list")
    if len(content["objects"]) > bounds.OBJECTS:
        raise InvalidScene(f"{where} has more than the {bounds.OBJECTS:,} objects that are read")
    exact = content.get("exact", False)
    if not isinstance(exact, bool):
        raise InvalidScene(f"{where}: exact is true or false, not {quoted(exact)}")
    objects = (_given(each, f"object {k + 1}", path.parent) for k, each in enumerate(content["objects"]))
    return SceneFile(where, exact, content.get("margin", 0.0), objects)


def _expect(given: Mapping[str, Any], known: Collection[str], where: str) -> None:
    """Refuse a key that nothing reads: it may be another one, misspelt."""
    for key in given:
        if key not in known:
            raise InvalidScene(f"{where} has {quoted(key)}{did_you_mean(str(key), known)}, which nothing reads")


def _given(each: Any, where: str, folder: Path) -> Given:
    if not isinstance(each, Mapping):
        raise InvalidScene(f"{where} is no mapping with a name")
    name = each.get("name", where)
    kinds = [kind for kind in KINDS if kind in each]
    more = [key for kind in kinds for key in _MORE.get(kind, ())]
    _expect(each, [*_PLACE, *more, *(kinds or KINDS)], quoted(name))
    if len(kinds) != 1:
        raise InvalidScene(f"{quoted(name)} must be one of {listed(KINDS)}")
    (kind,) = kinds
    figure = each[kind]
    T = _pose(each, name)
    if kind == "sphere":
        return Given(kind, (name, T[:3, 3], figure))
    if kind == "half_space":
        return Given(kind, (name, T[:3, 3], T[:3, :3] @ as_vector(figure, 3, f"normal of {quoted(name)}")))
    if kind == "mesh":
        return Given(kind, (name, T, folder / str(figure), each.get("scale", 1.0)))
    if kind == "points":
        return Given(kind, (name, _points(figure, name, folder), each.get("radius", 0.0)), T)
    if kind == "box":
        return Given(kind, (name, T, figure))
    if not isinstance(figure, Sequence) or len(figure) != 2:
        raise InvalidScene(f"{kind} of {quoted(name)} must be [radius, length]")
    return Given(kind, (name, T, *figure))


def _pose(each: Mapping[str, Any], name: Any) -> Array:
    if "rpy" in each and "quat" in each:
        raise InvalidScene(f"{quoted(name)} has rpy and quat, two ways to give its orientation: give one")
    try:
        if "quat" in each:
            T: Array = pose_from_xyz_quaternion(each.get("xyz", _ORIGIN), each["quat"], order="xyzw").homogeneous
        else:
            rpy = each.get("rpy", _ORIGIN)
            T = pose_of_xyz_rpy(each.get("xyz", _ORIGIN), rpy).homogeneous
            warn_of_degrees(f"rpy of {quoted(name)}", rpy)
    except InvalidPose as error:
        raise InvalidScene(f"place of {quoted(name)}: {error}") from None
    return T


def _points(figure: Any, name: Any, folder: Path) -> Any:
    if not isinstance(figure, str):
        return figure
    path = folder / figure
    try:
        if path.exists() and not path.is_file():
            raise ValueError(f"{label_of(path)} is not a regular file")
        if path.stat().st_size > bounds.CLOUD_BYTES:
            raise ValueError(f"{label_of(path)} is larger than {bounds.CLOUD_BYTES >> 20} MiB")
        if not path.stat().st_size:
            raise ValueError(f"{label_of(path)} is empty")
        with path.open("rb") as file:
            if path.suffix == ".npy":
                return np.lib.format.read_array(file, allow_pickle=False)
            return np.loadtxt(file, ndmin=2, delimiter=",")
    except (OSError, ValueError, MemoryError) as error:
        raise InvalidScene(f"points of {quoted(name)} cannot be read: {error}") from None
