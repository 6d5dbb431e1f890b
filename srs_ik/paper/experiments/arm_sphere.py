"""Robustness: 1,000 targets in a sphere of 1.2 times the reach, so that many are too far away."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.inputs.task import Task
from srs_ik.paper.experiments.drawing import COLOUR, MARK, add_limbs, limb_lines, space
from srs_ik.paper.experiments.measure import microseconds, posture_figures, solve
from srs_ik.paper.experiments.setting import BOTH, SEED, Outcome, Progress, ball, directions, reach, task_directions
from srs_ik.plots.figure import new_figure
from srs_ik.solve.posture import Posture
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm

RADIUS = 1.2
"""Of the sphere, in reaches."""


def arm_sphere(arm: Arm, progress: Progress, count: int = 1000, seed: int = SEED) -> Outcome:
    """Postures of both arms for random targets, velocities, forces across them, and grasp directions.

    The paper's second experiment, with the time of a posture. Beside it, the same targets without a grasp direction.
    """
    rng = np.random.default_rng(seed)
    x_d = arm.limb.shoulder + ball(rng, count, RADIUS * reach(arm))
    v, f = task_directions(rng, count)
    g = directions(rng, count)
    held, free = Task(x_d, v, f, g), Task(x_d, v, f)
    postures = {side: arm.posture(held, side) for side in BOTH}
    figures: dict[str, Any] = {
        "grasp": {side: posture_figures(arm, postures[side], x_d, side, True) for side in BOTH},
        "no_grasp": {side: posture_figures(arm, arm.posture(free, side), x_d, side, False) for side in BOTH},
    }
    progress(0.4)
    figures["joint_angles"] = {}
    for side in BOTH:
        solved = solve(arm, held, side)
        unfit = ~np.isfinite(solved.q).all(axis=1)
        figures["joint_angles"][side] = {"solved": int(np.sum(solved.ok)), "not_finite": int(unfit.sum())}
    progress(0.7)
    one = [Task(x_d[i], v[i], f[i], g[i]) for i in range(count)]
    figures["microseconds_a_posture"] = microseconds(arm.posture, one, held, count)
    progress(1.0)
    from_shoulder = np.linalg.norm(x_d - arm.limb.shoulder, axis=1)
    return Outcome(figures, lambda: _draw(postures, x_d, from_shoulder, reach(arm)), seed)


def _draw(postures: dict[Any, Posture], x_d: Array, from_shoulder: Array, farthest: float) -> Figure:
    figure = new_figure(12.0, 4.8)
    lines = {side: limb_lines(postures[side]) for side in BOTH}
    for column, side in enumerate(BOTH):
        axes = figure.add_subplot(1, 3, column + 1, projection="3d")
        add_limbs(axes, lines[side], side)
        ok = postures[side].reached
        axes.scatter(*x_d[ok].T, s=5, color="black", depthshade=False, label="target, reached")
        axes.scatter(*x_d[~ok].T, s=7, marker="x", linewidths=0.5, color="0.3", depthshade=False, label="not reached")
        space(axes, [x_d, *lines.values()])
        axes.view_init(elev=20, azim=-60)
        axes.set_title(f"{side} arm, {len(x_d)} targets", fontsize=10)
        axes.legend(fontsize=7, loc="upper left")
    axes = figure.add_subplot(1, 3, 3)
    for side in BOTH:
        size, face = (18, "none") if side == "left" else (5, COLOUR[side])
        axes.scatter(
            from_shoulder,
            np.abs(postures[side].miss),
            s=size,
            marker=MARK[side],
            facecolors=face,
            edgecolors=COLOUR[side],
            linewidths=0.6,
            label=f"{side} arm",
        )
    axes.axvline(farthest, color="black", linewidth=0.8, linestyle=":", label="reach of the arm")
    axes.set_xlabel("distance of the target from the shoulder (m)")
    axes.set_ylabel("distance of the hand from the target (m)")
    axes.legend(fontsize=8)
    return figure
