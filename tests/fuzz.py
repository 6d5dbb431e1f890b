"""Damaged robot files in great number: python tests/fuzz.py --count 20000 FOLDER_WITH_URDF_FILES ...

Each mutation goes through everything that a user would do with the file: list its arms, load each, and ask for a pose.
A process of its own does the work and is watched, since a parser in C++ can end the interpreter or hang. What counts as
a failure: an exception that is none of the package's, a message of more than one line, a NaN, an answer that says OK
and is not, more than two seconds, more than 2 GiB of memory, or the end of the process.
"""

from __future__ import annotations

import argparse
import queue
import resource
import subprocess
import sys
import threading
import time
from collections import Counter
from pathlib import Path

import numpy as np
from mutations import mutated

from srs_ik import SrsIkError, find_limbs, load, zoo

LONGEST = 2.0
MEMORY = 2 * 2**30


def corpus(folders: list[Path]) -> list[Path]:
    """The built-in robots, and the files of some folders."""
    return [zoo.card(name).urdf for name in zoo.robots()] + [p for f in folders for p in sorted(f.rglob("*.urdf"))]


def trial(data: bytes, path: Path) -> str:
    """What becomes of a file: "refused", "no limb", or "solved"; anything wrong is an AssertionError.

    Args:
        data: the content of the file.
        path: where to write it.
    """
    path.write_bytes(data)
    try:
        reports = find_limbs(path)
    except SrsIkError as error:
        complaint = str(error)
        assert len(complaint.splitlines()) == 1, complaint
        assert len(complaint) < 2500, f"{len(complaint)} characters: {complaint[:200]}"
        return "refused"
    arms = 0
    for report in reports:
        assert report.describe()
        if report.limb is None:
            continue
        arm = load(path, base=report.base, tip=report.tip)
        arms += 1
        q = np.clip(np.linspace(-0.5, 0.6, 7), arm.lower, arm.upper)
        pose = arm.forward_kinematics(q)
        assert np.isfinite(pose.homogeneous).all()
        solution = arm.solve(pose)
        assert np.isfinite(solution.q).all()
        if solution:
            assert max(arm.verify(pose, solution.q)) < 1e-9, "an answer that says OK and is not"
            assert (solution.q >= arm.lower).all()
            assert (solution.q <= arm.upper).all()
    return "solved" if arms else "no limb"


def work(paths: list[Path], scratch: Path) -> None:
    """The watched process: a seed a line on standard input, a verdict a line on standard output."""
    resource.setrlimit(resource.RLIMIT_AS, (8 * 2**30, 8 * 2**30))
    texts = [path.read_text() for path in paths]
    for name in zoo.robots():
        arm = load(name)
        arm.solve(arm.forward_kinematics(np.full(7, -0.3)))
    print("ready", flush=True)
    for line in sys.stdin:
        seed = int(line)
        data = mutated(texts[seed % len(texts)], seed)
        start = time.monotonic()
        try:
            verdict = trial(data, scratch)
        except Exception as error:
            verdict = f"FAILED {type(error).__name__}: {error}".replace("\n", " ")[:300]
        seconds = time.monotonic() - start
        if resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 > MEMORY:
            verdict = f"FAILED memory after {verdict}"
        print(f"{seconds:.3f} {verdict}", flush=True)


class Worker:
    """The watched process, and its lines as they come."""

    def __init__(self, folders: list[Path], scratch: Path) -> None:
        command = [sys.executable, __file__, "--work", str(scratch), *map(str, folders)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.lines: queue.Queue[str] = queue.Queue()
        threading.Thread(target=self._listen, daemon=True).start()
        self.line(300.0)

    def _listen(self) -> None:
        for line in self.process.stdout:
            self.lines.put(line)
        self.lines.put("")

    def line(self, seconds: float) -> str:
        try:
            return self.lines.get(timeout=seconds).strip()
        except queue.Empty:
            return "hang"

    def ask(self, seed: int) -> str:
        self.process.stdin.write(f"{seed}\n")
        self.process.stdin.flush()
        return self.line(30.0)

    def stop(self) -> int:
        self.process.kill()
        return self.process.wait()


def main() -> int:
    """Run the mutations; the exit status is 1 if one of them failed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", type=Path, nargs="*", help="folders with .urdf files")
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--work", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.work is not None:
        work(corpus(options.folders), options.work)
        return 0
    scratch = Path(f"/tmp/srs_ik_fuzz_{options.first}.urdf")
    worker, verdicts, failures, slowest = Worker(options.folders, scratch), Counter(), 0, 0.0
    for seed in range(options.first, options.first + options.count):
        answer = worker.ask(seed)
        seconds, _, verdict = answer.partition(" ")
        if not verdict:
            verdict = f"FAILED {answer or 'crash'}, exit status {worker.stop()}"
            worker, seconds = Worker(options.folders, scratch), "0"
        elif float(seconds) > LONGEST:
            verdict = f"FAILED {seconds} s after {verdict}"
        if verdict.startswith("FAILED"):
            failures += 1
            print(f"seed {seed}: {verdict}", flush=True)
        verdicts[verdict.partition(" ")[0] if verdict.startswith("FAILED") else verdict] += 1
        slowest = max(slowest, float(seconds))
    worker.stop()
    scratch.unlink(missing_ok=True)
    print(
        f"{options.count} mutations of {len(corpus(options.folders))} files, slowest {slowest:.2f} s: {dict(verdicts)}"
    )
    return int(failures > 0)


if __name__ == "__main__":
    sys.exit(main())
