"""How a pose is given on the command line: the options that several commands share, and their reading."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from srs_ik.cli.options import Four, Seven, Three, WrongInput, numbers, warn

if TYPE_CHECKING:
    import numpy as np

QUATERNION_TOLERANCE = 1e-3
"""A quaternion typed with four digits is still one; it is normalised."""

JOINTS = "Q1 .. Q7"

Xyz = Annotated[Three | None, typer.Option(metavar="X Y Z", help="Position of the tip in the base frame, metres.")]
Rpy = Annotated[
    Three | None,
    typer.Option(metavar="R P Y", help="Orientation as in a URDF: about the fixed x, then y, then z axis, radians."),
]
Quat = Annotated[
    Four | None, typer.Option(metavar="X Y Z W", help="Orientation as a unit quaternion, the scalar part last.")
]
PoseOfQ = Annotated[
    Seven | None, typer.Option("--q", metavar=JOINTS, help="Instead of a pose: the pose that these joint angles reach.")
]
NoLimits = Annotated[bool, typer.Option("--no-limits", help="Ignore the joint limits.")]


def unit_of(degrees: bool) -> float:
    """Radians in the unit in which angles are given."""
    return math.pi / 180.0 if degrees else 1.0


def angles(option: str, words: Sequence[str], unit: float, remedy: str = " Then add --degrees.") -> list[float]:
    """Angles in radians, of words in a unit; a line on standard error where these are radians and look like degrees.

    It names the option that they belong to, and ends with the remedy: what to do.

    Raises:
        WrongInput: a word is no finite number.
    """
    given = numbers(option, words)
    if unit == 1.0:
        warn_of_degrees(option, given, remedy)
    return [unit * angle for angle in given]


def warn_of_degrees(where: str, given: Sequence[float], remedy: str) -> None:
    """Print a line on standard error if an angle in radians is more than a turn."""
    largest = max(given, key=abs, default=0.0)
    if abs(largest) > 2.0 * math.pi:
        warn(f"{where} is in radians, and {largest:g} rad is more than a turn: are these degrees?{remedy}")


def read_pose(
    xyz: Three | None, rpy: Three | None, quat: Four | None, q: Seven | None, unit: float, turned: bool = False
) -> tuple[np.ndarray | None, list[float]]:
    """The pose (4, 4) of the tip in the base frame that the options give, or 7 joint angles, rad, that reach it.

    Words of positions are in metres, those of angles in a unit; of pose and joint angles one is given, the other none.
    A position alone will do where the tip may be `turned` as it likes.

    Raises:
        WrongInput: not exactly one pose is given, or its words are no finite numbers, or its quaternion no rotation.
    """
    if q and (xyz or rpy or quat):
        raise WrongInput("--q is a pose already and goes with none of --xyz, --rpy and --quat")
    configuration = angles("--q", q or (), unit)
    return (None if q else _given_pose(xyz, rpy, quat, unit, turned)), configuration


def _given_pose(xyz: Three | None, rpy: Three | None, quat: Four | None, unit: float, turned: bool) -> np.ndarray:
    if xyz is None and rpy is None and quat is None:
        raise WrongInput("give a pose: --xyz with --rpy or --quat, or --q")
    if rpy is not None and quat is not None:
        raise WrongInput("--rpy and --quat are two ways to give the orientation: give one")
    if xyz is None:
        raise WrongInput("an orientation alone is no pose: give the position with --xyz X Y Z")

    import numpy as np
    import pinocchio as pin

    T_base_tip = np.eye(4)
    T_base_tip[:3, 3] = numbers("--xyz", xyz)
    if rpy is not None:
        T_base_tip[:3, :3] = pin.rpy.rpyToMatrix(np.array(angles("--rpy", rpy, unit)))
    elif quat is not None:
        components = np.array(numbers("--quat", quat))
        length = math.hypot(*components)
        if abs(length - 1.0) > QUATERNION_TOLERANCE:
            raise WrongInput(f"--quat is a rotation only if its length is 1, not {length:.6g}")
        T_base_tip[:3, :3] = pin.Quaternion(components / length).toRotationMatrix()
    elif not turned:
        given = "a position alone is no pose: give the orientation with --rpy R P Y or --quat X Y Z W"
        raise WrongInput(f"{given}; 'srs-ik solve' leaves it free with --free-axis 0 0 1 --cone 180 --degrees")
    return T_base_tip
