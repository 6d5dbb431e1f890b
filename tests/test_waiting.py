"""Whoever waits for a compilation in a terminal is told so, once; a program that reads standard error is not."""

import os
import re
import subprocess
import sys

import pytest

pty = pytest.importorskip("pty")

COMPILE_TWICE = """
from srs_ik.cli.waiting import announce_compilation
announce_compilation()
from numba import njit
double = njit(lambda x: 2 * x)
print(double(2), double(2.5))
"""


@pytest.mark.numba
def test_a_terminal_gets_one_line():
    ours, theirs = pty.openpty()
    try:
        subprocess.run([sys.executable, "-c", COMPILE_TWICE], stderr=theirs, stdout=subprocess.PIPE, check=True)
        said = os.read(ours, 4096).decode()
    finally:
        os.close(theirs)
        os.close(ours)
    assert said.count("\n") == 1
    assert said.startswith("srs-ik: compiling")


def test_a_pipe_gets_nothing():
    result = subprocess.run([sys.executable, "-c", COMPILE_TWICE], capture_output=True, text=True, check=True)
    assert (result.stdout, result.stderr) == ("4 5.0\n", "")


INTERRUPTED = """
import ctypes, signal, time
from srs_ik.cli.waiting import let_interrupt
let_interrupt()

@ctypes.CFUNCTYPE(None)
def {name}():
    signal.raise_signal(signal.SIGINT)

try:
    {name}()
    for _ in range(100):
        time.sleep(0.1)
except KeyboardInterrupt:
    print("interrupted")
"""


def test_an_interruption_within_the_compiler_is_not_lost():
    from llvmlite.binding.executionengine import ExecutionEngine

    names = [name for name in vars(ExecutionEngine) if name.startswith("_raw_object_cache")]
    assert names
    for name in names:
        code = INTERRUPTED.format(name=name)
        result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300)
        assert (result.stdout, result.stderr) == ("interrupted\n", "")


BATCH = """
import time
from srs_ik.cli.waiting import at_work
from srs_ik.solve.threads import run_in_threads

with at_work("many poses"):
    run_in_threads(lambda first, last: time.sleep(0.001 * (last - first)), 1500, {threads})
print("done")
"""


@pytest.mark.parametrize("threads", [1, 2])
def test_a_terminal_shows_how_far_a_batch_is(threads):
    ours, theirs = pty.openpty()
    try:
        program = [sys.executable, "-c", BATCH.format(threads=threads)]
        done = subprocess.run(
            program, stderr=theirs, stdout=subprocess.PIPE, check=True, env={**os.environ, "TERM": "xterm"}
        )
        said = os.read(ours, 1 << 16).decode()
    finally:
        os.close(theirs)
        os.close(ours)
    assert done.stdout == b"done\n"
    assert "many poses" in said
    shares = {int(share) for share in re.findall(r"(\d+)%", said)}
    assert max(shares) == 100
    assert len(shares) > 3
    silent = subprocess.run(program, capture_output=True, check=True)
    assert silent.stderr == b""
