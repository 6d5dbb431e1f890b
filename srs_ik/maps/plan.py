"""What a map holds, and of what: the robot, the positions, the orientations and the measures."""

from __future__ import annotations

import hashlib
import math
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from srs_ik.errors import InvalidMap, did_you_mean, quoted
from srs_ik.kernels.layout.maps import MOST_ARCS
from srs_ik.maps.fingerprint import fingerprint
from srs_ik.maps.grid import MOST_POSITIONS, SIDE, Grid
from srs_ik.maps.orientations import MOST as MOST_ORIENTATIONS
from srs_ik.maps.orientations import Orientations
from srs_ik.system.bounds import FARTHEST

if TYPE_CHECKING:
    from srs_ik.arm import Arm

TURN = 2.0 * math.pi

Task = tuple[tuple[float, float, float], tuple[float, float, float]]
"""Directions of velocity and force, each of length one."""

FORMAT = 1
"""Number of the layout of stores."""

MEASURES = {
    "reached": ("u1", "1 where the arm reaches the cell (half-plane: at some yaw)"),
    "branches": ("u1", "bit b is set where branch b does"),
    "pieces": ("u2", "intervals of feasible arm angles, all branches together"),
    "width": ("f4", "sum of their widths, rad"),
    "widest": ("f4", "width of the widest, rad"),
    "margin": ("f4", "largest margin to the joint limits, 0 to 1"),
    "manipulability": ("f4", "largest manipulability (Yoshikawa)"),
    "free": ("f4", "width of the feasible arm angles that touch nothing in the scene, rad"),
    "ratio": ("f4", "smallest force-velocity ratio C of the task"),
    "ratio_arm_angle": ("f8", "arm angle of the posture with that ratio, rad"),
    "ratio_branch": ("u1", "branch of that posture"),
}
"""Type and meaning of every measure. Those of a half-plane set the limits of joint 1 aside: `yaw` holds these."""

LARGEST = 10**12
"""Count of anything."""

FREE = "free"
RATIO, RATIO_ANGLE, RATIO_BRANCH = "ratio", "ratio_arm_angle", "ratio_branch"
OF_SCENE = (FREE,)
OF_TASK = (RATIO, RATIO_ANGLE, RATIO_BRANCH)
"""Measures that come with a scene, and with a task."""

USUAL = ("reached", "branches", "pieces", "width", "widest")

YAW = "yaw"
"""Arcs of yaw (start, width), rad: turned about axis 1 by so much, the arm reaches the cell. Width 0: no arc."""


