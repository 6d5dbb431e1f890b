"""Damaged robot files in great number: python tests/fuzz.py --count 20000 FOLDER_WITH_URDF_FILES ...

The files are the URDFs of the folders and of the package, an MJCF file and an adapter. Each mutation goes through
everything that a user would do with the file: list its arms, load each, and ask for a pose. A process of its own does
the work and is watched, since a parser in C++ can end the interpreter or hang. What counts as a failure: an exception
that is none of the package's, a message of more than one line, a NaN, an answer that says OK and is not, more than two
seconds, more than 2 GiB of memory, or the end of the process.
"""

from __future__ import annotations

import argparse
import queue
import re
import resource
import subprocess
import sys
import threading
import time
from collections import Counter
from pathlib import Path
from typing import NamedTuple

import numpy as np
from mutations import mutated

from srs_ik import InvalidRobot, SrsIkError, find_limbs, load
from srs_ik.robot import zoo

LONGEST = 2.0
MEMORY = 2 * 2**30


class Sample(NamedTuple):
    """A whole file."""

    suffix: str
    text: str


def mjcf() -> str:
    """An arm of seven joints as MuJoCo describes one."""
    places = zip(["0 0 1", "0 1 0"] * 3 + ["0 0 1"], [0, 0, 3, 0, 3, 0, 1], strict=True)
    bodies = "".join(
        f'<body name="l{k}" pos="0 0 {height}"><joint name="j{k}" type="hinge" axis="{axis}" range="-2 2"/>'
        '<inertial pos="0 0 0.1" mass="1" diaginertia="0.1 0.1 0.1"/><geom type="sphere" size="0.01"/>'
        for k, (axis, height) in enumerate(places, 1)
    )
    compiler = '<compiler angle="radian" autolimits="true"/><default><joint damping="1"/></default>'
    return f'<mujoco model="arm">{compiler}<worldbody>{bodies}{"</body>" * 7}</worldbody></mujoco>'


def adapter() -> str:
    """An adapter for a built-in robot, with every table."""
    card = zoo.card("iiwa14")
    return (
        f"name = 'a'\nurdf = '{card.urdf}'\nside = 'left'\n[frames]\nbase = '{card.base}'\ntip = '{card.tip}'\n"
        "[arm_angle]\nreference = [0, 0, 1.0]\n[hand]\ngrasp = [1, 0, 0]\npronosupination = [0, 0, 1]\n"
        "[limits]\niiwa_joint_2 = { lower = -1.5, upper = 1.25, velocity = 1, effort = inf }\n"
        "[tool]\nxyz = [0, 0, 0.1]\nrpy = [0, 0.5, 0]\n[mount]\nxyz = [1, 2, 3]\nname = 'room'\n"
    )


def corpus(folders: list[Path]) -> list[Sample]:
    """The whole files that are damaged."""
    urdfs = [zoo.card(name).urdf for name in zoo.robots()] + [p for f in folders for p in sorted(f.rglob("*.urdf"))]
    samples = [Sample(".urdf", path.read_text()) for path in urdfs]
    return [*samples, Sample(".xml", mjcf()), Sample(".toml", adapter())]


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
        try:
            arm = load(path, base=report.base, tip=report.tip)
        except InvalidRobot:
            # Limits, a tool or a mount that make no sense: only an adapter has them.
            if path.suffix == ".toml":
                continue
            raise
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


def peak_memory() -> int:
    """Largest resident size of this process so far, bytes; that of getrusage would begin with its parent's."""
    status = Path("/proc/self/status")
    if status.exists():
        return int(re.search(r"VmHWM:\s+(\d+) kB", status.read_text())[1]) * 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def work(samples: list[Sample], scratch: Path) -> None:
    """The watched process: a seed a line on standard input, a verdict a line on standard output."""
    resource.setrlimit(resource.RLIMIT_AS, (8 * 2**30, 8 * 2**30))
    for name in zoo.robots():
        arm = load(name)
        arm.solve(arm.forward_kinematics(np.full(7, -0.3)))
    print("ready", flush=True)
    before = peak_memory()
    for line in sys.stdin:
        seed = int(line)
        sample = samples[seed % len(samples)]
        data = mutated(sample.text, seed)
        start = time.monotonic()
        try:
            verdict = trial(data, scratch.with_suffix(sample.suffix))
        except Exception as error:
            verdict = f"FAILED {type(error).__name__}: {error}".replace("\n", " ")[:300]
        seconds = time.monotonic() - start
        if peak_memory() - before > MEMORY:
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
    for sample in corpus([]):
        scratch.with_suffix(sample.suffix).unlink(missing_ok=True)
    print(
        f"{options.count} mutations of {len(corpus(options.folders))} files, slowest {slowest:.2f} s: {dict(verdicts)}"
    )
    return int(failures > 0)


if __name__ == "__main__":
    sys.exit(main())
