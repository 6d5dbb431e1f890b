"""Walking: six snapshots of a step with a leg of the arm's lengths, stretched where it bears."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from srs_ik.inputs.task import Task
from srs_ik.paper.experiments.drawing import COLOUR
from srs_ik.paper.experiments.measure import task_ease
from srs_ik.paper.experiments.setting import Outcome, Progress
from srs_ik.plots.figure import new_figure
from srs_ik.solve.posture import Tie
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm
    from srs_ik.solve.task import TaskSolution


class Snapshot(NamedTuple):
    """One moment of a step, in the x-z plane: x is forward, the hip is the shoulder of the arm."""

    name: str
    phase: float  # share of the cycle that has passed since toe-off
    leg_angle_deg: float  # of the ankle, forward from straight down
    extension: float  # distance from hip to ankle over that of the straight leg
    force_angle_deg: float  # of the direction in which the foot bears, backward from straight up


SNAPSHOTS = (
    Snapshot("toe-off", 0.00, -28.0, 0.97, -40.0),
    Snapshot("early swing", 0.12, -22.0, 0.86, -32.0),
    Snapshot("mid swing", 0.24, 6.0, 0.84, -5.0),
    Snapshot("late swing", 0.34, 26.0, 0.93, 15.0),
    Snapshot("heel strike", 0.42, 24.0, 1.00, 24.0),
    Snapshot("middle of the support", 0.71, 0.0, 1.00, 0.0),
)
"""A step by eye, as the paper's figure has it: the foot turns from toes down to toes up, and the leg that bears is
straight. The force points up the leg where it bears."""

GRASPS = ("V", "N", "F")


def walking(arm: Arm, progress: Progress) -> Outcome:
    """The leg in six snapshots with V-grasp: the foot along v, which is across the expected force f.

    The paper's fifth experiment; its directions are not printed, and these are chosen by eye. The velocity of the foot
    is that of a smooth cycle of one second through the six positions, relative to the hip. The knee goes forward,
    which is the upper elbow where the ankle is before the hip. For comparison, C of the same task with F- and N-grasp.

    Raises:
        InvalidTask: how the hand of the arm lies in the tip frame is not known.
    """
    v, f, toe = _directions_and_toes(arm)
    velocity = _velocity(toe)
    figures: dict[str, Any] = {"snapshots": []}
    lines = []
    for i, snapshot in enumerate(SNAPSHOTS):
        tie: Tie = "upper" if snapshot.leg_angle_deg >= 0.0 else "lower"
        solved = {grasp: _solve(arm, grasp, toe[i], v[i], f[i], tie) for grasp in GRASPS}
        figures["snapshots"].append(
            {
                **snapshot._asdict(),
                "v": v[i],
                "f": f[i],
                "foot_velocity_m_s": velocity[i],
                "angle_between_v_and_foot_velocity_deg": float(
                    np.rad2deg(np.arccos(v[i] @ velocity[i] / np.linalg.norm(velocity[i])))
                ),
                **_leg(arm, solved["V"]),
                "grasps": {grasp: _ease(arm, solved[grasp], v[i], f[i]) for grasp in GRASPS},
            }
        )
        posture = solved["V"].posture
        lines.append(np.stack([posture.shoulder, posture.elbow, posture.wrist, posture.hand]))
        progress((i + 1) / len(SNAPSHOTS))
    return Outcome(figures, lambda: _draw(np.array(lines), v, f, velocity))


def _directions_and_toes(arm: Arm) -> tuple[Array, Array, Array]:
    """Velocity and force directions (6, 3), and where the toes are (6, 3), metres."""
    leg, lean = np.deg2rad([[s.leg_angle_deg, s.force_angle_deg] for s in SNAPSHOTS]).T
    zero = np.zeros_like(leg)
    straight = np.array([s.extension for s in SNAPSHOTS]) * (arm.limb.upper_arm + arm.limb.forearm)
    ankle = arm.limb.shoulder + straight[:, None] * np.stack([np.sin(leg), zero, -np.cos(leg)], axis=1)
    f = np.stack([-np.sin(lean), zero, np.cos(lean)], axis=1)
    v = np.stack([np.cos(lean), zero, np.sin(lean)], axis=1)
    return v, f, ankle + arm.limb.hand * v


def _velocity(toe: Array) -> Array:
    """(6, 3) velocities in a periodic cycle of one second through the positions, m/s."""
    from scipy.interpolate import CubicSpline

    phases = [s.phase for s in SNAPSHOTS]
    cycle = CubicSpline([*phases, 1.0], np.vstack([toe, toe[:1]]), bc_type="periodic")
    return np.asarray(cycle(phases, 1))


def _solve(arm: Arm, grasp: str, toe: Array, v: Array, f: Array, tie: Tie) -> TaskSolution:
    from srs_ik.solve.task import TaskSolution

    task = Task(toe, v, f, {"V": v, "N": None, "F": -f}[grasp], np.cross(v, f))
    solution = arm.solve_task(task, respect_limits=False, tie=tie)
    assert isinstance(solution, TaskSolution)
    return solution


def _leg(arm: Arm, solution: TaskSolution) -> dict[str, Any]:
    posture = solution.posture
    thigh, shank = posture.elbow - posture.shoulder, posture.wrist - posture.elbow
    bend = np.arctan2(np.linalg.norm(np.cross(thigh, shank)), thigh @ shank)
    error = arm.verify(solution.T_base_tip, solution.q)
    return {
        "hip": posture.shoulder,
        "knee": posture.elbow,
        "ankle": posture.wrist,
        "toe": posture.hand,
        "knee_bend_deg": float(np.rad2deg(bend)),
        "q": solution.q,
        "position_error_m": error.position,
        "orientation_error_rad": error.orientation,
    }


def _ease(arm: Arm, solution: TaskSolution, v: Array, f: Array) -> dict[str, Any]:
    """How easily the foot moves along v and bears along f; for a toe that is reached."""
    return {"reached": True, **task_ease(arm.jacobian(solution.q), v, f)} if solution else {"reached": False}


_FOOT = "velocity of the foot"
_ARROWS = (("#16456e", "-", "velocity direction v"), ("#e9a23b", "--", "force direction f"), ("0.35", ":", _FOOT))


def _draw(lines: Array, v: Array, f: Array, velocity: Array) -> Figure:
    figure = new_figure(10.0, 6.6)
    length = float(np.linalg.norm(np.diff(lines[0], axis=0), axis=1).sum())
    speed = float(np.linalg.norm(velocity, axis=1).max())
    low, high = lines.reshape(-1, 3).min(axis=0), lines.reshape(-1, 3).max(axis=0)
    for i, (axes, snapshot) in enumerate(
        zip(figure.subplots(2, 3, sharex=True, sharey=True).flat, SNAPSHOTS, strict=True)
    ):
        x, _, z = lines[i].T
        axes.plot(x, z, color="black", linewidth=3.0, marker="o", markersize=6, markerfacecolor="white")
        axes.plot(x[2:], z[2:], color=COLOUR["left"], linewidth=5.0, solid_capstyle="round", zorder=1)
        vectors = (0.25 * length * v[i], 0.25 * length * f[i], 0.35 * length * velocity[i] / speed)
        for vector, (colour, style, label) in zip(vectors, _ARROWS, strict=True):
            # The foot's own velocity stands a little lower, where no foot hides it.
            start = (x[3], z[3] - (0.07 * length if label == _FOOT else 0.0))
            axes.annotate(
                "",
                (start[0] + vector[0], start[1] + vector[2]),
                start,
                arrowprops={"arrowstyle": "->", "color": colour, "linestyle": style, "linewidth": 1.6},
            )
            if i == 0:
                axes.plot([], [], color=colour, linestyle=style, label=label)
        axes.set_title(f"{i + 1}. {snapshot.name}", fontsize=10)
        margin = 0.3 * length
        axes.set(xlim=(low[0] - margin, high[0] + 1.3 * margin), ylim=(low[2] - 0.6 * margin, high[2] + 0.4 * margin))
        axes.set_aspect("equal")
        if i >= 3:
            axes.set_xlabel("x, forward (m)")
        if i % 3 == 0:
            axes.set_ylabel("z (m)")
    figure.legend(fontsize=8, loc="outside lower center", ncols=3)
    figure.suptitle(
        f"Hip, knee, ankle and toes; the fastest foot moves at {speed:.2f} m/s relative to the hip", fontsize=10
    )
    return figure
