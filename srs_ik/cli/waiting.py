"""A word to whoever waits: the first call of each kind compiles its kernels, once a machine, and that takes a while."""

from __future__ import annotations

import signal
import sys
import threading
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import Any, TypeVar

from srs_ik.kernels.native import all_compiled

T = TypeVar("T")

_CALLBACKS = "_raw_object_cache"
"""How the functions begin that LLVM calls while it compiles: an exception in one is printed and lost."""

_CATCHES_ALL = "trimesh"
"""A package that takes any exception in what it imports and calls for one that it may go on without."""


def let_interrupt() -> None:
    """Make Ctrl+C end the program while it compiles or reads meshes, too: as soon as the exception is not lost."""
    signal.signal(signal.SIGINT, _interrupt)


def _interrupt(number: int, frame: FrameType | None) -> None:
    if not _would_be_lost(frame):
        raise KeyboardInterrupt
    threading.Timer(0.01, signal.raise_signal, (number,)).start()


def _would_be_lost(frame: FrameType | None) -> bool:
    if frame is not None and frame.f_code.co_name.startswith(_CALLBACKS):
        return True
    while frame is not None:
        if frame.f_globals.get("__name__", "").partition(".")[0] == _CATCHES_ALL:
            return True
        frame = frame.f_back
    return False


def announce_compilation() -> None:
    """Print one line on standard error when something is first compiled; programs that read it, and logs, get none.

    Where the kernels were compiled when the package was built, nothing is; nor without Numba.
    """
    if not sys.stderr.isatty() or all_compiled():
        return
    try:
        from numba.core import event
    except ImportError:
        return

    class Announcement(event.Listener):  # type: ignore[misc]
        said = False

        def on_start(self, event: Any) -> None:
            if not self.said:
                self.said = True
                words = "compiling for this machine, once; it takes up to a minute ('srs-ik warm': all at once)"
                print(f"srs-ik: {words}", file=sys.stderr)

        def on_end(self, event: Any) -> None:
            pass

    event.register("numba:compile", Announcement())


@contextmanager
def at_work(words: str) -> Iterator[None]:
    """Within this block, show in a terminal how far a batch is; of other work, that it goes on."""
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console
    from rich.progress import Progress

    from srs_ik.solve.threads import watched

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(words, total=None)
        with watched(lambda begun, count: bar.update(task, completed=begun, total=count)):
            yield


def counted(items: Sequence[T], words: str) -> Iterator[T]:
    """Go through items, and show in a terminal how far that is."""
    if not sys.stderr.isatty():
        yield from items
        return
    from rich.console import Console
    from rich.progress import track

    yield from track(items, words, console=Console(stderr=True), transient=True)


def warn_in_one_line() -> None:
    """Print warnings as the command line's other words, without the line of code that they come from."""

    def show(message: Warning | str, *_: Any) -> None:
        print(f"srs-ik: {message}", file=sys.stderr)

    warnings.showwarning = show  # type: ignore[assignment]
    # Of options and files, `poses.warn_of_degrees` says so, with their names and the remedy.
    warnings.filterwarnings("ignore", r"(the arm angle is in radians|(q|seed) has joint \d more than a turn)")
