"""Answers without a table: the measures of any pose, its arcs of yaw, and postures rebuilt from cells."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from srs_ik.inputs.poses import as_matrices
from srs_ik.kernels.layout import maps as at
from srs_ik.kinematics import check_arm
from srs_ik.maps.extras import Asked, around_of, needs_postures, of_postures, task_of
from srs_ik.maps.placement import refuse_no_poses
from srs_ik.maps.plan import MEASURES, YAW, Plan, arcs_of, checked_measures
from srs_ik.maps.tasks import in_base
from srs_ik.solve.reachable import measured, reachable_batch
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from collections.abc import Iterable

    from srs_ik.arm import Arm
    from srs_ik.collision.scenes.scene import Scene


def measures_of(
    arm: Arm,
    poses: Any,
    measures: Iterable[str] = (),
    threads: int | None = None,
    *,
    scene: Scene | None = None,
    velocity: ArrayLike | None = None,
    force: ArrayLike | None = None,
) -> dict[str, NDArray]:
    """The measures of a map for any poses, exactly, within all joint limits.

    Args:
        arm: the arm.
        poses: (N, 4, 4) array or list of poses of its tip in its base frame.
        measures: "margin" and "manipulability" if they are wanted too.
        threads: at most so many; all processors if not given.
        scene: brings "free", see `build_map`.
        velocity: brings with `force` "ratio" and the posture that has it, see `build_map`.
        force: see `velocity`.

    Returns:
        (N,) of each measure, by name.

    Raises:
        InvalidPose: a pose is no finite rigid transform.
        InvalidConfiguration: `threads` is no positive integer.
        InvalidMap: there is no measure of that name, or its scene or task is missing.
        InvalidScene: this is no scene.
    """
    check_arm(arm)
    T = as_matrices(poses)
    refuse_no_poses(T)
    task = task_of(velocity, force)
    names = checked_measures(measures, scene is not None, task is not None)
    rows = measured(arm.packed, T, margin="margin" in names, threads=threads)
    columns = {
        "branches": at.CELL_BRANCHES,
        "pieces": at.CELL_PIECES,
        "width": at.CELL_WIDTH,
        "widest": at.CELL_WIDEST,
        "margin": at.CELL_MARGIN,
    }
    found = {name: np.zeros(len(T), MEASURES[name][0]) for name in names}
    for name, column in columns.items():
        if name in found:
            found[name][:] = rows[:, column]
    found["reached"][:] = reachable_batch(arm.packed, T, threads)
    if needs_postures(names):
        met = np.flatnonzero(found["reached"])
        for name, each in of_postures(Asked(arm.packed, names, around_of(arm, scene), task), T[met]).items():
            found[name][met] = each
    return found


def yaw_arcs(arm: Arm, poses: Any, threads: int | None = None) -> list[Array]:
    """How far poses may be turned about axis 1 and still be reached: exact arcs, each for itself.

    Args:
        arm: the arm.
        poses: (N, 4, 4) array or list of poses of its tip in its base frame.
        threads: at most so many; all processors if not given.

    Returns:
        For each pose (n, 2): start, in [-pi, pi), and width of each arc of yaw, rad. The whole circle is (-pi, 2 pi).

    Raises:
        InvalidPose: a pose is no finite rigid transform.
        InvalidConfiguration: `threads` is no positive integer.
        InvalidMap: joint 1 has so narrow a range that there may be more than 16 arcs.
    """
    check_arm(arm)
    T = as_matrices(poses)
    refuse_no_poses(T)
    most = arcs_of(arm)
    rows = measured(arm.packed, T, arcs=most, threads=threads)[:, at.CELL_ARCS :].reshape(-1, most, 2)
    return [arcs[arcs[:, 1] > 0.0] for arcs in rows]


def rebuild(arm: Arm, plan: Plan, one: tuple[slice, ...], orientations: Any, values: dict[str, NDArray]) -> float:
    """How far the postures of some cells of one position that are reached are from their poses, by Pinocchio, m or rad.

    Each is solved for at the middle of its widest arc of yaw. Infinite where there is no posture.
    """
    rotations = in_base(plan).reshape(-1, 3, 3)
    point, frame = plan.grid.points(one)[0], plan.grid.pose
    worst = 0.0
    for k in orientations:
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = rotations[k], point
        if plan.arcs:
            arcs = values[YAW][(0,) * len(one)][k]
            start, width = arcs[np.argmax(arcs[:, 1])]
            T = turned(frame, start + 0.5 * width) @ T
        solution = arm.solve(T)
        if not solution:
            return math.inf
        error = arm.verify(T, solution.q)
        worst = max(worst, error.position, error.orientation)
    return worst


def turned(frame: Array, yaw: float) -> Array:
    """(4, 4) the turn by a yaw about the z axis of a frame."""
    c, s = math.cos(yaw), math.sin(yaw)
    turn = np.eye(4)
    turn[0, 0], turn[0, 1], turn[1, 0], turn[1, 1] = c, -s, s, c
    R, p = frame[:3, :3], frame[:3, 3]
    back = np.eye(4)
    back[:3, :3], back[:3, 3] = R.T, -R.T @ p
    found: Array = frame @ turn @ back
    return found
