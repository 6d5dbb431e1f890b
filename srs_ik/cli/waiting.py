"""A word to whoever waits: the first call of each kind compiles its kernels, once a machine, and that takes a while."""

from __future__ import annotations

import sys
from typing import Any


def announce_compilation() -> None:
    """Print one line on standard error when something is first compiled; programs that read it, and logs, get none."""
    if not sys.stderr.isatty():
        return
    from numba.core import event

    class Announcement(event.Listener):  # type: ignore[misc]
        said = False

        def on_start(self, event: Any) -> None:
            if not self.said:
                self.said = True
                print("srs-ik: compiling for this machine, once; it takes up to half a minute", file=sys.stderr)

        def on_end(self, event: Any) -> None:
            pass

    event.register("numba:compile", Announcement())
