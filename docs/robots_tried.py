"""Makes the table of docs/robots_tried.md: python docs/robots_tried.py FOLDER ... with robot files anywhere below.

Looked for are the files of docs/robots_tried.toml; those that are not here are skipped and named. Every arm that is
found is asked for the poses of random configurations inside its limits. The poses come from Pinocchio on the file as it
is, and what is solved is checked by it; nothing of srs_ik takes part in either.
"""

from __future__ import annotations

import argparse
import sys
import time
import tomllib
from collections.abc import Iterator, Sequence
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

import numpy as np

import srs_ik

sys.path.append(str(Path(__file__).resolve().parents[1] / "benchmarks"))

from untouched import Untouched, distances

PAGE = Path(__file__).with_name("robots_tried.md")
FILES = Path(__file__).with_name("robots_tried.toml")
SUFFIXES = (".urdf", ".xacro", ".xml")


class Measured(NamedTuple):
    """What became of the poses of one arm."""

    solved: int
    asked: int
    position_error: float
    orientation_error: float
    median: float


def measure(path: Path, arm: srs_ik.Arm, count: int) -> Measured:
    """Solve the poses of random configurations inside the limits of an arm."""
    rng = np.random.default_rng(7)
    forward = Untouched(path, arm)
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    poses = forward.poses(rng.uniform(lower, upper, (count, 7)))
    arm.solve(poses[0])
    solutions, times = [], []
    for pose in poses:
        started = time.process_time()
        solutions.append(arm.solve(pose))
        times.append(time.process_time() - started)
    q = np.array([solution.q for solution in solutions])
    right = np.array([bool(s) for s in solutions]) & ((q >= arm.lower) & (q <= arm.upper)).all(axis=1)
    worst = [float(np.max(e[right], initial=0.0)) for e in distances(poses, forward.poses(q))]
    return Measured(int(right.sum()), count, *worst, float(np.median(times)))


def files(folders: Sequence[Path]) -> Iterator[tuple[str, str, Path]]:
    """Where each file is from, what the page calls it, and where it is here; files that are not are named."""
    here = [path for folder in folders for path in sorted(folder.resolve().rglob("*")) if path.suffix in SUFFIXES]
    installed = metadata.files("example-robot-data") or []
    here += [Path(str(file.locate())).resolve() for file in installed if file.suffix in SUFFIXES]
    for origin, listed in tomllib.loads(FILES.read_text()).items():
        for name in listed["files"]:
            path = next((path for path in here if path.as_posix().endswith(f"/{name}")), None)
            if path is None:
                print(f"skipped, for it is not here: {name} ({origin})", file=sys.stderr)
            else:
                yield origin, name.removeprefix("example-robot-data/robots/"), path


def rows(folders: Sequence[Path], count: int) -> Iterator[str]:
    """The lines of the table."""
    heads = ["file", "recognised as", "elbow offset (mm)", "axes miss by (mm)", "solved", "worst error (m)"]
    yield f"| {' | '.join([*heads, 'worst error (rad)', 'median time (us)', 'base to tip', 'from'])} |"
    yield "|---|---|--:|--:|--:|--:|--:|--:|---|---|"
    for origin, name, path in files(folders):
        shown = name.replace("/", "/<wbr>")
        try:
            reports = srs_ik.find_limbs(path)
        except srs_ik.InvalidRobot:
            reports = []
        if not reports:
            yield f"| {shown} | refused: {why_nothing(path)} | | | | | | | | {origin} |"
        for report in reports:
            # Where axes are parallel there is no centre to miss.
            miss = "" if np.isnan(report.misses_mm).all() else f"{report.misses_mm.max():.3f}"
            end = f"`{report.base}` to `{report.tip}` | {origin} |"
            if report.limb is None:
                note = f"; {report.note}" if report.note else ""
                yield f"| {shown} | refused: {report.reason}{note} | | {miss} | | | | | {end}"
                continue
            m = measure(path, srs_ik.load(path, base=report.base, tip=report.tip), count)
            kind = f"{report.kind}, {report.wrist_kind} wrist | {1e3 * report.elbow_offset:.3f} | {miss}"
            errors = f"{m.position_error:.1e} | {m.orientation_error:.1e}"
            yield f"| {shown} | {kind} | {m.solved} of {m.asked} | {errors} | {1e6 * m.median:.0f} | {end}"


def why_nothing(path: Path) -> str:
    """What `load` says of a file that it refuses, or of a robot without a chain of seven joints; without its name."""
    try:
        srs_ik.load(path)
    except (srs_ik.NotAnSrsLimb, srs_ik.InvalidRobot) as error:
        return str(error).removeprefix(str(path)).lstrip(": ")
    raise AssertionError(path)


def main() -> None:
    """Write the table into the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", type=Path, nargs="*", help="folders with robot files")
    parser.add_argument("--count", type=int, default=500, help="configurations an arm (default: 500)")
    options = parser.parse_args()
    table = "\n".join(rows(options.folders, options.count))
    begin, end = "<!-- table: begin -->", "<!-- table: end -->"
    before, rest = PAGE.read_text().split(begin)
    PAGE.write_text(f"{before}{begin}\n{table}\n{end}{rest.split(end)[1]}")
    print(table)


if __name__ == "__main__":
    main()
