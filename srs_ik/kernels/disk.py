"""Machine code on disk: read from each place where it may lie, written to the first place that takes it.

Numba's own cache ends the program where no folder can be written, where a file is damaged and where the disk is full.
Here the worst is to compile again, which is said once. A file is one function for one signature, below its SHA-256.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import pickle
import stat
import sys
import tempfile
import uuid
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from numba import __version__ as numba_version
from numba import config
from numba.core.caching import FunctionCache, _CacheLocator
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps
from numba.misc.appdirs import AppDirs

_SUM = hashlib.sha256().digest_size

_said = False
"""Whether this process has been told that its machine code cannot be kept."""


def places(source: Path) -> list[Path]:
    """Folders for the machine code of a source file, the best one first: NUMBA_CACHE_DIR alone where it is set."""
    below = _CacheLocator.get_suitable_cache_subpath(str(source))
    if config.CACHE_DIR:
        return [Path(config.CACHE_DIR, below)]
    of_user = Path(AppDirs(appname="numba", appauthor=False).user_cache_dir, below)
    # Without a home the user's folder is "~" in the working directory, whoever that belongs to.
    return [source.parent / "__pycache__", *([of_user] if of_user.is_absolute() else [])]


def private_folder(*, make: bool) -> Path | None:
    """A folder among the temporary ones that only this user can write to, made where missing if `make`, or None.

    Machine code is run as it is read, so a folder that someone else has made or can replace is of no use.
    """
    with contextlib.suppress(OSError, AttributeError):
        above = Path(tempfile.gettempdir()).absolute()
        user = os.geteuid()
        folder = above / f"srs_ik-{user}"
        if make:
            with contextlib.suppress(FileExistsError):
                folder.mkdir(mode=0o700)
        own, parent = folder.lstat(), above.stat()
        shared = parent.st_mode & (stat.S_IWGRP | stat.S_IWOTH) and not parent.st_mode & stat.S_ISVTX
        trusted = parent.st_uid in (0, user) and not shared
        if trusted and stat.S_ISDIR(own.st_mode) and own.st_uid == user and not own.st_mode & 0o077:
            return folder
    return None


class KernelCache(FunctionCache):  # type: ignore[misc]
    """The machine code of one function on disk, for each signature; out of date where what `stamp` gives changes."""

    def __init__(self, function: Callable[..., Any], stamp: Callable[[], str]) -> None:
        # The base class would look for a folder to write to, and stop where there is none.
        self._py_func = function
        self._name = repr(function)
        self._stamp = stamp
        self._source = Path(function.__code__.co_filename)
        self._places = places(self._source)
        self._cache_path = str(self._places[0])
        self.enable()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled function, or None if no place has it whole."""
        target_context.refresh()
        if not self._enabled:
            return None
        key = self._key(sig, target_context.codegen())
        for folder in self._readable():
            # Whatever a file holds that Numba cannot use, it is as good as none.
            with contextlib.suppress(Exception):
                return CompileResult._rebuild(target_context, *_read(folder / self._file(key), key))
        return None

    def save_overload(self, sig: Any, cres: Any) -> None:
        """Write the compiled function to the first place that takes it."""
        if not self._enabled or cres.lifted or cres.library.has_dynamic_globals:
            return
        key = self._key(sig, cres.codegen)
        content = dumps((key, cres._reduce()))
        reasons = []
        for folder in self._places:
            try:
                self._write(folder, key, content)
            except OSError as error:
                reasons.append(f"{folder}: {error.strerror}")
            else:
                return
        self._write_aside(key, content, "; ".join(reasons))

    def flush(self) -> None:
        """Forget what is on disk."""
        for folder in self._readable():
            for path in folder.glob(f"{self._prefix()}*.nbc"):
                with contextlib.suppress(OSError):
                    path.unlink()

    def _readable(self) -> Iterator[Path]:
        yield from self._places
        aside = None if config.CACHE_DIR else private_folder(make=False)
        if aside is not None:
            yield self._below(aside)

    def _write_aside(self, key: Any, content: bytes, reasons: str) -> None:
        """Write to a temporary folder, or not at all, and say so."""
        aside = None if config.CACHE_DIR else private_folder(make=True)
        if aside is not None:
            with contextlib.suppress(OSError):
                self._write(self._below(aside), key, content)
                _say(f"compiled kernels are kept in {aside} only, as no better place can be written ({reasons})")
                return
        _say(f"compiled kernels cannot be kept, so each start compiles them again ({reasons})")

    def _below(self, folder: Path) -> Path:
        return folder / _CacheLocator.get_suitable_cache_subpath(str(self._source))

    def _write(self, folder: Path, key: Any, content: bytes) -> None:
        """Write a file whole or not at all, and remove those of the function that are out of date."""
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / self._file(key)
        partial = path.with_suffix(f".{uuid.uuid4().hex}")
        try:
            partial.write_bytes(hashlib.sha256(content).digest() + content)
            partial.replace(path)
        except BaseException:
            with contextlib.suppress(OSError):
                partial.unlink()
            raise
        current = self._current()
        for other in folder.glob(f"{self._prefix()}*.nbc"):
            if not other.name.startswith(current):
                with contextlib.suppress(OSError):
                    other.unlink()

    def _prefix(self) -> str:
        name = self._py_func.__qualname__.replace("<", "").replace(">", "")
        return f"{self._source.stem}.{name}-{sys.implementation.cache_tag}-"

    def _current(self) -> str:
        return f"{self._prefix()}{self._stamp()[:16]}-"

    def _key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        # Numba's part of it tells functions apart by their bytecode, which does not hold their constants.
        line = self._py_func.__code__.co_firstlineno
        return numba_version, self._current(), line, self._index_key(sig, codegen)

    def _file(self, key: Any) -> str:
        return f"{self._current()}{hashlib.sha256(str(key).encode()).hexdigest()[:16]}.nbc"


def _read(path: Path, key: Any) -> Any:
    """What is left of a compiled function in a file; raises where it is damaged, or that of another function."""
    content = path.read_bytes()
    if hashlib.sha256(content[_SUM:]).digest() != content[:_SUM]:
        raise ValueError(f"{path} is damaged")
    stored, reduced = pickle.loads(content[_SUM:])
    if stored != key:
        raise ValueError(f"{path} is of another function or signature")
    return reduced


def _say(what: str) -> None:
    global _said
    if not _said:
        _said = True
        warnings.warn(f"{what}; NUMBA_CACHE_DIR can name a folder for them", RuntimeWarning, stacklevel=2)
