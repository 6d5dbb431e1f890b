"""Children forked while another thread of their parent loads or compiles: none waits for ever."""

import os
import subprocess
import sys

import pytest

if not hasattr(os, "fork"):
    pytest.skip("processes cannot be forked here", allow_module_level=True)

PROGRAM = """
import os, signal, sys, threading, time

PATIENCE = 600

def forked(count, child):
    "How the children end: a code, or minus the signal that ended one."
    codes = []
    for k in range(count):
        time.sleep(0.0007 * (k % 13))
        pid = os.fork()
        if pid == 0:
            signal.alarm(PATIENCE)
            code = 1
            try:
                child()
                code = 0
            finally:
                os._exit(code)
        codes.append(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))
    return codes
"""
LOADING = """
import srs_ik
srs_ik.load("iiwa14")
done = threading.Event()

def load_on():
    while not done.is_set():
        srs_ik.load("iiwa14")

thread = threading.Thread(target=load_on)
thread.start()
codes = forked(100, lambda: srs_ik.load("gen3"))
done.set()
thread.join()
print(len(codes), set(codes))
"""
STARTING = """
import srs_ik

def answer():
    arm = srs_ik.load("iiwa14")
    assert arm.solve(arm.forward_kinematics([0.3] * 7))

thread = threading.Thread(target=answer)
thread.start()
codes = forked(8, answer)
thread.join()
print(len(codes), set(codes))
"""
COMPILING = """
from numba import njit
import srs_ik.system.forks

def make(k):
    def f(x):
        total = 0.0
        for i in range(k):
            total += (x + i) ** 2
        return total
    return njit(f)

done = threading.Event()

def compile_on():
    k = 0
    while not done.is_set():
        k += 1
        make(k)(1.0)

thread = threading.Thread(target=compile_on)
thread.start()
codes = forked(20, lambda: make(100)(2.0))
done.set()
thread.join()
print(len(codes), set(codes))
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("program", "count"), [(LOADING, 100), (STARTING, 8), (COMPILING, 20)], ids=["loading", "starting", "compiling"]
)
def test_no_child_hangs(program, count):
    done = subprocess.run([sys.executable, "-c", PROGRAM + program], capture_output=True, text=True, timeout=1200)
    assert (done.stdout, done.stderr) == (f"{count} {{0}}\n", "")


def test_a_fork_comes_to_its_turn():
    """However often another thread takes the lock again: at most once between the wish for a fork and the fork."""
    program = """
from srs_ik.system.forks import WHOLE

taken, done = [0], threading.Event()

def take_on():
    while not done.is_set():
        with WHOLE:
            taken[0] += 1
            end = time.perf_counter() + 0.002
            while time.perf_counter() < end:
                pass

thread = threading.Thread(target=take_on)
thread.start()
between = []
for k in range(100):
    time.sleep(0.0007 * (k % 13))
    before = taken[0]
    pid = os.fork()
    if pid == 0:
        with WHOLE:
            os._exit(0)
    between.append(taken[0] - before)
    os.waitpid(pid, 0)
done.set()
thread.join()
print(max(between) <= 2, between)
"""
    done = subprocess.run([sys.executable, "-c", PROGRAM + program], capture_output=True, text=True, timeout=1200)
    assert (done.stdout[:4], done.stderr) == ("True", ""), done.stdout


def test_a_fork_within_is_no_deadlock():
    """Whoever forks while it loads itself, as a user's own function may, does not wait for itself."""
    program = """
from srs_ik.system.forks import WHOLE, whole

@whole
def inner():
    pid = os.fork()
    if pid == 0:
        with WHOLE:
            os._exit(7)
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])

signal.alarm(PATIENCE)
print(inner())
"""
    done = subprocess.run([sys.executable, "-c", PROGRAM + program], capture_output=True, text=True, timeout=1200)
    assert (done.stdout, done.stderr) == ("7\n", "")


@pytest.mark.slow
def test_locks_are_free_after_a_fork():
    program = """
import numba
from numba.core.compiler_lock import global_compiler_lock
from srs_ik.system.forks import WHOLE

def free():
    found = []
    def look():
        found.append(WHOLE.acquire(timeout=60) and global_compiler_lock._lock.acquire(timeout=60))
    thread = threading.Thread(target=look)
    thread.start()
    thread.join()
    assert found == [True]

print(forked(3, free))
free()
"""
    done = subprocess.run([sys.executable, "-c", PROGRAM + program], capture_output=True, text=True, timeout=1200)
    assert (done.stdout, done.stderr) == ("[0, 0, 0]\n", "")
