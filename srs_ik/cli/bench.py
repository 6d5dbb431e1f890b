"""`srs-ik bench`: how long everything takes on this machine."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from srs_ik.cli.options import AsJson

LARGEST = 10_000_000


def bench(
    robots: Annotated[
        list[str] | None,
        typer.Argument(metavar="[ROBOT|FILE]...", help="Robots to measure; iiwa14 and gen3 if none is named."),
    ] = None,
    poses: Annotated[int, typer.Option(min=1, max=LARGEST, metavar="N", help="Poses of each call.")] = 1000,
    growth: Annotated[
        int,
        typer.Option(
            min=0, max=LARGEST, metavar="N", help="Batches of 1, 10, .. N poses too, with time and memory; 0 for none."
        ),
    ] = 0,
    start: Annotated[bool, typer.Option("--start", help="The start of new processes too.")] = False,
    out: Annotated[Path | None, typer.Option(metavar="FILE.json", help="Write the figures into this file too.")] = None,
    as_json: AsJson = False,
) -> None:
    """Time single calls and batches on random poses over the full joint ranges, in microseconds.

    Each call has its own pose; medians and 99th percentiles are of single calls, batches the best of five. Errors are
    by Pinocchio. Figures of different runs and machines are not to be compared.
    """
    from srs_ik.bench.floor import floor_us
    from srs_ik.bench.growth import growth as grow
    from srs_ik.bench.own import batches, single_calls
    from srs_ik.bench.report import Report, machine
    from srs_ik.bench.start import starts
    from srs_ik.bench.work import Work
    from srs_ik.cli.render import print_json
    from srs_ik.loading import load
    from srs_ik.system.writing import write_whole

    names = robots or ["iiwa14", "gen3"]
    arms = [load(name) for name in names]
    report = Report(machine(), floor_us())
    for name, arm in zip(names, arms, strict=True):
        work = Work.of(arm, poses)
        report.calls += single_calls(arm, work)
        report.batches += batches(arm, work)
        if growth:
            report.growth += grow(name, growth)
    if start:
        report.start = starts()
    if out is not None:
        write_whole(out, json.dumps(report.as_dict(), indent=2) + "\n")
    if as_json:
        print_json(report.as_dict())
    else:
        typer.echo(report.markdown())
