"""Files that appear whole or not at all."""

from __future__ import annotations

import os
import tempfile
from contextlib import suppress
from pathlib import Path

from srs_ik.errors import PreviewError


def write_whole(path: Path, text: str) -> Path:
    """Write a text file by way of one beside it, so that no reader ever finds a part of it.

    Returns:
        The path.

    Raises:
        PreviewError: it cannot be written; what was there before is still there.
    """
    if path.is_dir():
        raise PreviewError(f"{path} is a folder: give the name of a file, such as scene.html")
    if not path.parent.is_dir():
        raise PreviewError(f"there is no folder {str(path.parent)!r} to write {path.name} into")
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.name[:40]}.", dir=path.parent)
        try:
            with open(handle, "w", encoding="utf-8") as file:
                file.write(text)
            os.chmod(name, 0o666 & ~_umask())
            os.replace(name, path)
        except BaseException:
            with suppress(OSError):
                os.unlink(name)
            raise
    except OSError as error:
        raise PreviewError(f"{path} cannot be written: {error.strerror or error}") from None
    return path


def _umask() -> int:
    """What a new file is not allowed; a temporary file is allowed nothing to others."""
    mask = os.umask(0o077)
    os.umask(mask)
    return mask
