"""How time and memory of one batch grow with its poses."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from srs_ik.bench.own import best_time
from srs_ik.bench.work import Work
from srs_ik.loading import load
from srs_ik.solve.solutions import BatchSolution

POSES_APART = 1000
"""So many different poses; larger batches repeat them."""
LONG = 1_000_000
"""Batches from this size on are called once, and their memory is measured."""


@dataclass(frozen=True)
class Growth:
    """One `solve_batch` at given arm angles."""

    robot: str  # name of the robot
    poses: int  # poses in the batch
    threads: int  # threads it was given
    us: float  # time a pose, microseconds; the least of some calls where they are short
    answers_mb: float | None = None  # size of the answers, megabytes; None where memory is not measured
    # most memory that the process held during the call beyond what it had before, megabytes. The answers are in it;
    # poses and arm angles were there before, and a copy of them would show.
    memory_mb: float | None = None


def growth(robot: str, largest: int) -> Iterator[Growth]:
    """Batches of 1, 10, 100 and so on to `largest` poses, on one thread and on two, each size in its own process."""
    sizes = [10**k for k in range(len(str(largest))) if 10**k <= largest]
    for size in sizes:
        for threads in (1, 2):
            done = subprocess.run(
                [sys.executable, "-m", __name__, robot, str(size), str(threads)],
                check=True,
                capture_output=True,
                text=True,
            )
            yield Growth(robot, size, threads, **json.loads(done.stdout))


def one_size(robot: str, size: int, threads: int) -> dict[str, float | None]:
    """Time and memory of one size, in this process."""
    arm = load(robot)
    work = Work.of(arm, min(size, POSES_APART))
    arm.solve_batch(work.poses, arm_angle=work.arm_angles, threads=threads)
    poses, angles = np.resize(work.poses, (size, 4, 4)), np.resize(work.arm_angles, size)

    def call() -> BatchSolution:
        return arm.solve_batch(poses, arm_angle=angles, threads=threads)

    if size < LONG:
        return {"us": best_time(call) / size}
    batch, seconds, peak = _measured(call)
    figures: dict[str, float | None] = {"us": 1e6 * seconds / size}
    if peak is not None:
        figures |= {"answers_mb": 1e-6 * batch._rows.nbytes, "memory_mb": 1e-6 * peak}
    return figures


def _resident(field: str) -> int:
    """Memory of this process, bytes: VmRSS now, VmHWM the most since the mark was reset."""
    line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith(field))
    return 1024 * int(line.split()[1])


def _measured(call: Callable[[], BatchSolution]) -> tuple[BatchSolution, float, int | None]:
    """Answer and seconds of a call, and the memory it took at its height; None where the system does not tell."""
    before = None
    with suppress(OSError):
        # "5" sets the high-water mark to what is in use (Linux).
        Path("/proc/self/clear_refs").write_text("5")
        before = _resident("VmRSS")
    begin = time.perf_counter()
    answer = call()
    seconds = time.perf_counter() - begin
    return answer, seconds, None if before is None else _resident("VmHWM") - before


if __name__ == "__main__":
    print(json.dumps(one_size(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))))
