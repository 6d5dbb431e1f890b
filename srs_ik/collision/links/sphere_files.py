"""Spheres of links: as given, or as robot files of cuRobo (YAML) and foam's results (JSON) have them."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from srs_ik.errors import InvalidScene, MissingExtra, quoted
from srs_ik.inputs.numbers import real_array, real_number
from srs_ik.robot.description.files import label_of, read
from srs_ik.system import bounds
from srs_ik.system.arrays import Array

_WRAPPERS = ("robot_cfg", "kinematics", "collision_spheres", "spheres")
_CENTRES = ("center", "centre", "origin")


def as_text(spheres: Mapping[str, Any]) -> str:
    """Spheres of links by name as JSON, by which plans are told apart.

    Raises:
        InvalidScene: of some link they are no (n, 4) numbers.
    """
    rows = {}
    for link, given in spheres.items():
        try:
            rows[str(link)] = real_array(given).tolist()
        except (TypeError, ValueError):
            raise InvalidScene(f"spheres of {quoted(str(link))} are centres and radii, (n, 4) numbers, m") from None
    return json.dumps(rows)


def read_spheres(file: str | Path) -> dict[str, Array]:
    """Spheres (n, 4) of links by name, in the frames of these links: centre and radius, m; of a file, or of `as_text`.

    Spheres without a radius, or with one that is not positive, are left out: cuRobo writes them for links that have
    none.

    Raises:
        InvalidScene: the file holds no spheres of links.
        Others: as `read_tree_of` does.
    """
    if isinstance(file, str) and file.startswith("{"):
        return {link: _rows(rows, f"spheres of {quoted(link)}") for link, rows in json.loads(file).items()}
    path = Path(file)
    content = read_tree_of(path)
    for _ in range(len(_WRAPPERS)):
        inner = next((content[key] for key in _WRAPPERS if isinstance(content, Mapping) and key in content), None)
        if inner is None:
            break
        content = read_tree_of(path.parent / inner) if isinstance(inner, str) else inner
    if not isinstance(content, Mapping) or not content:
        raise InvalidScene(f"{label_of(path)} holds no spheres by the names of links")
    return {str(link): _rows(rows, f"{label_of(path)}, link {quoted(str(link))}") for link, rows in content.items()}


def read_tree_of(path: Path) -> Any:
    """What a JSON or YAML file holds.

    Raises:
        InvalidScene: it is no JSON or YAML.
        InvalidRobot: there is no such file, or it cannot be read.
        MissingExtra: a YAML file, and no reader for it is installed.
    """
    text = read(path, label_of(path))
    try:
        tree = _tree(path, text)
    except (ValueError, RecursionError) as error:
        raise InvalidScene(f"{label_of(path)} is not what its name says: {error}") from None
    _refuse_multiplied(tree, path)
    return tree


def _tree(path: Path, text: bytes) -> Any:
    if path.suffix.lower() not in (".yml", ".yaml"):
        return json.loads(text, object_pairs_hook=_once)
    if len(text) > bounds.YAML_BYTES:
        raise InvalidScene(f"{label_of(path)} has more than the {bounds.YAML_BYTES >> 10} KiB that are read of YAML")
    try:
        import yaml
    except ImportError:
        raise MissingExtra("scene", "a YAML file") from None

    class Loader(yaml.SafeLoader):  # type: ignore[misc]
        def construct_mapping(self, node: Any, deep: bool = False) -> Any:
            _once([(key.value, None) for key, _ in node.value if isinstance(key, yaml.ScalarNode)])
            return super().construct_mapping(node, deep)

    try:
        return yaml.load(text, Loader)
    except (yaml.YAMLError, AttributeError, TypeError, OverflowError) as error:
        # Its own constructors fail in ways of theirs.
        raise ValueError(str(error)) from None


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A mapping of keys that are given once; readers would keep the last of several, and say nothing."""
    found: dict[str, Any] = {}
    for key, value in pairs:
        if key in found:
            raise ValueError(f"{quoted(key)} is given twice in one mapping")
        found[key] = value
    return found


def _refuse_multiplied(tree: Any, path: Path) -> None:
    """Refuse a tree of too many values, or one that holds itself."""
    waiting, count = [tree], 0
    while waiting:
        each = waiting.pop()
        inside = [*each, *each.values()] if isinstance(each, Mapping) else each
        if not isinstance(inside, list | tuple):
            continue
        count += len(inside)
        if count > bounds.TREE_NODES:
            raise InvalidScene(f"{label_of(path)} holds more than {bounds.TREE_NODES:,} values, or itself")
        waiting += inside


def _rows(spheres: Any, where: str) -> Array:
    if isinstance(spheres, Mapping):
        spheres = next((spheres[key] for key in _WRAPPERS if key in spheres), None)
    if not isinstance(spheres, Sequence) or isinstance(spheres, str):
        raise InvalidScene(f"{where}: spheres are a list of centres and radii")
    rows = [row for sphere in spheres if (row := _row(sphere, where))[3] > 0.0]
    return np.array(rows).reshape(-1, 4)


def _row(sphere: Any, where: str) -> list[float]:
    if isinstance(sphere, Mapping):
        centre = next((sphere[key] for key in _CENTRES if key in sphere), None)
        figures = [*(centre if isinstance(centre, Sequence) else ()), sphere.get("radius", 0.0)]
    else:
        figures = list(sphere) if isinstance(sphere, Sequence) else []
    row = [real_number(figure) for figure in figures]
    if len(row) != 4 or not np.isfinite(row).all() or max(map(abs, row)) > 1e3:
        raise InvalidScene(f"{where}: {quoted(str(sphere))} is no centre (3) with a radius, m")
    return row
