"""`srs-ik reproduce`: the experiments of the paper, into a folder."""

from __future__ import annotations

import sys
from collections.abc import Callable
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from srs_ik.cli.chosen import Chosen, choosing
from srs_ik.cli.options import Hand, WrongInput, numbers
from srs_ik.cli.picture import check

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

    from srs_ik.arm import Arm
    from srs_ik.paper.experiments.setting import Outcome

PAPERS_LIMB = "human_arm"
CONTROLLED_ARM = "iiwa14"


class Experiment(StrEnum):
    """What is reproduced."""

    lr_arms = "lr-arms"
    arm_sphere = "arm-sphere"
    ik_accuracy = "ik-accuracy"
    c_grasp = "c-grasp"
    walking = "walking"
    all = "all"
    control = "control"


@choosing
def reproduce(
    experiments: Annotated[
        list[Experiment],
        typer.Argument(
            metavar="EXPERIMENT...",
            help="Left and right arms at one target; targets in a sphere; errors of the inverse kinematics; C against "
            "extension and grasp; a walking leg; or all of these five. Several may be named. And control: torque "
            "control in simulation, ten experiments (extra 'sim').",
            show_default=False,
        ),
    ],
    chosen: Chosen,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Folder of the results; has to be given.")] = None,
    robot: Annotated[
        str | None,
        typer.Option(
            metavar="ROBOT|FILE",
            help="Another arm than the paper's limb, by name or file; control takes iiwa14 if none is named.",
            show_default=False,
        ),
    ] = None,
    hand: Hand = None,
    short: Annotated[
        bool, typer.Option("--short", help="Control alone: few seeds and short motions, to see that all runs.")
    ] = False,
) -> None:
    """Repeat the experiments of the source paper on its limb, or on any arm (extra 'plot').

    Each leaves a picture, NAME.png and NAME.svg, and its figures in NAME.json. The folder is made if it is not there.
    Joint limits play no part, as in the paper. "control" is what the paper leaves to the future: some minutes in
    MuJoCo, with the names control-NAME.
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
    from srs_ik.paper.experiments.files import write

    chosen_ones = _experiments(experiments, short)
    arm = load(
        robot or (CONTROLLED_ARM if Experiment.control in experiments else PAPERS_LIMB),
        **chosen,
        hand=None if axes is None else [axes[:3], axes[3:]],
    )
    out.mkdir(parents=True, exist_ok=True)
    # Where nobody looks, a bar would leave an empty line.
    with Progress(console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as bar:
        for name, run in chosen_ones.items():
            # Drawing takes about as long as computing.
            task = bar.add_task(name, total=2.0)
            outcome = run(arm, partial(_advance, bar, task))
            for path in write(out, name, arm, outcome):
                typer.echo(path)
            bar.update(task, completed=2.0)


def _experiments(named: list[Experiment], short: bool) -> dict[str, Callable[[Arm, Callable[[float], None]], Outcome]]:
    """The experiments to run, by name, each a function of an arm and a progress.

    Raises:
        MissingExtra: MuJoCo is not installed, and control is chosen.
        WrongInput: control is named with others, whose arm is another one.
    """
    if Experiment.control in named:
        if len(named) > 1:
            raise WrongInput("control is named alone: it takes another arm than the rest")
        from srs_ik.paper.experiments.control import CONTROL
        from srs_ik.sim.model import import_mujoco

        import_mujoco()
        return {name: partial(run, short=short) for name, run in CONTROL.items()}
    from srs_ik.paper.experiments import EXPERIMENTS

    if short:
        raise WrongInput("--short is for control alone")
    return {name: run for name, run in EXPERIMENTS.items() if Experiment.all in named or name in named}


def _advance(bar: Progress, task: TaskID, share: float) -> None:
    bar.update(task, completed=share)
