"""The picture of `srs-ik intervals --plot`: one bar a branch, from -180 to 180 degrees."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from srs_ik.cli.options import WrongInput
from srs_ik.errors import MissingExtra

if TYPE_CHECKING:
    from srs_ik.solution import Interval

BRANCHES = 8


def check(path: Path) -> None:
    """Make sure that a picture can be drawn into a file of this name, before the work is done.

    Raises:
        MissingExtra: Matplotlib is not installed.
        WrongInput: the name does not end in a known picture format, or its folder is missing.
    """
    try:
        from matplotlib.backend_bases import FigureCanvasBase
    except ImportError:
        raise MissingExtra("plot", "--plot") from None
    known = sorted(FigureCanvasBase.get_supported_filetypes())
    if path.suffix.lstrip(".").lower() not in known:
        raise WrongInput(f"--plot takes the name of a picture, such as intervals.png, not {str(path)!r}")
    if not path.parent.is_dir():
        raise WrongInput(f"--plot: there is no folder {str(path.parent)!r}")


def bars(found: Iterable[Interval]) -> list[list[tuple[float, float]]]:
    """For each branch the (start, width) of its bars, degrees from -180 to 180: what passes 180 is cut in two."""
    result: list[list[tuple[float, float]]] = [[] for _ in range(BRANCHES)]
    for interval in found:
        start, end = math.degrees(interval.lower), math.degrees(interval.upper)
        result[interval.branch].append((start, min(end, 180.0) - start))
        if end > 180.0:
            result[interval.branch].append((-180.0, end - 360.0 + 180.0))
    return result


def draw(found: Iterable[Interval], title: str, path: Path) -> None:
    """Draw the intervals into a file; `check` has said that it can be done.

    Raises:
        OSError: the file cannot be written.
    """
    # The figure itself rather than pyplot: no window system is asked for, and nothing is left behind.
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 3.6), layout="constrained")
    axes = figure.add_subplot()
    for branch, pieces in enumerate(bars(found)):
        axes.broken_barh([(-180.0, 360.0)], (branch - 0.4, 0.8), facecolors="0.93")
        # The edge keeps an interval visible that is narrower than a dot.
        axes.broken_barh(pieces, (branch - 0.4, 0.8), facecolors="tab:blue", edgecolors="tab:blue", linewidth=1.0)
    axes.set_xlim(-180.0, 180.0)
    axes.set_xticks(range(-180, 181, 45))
    axes.set_ylim(BRANCHES - 0.5, -0.5)
    axes.set_yticks(range(BRANCHES))
    axes.set_xlabel("arm angle (deg)")
    axes.set_ylabel("branch")
    axes.set_title(title)
    figure.savefig(path, dpi=150)
