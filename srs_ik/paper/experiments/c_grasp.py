"""The paper's C against extension and grasp angle, for the N-, F- and V-grasp."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.analysis.ellipsoids import force_velocity_ratio, velocity_ellipsoid
from srs_ik.inputs.task import Task
from srs_ik.paper.experiments.drawing import LINE, MARK, SHADES
from srs_ik.paper.experiments.measure import jacobians, solve, task_ease
from srs_ik.paper.experiments.setting import BOTH, Outcome, Progress, reach
from srs_ik.plots.figure import new_figure
from srs_ik.solve.posture import Side
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm

GRASPS = ("N", "F", "V")
DIRECTIONS = 36
EXTENSIONS = np.linspace(0.05, 1.0, 20)
"""Distances of the target from the shoulder, in reaches."""

_DRAWN = (0.3, 0.5, 0.7, 0.85, 0.95)
_SINGULAR = np.log(1e9)
"""Where C or its inverse is larger, one of its terms is rounding."""
_GRASP_LINE = {"N": "-", "F": "--", "V": ":"}
_GRASP_MARK = {"N": "o", "F": "s", "V": "^"}
_UP = np.array([0.0, 0.0, 1.0])


def c_grasp(arm: Arm, progress: Progress, extensions: Array = EXTENSIONS, count: int = DIRECTIONS) -> Outcome:
    """C = (f'JpJp'f) / (v'JpJp'v) for targets along x, and `count` equispaced pairs of v and f across each other.

    The paper's fourth experiment. Velocity and force turn together in the horizontal plane, v at the angle theta from x
    and f at theta + 90 degrees, so that the plane of the arm is that of the task. N-grasp: no grasp direction; F-grasp:
    g = -f; V-grasp: g = v. The hand's back is along the normal of the plane. Where a grasp puts the target out of
    reach there is no C. The paper does not say in which plane its directions turn.

    `elbow_straight` is the singular case that the paper has in mind for walking: shoulder, elbow and wrist in a line,
    the force along it and the velocity across.

    Raises:
        InvalidTask: how the hand of the arm lies in the tip frame is not known.
    """
    theta = 2.0 * np.pi * np.arange(count) / count
    C = {grasp: {} for grasp in GRASPS}  # type: dict[str, dict[Side, Array]]
    for i, grasp in enumerate(GRASPS):
        for side in BOTH:
            C[grasp][side] = _surface(arm, grasp, side, extensions, theta)
        progress((i + 1) / len(GRASPS))
    figures: dict[str, Any] = {
        "extension": extensions,
        "theta_deg": np.rad2deg(theta),
        "C": C,
        "by_extension": {
            grasp: {side: [_row(d, values) for d, values in zip(extensions, surface, strict=True)]}
            for grasp in GRASPS
            for side, surface in list(C[grasp].items())[:1]
        },
        "tasks_that_all_three_reach": _compared(C),
        "mirrored_arms": {grasp: _mirror(C[grasp], theta, grasp) for grasp in GRASPS},
        "elbow_straight": {grasp: _straight(arm, grasp) for grasp in GRASPS},
    }
    return Outcome(figures, lambda: _draw(C, extensions, theta))


def _task(arm: Arm, grasp: str, distance: Array, theta: Array) -> Task:
    """Tasks at a distance (N,) along x, metres, with velocities at angles (N,) from x."""
    v = np.stack([np.cos(theta), np.sin(theta), np.zeros_like(theta)], axis=1)
    f = np.cross(_UP, v)
    x_d = arm.limb.shoulder + distance[:, None] * [1.0, 0.0, 0.0]
    return Task(x_d, v, f, {"N": None, "F": -f, "V": v}[grasp], _UP)


def _surface(arm: Arm, grasp: str, side: Side, extensions: Array, theta: Array) -> Array:
    """(extensions, directions) C, NaN where the target is out of reach."""
    far = np.repeat(extensions * reach(arm), len(theta))
    task = _task(arm, grasp, far, np.tile(theta, len(extensions)))
    solution = solve(arm, task, side)
    ratio = force_velocity_ratio(jacobians(arm, solution.q), task.force, task.velocity)
    return np.where(solution.ok, ratio, np.nan).reshape(len(extensions), len(theta))


def _row(extension: float, C: Array) -> dict[str, Any]:
    C = C[np.isfinite(C)]
    logs = np.log(np.maximum(C, 1e-300))
    found = {"geometric_mean": np.exp(logs.mean()), "least": C.min(), "largest": C.max()} if C.size else {}
    return {"extension": extension, "reached": int(C.size), **found}


def _compared(C: dict[str, dict[Side, Array]]) -> dict[str, Any]:
    """Which grasp has the lowest C of tasks that all three reach, in total and by thirds of the reach."""
    stack = np.stack([C[grasp]["left"] for grasp in GRASPS])
    common = np.isfinite(stack).all(axis=0)
    best = np.where(common, np.argmin(np.where(common, stack, np.inf), axis=0), -1)
    V, F, N = (stack[GRASPS.index(grasp)][common] for grasp in "VFN")
    return {
        "tasks": int(common.sum()),
        "lowest_C": {grasp: int((best == i).sum()) for i, grasp in enumerate(GRASPS)},
        "V_below_F": int((V < F).sum()),
        "V_below_N": int((V < N).sum()),
        "geometric_mean": {
            grasp: float(np.exp(np.log(values).mean())) for grasp, values in zip("VFN", (V, F, N), strict=True)
        },
    }


def _mirror(C: dict[Side, Array], theta: Array, grasp: str) -> float:
    """Largest relative difference of the right arm's C from the mirrored left arm's, where the arm is not singular.

    The mirror image of a task has its velocity at -theta; that of -f is -f again at 180 degrees - theta.
    """
    start = np.pi if grasp == "F" else 0.0
    image = np.rint((start - theta) / (2.0 * np.pi) * len(theta)).astype(int) % len(theta)
    left, right = C["left"], C["right"][:, image]
    both = (np.abs(np.log(left)) < _SINGULAR) & (np.abs(np.log(right)) < _SINGULAR)
    return float(np.max(np.abs(right[both] / left[both] - 1.0), initial=0.0))


def _straight(arm: Arm, grasp: str) -> dict[str, Any]:
    """What is left at a stretched elbow, force along the arm and velocity across it."""
    wrist = arm.limb.shoulder + (arm.limb.upper_arm + arm.limb.forearm) * np.array([1.0, 0.0, 0.0])
    v, f = np.array([0.0, 1.0, 0.0]), np.array([-1.0, 0.0, 0.0])
    hand = {"N": -f, "F": -f, "V": v}[grasp]
    task = Task(wrist + arm.limb.hand * hand, v, f, {"N": None, "F": -f, "V": v}[grasp], _UP)
    solution = arm.solve_task(task, respect_limits=False)
    J = arm.jacobian(solution.q)
    return {"reached": bool(solution), "rank_of_J": velocity_ellipsoid(J, part="full").rank, **task_ease(J, v, f)}


def _draw(C: dict[str, dict[Side, Array]], extensions: Array, theta: Array) -> Figure:
    figure = new_figure(11.0, 9.5)
    grid = figure.add_gridspec(3, 3, height_ratios=(1.0, 1.0, 0.9))
    drawn = [int(np.abs(extensions - d).argmin()) for d in _DRAWN]
    finite = np.concatenate([C[grasp][side].ravel() for grasp in GRASPS for side in BOTH])
    low, high = np.nanquantile(np.maximum(finite, 1e-6), [0.005, 0.995])
    for row, side in enumerate(BOTH):
        for column, grasp in enumerate(GRASPS):
            axes = figure.add_subplot(grid[row, column])
            for i, shade in zip(drawn, SHADES, strict=True):
                (line,) = axes.plot(np.rad2deg(theta), C[grasp][side][i], color=shade, linestyle=LINE[side])
                line.set(linewidth=1.2, marker=MARK[side], markersize=3, label=f"{extensions[i]:.2f} reaches")
            axes.axhline(1.0, color="0.5", linewidth=0.6)
            axes.set(yscale="log", ylim=(0.5 * low, 2.0 * high), xticks=range(0, 361, 90))
            axes.set_title(f"{grasp}-grasp, {side} arm", fontsize=10)
            axes.set_xlabel("angle of v from x (deg)" + _GRASP_ANGLE[grasp])
            axes.set_ylabel("C (1)")
            if row == column == 0:
                figure.legend(title="target at", fontsize=8, title_fontsize=8, loc="outside upper center", ncols=5)
    axes = figure.add_subplot(grid[2, :])
    for grasp, shade in zip(GRASPS, ("0.55", "#e9a23b", "#16456e"), strict=True):
        rows = [_row(float(d), values) for d, values in zip(extensions, C[grasp]["left"], strict=True)]
        rows = [row for row in rows if row["reached"]]
        x, middle = ([row[name] for row in rows] for name in ("extension", "geometric_mean"))
        span = [[row[name] for row in rows] for name in ("least", "largest")]
        style: dict[str, Any] = {"color": shade, "linestyle": _GRASP_LINE[grasp]}
        axes.fill_between(x, *np.maximum(span, 1e-6), color=shade, alpha=0.12, linewidth=0)
        axes.plot(x, np.maximum(span, 1e-6).T, linewidth=0.8, **style)
        axes.plot(x, middle, marker=_GRASP_MARK[grasp], label=f"{grasp}-grasp: geometric mean and range", **style)
    axes.set(yscale="log", ylim=(0.5 * low, 2.0 * high), xlabel="distance of the target from the shoulder (reaches)")
    axes.set_ylabel("C (1)")
    axes.legend(fontsize=8, loc="upper left")
    axes.set_title(f"left arm, those of {len(theta)} directions that are reached", fontsize=10)
    return figure


_GRASP_ANGLE = {"N": "", "F": "; g 90 deg behind v", "V": "; g along v"}
