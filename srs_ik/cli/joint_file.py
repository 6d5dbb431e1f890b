"""Tables of joint angles as CSV files."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from srs_ik.cli.options import Seven, WrongInput, warn
from srs_ik.cli.pose_file import figures, places_of, read_table
from srs_ik.cli.poses import JOINTS, warn_of_degrees

if TYPE_CHECKING:
    import numpy as np

GivenJoints = Annotated[Seven | None, typer.Option(metavar=JOINTS, help="Joint angles of the arm.")]
JointsFile = Annotated[
    Path | None,
    typer.Option(metavar="JOINTS.csv", help="Joint angles of many postures, one a line; the header names the joints."),
]


def refuse_both_or_none(q: Seven | None, file: Path | None) -> None:
    """Raise WrongInput where joint angles are given neither by words nor by a file, or by both."""
    if (q is None) == (file is None):
        raise WrongInput(f"give the joint angles: --q {JOINTS}, or --file JOINTS.csv")


def read_joints(path: Path, joint_names: Sequence[str], unit: float) -> np.ndarray:
    """The joint angles of a CSV file whose header names the joints, (N, 7), rad.

    The columns are the names of the joints, or q1 to q7, in any order. Other columns and empty lines are left out. A
    line on standard error says where angles in radians look like degrees, or the other way about; `unit` is that of the
    file in radians.

    Raises:
        WrongInput: the header lacks a joint, or a line a number; the message says which line.
        OSError: the file cannot be read.
    """
    import numpy as np

    (line, header), *rows = read_table(path, joint_names)
    names = [name.strip() for name in header]
    wanted = tuple(joint_names) if any(name in names for name in joint_names) else tuple(f"q{k}" for k in range(1, 8))
    columns = places_of(f"{path}, line {line}", names, wanted, f"joints {', '.join(joint_names)}, or q1 to q7")
    if not rows:
        raise WrongInput(f"{path} has a header and no joint angles below it")
    given = np.array([list(figures(f"{path}, line {at}", row, columns)) for at, row in rows])
    if unit == 1.0:
        warn_of_degrees(str(path), given.ravel().tolist(), " Then add --degrees.")
    elif abs(given).max() <= 2.0 * math.pi:
        said = f"{path} is read in degrees, and none of its angles is more than {abs(given).max():.3g}"
        warn(f"{said}: are these radians? What commands write is in radians, whatever --degrees.")
    return unit * given
