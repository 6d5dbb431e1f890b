"""The two decorators of this folder: `kernel` for functions called by kernels, `entry` for those called from Python.

Where the entries were compiled when the package was built (see `native`), an entry is its compiled form, the kernels
behind it are never called, and Numba need not be there. Else, where a source has changed since, or with SRS_IK_JIT=1,
Numba compiles what is called; with SRS_IK_JIT=inner, only the kernels that tests call themselves. With
NUMBA_DISABLE_JIT=1 a function stays as it is, for a debugger.

Of what Numba compiles, only entry points are cached on disk (see `disk`); their machine code contains all that they
call, so the cache is keyed by a digest of the entry's file and of every kernel file that it imports, however
indirectly.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from srs_ik.kernels import native, sources

AHEAD = native.all_compiled()
"""Whether all entries were compiled when the package was built, from these sources."""

BY_NUMBA = (not AHEAD or native.asked_for_inner()) and not native.asked_for("NUMBA_DISABLE_JIT")
"""Whether Numba compiles what is called."""

if BY_NUMBA:
    try:
        from numba import njit, types
    except ImportError as error:
        from srs_ik.errors import MissingExtra

        reason = native.refused() or "srs_ik has no compiled kernels here"
        raise MissingExtra("jit", f"{reason}, and no Numba to compile them, which") from error

    if native.refused():
        warnings.warn(f"{native.refused()}; until then Numba compiles what is called", RuntimeWarning, stacklevel=1)

    from srs_ik.kernels.disk import KernelCache

    _compile = njit(error_model="numpy", nogil=True, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Decorator of an inner kernel: compiled into its callers, and not callable from Python.

    Numba would compile a kernel anew for every constant that it is called with; here a constant counts as its type.
    """
    if not BY_NUMBA:
        return function
    dispatcher = _compile(function)
    template = dispatcher.get_call_template
    dispatcher.get_call_template = lambda args, kws: template(
        tuple(types.unliteral(a) for a in args), {k: types.unliteral(a) for k, a in kws.items()}
    )
    return dispatcher


def source_digest(path: Path) -> str:
    """Digest of a kernel file and of every kernel file that it imports, however indirectly."""
    return sources.digest(path, Path(__file__).parent)


def entry(function: Callable[..., Any]) -> Callable[..., Any]:
    """Decorator of an entry point: compiled with the package, or once by Numba, then loaded from disk.

    What is loaded from disk is out of date where a source that it needs has changed.
    """
    ahead = native.compiled_entry(function)
    if ahead is not None or not BY_NUMBA:
        return ahead or function
    dispatcher = njit(error_model="numpy", nogil=True)(function)
    dispatcher._cache = KernelCache(function, partial(source_digest, Path(function.__code__.co_filename)))
    return dispatcher
