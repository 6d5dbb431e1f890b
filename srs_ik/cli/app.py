"""The command group: its commands, and how every wrong input becomes one line on standard error."""

from __future__ import annotations

import re
import sys
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from srs_ik import __version__
from srs_ik.cli import (
    EXIT_BROKEN_PIPE,
    EXIT_WRONG_INPUT,
    bench,
    collisions,
    ellipsoids,
    fk,
    follow,
    inspect,
    intervals,
    map_use,
    path,
    place,
    plot,
    preview,
    reproduce,
    robots,
    solve,
    task,
    warm,
)
from srs_ik.cli.options import ExampleCommand, NumbersCommand, WrongInput
from srs_ik.cli.waiting import announce_compilation

_HAND_OPTION = (
    "give its grasp and pronosupination direction there, --hand GX GY GZ PX PY PZ; "
    "'srs-ik inspect' says where the hand points"
)

WIDEST_HELP = 120
"""Columns of a help text, where the terminal has them."""


class OneLineGroup(TyperGroup):
    """A command group that answers wrong input with one line on standard error and exit status 2.

    Errors that are neither the command line's nor the package's own are faults of the program and pass unchanged.
    """

    def main(self, *args: Any, **options: Any) -> Any:
        """Run the group; arguments as for the base class."""
        standalone_mode = options.pop("standalone_mode", True)
        try:
            result = super().main(*args, **{**options, "standalone_mode": False})
        except SystemExit:
            # Without its standalone mode the base class does so only where the reader of a pipe has seen enough.
            result = EXIT_BROKEN_PIPE
        except Exception as error:
            line = _wrong_input(error)
            if line is None or not standalone_mode:
                raise
            print(f"srs-ik: {line}", file=sys.stderr)
            result = EXIT_WRONG_INPUT
        if standalone_mode:
            sys.exit(result if isinstance(result, int) else 0)
        return result


def _wrong_input(error: Exception) -> str | None:
    """The error in one line if it is the input, or the place of the output, that is wrong, else None."""
    from srs_ik.errors import AmbiguousLimb, InvalidTask, SrsIkError

    if hasattr(error, "possibilities") and getattr(error, "option_name", None):
        return _no_such_option(error)
    if isinstance(error, AmbiguousLimb):
        # What is an argument in Python is an option here.
        return re.sub(r"\b(base|tip|limb)='([^']*)'", r"--\1 \2", str(error))
    if isinstance(error, InvalidTask):
        return re.sub(r"load it with hand=\(.*", _HAND_OPTION, str(error))
    if isinstance(error, OSError):
        return f"{error.filename or 'cannot write the output'}: {error.strerror or error}"
    # The command-line library's own errors are told by their method, because typer has moved their base class about.
    formatted = getattr(error, "format_message", None)
    if formatted is None and not isinstance(error, (SrsIkError, WrongInput)):
        return None
    said = " ".join(str(formatted() if formatted else error).split())
    # What typer puts before the message of an enumeration's own error.
    return said.replace("': Value error, ", "': ")


def _no_such_option(error: Any) -> str:
    """An option that a command lacks, with those of its options that are close, or else all of them."""
    from srs_ik.errors import did_you_mean

    command = error.ctx.command
    options = [param.opts[0] for param in command.params if param.opts[0].startswith("--")]
    hint = did_you_mean(error.option_name, options) or f"; it takes {', '.join([*options, '--help'])}"
    return f"{error.ctx.info_name} has no option {error.option_name}{hint}"


def _show_version(context: typer.Context, wanted: bool) -> None:
    if wanted:
        typer.echo(__version__)
        if context.params.get("verbose"):
            from srs_ik.kernels.native import at_work

            typer.echo(f"kernels: {at_work()}")
        raise typer.Exit


app = typer.Typer(
    cls=OneLineGroup,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"max_content_width": WIDEST_HELP},
)


@app.callback(invoke_without_command=True)
def srs_ik(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and leave.", callback=_show_version)
    ] = False,
    verbose: Annotated[
        bool, typer.Option("--verbose", help="With --version: how kernels are compiled, too.", is_eager=True)
    ] = False,
) -> None:
    """Inverse kinematics of 7-joint shoulder-elbow-wrist (S-R-S) arms, in metres and radians.

    Exit status: 0 on success, 1 where there is no solution, 2 for wrong input.
    """
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
    elif "--help" not in sys.argv:
        announce_compilation()


_COMMANDS = (
    ("robots", robots.robots, ExampleCommand, "List the robots that have names."),
    ("inspect", inspect.inspect, ExampleCommand, "Show the 7-joint arms of a robot file."),
    ("fk", fk.fk, NumbersCommand, "Show the pose of the tip at joint angles."),
    ("solve", solve.solve, NumbersCommand, "Find joint angles that bring the tip to a pose."),
    ("intervals", intervals.intervals, NumbersCommand, "List the feasible arm angles of a pose."),
    ("path", path.path, NumbersCommand, "Find a continuous joint path through many poses."),
    ("follow", follow.follow, NumbersCommand, "Follow a moving target within all limits."),
    ("collisions", collisions.collisions, NumbersCommand, "Tell what meets at given joint angles."),
    ("task", task.task, NumbersCommand, "Find the posture that suits a task."),
    ("ellipsoids", ellipsoids.ellipsoids, NumbersCommand, "Show the velocity and force ellipsoids of the tip."),
    ("place", place.place, NumbersCommand, "Rank places for the base by the poses reached."),
    ("plot", plot.plot, NumbersCommand, "Draw a picture of an arm at a pose (extra 'plot')."),
    ("preview", preview.preview, NumbersCommand, "Show an arm in the browser, or save the page."),
    ("reproduce", reproduce.reproduce, NumbersCommand, "Repeat the experiments of the source paper."),
    ("bench", bench.bench, ExampleCommand, "Time every call on this machine."),
    ("warm", warm.warm, None, "Compile all kernels now, where none came compiled."),
)
"""Name, function, class, and what the list of commands says of it: in one line of a terminal of 80 columns."""

for name, function, kind, summary in _COMMANDS:
    app.command(name, cls=kind, short_help=summary)(function)
app.add_typer(map_use.map_app, name="map", short_help="Make and use maps of what an arm reaches.")
