"""The store of a map: a Zarr v3 group whose chunks are those of the tasks, and a record for each that is done.

A record is the CRC-32 of what a task has written, plus 2^32, so that it differs from the fill value; it is written
last. Chunks that hold nothing but zeros are no files, so only the record tells those from lost ones. Every file is
written whole and then renamed.
"""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import uuid
import zlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from srs_ik.errors import InvalidMap, MissingExtra, quoted
from srs_ik.maps.plan import MEASURES, YAW, Plan, plan_of, refuse_senseless

DONE = "done"
MARK = 1 << 32
KEY = "srs_ik"

Block = Sequence[slice]


def zarr_module() -> Any:
    """Zarr, which an extra brings; raises MissingExtra where it is not there."""
    try:
        import zarr
    except ImportError:
        raise MissingExtra("maps", "a map") from None
    return zarr


class Cells:
    """A Zarr array; reading what is damaged is an error of this package, whatever the decoder makes of it."""

    def __init__(self, array: Any, damaged: str) -> None:
        self._array = array
        self._damaged = damaged

    def __getitem__(self, at: Any) -> NDArray:
        """Read cells; raises InvalidMap where they are damaged."""
        try:
            values: NDArray = self._array[at]
        except Exception:
            # Every codec fails in ways of its own.
            raise InvalidMap(self._damaged) from None
        return values

    def __setitem__(self, at: Any, values: Any) -> None:
        self._array[at] = values

    def zeros(self) -> NDArray:
        """An array like this one, of zeros."""
        return np.zeros(self._array.shape, self._array.dtype)

    @property
    def vindex(self) -> Cells:
        """Cells by arrays of places."""
        return Cells(self._array.vindex, self._damaged)


def folder_of(path: Any) -> Path:
    """The folder of a store; raises InvalidMap for what is no path."""
    if not isinstance(path, str | os.PathLike) or isinstance(os.fspath(path), bytes):
        raise InvalidMap(f"the folder of a map is a path or text, not {quoted(path)}")
    return Path(path)


def identity_of(path: Path) -> tuple[int, int]:
    """What tells a store from another one that is made in the same folder later; raises InvalidMap where none is."""
    try:
        made = (path / "zarr.json").stat()
    except OSError:
        raise InvalidMap(f"{path} holds no map") from None
    return made.st_ino, made.st_mtime_ns


class Store:
    """A map on disk: the folder at `path`, and the `plan` of what it holds."""

    def __init__(self, path: Path, *, writable: bool = False) -> None:
        zarr = zarr_module()
        try:
            self._group = zarr.open_group(store=str(path), mode="r+" if writable else "r", zarr_format=3)
            attributes = self._group.attrs[KEY]
        except (OSError, LookupError, ValueError, TypeError, AttributeError, RecursionError):
            raise InvalidMap(f"{path} holds no map") from None
        self.path = path
        self.plan = plan_of(attributes, path)
        refuse_senseless(self.plan, path)
        self.names = (*self.plan.measures, *([YAW] if self.plan.arcs else []))
        self._arrays: dict[str, Cells] = {}

    def array(self, name: str) -> Cells:
        """An array of the store; raises InvalidMap where it is not there, or not of the size that the plan says."""
        if name not in self._arrays:
            shape, dtype, chunks = _form_of(self.plan, name)
            try:
                found = self._group[name]
                fits = (found.shape, found.dtype, found.chunks) == (shape, np.dtype(dtype), chunks)
            except Exception:
                # A damaged file fails in the decoder in ways of its own.
                fits = False
            if not fits:
                raise InvalidMap(f"{self.path} is damaged: {name} is not what the map's plan says")
            self._arrays[name] = Cells(found, f"{self.path} is damaged: {name} cannot be read")
        return self._arrays[name]

    def records(self) -> NDArray[np.uint64]:
        """(tasks,) the record of each task, 0 where it is not done."""
        found: NDArray[np.uint64] = self.array(DONE)[:]
        return found

    def write(self, task: int, block: Block, values: Mapping[str, NDArray]) -> int:
        """Write what a task has found, then its record, which is returned."""
        for name in self.names:
            self.array(name)[tuple(block)] = values[name]
        record = checksum(values, self.names)
        self.array(DONE)[task] = record
        return record

    def forget(self, task: int) -> None:
        """Take back the record of a task: it is to be done again."""
        self.array(DONE)[task] = 0

    def is_whole(self, task: int, record: int) -> bool:
        """Whether the files of a task hold what was written, by its record."""
        try:
            return checksum(self.read(self.plan.block(task)), self.names) == record
        except Exception:
            # A damaged file fails in the decoder in ways of its own.
            return False

    def refuse_damaged(self, task: int, record: int) -> None:
        """Raise InvalidMap where the files of a task do not hold what was written."""
        if not self.is_whole(task, record):
            raise InvalidMap(f"{self.path} is damaged: files are lost or changed; making the map again mends it")

    def read(self, block: Block) -> dict[str, NDArray]:
        """What a task has written."""
        return {name: self.array(name)[tuple(block)] for name in self.names}


def checksum(values: Mapping[str, NDArray], names: Sequence[str]) -> int:
    """The record of what a task has found."""
    crc = 0
    for name in names:
        crc = zlib.crc32(np.ascontiguousarray(values[name]).data, crc)
    return MARK + crc


