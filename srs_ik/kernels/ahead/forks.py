"""Calls made in processes of their own, each of which knows all that this process knows when it begins."""

from __future__ import annotations

import os
import sys
import tempfile
import traceback
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Self

CAN_FORK = sys.platform.startswith("linux")
"""Whether a process may be copied as it is; elsewhere libraries of the system forbid it, and calls are made here."""

MOST = 8
CORES = min(MOST, len(os.sched_getaffinity(0)) if CAN_FORK else 1)
"""So many calls at once: as many as this process may use processors, but each takes memory of its own."""


class Forks:
    """Calls that return bytes, some at a time; whatever else they change is lost."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self._running: set[int] = set()
        self._begun = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        while self._running:
            self._running.discard(os.wait()[0])
        self._folder.cleanup()

    def begin(self, call: Callable[[], bytes], most: int) -> None:
        """Begin a call as soon as fewer than `most` run."""
        path = self._path(self._begun)
        self._begun += 1
        if not CAN_FORK:
            path.write_bytes(call())
            return
        while not self.has_room(most):
            self._wait()
        child = os.fork()
        if child == 0:
            _answer(call, path)
        self._running.add(child)

    def has_room(self, most: int) -> bool:
        """Whether fewer than `most` run, or none."""
        while self._running:
            child, status = os.waitpid(-1, os.WNOHANG)
            if not child:
                break
            self._end(child, status)
        return len(self._running) < max(1, most)

    def results(self) -> list[bytes]:
        """What the calls returned, in the order in which they were begun.

        Raises:
            RuntimeError: one of them failed, and has told why.
        """
        while self._running:
            self._wait()
        return [self._path(i).read_bytes() for i in range(self._begun)]

    def _wait(self) -> None:
        self._end(*os.wait())

    def _end(self, child: int, status: int) -> None:
        self._running.discard(child)
        if status:
            raise RuntimeError("part of the kernels cannot be compiled, see above")

    def _path(self, number: int) -> Path:
        return Path(self._folder.name) / str(number)


def _answer(call: Callable[[], bytes], path: Path) -> None:
    """Make a call in a process that is there for it alone, and end that."""
    status = 1
    try:
        path.write_bytes(call())
        status = 0
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stderr.flush()
        os._exit(status)
