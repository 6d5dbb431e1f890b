"""Work on many poses: compiled ranges that release the interpreter lock, spread over threads, and soon interrupted."""

from __future__ import annotations

import os
import threading
import time
from _thread import start_new_thread
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from srs_ik.errors import InvalidConfiguration, quoted

Stop = NDArray[np.int8]
Result = TypeVar("Result")

SMALLEST_RANGE = 8
"""Poses that are worth a call, and those that show how long one takes."""

FIRST_RANGE = 128
"""Poses of the first call where one thread does them all; the slowest arms need a third of a second for them."""

LONGEST = 0.1
"""Seconds that a call takes at most, as far as the one before tells: an interruption is noticed between two calls."""

GROWTH = 8
"""How many times longer than the one before a range may be."""

RANGES = 12
"""Ranges at least for each of several threads: where a processor has other work too, the other threads do more."""

SHARE_OF_REST = 3
"""A range is at most one of so many equal ones that each thread would get of the rest: so the last ones are short, and
no thread is still at a long one, with dear poses, when the others have nothing left."""

SHORTEST = 5e-5
"""Seconds of work below which ranges are not made shorter for that: taking one costs some microseconds."""

WORTH_A_THREAD = 2e-4
"""Seconds of work for which threads are started; until one is at work, about a quarter of this is over."""

_watcher: ContextVar[Callable[[int, int], None] | None] = ContextVar("watcher", default=None)


@contextmanager
def watched(watcher: Callable[[int, int], None]) -> Iterator[None]:
    """Within this block, tell how far the batches of this thread are: watcher(poses begun, poses of the batch)."""
    token = _watcher.set(watcher)
    try:
        yield
    finally:
        _watcher.reset(token)


def tell(begun: int, count: int) -> None:
    """Tell whoever watches this thread how far a piece of work is."""
    watcher = _watcher.get()
    if watcher is not None:
        watcher(begun, count)


def processors() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def checked_threads(threads: int | None) -> int:
    """How many threads to work on: no more than processors, all of these if it is not said.

    Raises:
        InvalidConfiguration: `threads` is not a positive integer.
    """
    if threads is None:
        return processors()
    if isinstance(threads, bool) or not isinstance(threads, (int, np.integer)) or threads < 1:
        raise InvalidConfiguration(f"threads must be a positive integer, not {quoted(threads)}")
    return min(int(threads), processors())


def run_in_threads(work: Callable[[int, int], None], count: int, threads: int | None) -> None:
    """Call work(first, last) on ranges that cover 0 to count, at the same time on up to `threads` threads.

    The calling thread is one of them; there are no more than processors. Each range writes its own part of the output,
    so the result does not depend on their number. After an interruption or an error no range is begun any more.

    Raises:
        InvalidConfiguration: `threads` is not a positive integer.
    """
    helpers = min(checked_threads(threads), count // SMALLEST_RANGE) - 1
    if helpers < 1 and count <= FIRST_RANGE:
        work(0, count)
        return
    if helpers < 1:
        _Batch(work, count, count).work_off(FIRST_RANGE, _watcher.get())
        return
    begin = time.perf_counter()
    work(0, SMALLEST_RANGE)
    pace = (time.perf_counter() - begin) / SMALLEST_RANGE
    if pace * (count - SMALLEST_RANGE) < WORTH_A_THREAD:
        work(SMALLEST_RANGE, count)
        return
    longest = -(-count // (RANGES * (helpers + 1)))
    batch = _Batch(work, count, longest, SMALLEST_RANGE, SHARE_OF_REST * (helpers + 1), int(SHORTEST / pace))
    _share(batch, max(SMALLEST_RANGE, int(LONGEST / pace)), helpers)


class _Batch:
    """What is left of a batch of `count` poses, handed out in ranges that `work` does.

    A range has at most `longest` poses and one of `parts` of what is left, and at least `shortest`, where there are so
    many and more than too few to be worth a call; `begun` are done already.
    """

    def __init__(
        self,
        work: Callable[[int, int], None],
        count: int,
        longest: int,
        begun: int = 0,
        parts: int = 1,
        shortest: int = 0,
    ) -> None:
        self._work = work
        self._count = count
        self._longest = max(SMALLEST_RANGE, longest)
        self._begun = begun
        self._parts = parts
        self._shortest = max(SMALLEST_RANGE, shortest)
        self._lock = threading.Lock()

    def work_off(self, size: int, watcher: Callable[[int, int], None] | None = None) -> None:
        """Do ranges until none is left, the first one of at most `size` poses."""
        while True:
            with self._lock:
                first = self._begun
                left = self._count - first
                length = min(left, size, self._longest, max(self._shortest, left // self._parts))
                self._begun += length
            if length <= 0:
                return
            begin = time.perf_counter()
            self._work(first, first + length)
            took = time.perf_counter() - begin
            size = max(SMALLEST_RANGE, int(length * min(GROWTH, LONGEST / max(took, 1e-9))))
            if watcher is not None:
                watcher(self._begun, self._count)

    def abandon(self) -> None:
        """Leave the rest undone."""
        with self._lock:
            self._begun = self._count


def _share(batch: _Batch, size: int, helpers: int) -> None:
    """Work a batch off with so many helping threads; those that come too late are not waited for."""
    helping: list[Future[None]] = [Future() for _ in range(helpers)]
    try:
        for helper in helping:
            # Not a pool's: to wait until a thread has started takes as long as to solve hundreds of poses.
            start_new_thread(_help, (helper, batch, size))
        batch.work_off(size, _watcher.get())
        for helper in helping:
            if not helper.cancel():
                helper.result()
    finally:
        # After an error or an interrupt the helpers end after the range that they are in.
        batch.abandon()


def _help(done: Future[None], batch: _Batch, size: int) -> None:
    """Work off a part of a batch, unless it has been cancelled."""
    if not done.set_running_or_notify_cancel():
        return
    try:
        batch.work_off(size)
    except BaseException as error:
        done.set_exception(error)
    else:
        done.set_result(None)


def interruptible(compute: Callable[[Stop], Result], *, worth_it: bool) -> Result:
    """compute(stop), where an interruption ends the waiting at once and sets stop[0], for kernels that look at it.

    Only the main thread can be interrupted, and only what is `worth_it` gets a thread for that.
    """
    stop = np.zeros(1, np.int8)
    if not worth_it or threading.current_thread() is not threading.main_thread():
        return compute(stop)
    pool = ThreadPoolExecutor(1)
    try:
        return pool.submit(compute, stop).result()
    finally:
        stop[0] = 1
        pool.shutdown(wait=False)
