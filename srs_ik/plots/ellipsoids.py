"""The ellipsoids at the tip of the arm, in space."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.analysis.ellipsoids import Ellipsoid, force_ellipsoid, limits_of, velocity_ellipsoid
from srs_ik.errors import InvalidTask
from srs_ik.inputs.angles import as_joint_vector
from srs_ik.kinematics import check_arm
from srs_ik.plots.figure import FORCE, VELOCITY, new_figure
from srs_ik.plots.solids import Skeleton, Solid, arm_solids, collection, ellipsoid, skeleton
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm

_NAMES = {
    ("velocity", "linear"): "velocity",
    ("force", "linear"): "force",
    ("velocity", "angular"): "angular velocity",
    ("force", "angular"): "moment",
}
"""What the ellipsoid of a kind and part is of."""

DRAWN = 0.35
"""The largest bounded semi-axis is drawn this long, relative to the length from shoulder to wrist, stretched."""

UNBOUNDED = 1.6
"""An unbounded semi-axis is drawn this long, relative to the largest bounded one."""


def plot_ellipsoids(
    arm: Arm, q: ArrayLike, limits: bool = False, part: Literal["linear", "angular"] = "linear"
) -> Figure:
    """Picture of the arm with its velocity ellipsoid and its force ellipsoid at the tip.

    Each is drawn to a scale of its own, which is written under it. Where one is flat or unbounded it says so; an
    unbounded direction is a dashed line.

    Args:
        arm: the arm.
        q: (7,) joint angles, rad.
        limits: whether to weigh the joints by the arm's velocity and torque limits.
        part: "linear" or "angular".

    Returns:
        A `matplotlib.figure.Figure` with two panels.

    Raises:
        InvalidConfiguration: not 7 finite angles.
        InvalidTask: another part.
        MissingLimits: the arm's description does not give the limits.
        MissingExtra: Matplotlib is not installed.
    """
    check_arm(arm)
    if part not in ("linear", "angular"):
        raise InvalidTask(f"part of a picture is 'linear' or 'angular', not {part!r}")
    figure = new_figure(9.0, 5.0)
    q = as_joint_vector(q)
    J, shape = arm.jacobian(q), skeleton(arm, q)
    shown = (
        (velocity_ellipsoid(J, limits_of(arm, "velocity") if limits else None, part), VELOCITY),
        (force_ellipsoid(J, limits_of(arm, "effort") if limits else None, part), FORCE),
    )
    # Automatic layouts do not know how far the labels of axes in space reach.
    figure.set_layout_engine("none")
    panels = [figure.add_axes((left, 0.01, 0.5, 0.86), projection="3d", computed_zorder=False) for left in (0.0, 0.5)]
    points = [_draw(axes, shape, what, colour) for axes, (what, colour) in zip(panels, shown, strict=True)]
    for axes in panels:
        _frame(axes, np.vstack(points), shape)
    joints = "joints up to their limits" if limits else "1 rad/s and 1 N m in the joints"
    what = " and ".join(_NAMES[kind.kind, part] for kind, _ in shown)
    figure.suptitle(f"{arm.name}: {what} at the tip, for {joints}", fontsize="medium")
    return figure


def _draw(axes: Any, shape: Skeleton, what: Ellipsoid, colour: str) -> Array:
    """Draw the arm with an ellipsoid; returns the points (n, 3) that are drawn."""
    size = float(np.linalg.norm(np.diff(shape.line[1:4], axis=0), axis=1).sum())
    bounded = np.where(np.isfinite(what.radii), what.radii, 0.0)
    scale = DRAWN * size / (float(bounded.max()) or 1.0)
    tip = shape.line[-1]
    # A flat one is drawn as thick as paper.
    patches = ellipsoid(tip, what.axes * np.maximum(bounded * scale, 1e-3 * size))
    body = [*arm_solids(shape), Solid(patches, colour, 0.5)]
    axes.add_collection3d(collection(body))
    points = [solid.patches.reshape(-1, 3) for solid in body]
    for axis in what.axes.T[np.isinf(what.radii)]:
        line = tip + np.outer([-1.0, 1.0], UNBOUNDED * DRAWN * size * axis)
        axes.plot(*line.T, color="black", linestyle="--", linewidth=1.2, zorder=3)
        points.append(line)
    note = ", flat" if what.flat else ", unbounded along the dashed line" if what.unbounded else ""
    figures = f"semi-axes {_listed(what.radii)} {what.unit}; drawn 0.1 m for {0.1 / scale:.3g} {what.unit}"
    axes.set_title(f"{_NAMES[what.kind, what.part]} ellipsoid{note}\n{figures}", fontsize="small")
    return np.concatenate(points)


def _frame(axes: Any, points: Array, shape: Skeleton) -> None:
    """Equal scales, units, and a view across the plane in which the arm lies."""
    lower, upper = points.min(axis=0), points.max(axis=0)
    margin = 0.03 * float((upper - lower).max())
    lower, upper = lower - margin, upper + margin
    axes.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]), zlim=(lower[2], upper[2]))
    axes.set_box_aspect(upper - lower, zoom=0.84)
    ahead = shape.line[-1] - shape.line[1]
    axes.view_init(elev=18.0, azim=float(np.rad2deg(np.arctan2(ahead[1], ahead[0]))) - 65.0)
    for name in "xyz":
        axis = getattr(axes, f"{name}axis")
        axis.set_major_locator(_ticks())
        axis.set_tick_params(labelsize="x-small", pad=0)
        getattr(axes, f"set_{name}label")(f"{name} (m)", fontsize="small", labelpad=-2)


def _ticks() -> Any:
    from matplotlib.ticker import MultipleLocator

    return MultipleLocator(0.4)


def _listed(radii: Array) -> str:
    return ", ".join("∞" if np.isinf(r) else f"{r:.3g}" for r in radii)
