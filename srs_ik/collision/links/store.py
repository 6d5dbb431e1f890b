"""Figures on disk: what took seconds to find is kept under the digest of its question, in the user's cache folder.

`SRS_IK_CACHE` names another folder; an empty value keeps nothing. What the built-in arms ask comes with the package.
"""

from __future__ import annotations

import hashlib
import io
import os
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from srs_ik.system.arrays import Array
from srs_ik.system.writing import write_whole

BUILT_IN = Path(__file__).with_name("built_in.npz")
"""What the built-in arms ask; `tests/built_in_bodies.py` writes it."""

_VERSION = "1"
"""Of the way in which spheres are found."""

_DIGITS = 12

_MOST_BYTES = 1 << 20
"""Of a file that is read: some 30,000 spheres, many times what covers a body."""

_memory: dict[str, Array] = {}


def _folder() -> Path | None:
    named = os.environ.get("SRS_IK_CACHE")
    if named is not None:
        return Path(named) if named else None
    root = Path(os.environ.get("XDG_CACHE_HOME", ""))
    if not root.is_absolute():
        # Users of a container may have no home.
        root = Path(os.path.expanduser("~"), ".cache")
    return root / "srs_ik" / "spheres" if root.is_absolute() else None


def key_of(what: str, *figures: Array | NDArray[np.int64]) -> str:
    """What tells a question from all others: without last digits and minus zeros, which differ between machines."""
    digest = hashlib.sha256(what.encode())
    for array in figures:
        digest.update(np.ascontiguousarray(np.round(array, _DIGITS) + 0.0).tobytes())
    return digest.hexdigest()


@cache
def _built_in() -> dict[str, Array]:
    if not BUILT_IN.exists():
        return {}
    with np.load(BUILT_IN, allow_pickle=False) as kept:
        return dict(kept)


def load(key: str) -> Array | None:
    """What was kept under a key, (n, 4); None where there is nothing that can be read."""
    if key in _memory:
        return _memory[key]
    if key in _built_in():
        return _built_in()[key]
    folder = _folder()
    if folder is None:
        return None
    try:
        with open(folder / f"{key}-{_VERSION}.npy", "rb") as file:
            rows = np.lib.format.read_array(io.BytesIO(file.read(_MOST_BYTES)), allow_pickle=False)
    except (OSError, ValueError, EOFError, MemoryError):
        return None
    if rows.ndim != 2 or rows.shape[1] != 4 or rows.dtype != np.float64 or not np.isfinite(rows).all():
        return None
    _memory[key] = rows
    return np.asarray(rows)


def keep(key: str, rows: Array) -> None:
    """Keep rows (n, 4) under a key; where there is no folder to write to, in memory alone."""
    _memory[key] = rows
    folder = _folder()
    if folder is None:
        return
    buffer = io.BytesIO()
    np.save(buffer, rows)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(folder / f"{key}-{_VERSION}.npy", buffer.getvalue())
    except OSError:
        return
