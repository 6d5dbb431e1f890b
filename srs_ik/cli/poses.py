"""How a pose is given on the command line: the options that several commands share, and their reading."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

import typer

from srs_ik.cli.options import Four, Seven, Three, WrongInput, numbers

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
FromQ = Annotated[
    Seven | None, typer.Option(metavar=JOINTS, help="Instead of a pose: the pose that these joint angles reach.")
]
NoLimits = Annotated[bool, typer.Option("--no-limits", help="Ignore the joint limits.")]


def unit_of(degrees: bool) -> float:
    """Radians in the unit in which angles are given."""
    return math.pi / 180.0 if degrees else 1.0


def read_pose(
    xyz: Three | None, rpy: Three | None, quat: Four | None, from_q: Seven | None, unit: float
) -> tuple[np.ndarray | None, list[float]]:
    """The pose of the tip in the base frame that the options give, or the joint angles that reach it.

    Args:
        xyz: words for the position, metres.
        rpy: words for three angles.
        quat: words for a quaternion.
        from_q: words for seven joint angles.
        unit: radians in the unit of the angles.

    Returns:
        (4, 4) pose and no angles, or None and 7 angles, rad.

    Raises:
        WrongInput: not exactly one pose is given, or its words are no finite numbers, or its quaternion no rotation.
    """
    q = [unit * x for x in numbers("--from-q", from_q or ())]
    if q and (xyz or rpy or quat):
        raise WrongInput("--from-q is a pose already and goes with none of --xyz, --rpy and --quat")
    return (None if q else _given_pose(xyz, rpy, quat, unit)), q


def _given_pose(xyz: Three | None, rpy: Three | None, quat: Four | None, unit: float) -> np.ndarray:
    if xyz is None and rpy is None and quat is None:
        raise WrongInput("give a pose: --xyz with --rpy or --quat, or --from-q")
    if rpy is not None and quat is not None:
        raise WrongInput("--rpy and --quat are two ways to give the orientation: give one")
    if xyz is None:
        raise WrongInput("an orientation alone is no pose: give the position with --xyz X Y Z")

    import numpy as np
    import pinocchio as pin

    T_base_tip = np.eye(4)
    T_base_tip[:3, 3] = numbers("--xyz", xyz)
    if rpy is not None:
        T_base_tip[:3, :3] = pin.rpy.rpyToMatrix(unit * np.array(numbers("--rpy", rpy)))
    elif quat is not None:
        components = np.array(numbers("--quat", quat))
        length = float(np.linalg.norm(components))
        if abs(length - 1.0) > QUATERNION_TOLERANCE:
            raise WrongInput(f"--quat is a rotation only if its length is 1, not {length:.6g}")
        T_base_tip[:3, :3] = pin.Quaternion(components / length).toRotationMatrix()
    else:
        raise WrongInput("a position alone is no pose: give the orientation with --rpy R P Y or --quat X Y Z W")
    return T_base_tip
