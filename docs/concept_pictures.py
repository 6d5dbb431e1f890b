"""Pictures of docs/concepts.md: limb and arm angle, the circle of postures, and the plane of a task.

Run: python docs/pictures.py
"""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

import srs_ik
from srs_ik.plots.solids import skeleton

UP = np.array([0.0, 0.0, 1.0])
ARM, FREE, BLOCKED, MARK = "#59636e", "#2a78b5", "#c9ced4", "#d9822b"
Q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])


def elbow_circle(limb: srs_ik.SrsLimb, elbow: np.ndarray, wrist: np.ndarray) -> tuple[np.ndarray, Any]:
    """Foot of the elbow on the line from shoulder to wrist, and the point of its circle at an arm angle."""
    along = (wrist - limb.shoulder) / np.linalg.norm(wrist - limb.shoulder)
    foot = limb.shoulder + along * (along @ (elbow - limb.shoulder))
    zero = limb.reference - along * (along @ limb.reference)
    zero /= np.linalg.norm(zero)
    radius = np.linalg.norm(elbow - foot)
    return foot, lambda psi: foot + radius * (np.cos(psi) * zero + np.sin(psi) * np.cross(along, zero))


def panel(figure: Figure, title: str) -> Any:
    axes = figure.add_subplot(projection="3d")
    axes.set_title(title, fontsize=10)
    axes.set_axis_off()
    axes.view_init(18, -60)
    return axes


def draw_arm(axes: Any, line: np.ndarray, colour: str, width: float, **style: Any) -> None:
    axes.plot(*line.T, "o-", color=colour, linewidth=width, markersize=width + 1.0, solid_capstyle="round", **style)


def limb() -> Figure:
    """Centres, the elbow's circle, and the arm angle from the reference direction to the elbow."""
    arm = srs_ik.load("iiwa14")
    pose = arm.forward_kinematics(Q)
    solution = arm.solve(pose, arm_angle=0.9)
    line = skeleton(arm, solution.q).line
    foot, at = elbow_circle(arm.limb, line[2], line[3])
    figure = Figure(figsize=(6.0, 4.4), layout="constrained")
    axes = panel(figure, "Centres, elbow circle and arm angle")
    draw_arm(axes, line, ARM, 4.0)
    axes.plot(*line[[1, 3]].T, "--", color=ARM, linewidth=1.0)
    axes.plot(*np.array([at(psi) for psi in np.linspace(0, 2 * np.pi, 181)]).T, color=FREE, linewidth=1.2)
    arc = np.array([foot + 0.6 * (at(psi) - foot) for psi in np.linspace(0.0, solution.arm_angle, 40)])
    axes.plot(*arc.T, color=MARK, linewidth=2.5)
    for end in (at(0.0), line[2]):
        axes.plot(*np.array([foot, end]).T, color=MARK, linewidth=1.0)
    for text, place in (
        ("  S", line[1]),
        ("  E", line[2]),
        ("  W", line[3]),
        ("  tip", line[4]),
        ("arm angle 0", at(0.0) + 0.03 * UP),
        ("ψ  ", arc[20] - 0.07 * UP),
    ):
        axes.text(*place, text, fontsize=11)
    axes.set_aspect("equal")
    return figure


def redundancy() -> Figure:
    """The postures of one branch at one pose: inside the limits, and outside of them."""
    arm = srs_ik.load("iiwa14")
    pose = arm.forward_kinematics(Q)
    branch = arm.solve(pose).branch
    inside = [i for i in arm.intervals(pose) if i.branch == branch]
    figure = Figure(figsize=(6.0, 4.4), layout="constrained")
    axes = panel(figure, "One pose: postures inside the joint limits, and outside (grey)")
    for psi in np.linspace(-np.pi, np.pi, 36, endpoint=False):
        free = any(i.lower <= psi + turn <= i.upper for i in inside for turn in (0.0, 2 * np.pi))
        solution = arm.solve(pose, arm_angle=psi, branch=branch, respect_limits=False)
        draw_arm(axes, skeleton(arm, solution.q).line, FREE if free else BLOCKED, 1.4, alpha=0.9 if free else 0.5)
    axes.set_aspect("equal")
    return figure


def posture() -> Figure:
    """A task's velocity, force and grasp, and the arm with its plane laid into that of the first two."""
    arm = srs_ik.load("human_arm")
    task = srs_ik.Task([0.45, 0.15, -0.3], velocity=[1, 0, 0], force=[0, 0, -1], grasp=[1, 0, 0])
    found = arm.posture(task, side="left")
    figure = Figure(figsize=(6.0, 4.4), layout="constrained")
    axes = panel(figure, "A task, and the posture that suits it")
    line = np.array([found.shoulder, found.elbow, found.wrist, found.hand])
    draw_arm(axes, line, ARM, 4.0)
    axes.plot_trisurf(*line[:3].T, color=FREE, alpha=0.15)
    for text, direction, colour in (("v, g", task.velocity, FREE), ("f", task.force, MARK)):
        along = 0.16 * np.asarray(direction)
        axes.quiver(*line[3], *along, color=colour, linewidth=2.0)
        # Arrows do not count when Matplotlib decides how much is shown; a line that is not seen does.
        axes.plot(*np.array([line[3], line[3] + along]).T, alpha=0.0)
        axes.text(*(line[3] + 1.15 * along), f" {text}", color=colour, fontsize=12)
    for text, place in zip(("  S", "  E", "  W", ""), line, strict=True):
        axes.text(*place, text, fontsize=11)
    axes.set_aspect("equal")
    return figure
