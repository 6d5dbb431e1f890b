"""Where the ROS packages of this machine are, without ROS."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path

from srs_ik.errors import InvalidRobot
from srs_ik.robot.description.files import read

_NAME = re.compile(r"[A-Za-z0-9_-]+")
_PACKAGE_XML = "package.xml"
_DEPTH = 3
"""Folders between an entry of ROS_PACKAGE_PATH and a package in it; sources lie in ``src/repository/package``."""


def find_package(name: str, near: Path | None = None) -> Path | None:
    """Folder of a ROS package that a file, `near`, mentions, or None.

    Looked for around that file (in the folders above it, and their subfolders, as in a clone of a repository), then in
    the installations of AMENT_PREFIX_PATH, then below the folders of ROS_PACKAGE_PATH. Where none says that it is the
    package, a folder that only bears its name will do, as in collections that leave out ``package.xml``.
    """
    if not _NAME.fullmatch(name):
        return None
    candidates = list(_candidates(name, near))
    named = (folder for folder in candidates if folder.name == name and _is_bare(folder))
    return next((folder for folder in candidates if _is_package(folder, name)), None) or next(named, None)


def inside(package: Path, path: str) -> Path | None:
    """A file in a package; None where the path leads out of it."""
    file = package / path
    return file if ".." not in Path(path).parts and not Path(path).is_absolute() else None


def _candidates(name: str, near: Path | None) -> Iterator[Path]:
    for folder in near.absolute().parents if near is not None else ():
        yield folder
        yield folder / name
    for prefix in _entries("AMENT_PREFIX_PATH"):
        yield prefix / "share" / name
    for root in _entries("ROS_PACKAGE_PATH"):
        yield root
        for depth in range(_DEPTH):
            yield from sorted(root.glob("*/" * depth + name))


def _entries(variable: str) -> list[Path]:
    return [Path(entry) for entry in os.environ.get(variable, "").split(os.pathsep) if entry]


def _is_package(folder: Path, name: str) -> bool:
    """True if a folder is the package of a name: by its package.xml, as a clone may have any folder name."""
    file = folder / _PACKAGE_XML
    try:
        # No pipe, which would be waited for.
        text = read(file, str(file)).decode(errors="replace") if file.is_file() else ""
    except (InvalidRobot, OSError):
        return False
    match = re.search(r"<name>\s*+([^<\s]++)\s*+</name>", text)
    return match is not None and match[1] == name


def _is_bare(folder: Path) -> bool:
    """True if a folder says nothing of which package it is."""
    return folder.is_dir() and not (folder / _PACKAGE_XML).exists()
