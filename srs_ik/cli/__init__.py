"""The command line `srs-ik`: list robots, inspect a robot file, solve a pose, list its feasible arm angles."""

from __future__ import annotations

import contextlib
import os
import sys

EXIT_NO_SOLUTION = 1
EXIT_WRONG_INPUT = 2
EXIT_INTERRUPTED = 130
EXIT_BROKEN_PIPE = 141
"""What a shell says of a program that SIGPIPE ended: the reader of a pipe had seen enough."""


def main() -> None:
    """Run `srs-ik` with the arguments of this process, and exit.

    The exit status is 0 on success, 1 where there is no solution or no S-R-S limb, 2 for wrong input (with one line on
    standard error), 130 after an interruption, 141 where the reader of a pipe left.
    """
    _open_closed_streams()
    try:
        for stream in (sys.stdout, sys.stderr):
            # A joint name that the terminal's encoding lacks must not end in a traceback.
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
        # Imported here, so that an interruption while the libraries load is quiet too.
        from srs_ik.cli.app import app
        from srs_ik.cli.waiting import let_interrupt, warn_in_one_line

        let_interrupt()
        warn_in_one_line()
        app(prog_name="srs-ik")
    except KeyboardInterrupt:
        sys.exit(EXIT_INTERRUPTED)
    except BrokenPipeError:
        sys.exit(EXIT_BROKEN_PIPE)
    finally:
        _close_quietly()


def _open_closed_streams() -> None:
    """Give a stream that the caller has closed a place to write to, or the next file opened would be that place."""
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        try:
            os.fstat(number)
        except OSError:
            # The lowest number that is free, which is this one.
            os.open(os.devnull, os.O_RDWR)
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, mode, closefd=False))


def _close_quietly() -> None:
    """Flush both streams; what cannot take the rest is turned to nowhere, or Python would say so once more at exit."""
    broken = False
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError as error:
            with contextlib.suppress(OSError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
            broken = broken or isinstance(error, BrokenPipeError)
    if broken:
        sys.exit(EXIT_BROKEN_PIPE)
