"""Pictures of maps: slices coloured by a measure, the shell of what is reached, and arcs of yaw around axis 1."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.errors import InvalidMap, quoted
from srs_ik.inputs.poses import PoseLike, as_rigid_matrix
from srs_ik.maps.live import yaw_arcs
from srs_ik.maps.plan import FREE, RATIO, YAW
from srs_ik.maps.reader import Map, check_map
from srs_ik.plots.figure import EMPTY, FORCE, VELOCITY, new_figure
from srs_ik.plots.intervals import none_meets

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm

_LABELS = {
    "reached": "share of orientations reached",
    YAW: "share of orientations and yaws reached",
    "width": "mean width of feasible arm angles (rad)",
    "widest": "mean width of the widest interval (rad)",
    "pieces": "mean number of intervals",
    "margin": "mean margin to the joint limits",
    "manipulability": "mean manipulability",
    FREE: "mean width of arm angles that touch nothing (rad)",
    RATIO: "mean smallest force-velocity ratio of what is reached",
}


def plot_map(chart: Map, name: str = "reached", at: float = 0.0) -> Figure:
    """Picture of a measure, its mean over all orientations: the half-plane, or an upright slice of a box.

    Args:
        chart: the map.
        name: a measure of it, or "yaw" for a half-plane: with the limits of joint 1.
        at: y of the slice through a box, metres.

    Raises:
        InvalidMap: no map, or it has no measure of that name, or none that has a mean, or the slice is outside.
        MissingExtra: Matplotlib is not installed.
    """
    check_map(chart)
    if name not in _LABELS:
        raise InvalidMap(f"there is no picture of {quoted(name)}, but of {', '.join(_LABELS)}")
    values, extent, labels = _slice(chart, name, at)
    figure = new_figure(5.2, 6.0 if chart.plan.grid.kind == "half-plane" else 5.2)
    axes = figure.add_subplot()
    shown = axes.imshow(
        np.ma.masked_equal(values.T, 0.0), origin="lower", extent=extent, cmap="viridis", vmin=0.0, aspect="equal"
    )
    axes.set_facecolor(EMPTY)
    axes.set_xlabel(labels[0])
    axes.set_ylabel(labels[1])
    axes.set_title(f"{chart.plan.robot['name']}, tip {chart.plan.robot['tip']}")
    figure.colorbar(shown, ax=axes, label=_LABELS[name], shrink=0.8)
    return figure


def plot_shell(*charts: Map, share: float = 0.0, labels: Sequence[str] | None = None) -> Figure:
    """Picture of the shell around what is reached in more than a share of orientations (and yaws), for several maps.

    Args:
        charts: maps of half-planes, or boxes of which the slice at y = 0 is taken.
        share: 0 to 1.
        labels: what to call them; by default, by their robots.

    Raises:
        InvalidMap: one is no map.
        MissingExtra: Matplotlib is not installed.
    """
    for chart in charts:
        check_map(chart)
    figure = new_figure(5.2, 6.0)
    axes = figure.add_subplot()
    names = []
    for k, chart in enumerate(charts):
        values, extent, directions = _slice(chart, YAW if chart.plan.arcs else "reached", 0.0)
        x, y = (np.linspace(a, b, n + 1)[:-1] + 0.5 * (b - a) / n for a, b, n in _lines(extent, values.shape))
        colour = (VELOCITY, FORCE, "black", "tab:green")[k % 4]
        # Thinner ones lie on wider ones where shells coincide. A contour at zero would lie outside all that is reached.
        width = 1.5 * (len(charts) - k)
        drawn = axes.contour(x, y, values.T, levels=[max(share, 1e-9)], colors=[colour], linewidths=width)
        names.append((drawn.legend_elements()[0][0], labels[k] if labels else chart.plan.robot["name"]))
        axes.set_xlabel(directions[0])
        axes.set_ylabel(directions[1])
    axes.set_aspect("equal")
    figure.legend(*zip(*names, strict=True), loc="outside lower center", ncols=2)
    if charts and charts[0].plan.grid.kind == "half-plane":
        axes.set_xlim(left=0.0)
    axes.set_title(f"reached in more than {100.0 * share:g} % of orientations")
    return figure


def _lines(extent: tuple[float, ...], shape: tuple[int, ...]) -> list[tuple[float, float, int]]:
    return [(extent[0], extent[1], shape[0]), (extent[2], extent[3], shape[1])]


def _slice(chart: Map, name: str, at: float) -> tuple[Any, tuple[float, float, float, float], tuple[str, str]]:
    """Values (n, m), the edges of what they cover, and the names of both directions."""
    grid = chart.plan.grid
    values = chart.mean(name)
    ends = [(grid.lower[k], grid.lower[k] + grid.step * grid.shape[k]) for k in range(len(grid.shape))]
    if grid.kind == "half-plane":
        labels = ("distance from axis 1 (m)", "along axis 1, from the shoulder (m)")
        return values, (*ends[0], *ends[1]), labels
    k = math.floor((at - grid.lower[1]) / grid.step)
    if not 0 <= k < grid.shape[1]:
        raise InvalidMap(f"y = {at:g} m is outside the box, {ends[1][0]:g} to {ends[1][1]:g} m")
    return values[:, k], (*ends[0], *ends[2]), ("x (m)", "z (m)")


def plot_yaw_arcs(arm: Arm, pose: PoseLike) -> Figure:
    """Picture of how far a pose may be turned about axis 1 and still be reached, seen along the axis.

    Raises:
        InvalidPose: the pose is no finite rigid transform.
        InvalidMap: joint 1 has so narrow a range that there may be more than 16 arcs.
        MissingExtra: Matplotlib is not installed.
    """
    T = as_rigid_matrix(pose)
    (arcs,) = yaw_arcs(arm, [T])
    figure = new_figure(4.6, 4.6)
    axes = figure.add_subplot(projection="polar")
    axes.bar(0.0, 0.2, width=2.0 * math.pi, bottom=0.9, color=EMPTY)
    for start, width in arcs.tolist():
        axes.bar(start, 0.2, width=width, bottom=0.9, align="edge", color=VELOCITY)
    axes.plot([0.0, 0.0], [0.0, 1.15], color=FORCE, linewidth=1.2)
    axes.set_ylim(0.0, 1.2)
    axes.set_yticks([])
    if len(arcs):
        axes.set_title(f"{arm.name}: yaws of the pose (red: as it is)")
    else:
        axes.set_title(none_meets(arm, T, width=60), fontsize="x-small")
    return figure
