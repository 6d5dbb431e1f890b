"""`srs-ik map`: look into maps, check, compare, draw and export them."""

from __future__ import annotations

import contextlib
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from srs_ik.cli.chosen import Chosen, reading
from srs_ik.cli.map import map_app as map_app
from srs_ik.cli.options import AsJson, ExampleCommand, Source, WrongInput, fail, numbers, warn
from srs_ik.cli.pose_file import check_out, is_output, read_poses, write_table
from srs_ik.cli.poses import unit_of
from srs_ik.cli.scenes import Meshes, SceneFile, read, with_meshes
from srs_ik.cli.solve_file import MOST_LINES

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.maps.reader import Map

Folder = Annotated[Path, typer.Argument(metavar="MAP", help="Folder of the map.", show_default=False)]

Second = Annotated[Path, typer.Argument(metavar="MAP2", help="Folder of another map.", show_default=False)]


class Format(StrEnum):
    """What a map is written as."""

    npz = "npz"
    vti = "vti"
    h5 = "h5"


@map_app.command("info", cls=ExampleCommand, short_help="Say what a map holds.")
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
    if chart.done < 1.0:
        typer.echo("cells that are left to make count as not reached; the same 'srs-ik map make' goes on with it")


@map_app.command("query", cls=ExampleCommand, short_help="Say which poses of a file are reached, and how well.")
@reading
def query(
    folder: Folder,
    chosen: Chosen,
    poses: Annotated[
        Path,
        typer.Argument(metavar="FILE.csv", help="Poses of the tip in the base frame, one a line.", show_default=False),
    ],
    exact: Annotated[
        str | None, typer.Option(metavar="ROBOT|FILE", help="Let this arm answer, exactly, instead of the cells.")
    ] = None,
    scene: SceneFile = None,
    meshes: Meshes = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE.csv", help="Write the answers here.")] = None,
    degrees: Annotated[bool, typer.Option("--degrees", help="Angles in the file are given in degrees.")] = False,
    as_json: AsJson = False,
) -> None:
    """Say which poses of a file a map calls reached, and how well. Exit status 1 where one is not."""
    from srs_ik.cli.render import console, print_json, table

    check_out(out, as_json, poses)
    if exact is None and (scene is not None or meshes or any(chosen.values())):
        raise WrongInput("--scene, --meshes, --lock and xacro options are for the arm of --exact, which is not given")
    T, lines = read_poses(poses, unit_of(degrees))

    from srs_ik.maps.reader import open_map

    chart = open_map(folder) if exact is None else _with_arm(exact, folder, scene, meshes, chosen)
    found = chart.query(T, exact=exact is not None)
    names = tuple(found.measures)
    rows = [[found.measures[name][i].item() for name in names] for i in range(len(found))]
    if out is not None:
        write_table(out, ("line", *names), ([line, *row] for line, row in zip(lines, rows, strict=True)))
    if as_json:
        print_json(
            [{"line": line, **dict(zip(names, row, strict=True))} for line, row in zip(lines, rows, strict=True)]
        )
    elif not is_output(out):
        shown = [[str(line), *map(_figure, row)] for line, row in zip(lines[:MOST_LINES], rows, strict=False)]
        console().print(table(("line", *names), shown, left=0))
        if len(lines) > MOST_LINES:
            typer.echo(f"{len(lines) - MOST_LINES} lines are not shown")
    if exact is None and chart.done < 1.0 and not found.inside.all():
        warn(f"{folder} is {100.0 * chart.done:.0f} % done: poses in what is left of it count as not reached")
    missed = int((~found.reached).sum())
    if missed:
        fail(f"{missed} of {len(found)} poses are not reached")


def _figure(value: int | float) -> str:
    """A measure: whole numbers, counts and branches, as these."""
    from srs_ik.cli.render import fixed

    return str(value) if isinstance(value, int) else fixed(value, 4)


def _arm(source: str, folder: Path, chosen: Chosen) -> Arm:
    """The arm of a map: the one arm of the source, or that between the frames that the map names."""
    from srs_ik.errors import AmbiguousLimb, FrameNotFound
    from srs_ik.loading import load
    from srs_ik.maps.reader import open_map

    robot = open_map(folder).plan.robot
    base, tip = robot["base"], robot["tip"]
    # An adapter with a tool or a mount names frames that its robot file does not have.
    with contextlib.suppress(AmbiguousLimb):
        arm = load(source, **chosen)
        if (arm.base, arm.tip) == (base, tip):
            return arm
    try:
        return load(source, base=base, tip=tip, **chosen)
    except FrameNotFound:
        raise WrongInput(
            f"{folder} is a map of {robot['name']}, base {base}, tip {tip}: {source} has no such frames"
        ) from None


