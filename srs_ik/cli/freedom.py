"""Options for what of a pose's rotation is free."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from srs_ik.cli.options import Three, WrongInput, numbers

if TYPE_CHECKING:
    from srs_ik.inputs.freedom import FreeAxis

Axis = Annotated[
    Three | None,
    typer.Option("--free-axis", metavar="X Y Z", help="The roll about this direction of the tip frame is free."),
]
Cone = Annotated[
    str | None,
    typer.Option("--cone", metavar="ANGLE", help="With --free-axis: it may lean so far; half a turn: any rotation."),
]


def read(axis: Three | None, cone: str | None, unit: float) -> FreeAxis | None:
    """What is free.

    Raises:
        WrongInput: a cone about no axis, or none in degrees.
        InvalidTask: no direction, or no cone.
    """
    if axis is None:
        if cone is not None:
            raise WrongInput("--cone says how far the direction of --free-axis may lean: give that too")
        return None
    from srs_ik.inputs.freedom import FreeAxis

    lean = 0.0 if cone is None else numbers("--cone", [cone])[0]
    if unit != 1.0 and not 0.0 <= lean <= 180.0:
        raise WrongInput(f"--cone must be an angle from 0 to 180 degrees, not {cone}")
    return FreeAxis(numbers("--free-axis", axis), unit * lean)
