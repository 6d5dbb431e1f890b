"""`srs-ik map`: make, look into, check, compare and export capability maps."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from srs_ik.cli.options import AllowXacro, AsJson, Base, ExampleCommand, Limb, Source, Tip, WrongInput, numbers
from srs_ik.cli.pose_file import read_poses, write_table
from srs_ik.cli.poses import unit_of

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.maps.build import Estimate, Progress
    from srs_ik.maps.reader import Map

map_app = typer.Typer(no_args_is_help=True, rich_markup_mode=None, help="Maps of what an arm reaches, and how well.")

Folder = Annotated[Path, typer.Argument(metavar="MAP", help="Folder of the map.", show_default=False)]
Step = Annotated[str, typer.Option(metavar="METRES", help="Distance between positions.")]
Turns = Annotated[
    int, typer.Option(metavar="N", help="Orientations: 12 x 4^k x rolls, such as 576, 2304, 4608 or 36864.")
]
InBox = Annotated[bool, typer.Option("--box", help="Map a box around all that is reached, not the half-plane.")]
Bounds = Annotated[
    tuple[str, str, str, str, str, str] | None,
    typer.Option(metavar="X0 X1 Y0 Y1 Z0 Z1", help="Map this box of the base frame, metres."),
]
More = Annotated[
    list[str] | None,
    typer.Option("--measure", metavar="NAME", help="margin or manipulability as well; may be repeated."),
]


class Format(StrEnum):
    """What a map is written as."""

    npz = "npz"
    vti = "vti"
    h5 = "h5"


def _grid(step: str, box: bool, bounds: tuple[str, ...] | None) -> tuple[float, Any]:
    where: Any = box
    if bounds is not None:
        x = numbers("--bounds", bounds)
        where = [x[0:2], x[2:4], x[4:6]]
    return numbers("--step", [step])[0], where


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


@map_app.command("make", cls=ExampleCommand)
def make(
    source: Source,
    out: Annotated[
        Path, typer.Option(metavar="MAP", help="Folder for the map; one that is half made is gone on with.")
    ],
    step: Step = "0.05",
    orientations: Turns = 2304,
    box: InBox = False,
    bounds: Bounds = None,
    measure: More = None,
    threads: Annotated[
        int | None, typer.Option(metavar="N", min=1, help="Threads; all processors if not given.")
    ] = None,
    dask: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Scheduler of a Dask cluster; 'local' starts one here.")
    ] = None,
    base: Base = None,
    tip: Tip = None,
    limb: Limb = None,
    allow_xacro: AllowXacro = False,
) -> None:
    """Make a map, or go on with one. It may be killed at any moment: what is done stays done."""
    metres, where = _grid(step, box, bounds)

    from srs_ik.loading import load
    from srs_ik.maps.build import build_map, plan_map

    arm = load(source, base=base, tip=tip, limb=limb, allow_xacro=allow_xacro)
    names = measure or ()
    plan = plan_map(arm, metres, orientations=orientations, box_bounds=where, measures=names)
    with _client(dask) as client, _bar(f"{plan.cells:,} cells", plan.cells) as progress:
        made = build_map(
            arm,
            metres,
            out,
            client,
            orientations=orientations,
            box=where,
            measures=names,
            threads=threads,
            progress=progress,
        )
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


@map_app.command("estimate", cls=ExampleCommand)
def estimate(
    source: Source,
    step: Step = "0.05",
    orientations: Turns = 2304,
    box: InBox = False,
    bounds: Bounds = None,
    measure: More = None,
    workers: Annotated[int | None, typer.Option(metavar="N", min=1, help="Processors that share the work.")] = None,
    base: Base = None,
    tip: Tip = None,
    limb: Limb = None,
    allow_xacro: AllowXacro = False,
    as_json: AsJson = False,
) -> None:
    """Say what a map would take, from the time of some of its cells."""
    from dataclasses import asdict

    from srs_ik.cli.render import print_json

    metres, where = _grid(step, box, bounds)

    from srs_ik.loading import load
    from srs_ik.maps.build import estimate as estimated

    arm = load(source, base=base, tip=tip, limb=limb, allow_xacro=allow_xacro)
    found = estimated(arm, metres, orientations=orientations, box=where, measures=measure or (), workers=workers)
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


@map_app.command("info", cls=ExampleCommand)
def info(folder: Folder, as_json: AsJson = False) -> None:
    """Say what a map holds: robot, positions, orientations, measures, and how much of it is done."""
    from srs_ik.cli.render import print_json
    from srs_ik.maps.reader import open_map

    chart = open_map(folder)
    plan = chart.plan
    reached = float(chart.mean("reached").mean())
    if as_json:
        attributes = plan.as_attributes()
        print_json({**attributes, "cells": plan.cells, "done": chart.done, "reached": reached})
        return
    robot = plan.robot
    typer.echo(repr(chart))
    typer.echo(f"base {robot['base']}, tip {robot['tip']}, fingerprint {robot['fingerprint'][:16]}")
    typer.echo(f"{plan.cells:,} cells, {100.0 * reached:.2f} % reached; measures {', '.join(chart.store.names)}")


@map_app.command("query", cls=ExampleCommand)
def query(
    folder: Folder,
    poses: Annotated[
        Path,
        typer.Argument(metavar="FILE.csv", help="Poses of the tip in the base frame, one a line.", show_default=False),
    ],
    exact: Annotated[
        str | None, typer.Option(metavar="ROBOT|FILE", help="Let this arm answer, exactly, instead of the cells.")
    ] = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE.csv", help="Write the answers here.")] = None,
    degrees: Annotated[bool, typer.Option("--degrees", help="Angles in the file are given in degrees.")] = False,
    as_json: AsJson = False,
) -> None:
    """Say which poses of a file a map calls reached, and how well. Exit status 1 where one is not."""
    from srs_ik.cli.render import console, fixed, print_json, table

    T, lines = read_poses(poses, unit_of(degrees))

    from srs_ik.maps.reader import open_map

    chart = open_map(folder, _arm(exact, folder) if exact is not None else None)
    found = chart.query(T, exact=exact is not None)
    names = tuple(found.measures)
    rows = [[float(found.measures[name][i]) for name in names] for i in range(len(found))]
    if out is not None:
        write_table(out, ("line", *names), ([line, *row] for line, row in zip(lines, rows, strict=True)))
    if as_json:
        print_json(
            [{"line": line, **dict(zip(names, row, strict=True))} for line, row in zip(lines, rows, strict=True)]
        )
    else:
        shown = [[str(line), *(fixed(x, 4) for x in row)] for line, row in zip(lines[:40], rows, strict=False)]
        console().print(table(("line", *names), shown, left=0))
    missed = int((~found.reached).sum())
    if missed:
        typer.echo(f"srs-ik: {missed} of {len(found)} poses are not reached", err=True)
        raise typer.Exit(1)


def _arm(source: str, folder: Path) -> Arm:
    """The arm of a map, found by the frames that the map names."""
    from srs_ik.loading import load
    from srs_ik.maps.reader import open_map

    robot = open_map(folder).plan.robot
    return load(source, base=robot["base"], tip=robot["tip"])


@map_app.command("verify", cls=ExampleCommand)
def verify(
    folder: Folder,
    source: Source,
    count: Annotated[int, typer.Option(metavar="N", min=1, help="Cells to compute again.")] = 1000,
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="Of the random choice of cells.")] = 0,
    as_json: AsJson = False,
) -> None:
    """Check a map: its checksums, some of its cells, and postures rebuilt from them. Exit status 1 if it is wrong."""
    from dataclasses import asdict

    from srs_ik.cli.render import print_json
    from srs_ik.maps.reader import open_map

    found = open_map(folder, _arm(source, folder)).verify(count, seed)
    if as_json:
        print_json({**asdict(found), "right": bool(found)})
    else:
        typer.echo(
            f"{found.tasks} tasks, {len(found.damaged)} damaged; {found.cells} cells computed again, "
            f"{found.different} different; {found.rebuilt} postures rebuilt, off by {found.worst:.2g} m or rad at most"
        )
    if not found:
        typer.echo(f"srs-ik: {folder} is not what it was made to be: remove it and make it again", err=True)
        raise typer.Exit(1)


@map_app.command("compare", cls=ExampleCommand)
def compare(
    first: Folder,
    second: Annotated[Path, typer.Argument(metavar="MAP2", help="Folder of another map.", show_default=False)],
    as_json: AsJson = False,
) -> None:
    """Compare two maps on the same cells: of two arms or tools, or with other limits."""
    from srs_ik.cli.render import print_json
    from srs_ik.maps.pairs import compare as compared
    from srs_ik.maps.reader import open_map

    found = compared(open_map(first), open_map(second))
    if as_json:
        print_json({"both": found.both, "first": found.first, "second": found.second, "width": found.width})
        return
    typer.echo(
        f"of all cells, {100.0 * found.both:.2f} % are reached by both, {100.0 * found.first:.2f} % by {first} alone, "
        f"{100.0 * found.second:.2f} % by {second} alone; widths differ by {found.width:+.3f} rad on average"
    )


@map_app.command("combine", cls=ExampleCommand)
def combine(
    first: Folder,
    second: Annotated[Path, typer.Argument(metavar="MAP2", help="Folder of another map.", show_default=False)],
    out: Annotated[Path, typer.Option(metavar="MAP", help="Folder for the map of both.")],
) -> None:
    """Make the map of what either of two arms reaches, of two boxes with the same cells."""
    from srs_ik.maps.pairs import combine as combined
    from srs_ik.maps.reader import open_map

    typer.echo(repr(combined(open_map(first), open_map(second), out)))


@map_app.command("export", cls=ExampleCommand)
def export(
    folder: Folder,
    out: Annotated[Path, typer.Argument(metavar="FILE.npz|.vti|.h5", help="What to write.", show_default=False)],
    step: Annotated[
        str | None, typer.Option(metavar="METRES", help="Distance between points (.vti, .h5); that of the map.")
    ] = None,
) -> None:
    """Write a map for other programs: NumPy (.npz), a VTK image (.vti), or HDF5 of Reuleaux (.h5)."""
    from srs_ik.maps import export as exports
    from srs_ik.maps.reader import open_map

    kind = out.suffix[1:]
    if kind not in [each.value for each in Format]:
        raise WrongInput(f"{out}: a map is written as .npz, .vti or .h5")
    apart = None if step is None else numbers("--step", [step])[0]
    chart: Map = open_map(folder)
    if kind == Format.npz:
        exports.to_numpy(chart, out)
    elif kind == Format.vti:
        exports.to_vtk(chart, out, apart)
    else:
        exports.to_reuleaux(chart, out, apart)
