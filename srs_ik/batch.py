"""Work on many poses: compiled ranges that release the interpreter lock, spread over threads."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

from srs_ik.errors import SrsIkError

SMALLEST_RANGE = 32
"""Fewer poses than this are not worth a thread."""


def run_in_threads(work: Callable[[int, int], None], count: int, threads: int | None) -> None:
    """Call work(first, last) on ranges that cover 0 to count, at the same time on up to `threads` threads.

    Each range writes its own part of the output, so the result does not depend on their number.

    Raises:
        SrsIkError: `threads` is not a positive integer.
    """
    if threads is None:
        threads = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    elif isinstance(threads, bool) or not isinstance(threads, int) or threads < 1:
        raise SrsIkError(f"threads must be a positive integer, not {threads!r}")
    workers = max(1, min(threads, count // SMALLEST_RANGE))
    if workers == 1:
        work(0, count)
        return
    edges = [count * k // workers for k in range(workers + 1)]
    with ThreadPoolExecutor(workers) as pool:
        for done in [pool.submit(work, a, b) for a, b in pairwise(edges)]:
            done.result()
