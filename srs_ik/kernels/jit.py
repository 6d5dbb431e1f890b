"""The two decorators of this folder: `kernel` for functions called by kernels, `entry` for those called from Python.

With NUMBA_DISABLE_JIT=1 both leave a function as it is, for a debugger.

Only entry points are cached on disk (see `disk`); their machine code contains all that they call, so the cache is keyed
by a digest of the whole folder.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from numba import config, njit, types

from srs_ik.kernels.disk import KernelCache

_compile = njit(error_model="numpy", nogil=True, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Decorator of an inner kernel: compiled into its callers, and not callable from Python.

    Numba would compile a kernel anew for every constant that it is called with; here a constant counts as its type.
    """
    if config.DISABLE_JIT:
        return function
    dispatcher = _compile(function)
    template = dispatcher.get_call_template
    dispatcher.get_call_template = lambda args, kws: template(
        tuple(types.unliteral(a) for a in args), {k: types.unliteral(a) for k, a in kws.items()}
    )
    return dispatcher


@cache
def source_digest() -> str:
    """Digest of every source file of the kernels, in all rooms."""
    folder = Path(__file__).parent
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        digest.update(path.relative_to(folder).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


def entry(function: Callable[..., Any]) -> Callable[..., Any]:
    """Decorator of an entry point: compiled once, then loaded from disk as long as no kernel's source has changed."""
    if config.DISABLE_JIT:
        return function
    dispatcher = njit(error_model="numpy", nogil=True)(function)
    dispatcher._cache = KernelCache(function, source_digest)
    return dispatcher