def _with_arm(source: str, folder: Path, scene: Path | None, meshes: list[Path] | None, chosen: Chosen) -> Map:
    """A map with its arm, and its scene if it is of one."""
    from srs_ik.maps.reader import open_map

    return open_map(folder, with_meshes(_arm(source, folder, chosen), meshes), read(scene, None).get("scene"))


@map_app.command("verify", cls=ExampleCommand, short_help="Check the sums of a map, and some of its cells again.")
@reading
def verify(
    folder: Folder,
    chosen: Chosen,
    source: Source,
    count: Annotated[int, typer.Option(metavar="N", min=1, help="Cells to compute again.")] = 1000,
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="Of the random choice of cells.")] = 0,
    scene: SceneFile = None,
    meshes: Meshes = None,
    as_json: AsJson = False,
) -> None:
    """Check a map: its checksums, some of its cells, and postures rebuilt from them. Exit status 1 if it is wrong."""
    from dataclasses import asdict

    from srs_ik.cli.render import print_json

    found = _with_arm(source, folder, scene, meshes, chosen).verify(count, seed)
    if as_json:
        print_json({**asdict(found), "right": bool(found)})
    else:
        typer.echo(
            f"{found.tasks} tasks, {len(found.damaged)} damaged; {found.cells} cells computed again, "
            f"{found.different} different; {found.rebuilt} postures rebuilt, off by {found.worst:.2g} m or rad at most"
        )
    if not found:
        more = "the same 'srs-ik map make' mends it" if found.damaged else "remove it and make it again"
        fail(f"{folder} is not what it was made to be: {more}")


@map_app.command("compare", cls=ExampleCommand, short_help="Compare two maps on the same cells.")
def compare(first: Folder, second: Second, as_json: AsJson = False) -> None:
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


@map_app.command("combine", cls=ExampleCommand, short_help="Make the map of what either of two arms reaches.")
def combine(
    first: Folder, second: Second, out: Annotated[Path, typer.Option(metavar="MAP", help="Folder for the map of both.")]
) -> None:
    """Make the map of what either of two arms reaches, of two boxes with the same cells."""
    from srs_ik.maps.pairs import combine as combined
    from srs_ik.maps.reader import open_map

    typer.echo(repr(combined(open_map(first), open_map(second), out)))


@map_app.command("plot", cls=ExampleCommand, short_help="Draw a slice of a map, or the shell of its reach.")
def plot(
    folder: Folder,
    output: Annotated[
        Path, typer.Option("--output", "--out", metavar="FILE.png", help="Picture to write (.png, .pdf, .svg).")
    ],
    measure: Annotated[str | None, typer.Option(metavar="NAME", help="What to colour: a measure, or yaw.")] = None,
    shell: Annotated[bool, typer.Option("--shell", help="Draw the shell around what is reached instead.")] = False,
) -> None:
    """Draw a slice of a map, coloured by a measure, or the shell of what is reached."""
    from srs_ik.cli.picture import check, save

    check(output, "--output")

    from srs_ik.maps.reader import open_map
    from srs_ik.plots import plot_map, plot_shell

    chart = open_map(folder)
    usual = "yaw" if chart.plan.arcs else "reached"
    save(plot_shell(chart) if shell else plot_map(chart, measure or usual), output)


@map_app.command("preview", cls=ExampleCommand, short_help="Write a page of the arm in the cloud of its reach.")
@reading
def preview(
    folder: Folder,
    chosen: Chosen,
    source: Source,
    out: Annotated[Path, typer.Option("--save", metavar="FILE.html", help="Page to write; it needs no server.")],
    step: Annotated[str | None, typer.Option(metavar="METRES", help="Distance between points.")] = None,
    whole: Annotated[bool, typer.Option("--whole", help="Show the half in front (y < 0) too.")] = False,
) -> None:
    """Write a page of the arm in the coloured cloud of what it reaches."""
    from srs_ik.maps.reader import open_map
    from srs_ik.preview import Preview, show_map

    arm = _arm(source, folder, chosen)
    with Preview(arm) as view:
        apart = None if step is None else numbers("--step", [step])[0]
        count = show_map(view, open_map(folder, arm), apart, cut=not whole)
        view.save(out)
    typer.echo(f"{out}: {count:,} points")


@map_app.command("export", cls=ExampleCommand, short_help="Write a map for NumPy, VTK or Reuleaux.")
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
