"""`srs-ik map`: make capability maps, or say what they would take; the other commands are in `map_use`."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from srs_ik.cli.chosen import Chosen, choosing
from srs_ik.cli.options import AsJson, NumbersCommand, Six, Source, Three, WrongInput, numbers
from srs_ik.cli.scenes import Meshes, SceneFile, read, with_meshes

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.maps.build import Estimate, Progress

map_app = typer.Typer(no_args_is_help=True, rich_markup_mode=None, help="Maps of what an arm reaches, and how well.")

Step = Annotated[str, typer.Option(metavar="METRES", help="Distance between positions.")]
Turns = Annotated[
    int, typer.Option(metavar="N", help="Orientations: 12 x 4^k x rolls, such as 576, 2304, 4608 or 36864.")
]
InBox = Annotated[bool, typer.Option("--box", help="Map a box around all that is reached, not the half-plane.")]
Bounds = Annotated[
    Six | None, typer.Option(metavar="X0 X1 Y0 Y1 Z0 Z1", help="Map this box of the base frame, metres.")
]
More = Annotated[
    list[str] | None,
    typer.Option("--measure", metavar="NAME", help="margin or manipulability as well; may be repeated."),
]
Velocity = Annotated[
    Three | None,
    typer.Option(metavar="X Y Z", help="Direction in which a task moves: with --force, its ratio C in every cell."),
]
Force = Annotated[Three | None, typer.Option(metavar="X Y Z", help="Direction in which the task pushes.")]


def _grid(step: str, box: bool, bounds: tuple[str, ...] | None) -> tuple[float, Any]:
    where: Any = box
    if bounds is not None:
        x = numbers("--bounds", bounds)
        where = [x[0:2], x[2:4], x[4:6]]
    return numbers("--step", [step])[0], where


def _more(measure: list[str] | None, scene: Path | None, velocity: Three | None, force: Three | None) -> dict[str, Any]:
    """What is asked for beyond the usual measures, as arguments of `build_map`."""
    return {
        "measures": measure or (),
        "velocity": None if velocity is None else numbers("--velocity", velocity),
        "force": None if force is None else numbers("--force", force),
        "scene": read(scene, None).get("scene"),
    }


@contextmanager
def _bar(what: str, cells: int) -> Iterator[Progress]:
    """A bar with the time left, in a terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:>3.0f} %"))
    left = (TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn())
    console = Console(stderr=True)
    with Progress(*columns, *left, console=console, disable=not sys.stderr.isatty()) as shown:
        bar = shown.add_task(what, total=cells)
        yield lambda done, total: shown.update(bar, completed=done, total=total)


@map_app.command("make", cls=NumbersCommand, short_help="Make a map, or go on with one.")
@choosing
def make(
    source: Source,
    chosen: Chosen,
    out: Annotated[
        Path, typer.Option(metavar="MAP", help="Folder for the map; one that is half made is gone on with.")
    ],
    step: Step = "0.05",
    orientations: Turns = 2304,
    box: InBox = False,
    bounds: Bounds = None,
    measure: More = None,
    scene: SceneFile = None,
    meshes: Meshes = None,
    velocity: Velocity = None,
    force: Force = None,
    threads: Annotated[
        int | None, typer.Option(metavar="N", min=1, help="Threads; all processors if not given.")
    ] = None,
    dask: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Scheduler of a Dask cluster; 'local' starts one here.")
    ] = None,
) -> None:
    """Make a map, or go on with one. It may be killed at any moment: what is done stays done.

    What is done is checked first, and made again where it is damaged.
    """
    metres, where = _grid(step, box, bounds)

    from srs_ik.loading import load
    from srs_ik.maps.build import build_map, plan_map

    arm = with_meshes(load(source, **chosen), meshes)
    more = _more(measure, scene, velocity, force)
    plan = plan_map(arm, metres, orientations=orientations, box_bounds=where, **more)
    with _client(dask) as client, _bar(f"{plan.cells:,} cells", plan.cells) as progress:
        asked = {"orientations": orientations, "box": where, "threads": threads, "progress": progress}
        made = build_map(arm, metres, out, client, **asked, **more)
    typer.echo(repr(made))


@contextmanager
def _client(address: str | None) -> Iterator[Any]:
    if address is None:
        yield None
        return
    try:
        from dask.distributed import Client, LocalCluster
    except ImportError:
        from srs_ik.errors import MissingExtra

        raise MissingExtra("maps", "a map by Dask") from None
    if address == "local":
        with LocalCluster(threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
            yield client
        return
    try:
        client = Client(address, timeout=10)
    except (OSError, ValueError) as error:
        raise WrongInput(f"--dask {address}: no scheduler answers there ({error})") from None
    with client:
        yield client


@map_app.command("estimate", cls=NumbersCommand, short_help="Say how long a map would take.")
@choosing
def estimate(
    source: Source,
    chosen: Chosen,
    step: Step = "0.05",
    orientations: Turns = 2304,
    box: InBox = False,
    bounds: Bounds = None,
    measure: More = None,
    scene: SceneFile = None,
    meshes: Meshes = None,
    velocity: Velocity = None,
    force: Force = None,
    workers: Annotated[int | None, typer.Option(metavar="N", min=1, help="Processors that share the work.")] = None,
    as_json: AsJson = False,
) -> None:
    """Say what a map would take, from the time of some of its cells."""
    from dataclasses import asdict

    from srs_ik.cli.render import print_json

    metres, where = _grid(step, box, bounds)

    from srs_ik.loading import load
    from srs_ik.maps.build import estimate as estimated

    arm = with_meshes(load(source, **chosen), meshes)
    more = _more(measure, scene, velocity, force)
    found = estimated(arm, metres, orientations=orientations, box=where, workers=workers, **more)
    if as_json:
        print_json(asdict(found))
    else:
        _print_estimate(arm, found)


def _print_estimate(arm: Arm, found: Estimate) -> None:
    typer.echo(
        f"{arm.name}: {found.positions:,} positions x {found.orientations:,} orientations = {found.cells:,} cells in "
        f"{found.tasks:,} tasks\n"
        f"{found.rate:,.0f} cells a second on one processor; {_time(found.seconds)} on {found.workers}\n"
        f"about {_size(found.disk)} on disk, at most {_size(found.memory)} of memory beside Python itself"
    )


def _time(seconds: float) -> str:
    for unit, size in (("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0)):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.1f} {unit}"
    return f"{seconds:.1f} s"


def _size(count: float) -> str:
    for unit, size in (("TB", 1e12), ("GB", 1e9), ("MB", 1e6)):
        if count >= size:
            return f"{count / size:.1f} {unit}"
    return f"{count / 1e3:.1f} kB"
