"""Compile all entries: python -m srs_ik.kernels.ahead.build [FOLDER] puts library, extension and header there.

Without a folder they are this checkout's own, used until a kernel is edited.
"""

from __future__ import annotations

import argparse
import os
import platform
import shutil
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path

from srs_ik.kernels import entries as counter
from srs_ik.kernels.ahead import backend, glue, linking
from srs_ik.kernels.ahead.frontend import translate_all
from srs_ik.kernels.ahead.signatures import Entry, read_table, rooms
from srs_ik.kernels.disk import KernelCache
from srs_ik.kernels.native import FOLDER, stamps

X86 = (
    ("x86-64-v2", "true"),
    ("x86-64-v3", "has_x86_64_v3()"),
    ("x86-64-v4", "has_x86_64_v4()"),
)
"""Kinds of processors, the best last, and how C asks for them."""

Work = tuple[Entry, int, str]


def targets() -> tuple[tuple[str, str], ...]:
    """Kinds of processors that this machine's objects are written for."""
    return X86 if platform.machine() in ("x86_64", "AMD64") else (("generic", "true"),)


def triple() -> str:
    """What LLVM calls this kind of machine."""
    import llvmlite.binding as llvm

    return str(llvm.get_process_triple())


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


def parts(entries: tuple[Entry, ...]) -> list[list[Work]]:
    """All variants, in two parts that share few kernels: exact limbs, and the rest."""
    exact: list[Work] = []
    rest: list[Work] = []
    for entry in entries:
        for variant, absent in enumerate(entry.variants):
            part = exact if "J" in absent else rest
            part.append((entry, variant, glue.variant_symbol("kernel", entry, variant)))
    return [rest, exact]


def translated(work: list[Work]) -> list[bytes]:
    """LLVM's bitcode of a part."""
    return translate_all(work, lambda done: _say(f"translated {done} of {len(work)}"))


def compiled(whole: bytes, symbols: list[str], target: str) -> bytes:
    """Object code of everything for one kind of processor."""
    names = {symbol: symbol.replace("kernel", target.replace("-", "_"), 1) for symbol in symbols}
    processor = "" if target == "generic" else target
    return backend.emit(whole, triple(), processor, "", names)


def build(folder: Path, entries: tuple[Entry, ...]) -> None:
    """Put the compiled kernels, the extension and the header into a folder.

    Raises:
        NoCompiler: the glue cannot be compiled.
    """
    linking.c_compiler()
    begin = time.monotonic()
    work = parts(entries)
    symbols = [symbol for part in work for _, _, symbol in part]
    names = [name for name, _ in targets()]
    with ProcessPoolExecutor(min(2, os.cpu_count() or 1), get_context("spawn")) as pool:
        code = [each for part in pool.map(translated, work) for each in part]
        _say(f"translated by Numba in {time.monotonic() - begin:.0f} s")
        whole = backend.merge(code, set(symbols))
        objects = list(pool.map(compiled, [whole] * len(names), [symbols] * len(names), names))
    _say(f"compiled for {', '.join(names)} in {time.monotonic() - begin:.0f} s")
    with tempfile.TemporaryDirectory() as scratch:
        place = Path(scratch)
        paths = []
        for name, content in zip(names, objects, strict=True):
            paths.append(place / f"{name}.o")
            paths[-1].write_bytes(content)
        (place / f"{glue.NAME}.h").write_text(glue.header(entries))
        (place / "library.c").write_text(glue.library(entries, targets()))
        (place / "extension.c").write_text(glue.extension(entries, stamps(sorted({entry.room for entry in entries}))))
        shutil.copy(Path(__file__).with_name("runtime.c"), place)
        made = linking.link(place, glue.NAME, paths)
        folder.mkdir(parents=True, exist_ok=True)
        for path in (*made, place / f"{glue.NAME}.h"):
            # In one step: another process may be running what lies there.
            shutil.copy(path, folder / f"{path.name}.partial")
            (folder / f"{path.name}.partial").replace(folder / path.name)
    _say(f"done in {time.monotonic() - begin:.0f} s")


def _say(words: str) -> None:
    print(f"srs_ik: kernels: {words}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?", default=FOLDER)
    parser.add_argument("--room", help="only the entries of a room, to try something")
    given = parser.parse_args()
    os.environ["SRS_IK_JIT"] = "1"
    if unlisted():
        sys.exit(f"entries/table.py has no line for {', '.join(unlisted())}")
    try:
        build(given.folder, tuple(entry for entry in read_table() if given.room in (None, entry.room)))
    except linking.NoCompiler as error:
        sys.exit(str(error))
