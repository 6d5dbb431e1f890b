"""The feasible arm angles of all branches over a path, with the line that the path takes through them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.errors import InvalidConfiguration, InvalidPose, quoted
from srs_ik.inputs.poses import as_matrices
from srs_ik.kinematics import check_arm
from srs_ik.plots.figure import EMPTY, FORCE, JOINT, VELOCITY, new_figure
from srs_ik.plots.intervals import BRANCHES
from srs_ik.solve.path.solution import PathSolution
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm
    from srs_ik.collision.scenes.scene import Scene

MOST_COLUMNS = 400
"""Poses that are drawn of a longer path."""

TURNED = 1e-6
"""A path that is farther from its pose than this, by a figure of the matrix, has taken a turn that was left free."""


def plot_path(arm: Arm, poses: Any, path: PathSolution, *, scene: Scene | None = None, margin: float = 0.0) -> Figure:
    """Picture of the strips of a path: over the poses, the feasible arm angles of each branch, and the chosen line.

    Where poses leave a turn free, they are drawn with the turns that the path has chosen.

    Args:
        arm: the arm.
        poses: (N, 4, 4) array, or a list of poses.
        path: the answer of `Arm.solve_path` for them.
        scene: what must not be touched, as for the path: arm angles are then those that hit nothing.
        margin: what is to be left between any two bodies, m; it goes with a scene.

    Returns:
        A `matplotlib.figure.Figure`; write it with its method `savefig`.

    Raises:
        InvalidPose: a pose is no finite rigid transform, or there are more or fewer than the path has.
        InvalidConfiguration: the path is none.
        InvalidScene: no `Scene`, or no margin.
        NoBodies: no shapes of the arm are at hand.
        MissingExtra: Matplotlib is not installed.
    """
    check_arm(arm)
    T = as_matrices(poses)
    if not isinstance(path, PathSolution):
        raise InvalidConfiguration(f"a path is what Arm.solve_path gives, not {quoted(path)}")
    if len(T) != len(path):
        raise InvalidPose(f"a path is drawn over its own poses: it has {len(path)}, and {len(T)} are given")
    figure = new_figure(9.0, 7.0)
    grid = figure.subplots(BRANCHES // 2, 2, sharex=True, sharey=True)
    drawn = np.unique(np.linspace(0, len(T) - 1, min(len(T), MOST_COLUMNS)).astype(int))
    width = (drawn[-1] - drawn[0]) / max(len(drawn) - 1, 1) if len(drawn) > 1 else 1.0
    found = arm.intervals_batch(_as_taken(arm, T, path)[drawn], scene=scene, margin=margin)
    for branch, axes in enumerate(grid.T.flat):
        axes.set_facecolor(EMPTY)
        _draw_strips(axes, drawn, width, found, branch)
        _draw_line(axes, path, branch)
        for sample in np.flatnonzero(~path.ok):
            axes.axvline(sample, color=JOINT, linewidth=max(0.8, 2.0 - 0.02 * len(T)), linestyle="-", zorder=0.5)
        for pause in path.breaks:
            axes.axvline(pause.sample - 0.5, color="black", linewidth=0.8, linestyle=":")
        axes.set_title(f"branch {branch}", fontsize=8)
        axes.set_xlim(-0.5, len(T) - 0.5)
        axes.set_ylim(-180.0, 180.0)
        axes.set_yticks(range(-180, 181, 90))
    grid[0, 0].xaxis.set_major_locator(_whole())
    figure.supxlabel("pose")
    figure.supylabel("arm angle (deg)")
    count = f"{len(path.breaks)} {'break' if len(path.breaks) == 1 else 'breaks'}"
    missed = int((~path.ok).sum())
    if missed:
        count += f"; {missed} {'pose' if missed == 1 else 'poses'} not met: grey lines"
    figure.suptitle(f"{arm.name}: feasible arm angles along the path, and the path through them ({count})")
    return figure


def _as_taken(arm: Arm, T: Array, path: PathSolution) -> Array:
    """The poses (N, 4, 4) of a path, with the turns that it has chosen where they leave one free."""
    taken = arm.forward_kinematics_batch(path.q)
    turned = path.ok & (np.abs(taken - T).max(axis=(1, 2), initial=0.0) > TURNED)
    return np.where(turned[:, None, None], taken, T)


def _draw_strips(axes: Any, drawn: Any, width: float, found: Any, branch: int) -> None:
    """One bar a pose and interval; what passes 180 degrees is cut in two."""
    columns = np.repeat(drawn, found.counts)[found.branch == branch]
    lower = np.degrees(found.lower[found.branch == branch])
    upper = np.degrees(found.upper[found.branch == branch])
    over = upper > 180.0
    x = np.concatenate([columns, columns[over]])
    bottom = np.concatenate([lower, np.full(over.sum(), -180.0)])
    top = np.concatenate([np.minimum(upper, 180.0), upper[over] - 360.0])
    axes.bar(x, top - bottom, width, bottom, color=VELOCITY, alpha=0.45, linewidth=0.0)


def _draw_line(axes: Any, path: PathSolution, branch: int) -> None:
    """The path where it is in a branch at its poses, broken where the arm angle passes half a turn."""
    psi = np.where((path.branch == branch) & path.ok, np.degrees(path.arm_angle), math.nan)
    gaps = np.flatnonzero(np.abs(np.diff(psi)) > 180.0) + 1
    axes.plot(np.insert(np.arange(len(psi), dtype=float), gaps, math.nan), np.insert(psi, gaps, math.nan), color=FORCE)
    alone = np.isfinite(psi)
    alone[1:] &= ~np.isfinite(psi[:-1])
    alone[:-1] &= ~np.isfinite(psi[1:])
    axes.plot(np.flatnonzero(alone), psi[alone], ".", color=FORCE, markersize=3)


def _whole() -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(integer=True)
