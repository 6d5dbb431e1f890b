"""Files that appear whole or not at all."""

from __future__ import annotations

import errno
import os
import shutil
import uuid
from contextlib import suppress
from pathlib import Path


def write_whole(path: Path, content: bytes | str, *, replace: bool = True) -> Path:
    """Write a file by way of one beside it, so that no reader ever finds a part of it, and return its path.

    Text is UTF-8. A link stays one, and a file keeps its permissions. Devices and pipes are written to as they are.
    Whether it may `replace` a file that is there, the caller says.

    Raises:
        OSError: it cannot be written, with `filename` the path; what was there before is still there.
    """
    data = content.encode() if isinstance(content, str) else content
    check_place(path, replace=replace)
    try:
        if _is_stream(path):
            path.write_bytes(data)
        else:
            _replace(path.resolve(), data)
    except OSError as error:
        # Made from a number, it is the error of its kind.
        raise OSError(error.errno, error.strerror or str(error), str(path)) from None
    return path


def check_place(path: Path, *, replace: bool = True) -> None:
    """Raise the error of `write_whole` where there is no place for a file, before the work on what it is to hold."""
    number, why = 0, ""
    if not replace and os.path.lexists(path):
        number, why = errno.EEXIST, "it exists already"
    elif path.is_dir():
        number, why = errno.EISDIR, "it is a folder"
    elif not path.parent.is_dir():
        number, why = errno.ENOENT, f"there is no folder {str(path.parent)!r}"
    if why:
        raise OSError(number, why, str(path))


def _is_stream(path: Path) -> bool:
    """Whether there is nothing to put another file in place of; below /dev, even a file is open somewhere."""
    return Path("/dev") in path.absolute().parents or (path.exists() and not path.is_file())


def _replace(path: Path, data: bytes) -> None:
    partial = path.with_name(f".{path.name[:40]}.{uuid.uuid4().hex[:12]}")
    try:
        with partial.open("xb") as file:
            file.write(data)
            file.flush()
            # Some file systems find out that they are full only now.
            os.fsync(file.fileno())
        with suppress(FileNotFoundError):
            shutil.copymode(path, partial)
        partial.replace(path)
    except BaseException:
        with suppress(OSError):
            partial.unlink()
        raise
