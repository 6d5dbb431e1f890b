"""A word to whoever waits at a terminal."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

PATIENCE = 2.0
"""So long nobody asks what a program is at, s."""


@contextmanager
def said_if_long(words: str) -> Iterator[None]:
    """Print a line on standard error, if that is a terminal, where a block takes longer than a moment."""
    stderr = sys.stderr
    if stderr is None or not stderr.isatty():
        yield
        return
    timer = threading.Timer(PATIENCE, print, (f"srs_ik: {words}",), {"file": stderr})
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