@dataclass(frozen=True)
class Plan:
    """What a map holds."""

    robot: dict[str, Any]  # who is mapped, as it is written into the store
    grid: Grid  # positions
    orientations: Orientations  # orientations
    measures: tuple[str, ...]  # names of the measures
    arcs: int  # arcs of yaw that a cell may have; 0 for a box
    scene: str | None = None  # fingerprint of the arm in the scene that `free` is for
    task: Task | None = None  # directions of velocity and force that `ratio` is for, base frame

    @property
    def cells(self) -> int:
        """Number of cells: positions times orientations."""
        return math.prod(self.grid.shape) * len(self.orientations)

    @property
    def blocks(self) -> list[tuple[slice, ...]]:
        """The positions of each task."""
        return self.grid.blocks(len(self.orientations))

    def tasks_of(self, at: NDArray[np.int64]) -> NDArray[np.int64]:
        """(N,) the task of each position, by its (N, d) places along each direction."""
        side, parts = self._parts()
        return np.ravel_multi_index(tuple((at // side).T), parts)

    def block(self, task: int) -> tuple[slice, ...]:
        """The positions of one task."""
        side, parts = self._parts()
        begins = [side * int(k) for k in np.unravel_index(task, parts)]
        return tuple(slice(i, min(i + side, n)) for i, n in zip(begins, self.grid.shape, strict=True))

    def _parts(self) -> tuple[int, tuple[int, ...]]:
        """Positions of a task along each direction, and how many tasks there are."""
        side = self.grid.side(len(self.orientations))
        return side, tuple(-(-n // side) for n in self.grid.shape)

    @property
    def bytes_a_cell(self) -> int:
        """Bytes of a cell before they are compressed."""
        return 16 * self.arcs + sum(np.dtype(MEASURES[name][0]).itemsize for name in self.measures)

    def as_attributes(self) -> dict[str, Any]:
        """The plan as JSON can hold it; no time and no place, so that equal plans have equal stores."""
        grid = self.grid
        more: dict[str, Any] = {} if self.scene is None else {"scene": self.scene}
        if self.task is not None:
            more["task"] = {"velocity": list(self.task[0]), "force": list(self.task[1])}
        return {
            "format": FORMAT,
            "version": version(),
            "robot": self.robot,
            "grid": {
                "kind": grid.kind,
                "step": grid.step,
                "lower": list(grid.lower),
                "shape": list(grid.shape),
                "T_base_map": [list(row) for row in grid.T_base_map],
            },
            "orientations": {"nside": self.orientations.nside, "rolls": self.orientations.rolls},
            "measures": list(self.measures),
            "arcs": self.arcs,
            **more,
        }


def version() -> str:
    """Version of the package."""
    return str(sys.modules["srs_ik"].__version__)


def plan_of(attributes: Any, where: Path) -> Plan:
    """The plan of a store; raises InvalidMap where it is none, or one of another format."""
    try:
        if attributes["format"] != FORMAT:
            raise InvalidMap(f"{where} is a map of format {attributes['format']!r:.20}, not {FORMAT}; make it again")
        grid = attributes["grid"]
        return Plan(
            attributes["robot"],
            Grid(
                grid["kind"],
                float(grid["step"]),
                tuple(grid["lower"]),
                tuple(grid["shape"]),
                tuple(tuple(row) for row in grid["T_base_map"]),
            ),
            Orientations(**attributes["orientations"]),
            tuple(attributes["measures"]),
            int(attributes["arcs"]),
            attributes.get("scene"),
            _task(attributes.get("task")),
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        if isinstance(error, InvalidMap):
            raise
        raise InvalidMap(f"{where} holds no map") from None


def _task(task: Any) -> Task | None:
    if task is None:
        return None
    (a, b, c), (x, y, z) = task["velocity"], task["force"]
    return (a, b, c), (x, y, z)


def whole(value: Any, what: str, least: int = 0) -> int:
    """A whole number from `least` to `LARGEST`; raises InvalidMap, in which `what` names it, for anything else."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= LARGEST:
        raise InvalidMap(f"{what} must be a whole number from {least} to {LARGEST:g}, not {quoted(value)}")
    return int(value)


def checked_measures(measures: Any, scene: bool, task: bool) -> tuple[str, ...]:
    """Names of measures, each once, in their usual order; a scene and a task bring their own.

    Raises:
        InvalidMap: one is unknown, or its scene or its task is missing.
    """
    try:
        wanted = {*USUAL, *([measures] if isinstance(measures, str) else measures)}
    except TypeError:
        raise InvalidMap(f"measures are a list of names, not {quoted(measures)}") from None
    if not scene and wanted & set(OF_SCENE):
        raise InvalidMap("measure 'free' is for a scene: give one")
    if not task and wanted & set(OF_TASK):
        raise InvalidMap("measure 'ratio' is for a task: give its velocity and its force")
    wanted |= {*(OF_SCENE if scene else ()), *(OF_TASK if task else ())}
    for name in wanted:
        if name not in MEASURES:
            hint = did_you_mean(name, MEASURES)
            raise InvalidMap(f"there is no measure {quoted(name)}{hint}; there are {', '.join(MEASURES)}")
    return tuple(name for name in MEASURES if name in wanted)


def arcs_of(arm: Arm) -> int:
    """How many arcs of yaw a cell may have: each is as wide as the range of joint 1, and there are gaps between.

    Raises:
        InvalidMap: the range is so narrow that there may be too many.
    """
    width = float(arm.upper[0] - arm.lower[0])
    if width * (MOST_ARCS + 1) < TURN:
        raise InvalidMap(f"joint 1 of {arm.name} has a range of {width:.3g} rad: a half-plane gains nothing; map a box")
    return max(1, math.ceil(TURN / width) - 1) if math.isfinite(width) else 1


def robot_of(arm: Arm) -> dict[str, Any]:
    """Who is mapped: names, limits, the pose of tip (and tool) at zero, and digests."""
    return {
        "name": arm.name,
        "base": arm.base,
        "tip": arm.tip,
        "joint_names": list(arm.joint_names),
        "kind": arm.limb.kind,
        "lower": _finite(arm.lower),
        "upper": _finite(arm.upper),
        "T_base_tip_zero": arm.limb.T_base_tip_zero.tolist(),
        "fingerprint": fingerprint(arm),
        "description_sha256": _description(arm),
    }


def _description(arm: Arm) -> str | None:
    """SHA-256 of the robot's file or text, where there is one."""
    drawing = arm.drawing
    if drawing is None:
        return None
    try:
        content = drawing.content
        data = content.encode() if isinstance(content, str) else drawing.file.read_bytes() if drawing.file else None
    except OSError:
        return None
    return None if data is None else hashlib.sha256(data).hexdigest()


def _finite(values: NDArray[np.float64]) -> list[float | None]:
    return [float(x) if math.isfinite(x) else None for x in values]


def refuse_senseless(plan: Plan, where: Path) -> None:
    """Raise InvalidMap for a plan that nobody could have made; its sizes are bounded before any use."""
    try:
        sensible = _is_sensible(plan)
    except (KeyError, TypeError, ValueError, OverflowError):
        sensible = False
    if not sensible:
        raise InvalidMap(f"{where} is no map of this package: its figures make no sense")


def _is_sensible(plan: Plan) -> bool:
    grid, orientations, robot = plan.grid, plan.orientations, plan.robot
    sizes = [*grid.shape, orientations.nside, orientations.rolls]
    if grid.kind not in SIDE or not all(type(n) is int and 0 < n <= MOST_POSITIONS for n in sizes):
        return False
    frame = np.array(grid.T_base_map, dtype=float)
    figures = np.array([grid.step, *grid.lower, *frame.ravel()], dtype=float)
    return (
        math.prod(grid.shape) <= MOST_POSITIONS
        and len(orientations) <= MOST_ORIENTATIONS
        and orientations.nside.bit_count() == 1
        and len(grid.shape) == len(grid.lower) == len(grid.names)
        and frame.shape == (4, 4)
        and bool((np.abs(figures) <= FARTHEST).all())
        and grid.step > 0.0
        and plan.measures == tuple(name for name in MEASURES if name in plan.measures)
        and {*USUAL} <= {*plan.measures}
        and 0 <= plan.arcs <= MOST_ARCS
        and all(isinstance(robot[key], str) for key in ("name", "tip", "fingerprint"))
    )
