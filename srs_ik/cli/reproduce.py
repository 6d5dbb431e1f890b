"""`srs-ik reproduce`: the experiments of the paper, into a folder."""

from __future__ import annotations

import sys
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from srs_ik.cli.options import AllowXacro, Base, Limb, Tip, WrongInput, numbers
from srs_ik.cli.picture import check
from srs_ik.cli.task import Six

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

PAPERS_LIMB = "human_arm"


class Experiment(StrEnum):
    """What is reproduced."""

    lr_arms = "lr-arms"
    arm_sphere = "arm-sphere"
    ik_accuracy = "ik-accuracy"
    c_grasp = "c-grasp"
    walking = "walking"
    all = "all"


def reproduce(
    experiment: Annotated[
        Experiment,
        typer.Argument(
            help="Left and right arms at one target; targets in a sphere; errors of the inverse kinematics; C against "
            "extension and grasp; a walking leg; or all of them.",
            show_default=False,
        ),
    ],
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Folder of the results; has to be given.")] = None,
    robot: Annotated[
        str, typer.Option(metavar="ROBOT|FILE", help="Another arm than the paper's limb, by name or file.")
    ] = PAPERS_LIMB,
    base: Base = None,
    tip: Tip = None,
    limb: Limb = None,
    allow_xacro: AllowXacro = False,
    hand: Annotated[
        Six | None,
        typer.Option(
            metavar="GX GY GZ PX PY PZ",
            help="Grasp and pronosupination direction of the hand in the tip frame, for a robot that gives none.",
        ),
    ] = None,
) -> None:
    """Repeat the experiments of the source paper on its limb, or on any arm (extra 'plot').

    Each leaves a picture, NAME.png and NAME.svg, and its figures in NAME.json. The folder is made if it is not there.
    Joint limits play no part, as in the paper.
    """
    if out is None:
        raise WrongInput("name the folder of the results: --out DIR")
    if out.exists() and not out.is_dir():
        raise WrongInput(f"--out: {str(out)!r} is no folder")
    check(Path("figure.png"), "srs-ik reproduce")
    axes = None if hand is None else numbers("--hand", hand)

    from rich.console import Console
    from rich.progress import Progress

    from srs_ik.loading import load
    from srs_ik.paper.experiments import EXPERIMENTS
    from srs_ik.paper.experiments.files import write

    arm = load(
        robot,
        base=base,
        tip=tip,
        limb=limb,
        allow_xacro=allow_xacro,
        hand=None if axes is None else [axes[:3], axes[3:]],
    )
    names = list(EXPERIMENTS) if experiment is Experiment.all else [experiment.value]
    out.mkdir(parents=True, exist_ok=True)
    # Where nobody looks, a bar would leave an empty line.
    with Progress(console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as bar:
        for name in names:
            # Drawing takes about as long as computing.
            task = bar.add_task(name, total=2.0)
            outcome = EXPERIMENTS[name](arm, partial(_advance, bar, task))
            for path in write(out, name, arm, outcome):
                typer.echo(path)
            bar.update(task, completed=2.0)


def _advance(bar: Progress, task: TaskID, share: float) -> None:
    bar.update(task, completed=share)
