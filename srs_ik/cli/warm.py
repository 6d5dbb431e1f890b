"""`srs-ik warm`: all that Numba would compile when it is first needed, now."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import typer

ROBOTS = ("iiwa14", "gen3")
"""An exact limb and a near one: each needs kernels of its own, and all of its kind share them."""


def warm() -> None:
    """Compile all kernels for this machine now, in a few minutes, so that no later call waits.

    Where the package brought compiled kernels along, as wheels do, there is nothing to compile.
    """
    from rich.console import Console
    from rich.progress import Progress

    from srs_ik.kernels.native import all_compiled, at_work

    if all_compiled():
        typer.echo(f"Nothing to do: kernels are {at_work()}.")
        return
    # Without Numba, this is the error, and not one of each process.
    import srs_ik.arm  # noqa: F401

    begin = time.monotonic()
    with Progress(console=Console(stderr=True)) as bar, ThreadPoolExecutor(len(ROBOTS)) as pool:
        tasks = [bar.add_task(f"kernels for robots like {robot}", total=35) for robot in ROBOTS]

        def follow(robot: str, task: object) -> None:
            for _ in _asked(robot):
                bar.advance(task)  # type: ignore[arg-type]

        list(pool.map(follow, ROBOTS, tasks))
    typer.echo(f"Compiled for this machine in {time.monotonic() - begin:.0f} s.")


def _asked(robot: str) -> Iterator[str]:
    """What a process of its own has asked an arm, as it goes."""
    command = [sys.executable, "-m", "srs_ik.bench.exercise", robot]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        yield from process.stdout
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command)
