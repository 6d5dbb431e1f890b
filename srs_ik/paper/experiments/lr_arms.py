"""Left and right arms: 500 velocity directions at one target, with a grasp direction and without."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.inputs.task import Task
from srs_ik.paper.experiments.drawing import COLOUR, MARK, add_limbs, limb_lines, space
from srs_ik.paper.experiments.measure import distance, posture_figures
from srs_ik.paper.experiments.setting import BOTH, EXTENSION, SEED, Outcome, Progress, reach, task_directions, unit
from srs_ik.plots.figure import new_figure
from srs_ik.solve.posture import Posture
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm

_GRASPS = {"grasp": "grasp g = (1, 0, 0)", "no_grasp": "no grasp"}


def lr_arms(arm: Arm, progress: Progress, count: int = 500, seed: int = SEED) -> Outcome:
    """Postures of both arms for random velocities at x_d = (0.5, 0, 0) m, or as far out on another arm.

    The paper's first experiment. Its velocities come from a uniform random function in MATLAB; these are uniform on the
    sphere. The force is across the velocity.
    """
    v, f = task_directions(np.random.default_rng(seed), count)
    x_d = arm.limb.shoulder + EXTENSION * reach(arm) * np.array([1.0, 0.0, 0.0])
    target = np.broadcast_to(x_d, (count, 3))
    tasks = {"grasp": Task(x_d, v, f, [1.0, 0.0, 0.0]), "no_grasp": Task(x_d, v, f)}
    figures: dict[str, Any] = {"target_m": x_d}
    lines: dict[str, dict[str, Array]] = {}
    for i, (name, task) in enumerate(tasks.items()):
        postures = {side: arm.posture(task, side) for side in BOTH}
        held = name == "grasp"
        figures[name] = {side: posture_figures(arm, postures[side], target, side, held) for side in BOTH}
        figures[name]["two_elbows_opposite_m"] = float(_opposite(postures["left"], postures["right"], held).max())
        lines[name] = {side: limb_lines(postures[side]) for side in BOTH}
        progress(0.5 * (i + 1))
    return Outcome(figures, lambda: _draw(lines), seed)


def _opposite(left: Posture, right: Posture, held: bool) -> Array:
    """(N,) how far the middle between both elbows is from the line from the shoulder, metres."""
    S = left.shoulder
    line = unit((left.wrist if held else left.hand) - S)
    middle = 0.5 * (left.elbow + right.elbow) - S
    return distance(middle, np.sum(middle * line, axis=1, keepdims=True) * line)


def _draw(lines: dict[str, dict[str, Array]]) -> Figure:
    figure = new_figure(9.0, 8.0)
    for column, (name, title) in enumerate(_GRASPS.items()):
        above = figure.add_subplot(2, 2, column + 1, projection="3d")
        below = figure.add_subplot(2, 2, column + 3)
        for side in BOTH:
            add_limbs(above, lines[name][side], side, every=5)
            _, y, z = lines[name][side][:, 1].T
            below.scatter(y, z, s=8, marker=MARK[side], color=COLOUR[side], label=f"{side} elbow")
        space(above, lines[name].values())
        above.view_init(elev=22, azim=-60)
        above.set_title(f"{title}: {len(lines[name]['left'])} postures an arm", fontsize=10)
        below.set_xlabel("y (m), to the left")
        below.set_ylabel("z (m)")
        below.set_aspect("equal", adjustable="datalim")
        below.invert_xaxis()
        below.set_title("elbows, seen from behind", fontsize=10)
        below.legend(fontsize=8, loc="center")
    return figure
