"""Kernels that were compiled when the package was built: a library, its C header and the extension that calls it.

They lie in this folder where the package comes from a wheel. In a checkout there are none, and Numba compiles each
kernel when it is first needed.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent
KERNELS = FOLDER.parent
_TOOLS = KERNELS / "ahead"


def source_digest() -> str:
    """Digest of all files of kernels."""
    digest = hashlib.sha256()
    for path in sorted(KERNELS.rglob("*.py")):
        if _TOOLS not in path.parents:
            digest.update(path.relative_to(KERNELS).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def asked_for(variable: str) -> bool:
    """Whether a variable of the environment is set, and not to 0."""
    return os.environ.get(variable, "0") not in ("", "0")


@cache
def extension() -> Any:
    """The extension with the compiled entries; None where there is none of these sources, or Numba is asked for."""
    if asked_for("SRS_IK_JIT") or asked_for("NUMBA_DISABLE_JIT"):
        return None
    try:
        found = import_module(f"{__name__}.entries")
    except ImportError:
        return None
    return found if found.digest == source_digest() else None


def compiled_entry(function: Callable[..., Any]) -> Callable[..., Any]:
    """The compiled form of an entry.

    Raises:
        AttributeError: the table of entries had no line for it when the kernels were compiled.
    """
    return getattr(extension(), f"{function.__module__.rpartition('.')[2]}_{function.__name__}")


def limb_mark() -> bytes:
    """The first 16 bytes of a file with a packed limb: what it is, and of which columns."""
    return b"srs_ik\n\0" + hashlib.sha256((KERNELS / "layout" / "limb.py").read_bytes()).digest()[:8]


def at_work() -> str:
    """How kernels are run in this process, in words."""
    found = extension()
    if found is not None:
        return f"compiled when the package was built, for {found.target()}"
    if asked_for("NUMBA_DISABLE_JIT"):
        return "plain Python"
    return "compiled by Numba when first needed"
