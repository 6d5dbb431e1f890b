"""Reading files that may be anything: pipes, folders, devices, or far too large."""

from __future__ import annotations

import itertools
import os
from pathlib import Path

from srs_ik.errors import InvalidRobot, did_you_mean
from srs_ik.system import bounds

_LONGEST_LABEL = 300


def label_of(path: Path) -> str:
    """A path as one line of a message."""
    text = str(path)
    if len(text) > _LONGEST_LABEL:
        text = text[:_LONGEST_LABEL] + "..."
    return text if text.isprintable() else repr(text)


def read(path: Path, label: str) -> bytes:
    """Content of a file, cut off where it is too large; raises InvalidRobot where it cannot be read."""
    try:
        if path.is_dir():
            raise InvalidRobot(f"{label} is a directory, not a file", label)
        if path.exists() and not path.is_file():
            raise InvalidRobot(f"{label} is not a regular file", label)
        with path.open("rb") as file:
            # One byte more than is read tells a file that is too large from one that just fits.
            return file.read(bounds.XML_BYTES + 1)
    except FileNotFoundError:
        raise InvalidRobot(f"there is no file {label}{_close_files(path)}", label) from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise InvalidRobot(f"{label} cannot be read: {reason}", label) from None


def _close_files(path: Path) -> str:
    """The names of files beside a missing one that are like its own, as a clause."""
    try:
        with os.scandir(path.parent) as entries:
            beside = [entry.name for entry in itertools.islice(entries, bounds.FILES_BESIDE) if not entry.is_dir()]
    except (OSError, ValueError):
        return ""
    return did_you_mean(path.name, beside)
