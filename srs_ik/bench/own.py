"""The calls of this package, alone and in batches."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from srs_ik.arm import Arm
from srs_ik.bench.timing import Timed, measure
from srs_ik.bench.work import Work

PACKAGE = "srs-ik"
REPEATS = 5

BATCH = 20_000
LONGEST = 5e5
"""Poses of a batch, and the microseconds that it may take on one thread."""


@dataclass(frozen=True)
class Batch:
    """One batch call."""

    robot: str  # name of the robot
    call: str  # what was called
    poses: int  # poses in the batch
    one_thread_us: float  # time a pose on one thread, microseconds, the best of `REPEATS`
    two_threads_us: float  # the same on two threads


def single_calls(arm: Arm, work: Work) -> Iterator[Timed]:
    """Calls from Python, one pose at a time."""
    poses = list(work.poses)
    at_angle = list(zip(poses, work.arm_angles.tolist(), strict=True))
    free = [(pose, angle, False) for pose, angle in at_angle]
    seeded = [(pose, None, seed) for pose, seed in zip(poses, work.seeds, strict=True)]
    alone = [(pose,) for pose in poses]

    def of(name: str, call: Callable[..., Any], arguments: Any, postures: Any, near: Any = None) -> Timed:
        return measure(arm, PACKAGE, name, call, arguments, postures, near)

    yield of("solve(pose, arm_angle)", arm.solve, at_angle, _one)
    yield of("solve_all(pose, arm_angle)", arm.solve_all, at_angle, _all)
    yield of("solve_all(pose, arm_angle), no limits", arm.solve_all, free, _all)
    yield of("solve(pose, seed)", arm.solve, seeded, _one, (work.q, work.seeds))
    yield of("solve(pose)", arm.solve, alone, _one)
    yield of("intervals(pose)", arm.intervals, alone, None)


def _one(solution: Any) -> Any:
    return solution.q if solution else []


def _all(solutions: Any) -> Any:
    return solutions.q


def batches(arm: Arm, work: Work) -> Iterator[Batch]:
    """Batch calls on one thread and on two; the work is repeated to `BATCH` poses, as far as `LONGEST` allows."""

    def at_angle(work: Work, threads: int, **options: Any) -> Any:
        return arm.solve_batch(work.poses, work.arm_angles, threads=threads, **options)

    calls: dict[str, Callable[[Work, int], Any]] = {
        "solve_batch, arm angle": at_angle,
        "solve_batch, arm angle, branch 0, no limits": lambda work, n: at_angle(
            work, n, branch=0, respect_limits=False
        ),
        "solve_batch, arm angle, all branches, no limits": lambda work, n: at_angle(
            work, n, all_branches=True, respect_limits=False
        ),
        "solve_batch, seeds": lambda work, n: arm.solve_batch(work.poses, seed=work.seeds, threads=n),
        "solve_batch": lambda work, n: arm.solve_batch(work.poses, threads=n),
        "intervals_batch": lambda work, n: arm.intervals_batch(work.poses, threads=n),
    }
    for name, call in calls.items():
        once = best_time(call, work, 1, repeats=1)
        more = work.repeated(max(1, min(BATCH // len(work.poses), int(LONGEST / once))))
        poses = len(more.poses)
        yield Batch(arm.name, name, poses, *(best_time(call, more, n) / poses for n in (1, 2)))


def best_time(call: Callable[..., Any], *arguments: Any, repeats: int = REPEATS) -> float:
    """Least time of some calls, microseconds, after one that compiles."""
    call(*arguments)
    times = np.empty(repeats)
    for i in range(repeats):
        begin = time.perf_counter()
        call(*arguments)
        times[i] = time.perf_counter() - begin
    return 1e6 * float(times.min())
