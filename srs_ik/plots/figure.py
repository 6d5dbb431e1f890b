"""An empty Matplotlib figure, and the colours of all of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from srs_ik.errors import MissingExtra

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ARM = "#b8c0c8"
JOINT = "#59636e"
VELOCITY = "#2a78b5"
FORCE = "#e64c33"
EMPTY = "0.93"
"""What is not feasible; the feasible colour is darker in grey as well."""


def new_figure(width: float, height: float) -> Figure:
    """A figure of this size in inches.

    It is the figure itself rather than one of pyplot: no window system is asked for, and nothing is left behind. A
    notebook shows it where it is the last value of a cell.

    Raises:
        MissingExtra: Matplotlib is not installed.
    """
    try:
        from srs_ik.plots.picture import Picture
    except ImportError:
        raise MissingExtra("plot", "a picture") from None
    return Picture(figsize=(width, height), dpi=150, layout="constrained")