def create(path: Path, plan: Plan) -> None:
    """Make an empty store, whole or not at all.

    Raises:
        FileExistsError: there is something at that path, perhaps of another process, and made meanwhile.
        InvalidMap: it cannot be written.
    """
    zarr = zarr_module()
    beside = path.absolute().parent
    partial = beside / f".{path.name}.{uuid.uuid4().hex}.partial"
    try:
        beside.mkdir(parents=True, exist_ok=True)
        _fill(zarr, partial, plan)
        partial.rename(path)
    except OSError as error:
        if path.exists():
            raise FileExistsError(errno.EEXIST, "there is something already", str(path)) from None
        raise InvalidMap(f"{path} cannot be written: {error.strerror or error}") from None
    finally:
        shutil.rmtree(partial, ignore_errors=True)


@contextlib.contextmanager
def held(path: Path) -> Iterator[None]:
    """Hold a store while a map is made in it, against others on this machine; whoever is killed lets go of it.

    Where the system or its files have no such locks, nobody is kept out: what is written twice is written alike.

    Raises:
        InvalidMap: another process, or another thread, makes it just now.
    """
    try:
        import fcntl
    except ImportError:
        yield
        return
    folder = os.open(path, os.O_RDONLY)
    try:
        try:
            fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InvalidMap(f"{path} is being made by somebody else just now: wait until it is done") from None
        except OSError:
            pass
        yield
    finally:
        # Closing is not enough: a child that was forked meanwhile has the folder open, too.
        with contextlib.suppress(OSError):
            fcntl.flock(folder, fcntl.LOCK_UN)
        os.close(folder)


def _form_of(plan: Plan, name: str) -> tuple[tuple[int, ...], str, tuple[int, ...]]:
    """Shape, type and chunks of an array of a store."""
    if name == DONE:
        return (len(plan.blocks),), "u8", (1,)
    n = len(plan.orientations)
    side = plan.grid.side(n)
    more = (plan.arcs, 2) if name == YAW else ()
    shape, chunks = (*plan.grid.shape, n), (*(min(side, m) for m in plan.grid.shape), n)
    return (*shape, *more), "f8" if name == YAW else MEASURES[name][0], (*chunks, *more)


def _fill(zarr: Any, path: Path, plan: Plan) -> None:
    group = zarr.open_group(store=str(path), mode="w", zarr_format=3, attributes={KEY: plan.as_attributes()})
    grid, n = plan.grid, len(plan.orientations)
    names = [*grid.names, "orientation"]
    for name in plan.measures:
        _create(group, name, *_form_of(plan, name), names, {"long_name": MEASURES[name][1]})
    if plan.arcs:
        attributes = {
            "long_name": "arcs of yaw about axis 1 at which the cell is reached: start and width",
            "units": "rad",
        }
        _create(group, YAW, *_form_of(plan, YAW), [*names, "arc", "start_width"], attributes)
    _create(group, DONE, *_form_of(plan, DONE), ["task"], {"long_name": "2^32 + CRC-32 of what a task has written"})
    for k, name in enumerate(grid.names):
        _put(group, name, grid.centres(k), [name], {"units": "m"})
    _put(group, "rotation", plan.orientations.matrices().reshape(n, 9), ["orientation", "entry"], {})


def _create(
    group: Any,
    name: str,
    shape: Sequence[int],
    dtype: str,
    chunks: Sequence[int],
    dimensions: Sequence[str],
    attributes: Mapping[str, Any],
) -> Any:
    return group.create_array(
        name,
        shape=tuple(shape),
        dtype=dtype,
        chunks=tuple(chunks),
        fill_value=0,
        dimension_names=list(dimensions),
        attributes=dict(attributes),
    )


def _put(group: Any, name: str, values: NDArray, dimensions: Sequence[str], attributes: Mapping[str, Any]) -> None:
    _create(group, name, values.shape, "f8", values.shape, dimensions, attributes)[...] = values


def clear_leftovers(path: Path) -> None:
    """Remove files, and stores beside this one, that a killed process has left half written."""
    for each in path.rglob("*.partial"):
        with contextlib.suppress(OSError):
            each.unlink()
    for each in path.absolute().parent.glob(f".{path.name}.*.partial"):
        shutil.rmtree(each, ignore_errors=True)


def refuse_other(store: Store, plan: Plan) -> None:
    """Raise InvalidMap for a store of another robot, version, grid or set of measures than is asked for."""
    there, wanted = store.plan.as_attributes(), plan.as_attributes()
    there["version"] = store.array(DONE) and _version(store)
    if there["robot"]["fingerprint"] != wanted["robot"]["fingerprint"]:
        raise InvalidMap(
            f"{store.path} is a map of another robot ({there['robot']['name']}, tip {there['robot']['tip']}), or of "
            "other limits or another tool: give another folder"
        )
    for part in ("version", "grid", "orientations", "measures", "arcs", "scene", "task"):
        if there.get(part) != wanted.get(part):
            other = f"other {part}" if part.endswith("s") else f"another {part}"
            other += _differences(there.get(part), wanted.get(part))
            raise InvalidMap(f"{store.path} is a map with {other}: give another folder, or remove it")


def _differences(there: Any, wanted: Any) -> str:
    """What differs between two parts of plans that have names, as a clause in brackets."""
    if not (isinstance(there, dict) and isinstance(wanted, dict)):
        return ""
    told = [f"{k} {quoted(v)}, not {quoted(wanted[k])}" for k, v in there.items() if k in wanted and v != wanted[k]]
    return f" ({'; '.join(told)})" if told else ""


def _version(store: Store) -> Any:
    return store._group.attrs[KEY]["version"]
