"""Options for what of a pose's rotation is free."""

from __future__ import annotations

from dataclasses import dataclass
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


@dataclass
class Free:
    """What of a pose's rotation is free."""

    free_axis: Axis = None
    cone: Cone = None

    def read(self, unit: float) -> FreeAxis | None:
        """What is free.

        Raises:
            WrongInput: a cone about no axis, or none in degrees.
            InvalidTask: no direction, or no cone.
        """
        if self.free_axis is None:
            if self.cone is not None:
                raise WrongInput("--cone says how far the direction of --free-axis may lean: give that too")
            return None
        from srs_ik.inputs.freedom import FreeAxis

        lean = 0.0 if self.cone is None else numbers("--cone", [self.cone])[0]
        if unit != 1.0 and not 0.0 <= lean <= 180.0:
            raise WrongInput(f"--cone must be an angle from 0 to 180 degrees, not {self.cone}")
        return FreeAxis(numbers("--free-axis", self.free_axis), unit * lean)
