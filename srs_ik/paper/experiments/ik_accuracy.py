"""Accuracy of the inverse kinematics: five errors of 1,000 tasks, measured by Pinocchio."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.inputs.task import Task
from srs_ik.paper.experiments.drawing import COLOUR, MARK
from srs_ik.paper.experiments.measure import (
    angle_between,
    distance,
    microseconds,
    points,
    printed_angle_between,
    solve,
    summary,
)
from srs_ik.paper.experiments.setting import BOTH, SEED, Outcome, Progress, ball, reach, task_directions
from srs_ik.plots.figure import new_figure
from srs_ik.solve.posture import Side
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm

LENGTHS = ("elbow_m", "wrist_m", "hand_m")
ANGLES = ("grasp_rad", "pronosupination_rad")
_FLOOR = 1e-18
"""Where errors of exactly zero are drawn."""


def ik_accuracy(arm: Arm, progress: Progress, count: int = 1000, seed: int = SEED) -> Outcome:
    """Errors of elbow, wrist, hand, grasp and pronosupination between the posture and the joint angles for it.

    The paper's third experiment: g = v and phi = f, without joint limits. The paper does not say where its targets
    are; these are the first that the arm reaches, of points uniform in the sphere of its reach. The joint angles go
    through Pinocchio on the arm's description. Errors are those of the tasks that are solved.

    Elbow centre and wrist centre are points of links: the point of axis 4 nearest to axes 3 and 5, and one at rest in
    the hand. The elbow of the posture is the apex of the triangle on S-W, in the
    plane that suits the task, with upper arm and forearm as sides; on a near limb, whose S-E and E-W change by
    millimetres, as long as they are in that posture. So the elbow's error there is the distance from that plane. A hand
    at the very end of the reach may be out of that of the true chain.

    Raises:
        InvalidTask: how the hand of the arm lies in the tip frame is not known.
    """
    x_d, v, f = reached_tasks(arm, count, seed)
    task = Task(x_d, v, f, v, f)
    figures: dict[str, Any] = {}
    errors: dict[str, dict[str, Array]] = {}
    for i, side in enumerate(BOTH):
        errors[side], solved = five_errors(arm, task, side)
        printed = {name: errors[side].pop(name) for name in ("printed_grasp_rad", "printed_pronosupination_rad")}
        figures[side] = {"tasks": len(x_d), "solved": solved}
        figures[side] |= {name: summary(values) for name, values in (errors[side] | printed).items()}
        progress(0.4 * (i + 1))
    one = [Task(x_d[i], v[i], f[i], v[i], f[i]) for i in range(len(x_d))]
    figures["microseconds_posture_and_joint_angles"] = microseconds(
        lambda given: arm.solve_task(given, respect_limits=False), one, task, len(x_d)
    )
    progress(1.0)
    return Outcome(figures, lambda: _draw(errors), seed)


def reached_tasks(arm: Arm, count: int, seed: int = SEED) -> tuple[Array, Array, Array]:
    """Targets (count, 3) that both arms reach with g = v, metres, velocities and forces across them."""
    rng = np.random.default_rng(seed)
    kept: list[Array] = []
    while sum(map(len, kept)) < count:
        x_d = arm.limb.shoulder + ball(rng, 2 * count, reach(arm))
        v, f = task_directions(rng, 2 * count)
        kept.append(np.stack([x_d, v, f], axis=1)[arm.posture(Task(x_d, v, f, v)).reached])
    x_d, v, f = np.moveaxis(np.concatenate(kept)[:count], 1, 0)
    return x_d, v, f


def five_errors(arm: Arm, task: Task, side: Side) -> tuple[dict[str, Array], int]:
    """Errors (n,) of the tasks that are solved, by name, the two angles also as printed; and how many those are."""
    solution = solve(arm, task, side)
    ok = solution.ok
    posture = solution.posture
    elbow, wrist, tips = points(arm, solution.q)
    R = tips[:, :3, :3]
    assert arm.hand is not None
    assert task.grasp is not None
    assert task.pronosupination is not None
    g, phi = R @ np.array(arm.hand.grasp), R @ np.array(arm.hand.pronosupination)
    errors = {
        "elbow_m": distance(elbow, posture.elbow),
        "wrist_m": distance(wrist, posture.wrist),
        "hand_m": distance(tips[:, :3, 3], task.position),
        "grasp_rad": angle_between(g, task.grasp),
        "pronosupination_rad": angle_between(phi, task.pronosupination),
        "printed_grasp_rad": printed_angle_between(g, task.grasp),
        "printed_pronosupination_rad": printed_angle_between(phi, task.pronosupination),
    }
    return {name: values[ok] for name, values in errors.items()}, int(ok.sum())


def _draw(errors: dict[str, dict[str, Array]]) -> Figure:
    figure = new_figure(9.0, 4.5)
    jitter = np.random.default_rng(SEED)
    panels = figure.subplots(1, 2, gridspec_kw={"width_ratios": (3, 2)})
    for axes, names, unit in zip(panels, (LENGTHS, ANGLES), ("m", "rad"), strict=True):
        for side, shift in zip(BOTH, (-0.2, 0.2), strict=True):
            for place, name in enumerate(names):
                values = np.maximum(errors[side][name], _FLOOR)
                x = place + shift + jitter.uniform(-0.13, 0.13, len(values))
                label = f"{side} arm" if place == 0 else None
                axes.scatter(x, values, s=5, marker=MARK[side], color=COLOUR[side], label=label)
                mean = max(float(errors[side][name].mean()), _FLOOR)
                axes.hlines(mean, place + shift - 0.17, place + shift + 0.17, color="black", linewidth=1.5)
        axes.set_yscale("log")
        axes.set_xticks(range(len(names)), [name.rsplit("_", 1)[0] for name in names])
        axes.set_ylabel(f"error ({unit})")
        axes.grid(axis="y", linewidth=0.3)
    figure.legend(*panels[0].get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=2)
    figure.suptitle("Errors of the inverse kinematics; bars are means", fontsize=10)
    return figure
