"""Closed-form inverse kinematics for arms built like a human arm: a spherical shoulder, one elbow, a spherical wrist.

import srs_ik
arm = srs_ik.load("iiwa14")
solution = arm.solve(arm.forward_kinematics([0.1, 0.5, 0.2, -1.2, 0.3, 0.8, 0.0]))
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from srs_ik.analysis.ellipsoids import (
        Ellipsoid,
        force_ellipsoid,
        force_transmission,
        force_velocity_ratio,
        isotropy,
        manipulability,
        velocity_ellipsoid,
        velocity_transmission,
    )
    from srs_ik.analysis.polytopes import Polytope, force_polytope, velocity_polytope
    from srs_ik.arm import Arm
    from srs_ik.errors import (
        AmbiguousLimb,
        FrameNotFound,
        InvalidConfiguration,
        InvalidPose,
        InvalidRobot,
        InvalidTask,
        MissingExtra,
        MissingLimits,
        NotAnSrsLimb,
        PreviewError,
        SrsIkError,
    )
    from srs_ik.inputs.poses import PoseError
    from srs_ik.inputs.rotations import pose_from_xyz_quaternion, pose_from_xyz_rpy, xyz_quaternion
    from srs_ik.loading import LimbReport, find_limbs, load, robots
    from srs_ik.paper.printed_optimum import PrintedOptimum, printed_optimum
    from srs_ik.plots import plot_arm_angle, plot_ellipsoids, plot_intervals
    from srs_ik.preview import Preview
    from srs_ik.preview.interactive import InteractivePreview
    from srs_ik.robot.limb import Hand, SrsLimb
    from srs_ik.solve.intervals import IntervalsBatch
    from srs_ik.solve.objectives import OBJECTIVES, Objective
    from srs_ik.solve.optimise import Optimum
    from srs_ik.solve.path import PathSolution
    from srs_ik.solve.path_breaks import PathBreak
    from srs_ik.solve.posture import Posture, Task
    from srs_ik.solve.self_motion import SelfMotion
    from srs_ik.solve.solution import BatchSolution, Interval, Solution, Solutions, Status
    from srs_ik.solve.task import BatchTaskSolution, TaskSolution

__version__ = "0.1.0"

_MODULES = {
    "arm": ("Arm",),
    "analysis.ellipsoids": (
        "Ellipsoid",
        "force_ellipsoid",
        "force_transmission",
        "force_velocity_ratio",
        "isotropy",
        "manipulability",
        "velocity_ellipsoid",
        "velocity_transmission",
    ),
    "errors": (
        "AmbiguousLimb",
        "FrameNotFound",
        "InvalidConfiguration",
        "InvalidPose",
        "InvalidRobot",
        "InvalidTask",
        "MissingExtra",
        "MissingLimits",
        "NotAnSrsLimb",
        "PreviewError",
        "SrsIkError",
    ),
    "solve.intervals": ("IntervalsBatch",),
    "robot.limb": ("Hand", "SrsLimb"),
    "loading": ("LimbReport", "find_limbs", "load", "robots"),
    "solve.objectives": ("OBJECTIVES", "Objective"),
    "solve.optimise": ("Optimum",),
    "solve.path": ("PathSolution",),
    "solve.path_breaks": ("PathBreak",),
    "plots": ("plot_arm_angle", "plot_ellipsoids", "plot_intervals"),
    "analysis.polytopes": ("Polytope", "force_polytope", "velocity_polytope"),
    "preview": ("Preview",),
    "preview.interactive": ("InteractivePreview",),
    "paper.printed_optimum": ("PrintedOptimum", "printed_optimum"),
    "inputs.poses": ("PoseError",),
    "inputs.rotations": ("pose_from_xyz_quaternion", "pose_from_xyz_rpy", "xyz_quaternion"),
    "solve.self_motion": ("SelfMotion",),
    "solve.solution": ("BatchSolution", "Interval", "Solution", "Solutions", "Status"),
    "solve.posture": ("Posture", "Task"),
    "solve.task": ("BatchTaskSolution", "TaskSolution"),
}
_HOME = {name: module for module, names in _MODULES.items() for name in names}

__all__ = [
    "OBJECTIVES",
    "AmbiguousLimb",
    "Arm",
    "BatchSolution",
    "BatchTaskSolution",
    "Ellipsoid",
    "FrameNotFound",
    "Hand",
    "InteractivePreview",
    "Interval",
    "IntervalsBatch",
    "InvalidConfiguration",
    "InvalidPose",
    "InvalidRobot",
    "InvalidTask",
    "LimbReport",
    "MissingExtra",
    "MissingLimits",
    "NotAnSrsLimb",
    "Objective",
    "Optimum",
    "PathBreak",
    "PathSolution",
    "Polytope",
    "PoseError",
    "Posture",
    "Preview",
    "PreviewError",
    "PrintedOptimum",
    "SelfMotion",
    "Solution",
    "Solutions",
    "SrsIkError",
    "SrsLimb",
    "Status",
    "Task",
    "TaskSolution",
    "find_limbs",
    "force_ellipsoid",
    "force_polytope",
    "force_transmission",
    "force_velocity_ratio",
    "isotropy",
    "load",
    "manipulability",
    "plot_arm_angle",
    "plot_ellipsoids",
    "plot_intervals",
    "pose_from_xyz_quaternion",
    "pose_from_xyz_rpy",
    "printed_optimum",
    "robots",
    "velocity_ellipsoid",
    "velocity_polytope",
    "velocity_transmission",
    "xyz_quaternion",
]


def __getattr__(name: str) -> Any:
    """Import a public name from its module when it is first used."""
    if name not in _HOME:
        raise AttributeError(f"module 'srs_ik' has no attribute {name!r}")
    value = getattr(import_module(f"srs_ik.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
