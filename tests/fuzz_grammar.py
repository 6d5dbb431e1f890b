"""Made-up robot files in great number: python tests/fuzz_grammar.py --count 50000

The files are those of tests/grammar.py. Each goes through everything that a user would do with it, in a process that is
watched. What counts as a failure: the end of the process, an exception that is none of the package's, a message of more
than one line or of 2,500 characters, a NaN, an answer that says OK and is not, a xacro file that ran, more than 2 s of
the processor (or 30 s of them in silence), or more than 300 MB beyond what the process had before the file.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import queue
import resource
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from pathlib import Path

import numpy as np
from fuzz import peak_memory, trial
from grammar import Made, made
from robot_files import serial_arm

from srs_ik import SrsIkError, load
from srs_ik.robot import zoo

LONGEST = 2.0
MEMORY = 300e6
STARVED = 20.0
"""Where other processes take the processor, silence may last so many times as long."""

ARM = f'<robot name="small">{serial_arm()}</robot>'
RAN = Path("/tmp/srs_ik_xacro_ran")


def verdict_of(file: Made, folder: Path) -> str:
    """What becomes of a file: "refused", "no limb", "solved" or "read"; all else is an exception."""
    path = folder / f"made{file.suffix}"
    if file.suffix == ".srdf":
        path.write_bytes(file.content)
        try:
            load(ARM, srdf=path)
        except SrsIkError as error:
            return checked(str(error))
        return "read"
    content = file.content
    if file.suffix == ".toml":
        (folder / "arm.urdf").write_text(ARM)
        content = content.replace(b"ADAPTED", b"arm.urdf")
    verdict = trial(content, path)
    assert not RAN.exists(), "a xacro file ran"
    return verdict


def checked(message: str) -> str:
    """The verdict on a file that is refused with this message."""
    assert len(message.splitlines()) == 1, message
    assert len(message) < 2500, message[:100]
    return "refused"


def work(first: int, count: int) -> None:
    """The watched process: a line for each seed, with seconds, megabytes and the verdict."""
    resource.setrlimit(resource.RLIMIT_AS, (8 * 2**30, 8 * 2**30))
    for name in zoo.robots():
        arm = load(name)
        arm.solve(arm.forward_kinematics(np.full(7, -0.3)))
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(first, first + count):
            file = made(seed)
            before = _forget_peak()
            start = time.process_time()
            try:
                verdict = verdict_of(file, Path(folder))
            except Exception as error:
                verdict = f"FAILED {type(error).__name__}: {error}".replace("\n", " ")[:300]
            seconds = time.process_time() - start
            print(f"{seed} {seconds:.3f} {(peak_memory() - before) / 1e6:.0f} {verdict}", flush=True)


def _forget_peak() -> int:
    """Let the peak of memory begin anew, where the system can; the peak now, bytes."""
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")
    return peak_memory()


class Watched:
    """The watched process and its lines; one that ends or hangs is started again behind the seed it was at."""

    def __init__(self, first: int, count: int) -> None:
        command = [sys.executable, __file__, "--work", "--first", str(first), "--count", str(count)]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.lines: queue.Queue[str] = queue.Queue()
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        for line in self.process.stdout:
            self.lines.put(line.strip())
        self.lines.put("")

    def line(self, seconds: float) -> str:
        """The next line; empty where the process has ended, or has worked for some seconds without one."""
        worked, begin = self._worked(), time.monotonic()
        while True:
            try:
                return self.lines.get(timeout=seconds)
            except queue.Empty:
                if self._worked() - worked > 0.9 * seconds or time.monotonic() - begin > STARVED * seconds:
                    return ""

    def _worked(self) -> float:
        """Processor time of the process, s; that of the clock where no system tells."""
        with contextlib.suppress(OSError, IndexError):
            fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
            return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
        return time.monotonic()


def run(first: int, count: int) -> tuple[Counter[str], list[str], float, float]:
    """Verdicts, failures, the slowest file in seconds, and the largest in megabytes, of a range of seeds."""
    verdicts: Counter[str] = Counter()
    failures: list[str] = []
    slowest, largest, seed, end = 0.0, 0.0, first, first + count
    while seed < end:
        watched = Watched(seed, end - seed)
        patience = 600.0
        while seed < end and (line := watched.line(patience)):
            patience = 30.0
            _, seconds, megabytes, verdict = line.split(" ", 3)
            slowest, largest = max(slowest, float(seconds)), max(largest, float(megabytes))
            if float(seconds) > LONGEST:
                verdict = f"FAILED {seconds} s after {verdict}"
            elif float(megabytes) * 1e6 > MEMORY:
                verdict = f"FAILED {megabytes} MB after {verdict}"
            if verdict.startswith("FAILED"):
                failures.append(f"seed {seed}: {verdict}")
                print(failures[-1], flush=True)
            verdicts[verdict.split(" ")[0] if verdict.startswith("FAILED") else verdict] += 1
            seed += 1
        watched.process.kill()
        status = watched.process.wait()
        if seed < end:
            failures.append(f"seed {seed}: FAILED hang or end of the process, exit status {status}")
            print(failures[-1], flush=True)
            verdicts["FAILED"] += 1
            seed += 1
    return verdicts, failures, slowest, largest


def main() -> int:
    """Run the files; the exit status is 1 if one of them failed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--work", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.work:
        work(options.first, options.count)
        return 0
    RAN.unlink(missing_ok=True)
    verdicts, failures, slowest, largest = run(options.first, options.count)
    print(f"{options.count} files, slowest {slowest:.2f} s, largest {largest:.0f} MB: {dict(verdicts)}")
    return int(bool(failures))


if __name__ == "__main__":
    sys.exit(main())
