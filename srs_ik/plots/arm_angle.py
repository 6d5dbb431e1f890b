"""What the arm angle does: joint angles, manipulability and distance from the limits all around the elbow's circle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from srs_ik.analysis.ellipsoids import manipulability
from srs_ik.inputs.angles import as_branch
from srs_ik.inputs.poses import as_matrix
from srs_ik.kinematics import check_arm
from srs_ik.plots.figure import EMPTY, FORCE, JOINT, VELOCITY, new_figure
from srs_ik.plots.intervals import bars, none_meets, whole_circle
from srs_ik.solve.objectives import Objective
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm
    from srs_ik.inputs.poses import PoseLike

SAMPLES = 721
"""Arm angles that are drawn: every half degree."""

_STYLES = (
    (VELOCITY, "-"),
    (FORCE, (0, (7, 1.5))),
    (JOINT, (0, (1, 1))),
    ("black", "-"),
    (VELOCITY, (0, (3.5, 1.5))),
    (FORCE, (0, (6, 1.5, 1, 1.5))),
    (JOINT, (0, (3, 1, 1, 1, 1, 1))),
)
"""Colour and dashes of each joint; all dashes differ, but for the black line's, so that grey prints can be read."""


def plot_arm_angle(arm: Arm, pose: PoseLike, branch: int | None = None) -> Figure:
    """Picture of one branch at a pose, against the arm angle; what is feasible is white, the rest is shaded.

    Args:
        arm: the arm.
        pose: wanted pose of the tip frame in the base frame.
        branch: 0 to 7; that of `arm.solve(pose)` if not given.

    Returns:
        A `matplotlib.figure.Figure` with three panels: the seven joint angles, the manipulability sqrt(det JJ'), and
        the limit margin (1 where every joint is in the middle of its range, 0 where one is at a limit, below that
        outside). Out of reach, the panels are empty.

    Raises:
        InvalidPose: the pose is no finite rigid transform.
        InvalidConfiguration: branch is not an integer from 0 to 7.
        MissingExtra: Matplotlib is not installed.
    """
    check_arm(arm)
    figure = new_figure(8.0, 7.2)
    T = as_matrix(pose)
    chosen = arm.solve(T).branch if branch is None else as_branch(branch)
    psi = np.linspace(-np.pi, np.pi, SAMPLES)
    found = arm.solve_batch(np.tile(T, (SAMPLES, 1, 1)), psi, branch=chosen, respect_limits=False)
    # What is no number is not drawn: a line ends where the branch does.
    q = np.where(found.ok[:, None], found.q, np.nan)
    volumes, margins = np.full(SAMPLES, np.nan), np.full(SAMPLES, np.nan)
    margin = Objective("limit_margin").evaluator(arm)
    for i in np.flatnonzero(found.ok):
        volumes[i], margins[i] = manipulability(arm.jacobian(q[i])), margin(q[i])

    top, middle, bottom = figure.subplots(3, sharex=True, height_ratios=(2.2, 1.0, 1.0))
    degrees = np.rad2deg(psi)
    for name, angles, (colour, dashes) in zip(arm.joint_names, q.T, _STYLES, strict=True):
        top.plot(*_broken(degrees, np.rad2deg(angles)), color=colour, linestyle=dashes, label=name, linewidth=1.4)
    middle.plot(degrees, volumes, color="black", linewidth=1.4)
    bottom.plot(degrees, margins, color="black", linewidth=1.4)
    bottom.axhline(0.0, color=JOINT, linewidth=0.8)
    intervals = arm.intervals(T)
    feasible = bars(i for i in intervals if i.branch == chosen)[chosen]
    for axes in (top, middle, bottom):
        axes.set_facecolor(EMPTY)
        for start, width in feasible:
            axes.axvspan(start, start + width, facecolor="white", zorder=0.5)
        axes.grid(color="0.8", linewidth=0.5)
    whole_circle(bottom)
    half_turns = max(1, int(np.ceil(np.nanmax(np.abs(q), initial=0.0) / np.pi - 1e-9)))
    top.set_yticks(range(-180 * half_turns, 180 * half_turns + 1, 60 * half_turns))
    top.set_ylim(-185.0 * half_turns, 185.0 * half_turns)
    top.set_ylabel("joint angle (deg)")
    middle.set_ylim(bottom=0.0)
    middle.set_ylabel("manipulability (m³)")
    bottom.set_ylabel("limit margin (1)")
    bottom.set_xlabel("arm angle (deg)")
    if intervals:
        top.set_title(f"{arm.name}, branch {chosen}: feasible where the ground is white")
    else:
        top.set_title(none_meets(arm, T), fontsize="small")
    figure.align_ylabels()
    figure.legend(*top.get_legend_handles_labels(), loc="outside right upper", frameon=False)
    return figure


def _broken(x: Array, y: Array) -> tuple[Array, Array]:
    """A line of angles in degrees without the strokes from 180 to -180."""
    jumps = np.flatnonzero(np.abs(np.diff(y)) > 180.0) + 1
    return np.insert(x, jumps, np.nan), np.insert(y, jumps, np.nan)
