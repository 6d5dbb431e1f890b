"""Options that several commands share, and the reading of numbers from the command line."""

from __future__ import annotations

import itertools
import math
import sys
from collections.abc import Sequence
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperCommand

from srs_ik.cli import EXIT_NO_SOLUTION
from srs_ik.cli.examples import with_examples

Three = tuple[str, str, str]
Four = tuple[str, str, str, str]
Six = tuple[str, str, str, str, str, str]
Seven = tuple[str, str, str, str, str, str, str]

Source = Annotated[
    str,
    typer.Argument(
        metavar="ROBOT|FILE",
        help="The name of a robot (see 'srs-ik robots'), a URDF, xacro or MJCF file, or an adapter (robot.toml). "
        "A xacro file is a program: name only those that you trust.",
        show_default=False,
    ),
]
Hand = Annotated[
    Six | None,
    typer.Option(
        metavar="GX GY GZ PX PY PZ",
        help="Grasp and pronosupination direction of the hand in the tip frame, for a robot that gives none.",
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON and nothing else, in metres and radians.")]


FORMER_Q = "--from-q"
"""What --q was called in some commands; still understood in all."""


class WrongInput(Exception):
    """Words on the command line that make no sense; the message is one sentence."""


def warn(text: str) -> None:
    """Print one line on standard error about what is probably meant otherwise."""
    print(f"srs-ik: {text}", file=sys.stderr)


def fail(text: str) -> NoReturn:
    """Print one line on standard error about what was not found, and leave with exit status 1."""
    warn(text)
    raise typer.Exit(EXIT_NO_SOLUTION)


class ExampleCommand(TyperCommand):
    """A command whose help ends with examples."""

    get_help = with_examples(TyperCommand.get_help)


class NumbersCommand(ExampleCommand):
    """A command whose options of several numbers say how many they take.

    The parser behind it hands such an option the next words whatever they are, and then stumbles over the rest: of
    `--xyz 1 2 --rpy 0 0 0` it would say that three zeros are too many.
    """

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Check the count of the numbers behind each option, then parse."""
        if any("--q" in param.opts for param in self.params):
            args = ["--q" if word == FORMER_Q else word for word in args]
        counts = {name: param.nargs for param in self.params if param.nargs > 1 for name in param.opts}
        for i, word in enumerate(args):
            if word in counts:
                _check_count(word, counts[word], args[i + 1 :])
        return super().parse_args(ctx, args)


def _check_count(option: str, count: int, following: list[str]) -> None:
    given = list(itertools.takewhile(is_number, following))
    if len(given) == count:
        return
    culprit = following[len(given)] if len(given) < min(count, len(following)) else "--"
    if culprit.startswith("--"):
        raise WrongInput(f"{option} takes {count} numbers, not {len(given)}")
    raise WrongInput(f"{option} takes {count} numbers, and {culprit!r} is not a number")


def is_number(word: str) -> bool:
    """Whether a word is a number as people write it: Python takes 1_0 for ten, too."""
    try:
        float(word)
    except ValueError:
        return False
    return "_" not in word


def numbers(option: str, words: Sequence[str]) -> list[float]:
    """Read the numbers that an option was given; raises WrongInput where a word is no finite number."""
    for word in words:
        if not is_number(word):
            raise WrongInput(f"{option} takes a number, not {word!r}")
        if not math.isfinite(float(word)):
            raise WrongInput(f"{option} takes finite numbers, not {word}")
    return [float(word) for word in words]
