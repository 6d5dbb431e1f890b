"""Tables of poses and of joint angles as CSV files."""

from __future__ import annotations

import csv
import io
import itertools
import math
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from srs_ik.cli.options import WrongInput, is_number, warn
from srs_ik.cli.poses import warn_of_degrees
from srs_ik.errors import quoted
from srs_ik.system.writing import check_place, write_whole

if TYPE_CHECKING:
    import numpy as np

    from srs_ik.arm import Arm
    from srs_ik.solve.path.solution import PathSolution
    from srs_ik.solve.path.trajectory import Samples

POSITION = ("x", "y", "z")
RPY = ("roll", "pitch", "yaw")
QUATERNION = ("qx", "qy", "qz", "qw")
TIMES = ("t", "time", "timestamp")
"""How a column of times may be called."""

_INPUT = Path("-")
_OUTPUT = ("-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1")
"""Names of standard output. Opened anew, a file behind it would lose what else is printed there, or be overwritten."""

DELIMITERS = {";": "semicolons", "\t": "tabs", "|": "bars"}
"""What else tables are separated by, and its name."""


def is_output(path: Path | None) -> bool:
    """Whether a file that is written is standard output, which then has nothing else."""
    return path is not None and str(path) in _OUTPUT


def check_out(out: Path | None, as_json: bool, *read: Path | None) -> None:
    """Raise WrongInput where answers would be written onto a file that is read, under whatever name, or beside JSON.

    And OSError where there is no place for them.
    """
    if is_output(out) and as_json:
        raise WrongInput(f"--json and --out {out} both write on standard output: give one of them")
    if out is not None and not is_output(out):
        check_place(out)
    for path in read:
        if (
            out is not None
            and not is_output(out)
            and path is not None
            and out.is_file()
            and path.is_file()
            and out.samefile(path)
        ):
            raise WrongInput(f"{out} is read: give the answers a file of their own")


def read_poses(path: Path, unit: float, period: float | None = None) -> tuple[np.ndarray, list[int]]:
    """The poses of a CSV file whose header names the columns.

    The columns are x, y, z in metres and either roll, pitch, yaw or qx, qy, qz, qw, in any order. Other columns and
    empty lines are left out.

    Args:
        path: the file.
        unit: radians in the unit of roll, pitch and yaw.
        period: seconds from pose to pose, where somebody says so; a line on standard error tells other times in the
            file.

    Returns:
        (N, 4, 4) poses, and the line of the file on which each stands.

    Raises:
        WrongInput: the header lacks a column, or a line a number; the message says which line.
        OSError: the file cannot be read.
    """
    import numpy as np

    table = read_table(path, (*POSITION, *RPY))
    if period is not None:
        _warn_of_times(path, table, period)
    poses, lines = _poses(path, table, unit, lost=False)
    return np.array(poses), lines


def read_targets(path: Path, unit: float, period: float) -> list[np.ndarray | None]:
    """The poses of a CSV file as `read_poses` gives and refuses them, one a period; None where it was lost.

    That is a line of nan or of nothing; lines of empty cells count, as pandas writes them. A line on standard error
    says so if the file has times of its own that are not a period apart.
    """
    table = read_table(path, (*POSITION, *RPY), empty_cells=True)
    _warn_of_times(path, table, period)
    return _poses(path, table, unit, lost=True)[0]


