"""Times every batch on one thread and on several, in turn, and prints how many times sooner several are done.

Run: python benchmarks/threads.py [ROBOT]... [--threads 2] [--turns 40]

A figure is the least of all turns, since whatever else a machine does only adds to a time. The ratio of processor times
is what several threads cost: 1 where they neither wait for one another nor get in each other's way.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np

import srs_ik

SECONDS = 0.03
"""What a batch takes on one thread, about: long for a thread, and short enough for many turns."""
LEAST = 1000
MOST = 300_000


def batches(arm: srs_ik.Arm, count: int) -> dict[str, Callable[[int], object]]:
    """Batches of so many known poses, by name, to be called with a number of threads."""
    q = np.random.default_rng(1).uniform(-1.5, 1.5, (count, 7))
    poses = arm.forward_kinematics_batch(q)
    anywhere = {"arm_angle": 0.4, "respect_limits": False}
    return {
        "arm angle": lambda threads: arm.solve_batch(poses, arm_angle=0.4, threads=threads),
        "arm angle, no limits, branch 0": lambda threads: arm.solve_batch(poses, branch=0, threads=threads, **anywhere),
        "arm angle, no limits, all branches": lambda threads: arm.solve_batch(
            poses, all_branches=True, threads=threads, **anywhere
        ),
        "seeds": lambda threads: arm.solve_batch(poses, seed=q + 0.05, threads=threads),
        "widest": lambda threads: arm.solve_batch(poses, threads=threads),
        "intervals": lambda threads: arm.intervals_batch(poses, threads=threads),
        "reachable": lambda threads: arm.reachable_batch(poses, threads=threads),
        "Jacobians": lambda threads: arm.jacobian_batch(q, threads=threads),
    }


def timed(call: Callable[[int], object], threads: int) -> tuple[float, float]:
    """Seconds by the clock, and of all threads together."""
    begin = time.perf_counter(), time.process_time()
    call(threads)
    return time.perf_counter() - begin[0], time.process_time() - begin[1]


def main() -> None:
    """One line a batch."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("robots", nargs="*", default=["iiwa14", "gen3"])
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--turns", type=int, default=40)
    given = parser.parse_args()
    for robot in given.robots:
        arm = srs_ik.load(robot)
        for name, tried in batches(arm, LEAST).items():
            pace = min(timed(tried, 1)[0] for _ in range(2)) / LEAST
            count = int(np.clip(SECONDS / pace, LEAST, MOST))
            call = batches(arm, count)[name]
            turns = [[timed(call, threads) for threads in (1, given.threads)] for _ in range(given.turns)]
            (one, alone), (many, together) = np.array(turns).min(axis=0)
            print(
                f"{robot} {name:35} {count:6} poses {1e6 * one / count:8.3f} us a pose on 1 thread, "
                f"{1e6 * many / count:8.3f} on {given.threads}: {one / many:.2f} times sooner, "
                f"in {together / alone:.2f} of the processor time",
                flush=True,
            )


if __name__ == "__main__":
    main()
