"""A word to whoever waits, at a terminal or in a notebook, and to the log of a program."""

from __future__ import annotations

import logging
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

PATIENCE = 2.0
"""So long nobody asks what a program is at, s."""

_LOG = logging.getLogger("srs_ik")


@contextmanager
def said_if_long(words: str) -> Iterator[None]:
    """Say words where a block takes longer than a moment.

    They go to the logger "srs_ik", level INFO, and as a line to standard error where a person reads that: a terminal
    or a notebook.
    """
    timer = threading.Timer(PATIENCE, _say, (words,))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def _say(words: str) -> None:
    _LOG.info(words)
    stderr = sys.stderr
    # That of a notebook's kernel is no terminal, and shown below the cell.
    if stderr is not None and (stderr.isatty() or type(stderr).__module__.startswith("ipykernel.")):
        print(f"srs_ik: {words}", file=stderr)
