"""Folders to search for meshes, as callers give them."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from srs_ik.errors import InvalidRobot, quoted


def folders_of(given: str | Path | Iterable[str | Path]) -> tuple[Path, ...]:
    """One folder to search for meshes, or several; raises InvalidRobot where one is not there."""
    several = (given,) if isinstance(given, str | os.PathLike) else given
    try:
        folders = tuple(Path(folder) for folder in several)
    except TypeError:
        raise InvalidRobot(f"folders to search for meshes are a path or a list of paths, not {quoted(given)}") from None
    for folder in folders:
        if not folder.is_dir():
            raise InvalidRobot(f"there is no folder {str(folder)!r} to search for meshes")
    return folders
