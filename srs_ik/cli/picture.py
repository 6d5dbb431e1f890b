"""Where a picture goes: the name of a file, checked before the work is done."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

from srs_ik.cli.options import WrongInput
from srs_ik.errors import MissingExtra
from srs_ik.system.writing import write_whole


def check(path: Path, option: str) -> None:
    """Make sure that a picture can be drawn into a file of this name.

    Raises:
        MissingExtra: Matplotlib is not installed.
        WrongInput: the name does not end in a known picture format, or its folder is missing.
    """
    try:
        from matplotlib.backend_bases import FigureCanvasBase
    except ImportError:
        raise MissingExtra("plot", option) from None
    known = sorted(FigureCanvasBase.get_supported_filetypes())
    if path.suffix.lstrip(".").lower() not in known:
        raise WrongInput(f"{option} takes the name of a picture, such as intervals.png, not {str(path)!r}")
    if not path.parent.is_dir():
        raise WrongInput(f"{option}: there is no folder {str(path.parent)!r}")


def save(figure: Any, path: Path) -> None:
    """Write a Matplotlib figure, in the format that the name ends in."""
    content = io.BytesIO()
    figure.savefig(content, format=path.suffix.lstrip(".").lower())
    write_whole(path, content.getvalue())
