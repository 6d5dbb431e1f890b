"""Fails where a posture has become much slower, as a ratio to its own transcendental functions in the same process.

Run: python benchmarks/gate.py

Times on a shared machine say little, their ratio says enough: both sides are the least of many short runs, taken by
turns, and the bounds are a little more than twice what the code takes on registers of 512 bits.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

import srs_ik
from srs_ik.bench.floor import floor_us
from srs_ik.bench.work import Work

POSES = 200
ROUNDS = 40
BOUNDS = {"solve_batch at arm angles": 12.0, "eight branches": 12.0, "intervals_batch": 50.0, "solve": 35.0}


def least_us(call: Callable[[], Any], poses: int) -> float:
    """Time a pose, microseconds."""
    begin = time.perf_counter()
    call()
    return 1e6 * (time.perf_counter() - begin) / poses


def main() -> int:
    """Exit status: 1 where a ratio is above its bound."""
    arm = srs_ik.load("iiwa14")
    work = Work.of(arm, POSES)
    first = list(zip(work.poses[:50], work.arm_angles[:50].tolist(), strict=True))
    calls: dict[str, tuple[Callable[[], Any], int]] = {
        "solve_batch at arm angles": (lambda: arm.solve_batch(work.poses, work.arm_angles, threads=1), POSES),
        "eight branches": (
            lambda: arm.solve_batch(work.poses, work.arm_angles, all_branches=True, threads=1),
            POSES,
        ),
        "intervals_batch": (lambda: arm.intervals_batch(work.poses, threads=1), POSES),
        "solve": (lambda: [arm.solve(pose, angle) for pose, angle in first], len(first)),
    }
    floor = min(floor_us() for _ in range(3))
    least = dict.fromkeys(calls, float("inf"))
    for _ in range(ROUNDS):
        for name, (call, poses) in calls.items():
            least[name] = min(least[name], least_us(call, poses))
        floor = min(floor, floor_us())
    slow = False
    for name, us in least.items():
        ratio = us / floor
        slow = slow or ratio > BOUNDS[name]
        print(f"{name}: {us:.3f} us a pose, {ratio:.1f} times its functions ({floor:.3f} us); bound {BOUNDS[name]:.0f}")
    return int(slow)


if __name__ == "__main__":
    sys.exit(main())
