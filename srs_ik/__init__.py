"""Closed-form inverse kinematics for arms built like a human arm: a spherical shoulder, one elbow, a spherical wrist.

import srs_ik
arm = srs_ik.load("iiwa14")
solution = arm.solve(arm.forward_kinematics([0.1, 0.5, 0.2, -1.2, 0.3, 0.8, 0.0]))
"""

from __future__ import annotations

from contextlib import suppress
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from srs_ik.system.forks import WHOLE

if TYPE_CHECKING:
    from srs_ik import analysis as analysis
    from srs_ik import control as control
    from srs_ik import maps as maps
    from srs_ik import paper as paper
    from srs_ik import plots as plots
    from srs_ik import preview as preview
    from srs_ik import sim as sim
    from srs_ik.analysis.ellipsoids import (
        Ellipsoid,
        force_ellipsoid,
        force_velocity_ratio,
        manipulability,
        velocity_ellipsoid,
    )
    from srs_ik.analysis.polytopes import Polytope, force_polytope, velocity_polytope
    from srs_ik.arm import Arm
    from srs_ik.collision.links.bodies import Body
    from srs_ik.collision.links.pairs import Pair
    from srs_ik.collision.scenes.scene import Scene
    from srs_ik.errors import (
        AmbiguousLimb,
        FrameNotFound,
        InvalidConfiguration,
        InvalidController,
        InvalidMap,
        InvalidPose,
        InvalidRobot,
        InvalidScene,
        InvalidTask,
        MissingExtra,
        MissingLimits,
        NoBodies,
        NotAnSrsLimb,
        PreviewError,
        SrsIkError,
    )
    from srs_ik.inputs.freedom import FreeAxis
    from srs_ik.inputs.poses import PoseError, nearest_pose, xyz_quaternion
    from srs_ik.inputs.rotations import pose_from_xyz_quaternion, pose_from_xyz_rpy
    from srs_ik.inputs.task import Task
    from srs_ik.loading import LimbReport, find_limbs, load, robots
    from srs_ik.maps.build import build_map
    from srs_ik.maps.placement import Placement, base_placement
    from srs_ik.maps.reader import open_map
    from srs_ik.preview import Preview
    from srs_ik.robot.limb import Hand, SrsLimb
    from srs_ik.solve.free_splits import FreeSplit
    from srs_ik.solve.in_scene.edges import PathCollision
    from srs_ik.solve.intervals import Interval, IntervalsBatch
    from srs_ik.solve.objectives import OBJECTIVES, Objective
    from srs_ik.solve.optimise import Optimum
    from srs_ik.solve.path.breaks import PathBreak
    from srs_ik.solve.path.solution import PathSolution
    from srs_ik.solve.posture import Posture
    from srs_ik.solve.self_motion import SelfMotion
    from srs_ik.solve.solution import Collision, Solution, Status
    from srs_ik.solve.solutions import BatchSolution, Solutions
    from srs_ik.solve.task import BatchTaskSolution, TaskSolution

__version__ = "0.1.0"

