"""Times this package and its peers side by side, in one run on one machine.

Run: python benchmarks/quick.py [--poses N] [--growth N] [--no-start] [--json FILE] [--markdown FILE]

Prints Markdown: single calls of every package that is installed (extra "bench" brings them), batches, how these grow,
and the start of new processes. Figures of different runs or machines are not to be compared.
"""

from __future__ import annotations

import argparse
import json
import sys
import warnings
from collections.abc import Sequence
from importlib import util
from pathlib import Path

import srs_ik
from srs_ik.bench.floor import floor_us
from srs_ik.bench.growth import growth
from srs_ik.bench.own import batches, single_calls
from srs_ik.bench.report import Report, machine
from srs_ik.bench.start import starts
from srs_ik.bench.work import Work

sys.path.insert(0, str(Path(__file__).resolve().parent))

from peers import PEERS, eaik_batch

ROBOTS = ("iiwa14", "gen3")


def run(poses: int, largest: int, with_starts: bool) -> Report:
    """Measure everything: each robot, this package first."""
    report = Report(machine(), floor_us())
    for robot in ROBOTS:
        arm = srs_ik.load(robot)
        work = Work.of(arm, poses)
        report.calls += single_calls(arm, work)
        for module, peer in PEERS.items():
            if util.find_spec(module):
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    report.calls += peer(arm, work)
        report.batches += batches(arm, work)
        if util.find_spec("eaik"):
            report.batches += eaik_batch(arm, work)
        if largest:
            report.growth += growth(robot, largest if robot == "iiwa14" else largest // 1000)
    if with_starts:
        report.start = starts()
    return report


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print, and write the figures where they are wanted."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--poses", type=int, default=1000, help="poses a robot and call (default 1000)")
    parser.add_argument("--growth", type=int, default=0, help="batches of up to so many poses (default: none)")
    parser.add_argument("--no-start", action="store_true", help="leave out the start of new processes")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures into this file too")
    parser.add_argument("--markdown", type=Path, metavar="FILE", help="write the tables into this file too")
    chosen = parser.parse_args(arguments)
    if chosen.poses < 1:
        parser.error("--poses must be at least 1")
    report = run(chosen.poses, chosen.growth, not chosen.no_start)
    print(report.markdown())
    if chosen.json:
        chosen.json.write_text(json.dumps(report.as_dict(), indent=2) + "\n")
    if chosen.markdown:
        chosen.markdown.write_text(report.markdown() + "\n")


if __name__ == "__main__":
    main()
