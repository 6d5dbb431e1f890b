"""The feasible arm angles of the eight branches: one bar a branch, from -180 to 180 degrees."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from textwrap import fill
from typing import TYPE_CHECKING, Any

from srs_ik.kinematics import check_arm
from srs_ik.plots.figure import EMPTY, VELOCITY, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm
    from srs_ik.collision.scenes.scene import Scene
    from srs_ik.inputs.poses import PoseLike
    from srs_ik.solve.intervals import Interval

BRANCHES = 8


def plot_intervals(
    arm: Arm, pose: PoseLike, respect_limits: bool = True, *, scene: Scene | None = None, margin: float = 0.0
) -> Figure:
    """Picture of the arm angles at which a pose can be met, for each branch.

    Args:
        arm: the arm.
        pose: wanted pose of the tip frame in the base frame.
        respect_limits: whether the joint limits count.
        scene: what must not be touched, as for `Arm.intervals`.
        margin: what is to be left between any two bodies, m; it goes with a scene.

    Returns:
        A `matplotlib.figure.Figure`; write it with its method `savefig`.

    Raises:
        InvalidPose: the pose is no finite rigid transform.
        InvalidScene: no `Scene`, or no margin.
        NoBodies: no shapes of the arm are at hand.
        MissingExtra: Matplotlib is not installed.
    """
    check_arm(arm)
    figure = new_figure(8.0, 3.6)
    asked: dict[str, Any] = {"respect_limits": respect_limits, "scene": scene, "margin": margin}
    found = arm.intervals(pose, **asked)
    draw_intervals(figure.add_subplot(), found)
    free = "" if scene is None else " and hits nothing"
    title = f"{arm.name}: arm angles at which {arm.tip} meets the pose{free}" if found else none_meets(arm, pose, asked)
    figure.axes[0].set_title(title, fontsize=None if found else "small")
    return figure


def none_meets(arm: Arm, pose: PoseLike, asked: Mapping[str, Any] | None = None, width: int = 90) -> str:
    """The title over a pose that no posture meets, as it was asked for: which arm, and why."""
    answer = arm.solve(pose, **(asked or {}))
    return fill(f"{arm.name}: {answer.status}, {answer.message}", width)


def bars(found: Iterable[Interval]) -> list[list[tuple[float, float]]]:
    """For each branch the (start, width) of its bars, degrees from -180 to 180: what passes 180 is cut in two."""
    result: list[list[tuple[float, float]]] = [[] for _ in range(BRANCHES)]
    for interval in found:
        start, end = math.degrees(interval.lower), math.degrees(interval.upper)
        result[interval.branch].append((start, min(end, 180.0) - start))
        if end > 180.0:
            result[interval.branch].append((-180.0, end - 360.0 + 180.0))
    return result


def draw_intervals(axes: Any, found: Iterable[Interval]) -> None:
    """Draw the intervals into Matplotlib axes."""
    for branch, pieces in enumerate(bars(found)):
        axes.broken_barh([(-180.0, 360.0)], (branch - 0.4, 0.8), facecolors=EMPTY)
        # The edge keeps an interval visible that is narrower than a dot.
        axes.broken_barh(pieces, (branch - 0.4, 0.8), facecolors=VELOCITY, edgecolors=VELOCITY, linewidth=1.0)
    whole_circle(axes)
    axes.set_ylim(BRANCHES - 0.5, -0.5)
    axes.set_yticks(range(BRANCHES))
    axes.set_xlabel("arm angle (deg)")
    axes.set_ylabel("branch")


def whole_circle(axes: Any) -> None:
    """Let the x axis be the arm angle, in degrees."""
    axes.set_xlim(-180.0, 180.0)
    axes.set_xticks(range(-180, 181, 45))
