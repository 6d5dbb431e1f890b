"""Kernels that were compiled when the package was built: a library, its C header and the extension that calls it.

They lie in this folder where the package comes from a wheel, or where a checkout was built in place. Numba compiles an
entry that they lack, or one of whose sources was edited since, when it is first needed.
"""

from __future__ import annotations

import hashlib
import os
import warnings
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from srs_ik.kernels import sources

FOLDER = Path(__file__).parent
KERNELS = FOLDER.parent

REMEDY = "install srs_ik again on this machine, or once for all with SRS_IK_BUILD=portable"
"""What helps where kernels were compiled for another kind of machine."""


def stamps(rooms: list[str]) -> dict[str, str]:
    """Digests to remember with what is compiled: that of all sources, below "", and that of each room of entries."""
    return {"": sources.digest_of_all(KERNELS)} | {room: _digest(room) for room in rooms}


def _digest(room: str) -> str:
    return sources.digest(KERNELS / "entries" / f"{room}.py", KERNELS)


def asked_for(variable: str) -> bool:
    """Whether a variable of the environment is set, and not to 0."""
    return os.environ.get(variable, "0") not in ("", "0")


def asked_for_inner() -> bool:
    """Whether Numba compiles inner kernels for those who call them, beside entries that were compiled before."""
    return os.environ.get("SRS_IK_JIT") == "inner"


def extension() -> Any:
    """The extension with the compiled entries; None where there is none, it cannot run here, or Numba is asked for."""
    return _found()[0]


def refused() -> str:
    """Why the compiled kernels that are there cannot run on this machine, in words; empty where they can."""
    return _found()[1]


@cache
def _found() -> tuple[Any, str]:
    if (asked_for("SRS_IK_JIT") and not asked_for_inner()) or asked_for("NUMBA_DISABLE_JIT"):
        return None, ""
    try:
        found = import_module(f"{__name__}.entries")
    except ModuleNotFoundError:
        return None, ""
    except ImportError as error:
        return None, f"srs_ik's compiled kernels cannot run here: {error}; {REMEDY}"
    wanted, taken = os.environ.get("SRS_IK_TARGET", ""), found.target()
    if wanted not in ("", taken):
        message = (
            f"SRS_IK_TARGET={wanted} changes nothing: there are no such kernels that run here; {taken} are at work"
        )
        warnings.warn(message, RuntimeWarning, stacklevel=1)
    return found, ""


@cache
def _stamps() -> dict[str, str]:
    """What is remembered with the compiled entries."""
    found = extension()
    return {} if found is None else dict(line.split(":") for line in found.digests.split())


@cache
def all_compiled() -> bool:
    """Whether all entries are compiled, from the sources as they are."""
    return bool(_stamps()) and _stamps()[""] == sources.digest_of_all(KERNELS)


@cache
def is_compiled(room: str) -> bool:
    """Whether the entries of a room are compiled, from the sources as they are."""
    if all_compiled():
        return True
    return room in _stamps() and (KERNELS / "entries" / f"{room}.py").is_file() and _stamps()[room] == _digest(room)


def compiled_entry(function: Callable[..., Any]) -> Any:
    """The compiled form of an entry; None where there is none of these sources. AttributeError: the table lacks it."""
    room = function.__module__.rpartition(".")[2]
    return getattr(extension(), f"{room}_{function.__name__}") if is_compiled(room) else None


def limb_mark() -> bytes:
    """The first 16 bytes of a file with a packed limb: what it is, and of which columns."""
    return b"srs_ik\n\0" + hashlib.sha256((KERNELS / "layout" / "limb.py").read_bytes()).digest()[:8]


def at_work() -> str:
    """How kernels are run in this process, in words."""
    if asked_for("NUMBA_DISABLE_JIT"):
        return "plain Python"
    changed = [room for room in _stamps() if room and not is_compiled(room)]
    if not _stamps() or len(changed) == len(_stamps()) - 1:
        return "compiled by Numba when first needed"
    ahead = f"compiled when the package was built, for {extension().target()}"
    return f"{ahead}, but for what was edited since: {', '.join(changed)}" if changed else ahead
