"""How an objective is given on the command line: its name, and the parameters that it takes."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Annotated, Any

import typer

from srs_ik.cli.options import Seven, Six, Three, WrongInput, numbers
from srs_ik.cli.poses import JOINTS, angles

if TYPE_CHECKING:
    from srs_ik.solve.objectives import Objective

SIX = "X Y Z RX RY RZ"

Name = Annotated[
    str | None,
    typer.Option(
        metavar="NAME",
        help="Choose the best posture of all by this objective, such as manipulability or force_velocity_ratio.",
    ),
]
Force = Annotated[Three | None, typer.Option(metavar="X Y Z", help="For --objective: direction of the force.")]
Velocity = Annotated[Three | None, typer.Option(metavar="X Y Z", help="For --objective: direction of the velocity.")]
Twist = Annotated[Six | None, typer.Option(metavar=SIX, help="For --objective: direction of a twist, linear first.")]
Wrench = Annotated[Six | None, typer.Option(metavar=SIX, help="For --objective: direction of a wrench, force first.")]
Reference = Annotated[Seven | None, typer.Option(metavar=JOINTS, help="For --objective reference_posture.")]
Tolerance = Annotated[
    str | None,
    typer.Option(metavar="SHARE", help="For a lexicographic --objective: what its first part gives away, 0.01."),
]


def read_objective(
    name: str | None,
    force: Three | None,
    velocity: Three | None,
    twist: Six | None,
    wrench: Six | None,
    reference: Seven | None,
    tolerance: str | None,
    unit: float,
) -> Objective | str | None:
    """The objective that the options give, the name of one that a scene has to tell, or None.

    Raises:
        WrongInput: a parameter without an objective, words that are no finite numbers, an unknown objective, or not the
            parameters that it takes.
    """
    words = {"force": force, "velocity": velocity, "twist": twist, "wrench": wrench, "reference": reference}
    given: dict[str, Any] = {key: numbers(f"--{key}", value) for key, value in words.items() if value is not None}
    if tolerance is not None:
        (given["tolerance"],) = numbers("--tolerance", [tolerance])
    if name is None:
        if given:
            raise WrongInput(f"--{next(iter(given))} is a parameter of an objective: give --objective NAME")
        return None

    from srs_ik.errors import InvalidTask
    from srs_ik.solve.objectives import CLEARANCE, Objective

    if name == CLEARANCE and not given:
        return name
    if reference is not None:
        given["reference"] = angles("--reference", reference, unit)
    try:
        return Objective(name, **given)
    except InvalidTask as error:
        # Parameters are options here.
        raise WrongInput(re.sub(r"\b(\w+)=", r"--\1", str(error))) from None
