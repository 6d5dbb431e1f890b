"""Which kernel files an entry needs, and a digest of them: what was compiled from others is out of date."""

from __future__ import annotations

import hashlib
import re
from functools import cache
from pathlib import Path

_IMPORT = re.compile(rb"^[ \t]*(?:from|import)[ \t]+([\w.]+)(?:[ \t]+import[ \t]+(\w[^\n#]*))?", re.MULTILINE)


@cache
def _imported(path: Path, folder: Path) -> tuple[Path, ...]:
    """Kernel files that a kernel file names in its imports; a room that names none of its files stands for all."""
    found: list[Path] = []
    for name, imported in _IMPORT.findall(path.read_bytes()):
        parts = name.decode().split(".")
        if folder.name in parts:
            below = folder.joinpath(*parts[parts.index(folder.name) + 1 :])
            named = [below / f"{word.split()[0]}.py" for word in imported.decode().split(",") if word.strip()]
            if not below.is_dir():
                found.append(below.with_suffix(".py"))
            else:
                found += named if named and all(file.is_file() for file in named) else below.rglob("*.py")
    return tuple(path for path in found if path.is_file())


@cache
def _of_content(path: Path) -> bytes:
    return hashlib.sha256(path.read_bytes()).digest()


@cache
def digest(path: Path, folder: Path) -> str:
    """Digest of a kernel file and of every file in the folder of all kernels that it imports, however indirectly."""
    files, waiting = {path, folder / "jit.py"}, [path]
    while waiting:
        new = set(_imported(waiting.pop(), folder)) - files
        files |= new
        waiting += new
    whole = hashlib.sha256()
    for file in sorted(files):
        whole.update(_of_content(file))
    return whole.hexdigest()


def digest_of_all(folder: Path) -> str:
    """Digest of all kernel files, but for the tools that compile them ahead: ten times as quick as one for each."""
    whole = hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        if folder / "ahead" not in path.parents:
            whole.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return whole.hexdigest()
