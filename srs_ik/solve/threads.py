"""Work on many poses: compiled ranges that release the interpreter lock, spread over threads."""

from __future__ import annotations

import os
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np

from srs_ik.errors import SrsIkError

SMALLEST_RANGE = 8
"""Poses that are worth a call, and those that show how long one takes."""

RANGES = 16
"""Ranges for each thread: where a processor has other work too, the other threads do more of them."""

WORTH_A_THREAD = 2e-4
"""Seconds of work for which threads are started; to start one takes about a quarter of this."""


def run_in_threads(work: Callable[[int, int], None], count: int, threads: int | None) -> None:
    """Call work(first, last) on ranges that cover 0 to count, at the same time on up to `threads` threads.

    The calling thread is one of them. Each range writes its own part of the output, so the result does not depend on
    their number.

    Raises:
        SrsIkError: `threads` is not a positive integer.
    """
    if threads is None:
        threads = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    elif isinstance(threads, bool) or not isinstance(threads, (int, np.integer)) or threads < 1:
        raise SrsIkError(f"threads must be a positive integer, not {threads!r}")
    helpers = min(threads, count // SMALLEST_RANGE) - 1
    if helpers < 1:
        work(0, count)
        return
    begin = time.perf_counter()
    work(0, SMALLEST_RANGE)
    rest = count - SMALLEST_RANGE
    if (time.perf_counter() - begin) * rest < WORTH_A_THREAD * SMALLEST_RANGE:
        work(SMALLEST_RANGE, count)
        return
    ranges = min(RANGES * (helpers + 1), -(-rest // SMALLEST_RANGE))
    edges = [SMALLEST_RANGE + rest * k // ranges for k in range(ranges + 1)]
    _share(work, deque(pairwise(edges)), helpers)


def _share(work: Callable[[int, int], None], left: deque[tuple[int, int]], helpers: int) -> None:
    """Do ranges until none is left, with so many helping threads; those that come too late are not waited for."""

    def take_ranges() -> None:
        while True:
            try:
                first, last = left.popleft()
            except IndexError:
                return
            work(first, last)

    pool = ThreadPoolExecutor(helpers)
    try:
        helping = [pool.submit(take_ranges) for _ in range(helpers)]
        take_ranges()
        for helper in helping:
            if not helper.cancel():
                helper.result()
    finally:
        # After an error or an interrupt nobody begins another range, and the helpers end after the one they are in.
        left.clear()
        pool.shutdown(wait=False, cancel_futures=True)
