"""`srs-ik place`: where to put the base of an arm for the poses of a task."""

from __future__ import annotations

import math
from enum import StrEnum
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from srs_ik.cli.chosen import Chosen, choosing
from srs_ik.cli.options import AsJson, Six, Source, WrongInput, fail, numbers
from srs_ik.cli.pose_file import POSITION, QUATERNION, check_out, is_output, read_poses, write_table
from srs_ik.cli.poses import unit_of
from srs_ik.cli.waiting import at_work

if TYPE_CHECKING:
    import numpy as np

    from srs_ik.arm import Arm
    from srs_ik.maps.placement import Placement

MOST_CANDIDATES = 10_000_000


class By(StrEnum):
    """What candidates are ranked by."""

    share = "share"
    width = "width"
    margin = "margin"
    manipulability = "manipulability"


@choosing
def place(
    source: Source,
    chosen: Chosen,
    poses: Annotated[
        Path,
        typer.Argument(
            metavar="FILE.csv",
            help="Poses of the tip in the room, one a line; the header names x, y, z and roll, pitch, yaw or "
            "qx, qy, qz, qw.",
            show_default=False,
        ),
    ],
    candidates: Annotated[
        Path | None, typer.Option(metavar="FILE.csv", help="Poses of the base in the room, in the same form.")
    ] = None,
    grid: Annotated[
        Six | None,
        typer.Option(metavar="X0 X1 NX Y0 Y1 NY", help="Instead: upright bases on a grid, NX x NY of them, metres."),
    ] = None,
    height: Annotated[
        str | None, typer.Option(metavar="Z", help="Height of that grid, metres; 0 if not given.")
    ] = None,
    yaws: Annotated[int, typer.Option(metavar="N", min=1, help="Turns of the base at each place of that grid.")] = 1,
    by: Annotated[By, typer.Option(help="Mean over all poses; those that are not reached count 0.")] = By.share,
    top: Annotated[int, typer.Option(metavar="N", min=1, help="Candidates to print.")] = 10,
    out: Annotated[Path | None, typer.Option(metavar="FILE.csv", help="Write all candidates here, best first.")] = None,
    degrees: Annotated[bool, typer.Option("--degrees", help="Angles in the files are given in degrees.")] = False,
    as_json: AsJson = False,
) -> None:
    """Rank places for the base of an arm by how well it reaches the poses of a file from there.

    Exit status 1 where no candidate reaches any pose.
    """
    unit = unit_of(degrees)
    check_out(out, as_json, poses, candidates)
    T_room_tip, _ = read_poses(poses, unit)
    if (candidates is None) == (grid is None):
        raise WrongInput("give the places for the base: either --candidates FILE.csv or --grid X0 X1 NX Y0 Y1 NY")
    if grid is not None:
        T_room_base = _on_grid(grid, height, yaws)
    elif height is not None or yaws != 1:
        raise WrongInput("--height and --yaws belong to --grid")
    else:
        T_room_base, _ = read_poses(candidates, unit)  # type: ignore[arg-type]

    from srs_ik.loading import load
    from srs_ik.maps.placement import base_placement

    arm = load(source, **chosen)
    with at_work(f"{len(T_room_base)} places for {len(T_room_tip)} poses"):
        found = base_placement(arm, T_room_tip, T_room_base, by.value)
    if out is not None:
        rows = _rows(found, len(found))
        write_table(out, tuple(rows[0]), (list(row.values()) for row in rows))
    if as_json:
        _print_json(arm, found, top)
    elif not is_output(out):
        _print_table(arm, found, top)
    if not found.reached.any():
        fail("no candidate reaches any of the poses")


def _on_grid(grid: Six, height: str | None, yaws: int) -> np.ndarray:
    import numpy as np

    x0, x1, nx, y0, y1, ny = numbers("--grid", grid)
    for count in (nx, ny):
        if count != int(count) or count < 1:
            raise WrongInput(f"--grid takes whole numbers of places for NX and NY, not {count:g}")
    if nx * ny * yaws > MOST_CANDIDATES:
        raise WrongInput(f"--grid and --yaws make {nx * ny * yaws:g} candidates; {MOST_CANDIDATES} are enough")
    z = numbers("--height", [height])[0] if height is not None else 0.0
    x, y, yaw = np.meshgrid(
        np.linspace(x0, x1, int(nx)),
        np.linspace(y0, y1, int(ny)),
        2.0 * math.pi * np.arange(yaws) / yaws,
        indexing="ij",
    )
    T = np.zeros((x.size, 4, 4))
    c, s = np.cos(yaw.ravel()), np.sin(yaw.ravel())
    T[:, 0, 0], T[:, 0, 1], T[:, 1, 0], T[:, 1, 1] = c, -s, s, c
    T[:, 2, 2] = T[:, 3, 3] = 1.0
    T[:, 0, 3], T[:, 1, 3], T[:, 2, 3] = x.ravel(), y.ravel(), z
    return T


def _rows(found: Placement, count: int) -> list[dict[str, float]]:
    """The best candidates, column by column; the measure that they are ranked by may be the share itself."""
    from srs_ik.inputs.poses import xyz_quaternion

    rows = []
    for rank, each in enumerate(islice(found, count), 1):
        xyz, quaternion = xyz_quaternion(found.candidates[each.candidate], order="xyzw")
        figures = {"rank": rank, "candidate": each.candidate, "share": each.share, found.by: each.value}
        rows.append(
            {**figures, **dict(zip((*POSITION, *QUATERNION), (*xyz.tolist(), *quaternion.tolist()), strict=True))}
        )
    return rows


def _print_json(arm: Arm, found: Placement, top: int) -> None:
    from srs_ik.cli.render import print_json

    best = [
        {
            **{name: row[name] for name in ("rank", "candidate", "share")},
            "value": row[found.by],
            "xyz": [row[name] for name in POSITION],
            "quaternion": [row[name] for name in QUATERNION],
        }
        for row in _rows(found, top)
    ]
    print_json(
        {
            "robot": arm.name,
            "base": arm.base,
            "tip": arm.tip,
            "poses": found.reached.shape[1],
            "candidates": len(found),
            "by": found.by,
            "best": best,
        }
    )


def _print_table(arm: Arm, found: Placement, top: int) -> None:
    from srs_ik.cli.render import console, table

    rows = _rows(found, top)
    names = ("reached (%)" if name == "share" else name for name in rows[0])
    out = console()
    out.print(f"{arm.name}: places of {arm.base} for {found.reached.shape[1]} poses of {arm.tip}")
    out.print(table(tuple(names), [[_shown(*item) for item in row.items()] for row in rows], left=0))


def _shown(name: str, value: float) -> str:
    from srs_ik.cli.render import fixed

    if name == "share":
        return fixed(100.0 * value, 1)
    return str(value) if isinstance(value, int) else fixed(value, 4)
