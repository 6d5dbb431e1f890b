"""How the figures of the experiments look: two arms that differ in shade, line and mark, so that grey is enough."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.posture import Posture

COLOUR = {"left": "#16456e", "right": "#e9a23b"}
LINE = {"left": "-", "right": "--"}
MARK = {"left": "o", "right": "^"}
SHADES = ("#000000", "#16456e", "#b5541c", "#6fa8d6", "#ecc875")
"""Of series that are ordered; lighter and lighter, in grey too."""


def limb_lines(posture: Posture) -> Array:
    """(N, 4, 3) shoulder, elbow, wrist and hand of N postures."""
    return np.stack([posture.shoulder, posture.elbow, posture.wrist, posture.hand], axis=1)


def add_limbs(axes: Any, lines: Array, side: str, every: int = 1) -> None:
    """Draw limbs (N, 4, 3) as thin lines in space, one of so many, with a mark at every elbow."""
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    axes.add_collection3d(Line3DCollection(lines[::every], colors=COLOUR[side], linewidths=0.4, alpha=0.5))
    x, y, z = lines[:, 1].T
    axes.scatter(x, y, z, s=4, marker=MARK[side], color=COLOUR[side], depthshade=False, label=f"{side} elbow")


def space(axes: Any, clouds: Iterable[Array]) -> None:
    """Axes of equal scale, in metres, that hold all points."""
    from matplotlib.ticker import MaxNLocator

    points = np.concatenate([cloud.reshape(-1, 3) for cloud in clouds])
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = 0.5 * (low + high), 0.5 * float((high - low).max())
    for name, centre in zip("xyz", middle, strict=True):
        getattr(axes, f"set_{name}lim")(centre - half, centre + half)
        getattr(axes, f"set_{name}label")(f"{name} (m)")
        getattr(axes, f"{name}axis").set_major_locator(MaxNLocator(5))
    # Matplotlib cuts off the labels of a box that fills its panel.
    axes.set_box_aspect((1, 1, 1), zoom=0.87)
    axes.tick_params(labelsize=7)
