"""All code in parts of about the same size, each of which LLVM optimises by itself.

A small function stands in every part that calls it, since it will be part of its callers. A large one stands in one of
them and is called from the others.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from typing import NamedTuple

LARGE = 8000
"""Instructions, with those of all that it calls, from which a function is compiled once: what LLVM knows of it beside
its caller is worth less than to compile so many twice."""

SMALL = 100
"""Instructions of its own below which LLVM makes a function part of its callers, whatever it calls."""

_DEFINITION = re.compile(r"^define (?:internal )?(.*? )(@[^( ]+|@\"[^\"]+\")(\(.*?\n)(.*?^}\n)", re.M | re.S)
_CALLED = re.compile(r" call [^@\n]*(@[^( \n]+|@\"[^\"\n]+\")\(")

_NOTE = re.compile(r"^(![0-9]+ = !{)ptr @.*}$", re.M)
"""Older versions of Numba note functions for a search for references that LLVM's own has replaced."""


class _Function(NamedTuple):
    """A function in the text of a module, and what matters of it."""

    begin: int
    end: int
    size: int
    calls: Counter[str]


class Unit(NamedTuple):
    """A part: the text of its module, its entries, and other names in it that several parts use."""

    text: str
    entries: list[str]
    shared: list[str]


def divide(text: str, entries: list[list[str]]) -> list[Unit]:
    """Divide a module, as LLVM prints it with a name for every function, by the names of the entries of each part."""
    text = _NOTE.sub(r"\1}", text)
    found = {
        match[2].strip('@"'): _Function(
            match.start(),
            match.end(),
            match[4].count("\n  "),
            Counter(each.strip('@"') for each in _CALLED.findall(match[4])),
        )
        for match in _DEFINITION.finditer(text)
    }
    heads = _heads(found, entries)
    parts = _assigned(found, entries, heads)
    owner = {head: i for i, part in enumerate(parts) for head in part}
    units = []
    for i, part in enumerate(parts):
        inside = _reached(found, part, {head for head in heads if owner[head] != i})
        foreign = {callee for name in inside for callee in found[name].calls if callee in heads} - inside
        pieces, at = [], 0
        for name, each in found.items():
            pieces.append(text[at : each.begin])
            at = each.end
            if name in inside:
                body = text[each.begin : each.end]
                pieces.append(body.replace("define internal", "define hidden", 1) if name in heads else body)
            elif name in foreign:
                head = _DEFINITION.match(text, each.begin)
                assert head is not None
                pieces.append(f"declare hidden {head[1]}{head[2]}{head[3].rstrip().rstrip('{')}\n")
        units.append(Unit("".join([*pieces, text[at:]]), entries[i], sorted(foreign | (heads & inside))))
    return units


def _reached(found: dict[str, _Function], roots: Iterable[str], barred: set[str]) -> set[str]:
    """All functions that some functions call, however indirectly, but for the barred and what only these call."""
    seen: set[str] = set()
    left = [root for root in roots if root not in barred]
    while left:
        name = left.pop()
        if name not in seen:
            seen.add(name)
            left += [callee for callee in found[name].calls if callee in found and callee not in barred]
    return seen


def _heads(found: dict[str, _Function], entries: list[list[str]]) -> set[str]:
    """Large functions that every part calls, from more than one place; what is called once is part of its caller."""
    if len(entries) < 2:
        return set()
    places = sum((each.calls for each in found.values()), Counter[str]())
    common = set.intersection(*(_reached(found, roots, set()) for roots in entries))
    return {
        name
        for name in common
        if found[name].size >= SMALL and places[name] > 1 and _size(found, _reached(found, [name], set())) >= LARGE
    }


def _assigned(found: dict[str, _Function], entries: list[list[str]], heads: set[str]) -> list[list[str]]:
    """Entries and heads of each part, so that all take about as long."""
    parts = [list(each) for each in entries]
    inside = [_reached(found, part, heads) for part in parts]
    behind = {head: _reached(found, [head], heads - {head}) for head in heads}
    for head in sorted(heads, key=lambda name: (-_size(found, behind[name]), name)):
        sizes = [_size(found, each | behind[head]) for each in inside]
        least = sizes.index(min(sizes))
        parts[least].append(head)
        inside[least] |= behind[head]
    return parts


def _size(found: dict[str, _Function], names: Iterable[str]) -> int:
    return sum(found[name].size for name in names)