_MODULES = {
    "arm": ("Arm",),
    "analysis.ellipsoids": (
        "Ellipsoid",
        "force_ellipsoid",
        "force_velocity_ratio",
        "manipulability",
        "velocity_ellipsoid",
    ),
    "collision.links.bodies": ("Body",),
    "collision.links.pairs": ("Pair",),
    "collision.scenes.scene": ("Scene",),
    "errors": (
        "AmbiguousLimb",
        "FrameNotFound",
        "InvalidConfiguration",
        "InvalidController",
        "InvalidMap",
        "InvalidPose",
        "InvalidRobot",
        "InvalidScene",
        "InvalidTask",
        "MissingExtra",
        "MissingLimits",
        "NoBodies",
        "NotAnSrsLimb",
        "PreviewError",
        "SrsIkError",
    ),
    "solve.derivatives": ("SolutionDerivatives",),
    "solve.free_splits": ("FreeSplit",),
    "solve.in_scene.edges": ("PathCollision",),
    "solve.intervals": ("Interval", "IntervalsBatch"),
    "robot.limb": ("Hand", "SrsLimb"),
    "loading": ("LimbReport", "find_limbs", "load", "robots"),
    "maps.build": ("build_map",),
    "maps.placement": ("Placement", "base_placement"),
    "maps.reader": ("open_map",),
    "solve.objectives": ("OBJECTIVES", "Objective"),
    "solve.optimise": ("Optimum",),
    "solve.path.solution": ("PathSolution",),
    "solve.path.breaks": ("PathBreak",),
    "analysis.polytopes": ("Polytope", "force_polytope", "velocity_polytope"),
    "preview": ("Preview",),
    "inputs.poses": ("PoseError", "nearest_pose", "xyz_quaternion"),
    "inputs.rotations": ("pose_from_xyz_quaternion", "pose_from_xyz_rpy"),
    "solve.self_motion": ("SelfMotion",),
    "solve.solution": ("Collision", "Solution", "Status"),
    "solve.solutions": ("BatchSolution", "Solutions"),
    "solve.posture": ("Posture",),
    "inputs.freedom": ("FreeAxis",),
    "inputs.task": ("Task",),
    "solve.task": ("BatchTaskSolution", "TaskSolution"),
    "solve.tracker.step": ("TrackerStatus", "TrackerStep"),
    "solve.tracker.tracker": ("Tracker",),
}
NAMESPACES = ("analysis", "control", "maps", "paper", "plots", "preview", "sim")
"""Rooms that have public names of their own."""

_HOME = {name: module for module, names in _MODULES.items() for name in names}

__all__ = [
    "OBJECTIVES",
    "AmbiguousLimb",
    "Arm",
    "BatchSolution",
    "BatchTaskSolution",
    "Body",
    "Collision",
    "Ellipsoid",
    "FrameNotFound",
    "FreeAxis",
    "FreeSplit",
    "Hand",
    "Interval",
    "IntervalsBatch",
    "InvalidConfiguration",
    "InvalidController",
    "InvalidMap",
    "InvalidPose",
    "InvalidRobot",
    "InvalidScene",
    "InvalidTask",
    "LimbReport",
    "MissingExtra",
    "MissingLimits",
    "NoBodies",
    "NotAnSrsLimb",
    "Objective",
    "Optimum",
    "Pair",
    "PathBreak",
    "PathCollision",
    "PathSolution",
    "Placement",
    "Polytope",
    "PoseError",
    "Posture",
    "Preview",
    "PreviewError",
    "Scene",
    "SelfMotion",
    "Solution",
    "SolutionDerivatives",
    "Solutions",
    "SrsIkError",
    "SrsLimb",
    "Status",
    "Task",
    "TaskSolution",
    "Tracker",
    "TrackerStatus",
    "TrackerStep",
    "base_placement",
    "build_map",
    "find_limbs",
    "force_ellipsoid",
    "force_polytope",
    "force_velocity_ratio",
    "load",
    "manipulability",
    "nearest_pose",
    "open_map",
    "pose_from_xyz_quaternion",
    "pose_from_xyz_rpy",
    "robots",
    "velocity_ellipsoid",
    "velocity_polytope",
    "xyz_quaternion",
]


if not TYPE_CHECKING:  # to which the names above are known, and no others

    def __getattr__(name: str) -> Any:
        """Import a public name from its module when it is first used."""
        if name in NAMESPACES:
            return import_module(f"srs_ik.{name}")
        if name not in _HOME:
            raise AttributeError(f"module 'srs_ik' has no attribute {name!r}{_hint(name)}")
        with WHOLE:
            value = getattr(import_module(f"srs_ik.{_HOME[name]}"), name)
        globals()[name] = value
        return value

    def _hint(name: str) -> str:
        """Where a name is that is not here: in a namespace, or misspelt."""
        from srs_ik.errors import did_you_mean

        if name.startswith("_") or find_spec(f"srs_ik.{name}"):
            return ""  # what Python asks of modules, and modules that are imported just now
        for room in NAMESPACES:
            with suppress(ImportError):  # a namespace whose extra is not installed
                if name in import_module(f"srs_ik.{room}").__all__:
                    return f"; it is srs_ik.{room}.{name}"
        return did_you_mean(name, __all__)


def __dir__() -> list[str]:
    return sorted({*__all__, *NAMESPACES, *(name for name in globals() if name.startswith("__"))})
