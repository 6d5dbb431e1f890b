"""Times of single calls, each on its own pose, with what the answers are worth."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import metadata
from typing import Any

import numpy as np

from srs_ik.arm import Arm
from srs_ik.system.arrays import Array

WARM_UP = 20
FARTHER = 1e-6
"""A posture is farther from the seed than the known one by more than this, rad: the square root of a rounding error."""
OUTSIDE = 1e-9
"""A posture is outside the limits by more than this, rad."""


@dataclass(frozen=True)
class Timed:
    """Single calls of one function, one for each pose."""

    robot: str  # name of the robot
    package: str  # name and version
    call: str  # what was called
    median_us: float  # median time of a call, microseconds
    p99_us: float  # 99th percentile
    poses: int  # poses asked for
    answered: int  # poses with an answer, by the package's own word
    # largest error of all answers, the larger of m and rad, by Pinocchio; None where there are no postures
    error: float | None
    inside: int | None  # poses with an answer inside the limits; None where there are no postures
    farther: int | None  # answers farther from the seed than the known posture; None without seeds
    found: int  # postures or intervals that were found, over all poses


def time_calls(call: Callable[..., Any], arguments: Sequence[tuple[Any, ...]]) -> tuple[Array, list[Any]]:
    """Time of each call, microseconds, and what each returned; first calls, which compile or allocate, come before."""
    for given in arguments[:WARM_UP]:
        call(*given)
    times, answers = np.empty(len(arguments)), []
    gc.disable()
    try:
        for i, given in enumerate(arguments):
            begin = time.perf_counter_ns()
            answer = call(*given)
            times[i] = 1e-3 * (time.perf_counter_ns() - begin)
            answers.append(answer)
    finally:
        gc.enable()
    return times, answers


def measure(
    arm: Arm,
    package: str,
    name: str,
    call: Callable[..., Any],
    arguments: Sequence[tuple[Any, ...]],
    postures: Callable[[Any], Any] | None,
    near: tuple[Array, Array] | None = None,
) -> Timed:
    """Time a function on the arguments of each call, whose first is the pose; the arm measures the errors.

    `postures` gives the (k, 7) postures of an answer, None where answers are lists of something else; `near` are (N, 7)
    known postures and (N, 7) seeds, where the answer is to be near the seed.
    """
    times, answers = time_calls(call, arguments)
    median, p99 = np.percentile(times, [50.0, 99.0]).tolist()
    version = f"{package} {metadata.version(package)}"
    head = (arm.name, version, name, median, p99, len(answers))
    if postures is None:
        counts = [len(answer) for answer in answers]
        return Timed(*head, sum(map(bool, counts)), None, None, None, sum(counts))
    found = [np.reshape(np.asarray(postures(answer), float), (-1, 7)) for answer in answers]
    errors = [max(arm.verify(given[0], q)) for given, Q in zip(arguments, found, strict=True) for q in Q]
    inside = sum(any(_is_inside(arm, q) for q in Q) for Q in found)
    farther = None
    if near is not None:
        farther = sum(
            len(Q) > 0 and min(_distance(arm, q, seed) for q in Q) > _distance(arm, known, seed) + FARTHER
            for Q, known, seed in zip(found, *near, strict=True)
        )
    answered = sum(len(Q) > 0 for Q in found)
    return Timed(*head, answered, max(errors, default=None), inside, farther, sum(map(len, found)))


def _is_inside(arm: Arm, q: Array) -> bool:
    return bool((q >= arm.lower - OUTSIDE).all() and (q <= arm.upper + OUTSIDE).all())


def _distance(arm: Arm, q: Array, seed: Array) -> float:
    """Root of the sum of squared joint differences, with every continuous joint in the turn nearest the seed."""
    apart = q - seed
    endless = ~np.isfinite(arm.lower)
    apart[endless] = (apart[endless] + np.pi) % (2.0 * np.pi) - np.pi
    return float(np.linalg.norm(apart))