def _warn_of_times(path: Path, table: list[tuple[int, list[str]]], period: float) -> None:
    names = [name.strip().lower() for name in table[0][1]]
    column = next((names.index(name) for name in TIMES if name in names), None)
    if column is None:
        return
    cells = [row[column] for _, row in table[1:] if column < len(row)]
    times = [float(cell) for cell in cells if is_number(cell)]
    steps = sorted(after - before for before, after in itertools.pairwise(times))
    if steps and abs(steps[len(steps) // 2] - period) > 0.01 * period:
        usual = steps[len(steps) // 2]
        warn(f"{path} has times {usual:.6g} s apart, and --dt says {period:g} s, which counts")


def _poses(
    path: Path, table: list[tuple[int, list[str]]], unit: float, lost: bool
) -> tuple[list[np.ndarray | None], list[int]]:
    """The poses of a table and their lines; where targets may be lost, None for a line of nan or of nothing."""
    from srs_ik.errors import InvalidPose
    from srs_ik.inputs.rotations import pose_from_xyz_quaternion, pose_of_xyz_rpy

    columns, turned = _columns(path, *table[0])
    poses: list[np.ndarray | None] = []
    lines, largest = [], 0.0
    for line, row in table[1:]:
        missing = [name for name, index in columns.items() if _is_missing(row, index)] if lost else []
        if len(missing) == len(columns):
            poses.append(None)
            lines.append(line)
            continue
        if missing:
            said = f"{path}, line {line}: there is no {', '.join(missing)}"
            raise WrongInput(f"{said}; where a target was lost, all of its columns are empty, or nan")
        values = list(figures(f"{path}, line {line}", row, columns))
        position, orientation = values[:3], values[3:]
        try:
            if turned:
                pose = pose_from_xyz_quaternion(position, orientation, order="xyzw")
            else:
                largest = max(largest, *orientation, key=abs)
                pose = pose_of_xyz_rpy(position, [unit * angle for angle in orientation])
        except InvalidPose as error:
            raise WrongInput(f"{path}, line {line}: {error}") from None
        poses.append(pose.homogeneous)
        lines.append(line)
    if not poses:
        raise WrongInput(f"{path} has a header and no poses below it")
    if unit == 1.0:
        warn_of_degrees(str(path), [largest], " Then add --degrees.")
    return poses, lines


def _is_missing(row: Sequence[str], index: int) -> bool:
    """Whether a cell says that it has no number."""
    return index < len(row) and row[index].strip().lower() in ("nan", "")


def read_table(path: Path, columns: Sequence[str], empty_cells: bool = False) -> list[tuple[int, list[str]]]:
    """The lines of a CSV file that are not empty, each with its number; the first names its columns, such as these.

    Lines that begin with # are comments; the last one above figures names their columns, as `numpy.savetxt` writes it.
    Lines of empty cells count only where that is said. Else those at the end are left out, as spreadsheets write them;
    in between they are refused, since answers would no longer stand beside their questions.

    Raises:
        WrongInput: no text, no CSV, nothing in it, or a line of empty cells that does not count.
        OSError: the file cannot be read.
    """
    try:
        text = (sys.stdin.buffer.read() if path == _INPUT else path.read_bytes()).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise WrongInput(f"{path} is no text file") from None
    reader = csv.reader(text.splitlines(), skipinitialspace=True)
    try:
        table = [(reader.line_num, row) for row in reader if len(row) > 1 or any(cell.strip() for cell in row)]
    except csv.Error as error:
        raise WrongInput(f"{path}, line {reader.line_num}: {error}") from None
    table = _without_comments(table)
    if not empty_cells:
        while table and not _has_text(table[-1]):
            table.pop()
    table = list(itertools.dropwhile(lambda each: not _has_text(each), table))
    if not table:
        raise WrongInput(f"{path} is empty: its first line names the columns {', '.join(columns)}")
    first, header = table[0]
    for sign, name in DELIMITERS.items():
        if len(header) == 1 and sign in header[0]:
            raise WrongInput(f"{path}, line {first}: columns are separated by commas, not by {name}")
    for line, row in table[1:]:
        if not empty_cells and not _has_text((line, row)):
            raise WrongInput(f"{path}, line {line}: all cells are empty; take the line out, or give its figures")
        if any(cell.strip() for cell in row[len(header) :]):
            if len(header) == 1:
                said = f"{path}, line {first}: columns are to be named here, such as {', '.join(columns)}"
                raise WrongInput(f"{said}, not {quoted(header[0].strip())}; comments begin with #")
            raise WrongInput(
                f"{path}, line {line}: there are {len(row)} columns and names for {len(header)}; "
                "decimals have points, not commas, and text with commas stands in quotes"
            )
    return table


def _has_text(numbered: tuple[int, list[str]]) -> bool:
    return any(cell.strip() for cell in numbered[1])


def _without_comments(table: list[tuple[int, list[str]]]) -> list[tuple[int, list[str]]]:
    rest = [(line, row) for line, row in table if not row[0].lstrip().startswith("#")]
    if rest and all(is_number(cell) for cell in rest[0][1]):
        above = [(line, row) for line, row in table if line < rest[0][0]]
        rest = [(line, [row[0].lstrip().lstrip("#"), *row[1:]]) for line, row in above[-1:]] + rest
    return rest


def _columns(path: Path, line: int, header: Sequence[str]) -> tuple[dict[str, int], bool]:
    """Where the columns of a pose stand, in order, and whether its orientation is a quaternion."""
    names = [name.strip().lower() for name in header]
    turned, by_angles = (any(name in names for name in kind) for kind in (QUATERNION, RPY))
    if turned and by_angles:
        raise WrongInput(f"{path}, line {line}: give either {', '.join(RPY)} or {', '.join(QUATERNION)}")
    wanted = (*POSITION, *(QUATERNION if turned else RPY))
    either = "" if turned or by_angles else f" (or {', '.join(QUATERNION)})"
    return places_of(f"{path}, line {line}", names, wanted, f"columns {', '.join(wanted)}{either}"), turned


def places_of(where: str, names: Sequence[str], wanted: Sequence[str], said: str) -> dict[str, int]:
    """Where columns stand in a header, `where`; raises WrongInput, as it is `said` what that must name."""
    missing = [name for name in wanted if name not in names]
    if missing:
        raise WrongInput(f"{where}: the header must name the {said}; it lacks {', '.join(missing)}")
    twice = next((name for name in wanted if names.count(name) > 1), None)
    if twice is not None:
        raise WrongInput(f"{where}: there are two columns {twice!r}")
    return {name: names.index(name) for name in wanted}


def figures(where: str, row: Sequence[str], columns: dict[str, int]) -> Iterator[float]:
    """The finite numbers of a line, `where`, in some columns; raises WrongInput where one is missing or none."""
    for name, index in columns.items():
        if index >= len(row):
            raise WrongInput(f"{where}: there is no {name}; the line ends after {len(row)} columns")
        if not is_number(row[index]) or not math.isfinite(float(row[index])):
            raise WrongInput(f"{where}: {name} must be a finite number, not {row[index].strip()!r}")
        yield float(row[index])


def write_path(path: Path, arm: Arm, found: PathSolution, times: Sequence[float] | None) -> None:
    """Write the joint angles of a path, rad, a line for each pose: joints by name, after the time if it is known."""
    if times is None:
        write_table(path, arm.joint_names, found.q.tolist())
        return
    rows = ([time, *q] for time, q in zip(times, found.q.tolist(), strict=True))
    write_table(path, ("t", *arm.joint_names), rows)


def write_motion(path: Path, arm: Arm, samples: Samples) -> None:
    """Write a motion, a line for each sample: time, s, joint angles by name, rad, and velocities, rad/s."""
    import numpy as np

    header = ("t", *arm.joint_names, *(f"{name}_velocity" for name in arm.joint_names))
    write_table(path, header, np.column_stack([samples.times, samples.q, samples.velocity]).tolist())


def write_table(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a CSV file, whole or not at all, or on standard output."""
    text = io.StringIO(newline="")
    # As other tools of a shell end lines: cut and awk take a carriage return for a part of the last column.
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    if is_output(path):
        print(text.getvalue(), end="", flush=True)
    else:
        write_whole(path, text.getvalue())
