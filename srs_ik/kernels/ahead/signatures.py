"""The table of entries, read: names, types and sizes of all that crosses the counter between Python, C and kernels."""

from __future__ import annotations

import importlib
import re
from dataclasses import dataclass
from functools import cache
from pkgutil import iter_modules
from typing import Any

from srs_ik.kernels import entries, layout
from srs_ik.kernels.entries.table import ARGUMENTS, ENTRIES

_LINE = re.compile(r"(\w+)\.(\w+)\((.*?)\)(?: -> (.*))?$")
_ARGUMENT = re.compile(r"(\w+): (float|int|byte|bool)(?:\[(.*?)\])?(&?)$")
_USUAL = dict(line.split(": ", 1) for line in ARGUMENTS.strip().splitlines())


@dataclass(frozen=True)
class Argument:
    """An argument of an entry."""

    name: str  # its name
    element: str  # `float`, `int`, `byte` or `bool`
    shape: tuple[int | str, ...] | None  # sizes of an array, a name where any size will do; None of a scalar
    written: bool  # whether the entry writes to the array


@dataclass(frozen=True)
class Entry:
    """An entry: its room among the entries, name, arguments and results."""

    room: str
    name: str
    arguments: tuple[Argument, ...]
    results: tuple[str, ...]

    @property
    def symbol(self) -> str:
        """Its name in C."""
        return f"srs_ik_{self.room}_{self.name}"

    @property
    def sizes(self) -> tuple[str, ...]:
        """Names of the sizes that a call brings along, in the order of the arguments."""
        return tuple(dict.fromkeys(n for a in self.arguments for n in a.shape or () if isinstance(n, str)))


@cache
def read_table(text: str = ENTRIES) -> tuple[Entry, ...]:
    """All entries of the table; raises ValueError for a line that cannot be read."""
    return tuple(_entry(line) for line in re.sub(r"\n +", " ", text).strip().splitlines())


def _entry(line: str) -> Entry:
    match = _LINE.match(line)
    if match is None:
        raise ValueError(f"no entry of the table: {line!r}")
    room, name, arguments, results = match.groups()
    parts = re.split(r", (?![^\[]*\])", arguments) if arguments else []
    kinds = tuple((results or "").strip("()").replace(" ", "").split(",")) if results else ()
    return Entry(room, name, tuple(_argument(room, part) for part in parts), kinds)


def _argument(room: str, text: str) -> Argument:
    match = _ARGUMENT.match(text if ":" in text else f"{text}: {_USUAL.get(text)}")
    if match is None:
        raise ValueError(f"no argument of an entry: {text!r}")
    name, element, shape, written = match.groups()
    sizes = None if shape is None else tuple(_size(room, part.strip()) for part in shape.split(","))
    return Argument(name, element, sizes, bool(written))


def _size(room: str, text: str) -> int | str:
    if text.isdigit():
        return int(text)
    of, _, name = text.rpartition(".")
    return _named_size(of or room, name) if len(name) > 1 and name.isupper() else text


def _named_size(room: str, name: str) -> int:
    """A size of a room of entries, of its namesake in `layout`, or of another one there if it is the only one."""
    columns = [f"{layout.__name__}.{each.name}" for each in iter_modules(layout.__path__)]
    own = [f"{entries.__name__}.{room}", f"{layout.__name__}.{room}"]
    found = {each: _constant(each, name) for each in (*own, *columns) if _constant(each, name) is not None}
    values = {value for each, value in found.items() if each not in own}
    for each in own:
        if each in found:
            return int(found[each])
    if len(values) != 1:
        raise ValueError(f"{len(values)} sizes {name} for {room}: name one of {', '.join(found) or 'layout'}")
    return int(values.pop())


def _constant(module: str, name: str) -> Any:
    try:
        return getattr(importlib.import_module(module), name, None)
    except ModuleNotFoundError:
        return None


def rooms() -> list[str]:
    """Names of the modules of entries."""
    return [m.name for m in iter_modules(entries.__path__) if m.name != "table"]
