"""`srs-ik solve --file`: joint angles for every pose of a file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from srs_ik.cli.options import fail
from srs_ik.cli.pose_file import is_output, write_table

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.solve.solutions import BatchSolution

MOST_LINES = 40
"""Answers that a table for people shows."""


def report(arm: Arm, found: BatchSolution, poses: Path, lines: list[int], out: Path | None, as_json: bool) -> None:
    """Print what became of the poses of a file, and write it to another one.

    Raises:
        typer.Exit: a pose has no solution; a line on standard error names the first one.
    """
    if out is not None:
        columns = {name: column.tolist() for name, column in found.as_table().items()}
        write_table(out, tuple(columns), zip(*columns.values(), strict=True))
    if as_json:
        _print_json(arm, found, lines)
    elif not is_output(out):
        _print_table(arm, found, lines)
    failed = (~found.ok).nonzero()[0].tolist()
    if failed:
        first, more = found[failed[0]], f" ({len(failed) - 1} more)" if len(failed) > 1 else ""
        place = f"{poses}, line {lines[failed[0]]}"
        fail(f"{place}: {first.status.name}: {first.message}{more}")


def _print_json(arm: Arm, found: BatchSolution, lines: list[int]) -> None:
    from srs_ik.cli.render import fields, heading, print_json

    answers = [{"line": line, **fields(found[i])} for i, line in enumerate(lines)]
    print_json({**heading(arm), "solved": found.solved, "solutions": answers})


def _print_table(arm: Arm, found: BatchSolution, lines: list[int]) -> None:
    import numpy as np

    from srs_ik.cli.render import console, fixed, table

    rows = [
        (found[i].status.name, str(line), str(found[i].branch), *(fixed(x, 4) for x in np.rad2deg(found[i].q)))
        for i, line in enumerate(lines[:MOST_LINES])
    ]
    out = console()
    out.print(f"{arm.name}: {arm.tip} in {arm.base}, angles in degrees")
    out.print(table(("status", "line", "branch", *(f"q{k}" for k in range(1, 8))), rows))
    rest = f"; {len(lines) - MOST_LINES} lines are not shown" if len(lines) > MOST_LINES else ""
    out.print(f"{found.solved} of {len(found)} poses solved{rest}")
