"""Whoever waits for a compilation in a terminal is told so, once; a program that reads standard error is not."""

import os
import re
import subprocess
import sys
import threading
from contextlib import suppress

import pytest

pty = pytest.importorskip("pty")


def in_terminal(program):
    """What a program prints, and all that it says on a terminal, however much of it is there at a time."""
    ours, theirs = pty.openpty()
    said = []

    def listen():
        # The end of a terminal that nobody else holds open is an error on Linux, and nothing on macOS.
        with suppress(OSError):
            while part := os.read(ours, 4096):
                said.append(part)

    listener = threading.Thread(target=listen)
    listener.start()
    try:
        env = {**os.environ, "TERM": "xterm"}
        done = subprocess.run(program, stderr=theirs, stdout=subprocess.PIPE, check=True, env=env, text=True)
    finally:
        os.close(theirs)
        listener.join()
        os.close(ours)
    return done.stdout, b"".join(said).decode()


COMPILE_TWICE = """
from srs_ik.cli.waiting import announce_compilation
announce_compilation()
from numba import njit
double = njit(lambda x: 2 * x)
print(double(2), double(2.5))
"""


@pytest.mark.jit
def test_a_terminal_gets_one_line():
    _, said = in_terminal([sys.executable, "-c", COMPILE_TWICE])
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


SWALLOWED = """
import signal, sys, time
from srs_ik.cli.waiting import let_interrupt
let_interrupt()

class Interrupt:
    def find_spec(self, name, path, target=None):
        if name == "scipy.sparse.csgraph":  # which trimesh goes on without
            sys.meta_path.remove(self)
            signal.raise_signal(signal.SIGINT)

assert "scipy.sparse.csgraph" not in sys.modules
sys.meta_path.insert(0, Interrupt())
try:
    import trimesh
    for _ in range(100):
        time.sleep(0.1)
except KeyboardInterrupt:
    print("interrupted")
"""


def test_an_interruption_while_trimesh_is_imported_is_not_lost():
    result = subprocess.run([sys.executable, "-c", SWALLOWED], capture_output=True, text=True, timeout=300)
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
    program = [sys.executable, "-c", BATCH.format(threads=threads)]
    printed, said = in_terminal(program)
    assert printed == "done\n"
    assert "many poses" in said
    shares = {int(share) for share in re.findall(r"(\d+)%", said)}
    assert max(shares) == 100
    assert len(shares) > 3
    silent = subprocess.run(program, capture_output=True, check=True)
    assert silent.stderr == b""
