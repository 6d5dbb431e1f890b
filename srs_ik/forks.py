"""Forks that wait: a child inherits every lock that a thread of its parent holds, and nobody releases it there.

A fork waits for what holds `WHOLE`, such as the loading of a robot, and for the end of a compilation.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")

WHOLE = threading.RLock()
"""Held by whoever must not be cut in two by a fork."""

_compiler: list[Any] = []
"""Numba's lock, while a fork holds it."""


def whole(function: Callable[P, R]) -> Callable[P, R]:
    """Decorator of a function that a fork in another thread waits for: one that imports, compiles or diverts output."""

    @wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> R:
        with WHOLE:
            return function(*args, **kwargs)

    return call


def _before() -> None:
    WHOLE.acquire()
    # Second, as it is in the functions above; and not imported, as a program that never compiles has no such lock.
    module = sys.modules.get("numba.core.compiler_lock")
    lock = getattr(module, "global_compiler_lock", None)
    if lock is not None:
        lock.acquire()
        _compiler.append(lock)


def _after() -> None:
    if _compiler:
        _compiler.pop().release()
    WHOLE.release()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_before, after_in_parent=_after, after_in_child=_after)
