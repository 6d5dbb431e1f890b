"""Times every public call with kernels compiled ahead of time and with Numba's, in one run, and prints their ratio.

Run: python benchmarks/ahead.py FOLDER [ROBOT]...

FOLDER is an installed package with compiled kernels: pip install --no-deps --target FOLDER a wheel of this checkout.
Two processes answer by turns, one on each; a figure is the least processor time of many turns, that of all threads.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from pathlib import Path

TURNS = 15
BOUND = 1.05
LEFT_OUT = ("yardstick",)
"""Machine code without kernels of an arm."""

WORKER = """
import sys, time
import srs_ik
from srs_ik.bench.exercise import calls
from srs_ik.kernels.native import at_work

def seconds(call, count):
    begin = time.process_time()
    for _ in range(count):
        call()
    return (time.process_time() - begin) / count

made = calls(srs_ik.load(sys.argv[1]))
counts = {}
print(at_work(), flush=True)
for line in sys.stdin:
    call = made[line.rstrip()]
    if line not in counts:
        call()
        counts[line] = max(1, min(1000, int(0.02 / seconds(call, 1))))
    print(min(seconds(call, counts[line]) for _ in range(3)), flush=True)
"""


def worker(robot: str, environment: dict[str, str]) -> subprocess.Popen[str]:
    """A process that times the call whose name it is given."""
    return subprocess.Popen(
        [sys.executable, "-c", WORKER, robot],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd="/",
        env={**os.environ, **environment},
    )


def asked(process: subprocess.Popen[str], name: str) -> float:
    """Seconds of a call."""
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(f"{name}\n")
    process.stdin.flush()
    return float(process.stdout.readline())


def main() -> int:
    """Exit status: 1 where a call is slower ahead of time than the bound allows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("robots", nargs="*", default=["iiwa14", "gen3"])
    parser.add_argument("--turns", type=int, default=TURNS)
    given = parser.parse_args()
    sys.path.insert(0, str(given.folder))
    import srs_ik
    from srs_ik.bench.exercise import calls

    slow = []
    for robot in given.robots:
        checkout = str(Path(__file__).resolve().parents[1])
        by_numba = worker(robot, {"SRS_IK_JIT": "1", "PYTHONPATH": checkout})
        ahead = worker(robot, {"SRS_IK_JIT": "0", "PYTHONPATH": str(given.folder.resolve())})
        for process in (by_numba, ahead):
            assert process.stdout is not None
            print(f"{robot}: {process.stdout.readline().strip()}")
        for name in calls(srs_ik.load(robot)):
            if name in LEFT_OUT:
                continue
            times = [(asked(by_numba, name), asked(ahead, name)) for _ in range(given.turns)]
            old, new = (1e6 * min(column) for column in zip(*times, strict=True))
            print(f"{name:30} {old:11.2f} us by Numba {new:11.2f} us ahead {new / old:6.2f}", flush=True)
            if new > BOUND * old:
                slow.append(f"{robot}: {name}")
        for process in (by_numba, ahead):
            process.communicate()
    print(f"slower than {BOUND}: {', '.join(slow) or 'none'}")
    return int(bool(slow))


if __name__ == "__main__":
    sys.exit(main())
