"""Compile all entries: python -m srs_ik.kernels.ahead.build [FOLDER] puts library, extension and header there.

Without a folder they are this checkout's own, used until a kernel is edited. They are for the kind of processor that
this machine has; with SRS_IK_BUILD=portable for all kinds.
"""

from __future__ import annotations

import argparse
import os
import platform
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from importlib import import_module
from pathlib import Path

import llvmlite.binding as llvm

from srs_ik.kernels import entries as counter
from srs_ik.kernels.ahead import backend, glue, linking
from srs_ik.kernels.ahead.forks import CORES, Forks
from srs_ik.kernels.ahead.frontend import Frontend, Written
from srs_ik.kernels.ahead.signatures import Entry, read_table, rooms
from srs_ik.kernels.ahead.units import Unit, divide
from srs_ik.kernels.disk import KernelCache
from srs_ik.kernels.native import FOLDER, stamps

HERE = platform.machine()
"""What this machine is called."""

Targets = tuple[tuple[str, str], ...]
"""Kinds of processors, the best last, and how C asks for them."""

X86: Targets = (("x86-64-v2", "has_x86_64_v2()"), ("x86-64-v3", "has_x86_64_v3()"), ("x86-64-v4", "has_x86_64_v4()"))

NEEDED = {
    "x86-64-v3": {"avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe"},
    "x86-64-v4": {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"},
}
"""What a kind has that the kind before it lacks, as LLVM names it."""

Work = tuple[Entry, str]


def targets(machine: str = HERE, *, portable: bool = True) -> Targets:
    """Kinds of processors that a machine's objects are written for: all of them, or the one that this machine is."""
    if machine not in ("x86_64", "AMD64"):
        return (("generic", "true"),)
    return X86 if portable or machine != HERE else (own_kind(),)


def own_kind() -> tuple[str, str]:
    """The best kind that this machine is."""
    here = {name for name, has in llvm.get_host_cpu_features().items() if has}
    best = X86[0]
    for each in X86[1:]:
        if not NEEDED[each[0]] <= here:
            break
        best = each
    return best


def is_portable() -> bool:
    """Whether SRS_IK_BUILD asks for all kinds of processors; raises ValueError for anything else."""
    asked = os.environ.get("SRS_IK_BUILD", "")
    if asked not in ("", "portable"):
        raise ValueError(f"SRS_IK_BUILD is portable or pure, not {asked}")
    return bool(asked)


def triple(machine: str = HERE) -> str:
    """What LLVM calls a kind of machine: this one, or another one under Linux."""
    return str(llvm.get_process_triple()) if machine == HERE else f"{machine}-unknown-linux-gnu"


def unlisted() -> list[str]:
    """Entries that the table has no line for; Numba has to be at work in this process."""
    listed = {(entry.room, entry.name) for entry in read_table()}
    found = []
    for room in rooms():
        module = import_module(f"{counter.__name__}.{room}")
        for name, value in vars(module).items():
            own = getattr(getattr(value, "py_func", None), "__module__", "") == module.__name__
            if own and isinstance(value._cache, KernelCache) and (room, name) not in listed:
                found.append(f"{room}.{name}")
    return found


APART = ("collision", "control", "kinematics", "maps", "rates")
"""Rooms of entries that call few kernels of near limbs."""


def parts(entries: tuple[Entry, ...]) -> list[list[Work]]:
    """All entries, in two parts that share few kernels and take about as long: near limbs, and the rest."""
    near: list[Work] = []
    rest: list[Work] = []
    for entry in entries:
        (rest if entry.room in APART else near).append((entry, glue.symbol("kernel", entry)))
    return [near, rest]


BATCH = 64
"""Functions whose code is written by one process."""


def translated(work: list[Work], machine: str) -> list[bytes]:
    """All kernels and entries in LLVM, part by part."""
    with Forks() as forks:

        def share(frontend: Frontend) -> None:
            # Types are found by this process alone: it goes on while others write. The last function is not done yet.
            while frontend.waiting() > BATCH and forks.has_room(CORES - 1):
                forks.begin(partial(_written, frontend.take(BATCH), machine), CORES - 1)

        frontend = Frontend(share)
        forks.begin(lambda: backend.prepare(frontend.runtime(), None, triple(machine)), CORES)
        for done, each in enumerate(work, 1):
            frontend.find_types(*each)
            _say(f"read {done} of {len(work)}")
        while frontend.waiting():
            forks.begin(partial(_written, frontend.take(BATCH), machine), CORES)
        return forks.results()


def _written(write: Callable[[], Written], machine: str) -> bytes:
    return backend.prepare(*write(), triple(machine))


def compiled(works: list[list[Work]], machine: str, kinds: Targets) -> list[bytes]:
    """Object code of parts for some kinds of processors."""
    code = translated([each for work in works for each in work], machine)
    symbols = [[symbol for _, symbol in work] for work in works]
    whole = backend.join(code, {each for part in symbols for each in part}, triple(machine))
    units = divide(whole, symbols)
    with Forks() as forks:
        for unit in units:
            for kind, _ in kinds:
                forks.begin(partial(_object, unit, machine, kind), CORES)
        return forks.results()


def _object(unit: Unit, machine: str, kind: str) -> bytes:
    # Objects for several kinds stand in one library.
    names = {symbol: symbol.replace("kernel", kind.replace("-", "_"), 1) for symbol in unit.entries}
    names |= {symbol: f"{kind}.{symbol}" for symbol in unit.shared}
    code = backend.emit(unit.text, triple(machine), "" if kind == "generic" else kind, "", names)
    _say(f"compiled {len(unit.entries)} for {kind}")
    return code


def build(folder: Path, entries: tuple[Entry, ...], kinds: Targets, machine: str = HERE) -> None:
    """Put the compiled kernels, the extension and the header into a folder, for some kinds of processors of a machine.

    For another machine than this one, CC has to name a compiler for it; raises NoCompiler where the glue cannot be
    compiled.
    """
    linking.c_compiler()
    begin = time.monotonic()
    # Before kernels are read: what is edited meanwhile is out of date.
    stamped = stamps(sorted({entry.room for entry in entries}))
    objects = compiled(list(filter(None, parts(entries))), machine, kinds)
    with tempfile.TemporaryDirectory() as scratch:
        place = Path(scratch)
        paths = []
        for i, content in enumerate(objects):
            paths.append(place / f"{i}.o")
            paths[-1].write_bytes(content)
        (place / f"{glue.NAME}.h").write_text(glue.header(entries))
        (place / "library.c").write_text(glue.library(entries, kinds))
        (place / "extension.c").write_text(glue.extension(entries, kinds, stamped))
        shutil.copy(Path(__file__).with_name("runtime.c"), place)
        made = linking.link(place, glue.NAME, paths)
        folder.mkdir(parents=True, exist_ok=True)
        for path in (*made, place / f"{glue.NAME}.h"):
            # In one step: another process may be running what lies there.
            shutil.copy(path, folder / f"{path.name}.partial")
            (folder / f"{path.name}.partial").replace(folder / path.name)
    _say(f"compiled for {' and '.join(kind for kind, _ in kinds)} in {time.monotonic() - begin:.0f} s")


def _say(words: str) -> None:
    print(f"srs_ik: kernels: {words}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?", default=FOLDER)
    parser.add_argument("--room", help="only the entries of a room, to try something")
    parser.add_argument("--machine", default=HERE, help="kind of machine to compile for, such as aarch64")
    given = parser.parse_args()
    os.environ["SRS_IK_JIT"] = "1"
    if unlisted():
        sys.exit(f"entries/table.py has no line for {', '.join(unlisted())}")
    try:
        kinds = targets(given.machine, portable=is_portable())
        wanted = tuple(entry for entry in read_table() if given.room in (None, entry.room))
        build(given.folder, wanted, kinds, given.machine)
    except (linking.NoCompiler, ValueError) as error:
        sys.exit(str(error))
    # All that Numba has made goes with the process: to take it apart piece by piece would take seconds.
    os._exit(0)
