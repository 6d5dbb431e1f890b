"""Measures that more than the arm is needed for: what a scene leaves free, and the best posture for a task."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from srs_ik.errors import InvalidMap
from srs_ik.maps.fingerprint import fingerprint
from srs_ik.maps.plan import FREE, OF_SCENE, OF_TASK, RATIO, RATIO_ANGLE, RATIO_BRANCH, Task
from srs_ik.solve.objectives import Objective
from srs_ik.solve.optimise import optimise
from srs_ik.solve.reachable import free_first_joint
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from collections.abc import Collection

    from srs_ik.arm import Arm
    from srs_ik.collision.scenes.scene import Scene
    from srs_ik.solve.in_scene.surroundings import Surroundings
    from srs_ik.solve.packed import PackedArm

Direction = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Around:
    """An arm in a scene, as workers get it."""

    arm: Arm  # the arm, with its bodies
    scene: Scene  # what it must not touch, as it stood when this was made
    digest: str  # their fingerprint


class Asked(NamedTuple):
    """What measures are wanted of an arm for which every pose is searched by itself."""

    packed: PackedArm
    measures: Collection[str]
    around: Around | None
    task: Task | None
    any_yaw: bool = False
    """Whether the limits of joint 1 are set aside."""


def needs_postures(measures: Collection[str]) -> bool:
    """Whether there are measures for which every pose is searched by itself."""
    return bool({"manipulability", *OF_SCENE, *OF_TASK} & set(measures))


def of_postures(asked: Asked, poses: Array) -> dict[str, NDArray]:
    """Those measures of poses (N, 4, 4) that are reached, (N,) by name."""
    found: dict[str, NDArray] = {}
    if "manipulability" in asked.measures:
        found["manipulability"] = best_manipulability(asked.packed, poses, asked.any_yaw)
    if asked.task is not None:
        found |= best_ratios(asked.packed, poses, asked.task)
    if asked.around is not None:
        found[FREE] = free_widths(asked.around, poses)
    return found


def around_of(arm: Arm, scene: Scene | None) -> Around | None:
    """An arm in a scene; None without one.

    Raises:
        InvalidScene: this is no scene.
        NoBodies: no shapes of the arm are at hand.
    """
    if scene is None:
        return None
    digest = fingerprint(arm, scene)
    return Around(arm, copy.copy(scene), digest)


_ready: dict[str, Surroundings] = {}
"""The last surroundings that this process has worked in: made in seconds, and every task comes with its own arm."""


def surroundings(around: Around) -> Surroundings:
    """The arm in its scene, ready to be asked."""
    found = _ready.get(around.digest)
    if found is None:
        from srs_ik.solve.in_scene.surroundings import Surroundings

        found = Surroundings(around.arm, around.arm.packed, around.scene, 0.0)
        _ready.clear()
        _ready[around.digest] = found
    return found


def free_widths(around: Around, poses: Array) -> Array:
    """(N,) width of the feasible arm angles of poses (N, 4, 4) that touch nothing, rad, all branches together."""
    inside = surroundings(around)
    widths = np.empty(len(poses))
    for i, T in enumerate(poses):
        rows = inside.all_free(T, True)
        widths[i] = (rows[:, 2] - rows[:, 1]).sum()
    return widths


def task_of(velocity: ArrayLike | None, force: ArrayLike | None) -> Task | None:
    """Directions of velocity and force, each of length one; None if neither is given.

    Raises:
        InvalidMap: only one of them is, or one has no direction.
    """
    if velocity is None and force is None:
        return None
    if velocity is None or force is None:
        raise InvalidMap("a task has a velocity and a force: give both")
    return _direction("velocity", velocity), _direction("force", force)


def _direction(name: str, values: ArrayLike) -> Direction:
    try:
        v = np.array(values, dtype=float)
    except (TypeError, ValueError):
        v = np.empty(0)
    length = float(np.linalg.norm(v))
    if v.shape != (3,) or not math.isfinite(length) or length == 0.0:
        raise InvalidMap(f"{name} of a task is a direction, three numbers that are not all zero")
    x, y, z = (v / length).tolist()
    return x, y, z


def best_ratios(packed: PackedArm, poses: Array, task: Task) -> dict[str, NDArray]:
    """The smallest force-velocity ratio C of each pose (N, 4, 4), and arm angle and branch of that posture."""
    velocity, force = task
    objective = Objective("force_velocity_ratio", velocity=velocity, force=force)
    best = [optimise(packed, None, T, objective) for T in poses]  # type: ignore[arg-type]
    return {
        RATIO: np.array([each.value for each in best]),
        RATIO_ANGLE: np.array([each.arm_angle for each in best]),
        RATIO_BRANCH: np.array([each.branch for each in best]),
    }


def best_manipulability(packed: PackedArm, poses: Array, any_yaw: bool) -> Array:
    """(N,) the largest manipulability of poses (N, 4, 4), with any angle of joint 1 or inside its limits."""
    if any_yaw:
        lower, upper = packed.lower.copy(), packed.upper.copy()
        lower[0], upper[0] = -np.inf, np.inf
        packed = replace(packed, family=free_first_joint(packed), lower=lower, upper=upper)
    return np.array([optimise(packed, None, T, "manipulability").value for T in poses])  # type: ignore[arg-type]
