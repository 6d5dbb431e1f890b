"""The C compiler of this machine, or that of the package `ziglang`: glue compiled, and linked with the kernels."""

from __future__ import annotations

import importlib.util
import os
import platform
import shlex
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Sequence
from pathlib import Path

OPTIONS = ("-std=c11", "-O2", "-fPIC", "-pthread", "-Wall", "-Wextra", "-Wno-missing-field-initializers")


class NoCompiler(Exception):
    """There is no C compiler, or it cannot compile; the message says which."""


def c_compiler() -> list[str]:
    """The command of a C compiler, that of CC, cc, or zig; raises NoCompiler where there is none."""
    named = shlex.split(os.environ.get("CC", ""))
    if named and shutil.which(named[0]):
        return named
    for name in ("cc", "gcc", "clang"):
        if shutil.which(name):
            return [name]
    if importlib.util.find_spec("ziglang") is not None:
        return [sys.executable, "-m", "ziglang", "cc"]
    raise NoCompiler("no C compiler (cc, or the package ziglang)")


def link(folder: Path, name: str, objects: Sequence[Path]) -> tuple[Path, Path]:
    """Compile the glue in a folder and link it: the library of kernels, and the extension that calls it.

    The folder has `library.c`, `runtime.c`, `extension.c` and the header; raises NoCompiler where the compiler fails.
    """
    compiler = [*c_compiler(), *OPTIONS]
    mac = platform.system() == "Darwin"
    compiler += ["-dynamiclib", "-Wl,-x"] if mac else ["-shared", "-s", "-Wl,--build-id=none"]
    library = folder / (f"lib{name}.dylib" if mac else f"lib{name}.so")
    own_name = f"-Wl,-install_name,@rpath/{library.name}" if mac else f"-Wl,-soname,{library.name}"
    sources = ["library.c", "runtime.c", *map(str, objects)]
    # What kernels ask of Numba's runtime has to be in `runtime.c`; better to hear it here than at the first import.
    whole = [] if mac else ["-Wl,--no-undefined"]
    _run([*compiler, own_name, *whole, *sources, "-o", library.name, "-lm"], folder)
    extension = folder / "entries.abi3.so"
    beside = ["-undefined", "dynamic_lookup", "-Wl,-rpath,@loader_path"] if mac else ["-Wl,-rpath,$ORIGIN"]
    python = f"-I{sysconfig.get_path('include')}"
    _run([*compiler, python, "extension.c", "-L.", f"-l{name}", *beside, "-o", extension.name], folder)
    return library, extension


def _run(command: list[str], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise NoCompiler(f"{shlex.join(command[:3])} ... fails: {done.stderr.strip()[-2000:]}")
