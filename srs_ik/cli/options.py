"""Options that several commands share, and the reading of numbers from the command line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated

import typer

Source = Annotated[
    str,
    typer.Argument(
        metavar="ROBOT|FILE", help="A URDF file, or the name of a robot (see 'srs-ik robots').", show_default=False
    ),
]
Base = Annotated[
    str | None, typer.Option(metavar="FRAME", help="Base frame; may be left out where there is one choice.")
]
Tip = Annotated[str | None, typer.Option(metavar="FRAME", help="Tip frame; may be left out where there is one choice.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON and nothing else, in metres and radians.")]

Three = tuple[str, str, str]
Four = tuple[str, str, str, str]
Seven = tuple[str, str, str, str, str, str, str]


def numbers(option: str, words: Sequence[str]) -> list[float]:
    """Read the numbers that an option was given.

    Words rather than numbers are taken from the command line so that a missing number is called that: in
    `--xyz 1 2 --rpy 0 0 0` the third word of `--xyz` is `--rpy`.

    Raises:
        typer.BadParameter: if a word is no finite number.
    """
    values = []
    for i, word in enumerate(words):
        try:
            value = float(word)
        except ValueError:
            if word.startswith("--"):
                raise typer.BadParameter(f"{option} takes {len(words)} numbers, not {i}.") from None
            raise typer.BadParameter(f"{option} takes {len(words)} numbers, and {word!r} is not a number.") from None
        if not math.isfinite(value):
            raise typer.BadParameter(f"{option} takes {len(words)} finite numbers, not {word}.")
        values.append(value)
    return values
