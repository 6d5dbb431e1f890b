"""Forks that wait: a child inherits every lock that a thread of its parent holds, and nobody releases it there.

A fork waits for what holds `WHOLE`, such as the loading of a robot, and for the end of a compilation.
"""

from __future__ import annotations

# These take locks of their own around a fork. Imported while one waits here, they would release what they never took.
import concurrent.futures.thread  # noqa: F401
import logging  # noqa: F401
import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import wraps
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


class _InTurn:
    """A lock that its holder may take again, and that a thread which waits gets before the same one gets it anew.

    Python's own locks promise no order: a fork beside a thread that loads one robot after another could wait for ever.
    """

    def __init__(self) -> None:
        self._lock, self._turn, self._mine = threading.RLock(), threading.Lock(), threading.local()

    def acquire(self, timeout: float = -1) -> bool:
        if self._depth > 0:
            taken = self._lock.acquire()
        else:
            # Whoever is next waits with the turn in hand.
            if not self._turn.acquire(timeout=timeout):
                return False
            try:
                taken = self._lock.acquire(timeout=timeout)
            finally:
                self._turn.release()
        self._mine.depth = self._depth + taken
        return taken

    def release(self) -> None:
        self._mine.depth = self._depth - 1
        self._lock.release()

    def renew(self) -> None:
        """In a child: a thread that is not there may have waited with the turn in hand."""
        self._turn = threading.Lock()

    @property
    def _depth(self) -> int:
        return getattr(self._mine, "depth", 0)

    def __enter__(self) -> None:
        self.acquire()

    def __exit__(self, *_: object) -> None:
        self.release()


WHOLE = _InTurn()
"""Held by whoever must not be cut in two by a fork."""

_held = ExitStack()
"""The locks of Numba and LLVM, while a fork holds them."""


def whole(function: Callable[P, R]) -> Callable[P, R]:
    """Decorator of a function that a fork in another thread waits for: one that imports, compiles or diverts output."""

    @wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> R:
        with WHOLE:
            return function(*args, **kwargs)

    return call


def _locks() -> Iterator[Any]:
    """Numba's lock of compilations, then that of calls to LLVM, which the collection of garbage takes alone.

    They are not imported: a program that never compiles has no such locks.
    """
    yield getattr(sys.modules.get("numba.core.compiler_lock"), "global_compiler_lock", None)
    yield getattr(getattr(sys.modules.get("llvmlite.binding.ffi"), "lib", None), "_lock", None)


def _before() -> None:
    WHOLE.acquire()
    # In the order in which a compilation takes them.
    for lock in _locks():
        if lock is not None:
            _held.enter_context(lock)


def _after() -> None:
    _held.close()
    WHOLE.release()


def _after_in_child() -> None:
    WHOLE.renew()
    _after()
    # Numba looks its contexts up under locks that no order leads to. There is one thread now, which holds none of them.
    registry = sys.modules.get("numba.core.registry")
    for lookup in vars(getattr(registry, "CPUTarget", object)).values():
        for name in {"_lock", "lock"} & set(getattr(lookup, "__dict__", ())):
            setattr(lookup, name, threading.RLock())


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_before, after_in_parent=_after, after_in_child=_after_in_child)
