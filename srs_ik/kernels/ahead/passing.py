"""How values pass from kernel to kernel: what has been put together is not taken apart, and not written if nobody asks.

A named tuple of work space has dozens of parts, which Numba passes one by one. To find them in a value that was made of
them a moment ago was half of the instructions that LLVM had to read, and values that nobody
reads a quarter of the rest.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core.datamodel import models

WITHOUT_EFFECT = (
    ir.instructions.CastInstr,
    ir.instructions.ExtractValue,
    ir.instructions.GEPInstr,
    ir.instructions.ICMPInstr,
    ir.instructions.InsertValue,
    ir.instructions.LoadInstr,
)
"""Instructions that are there for their value alone."""

_asked: list[Any] = []
"""Values that have been asked for while a function was written."""


def make_passing() -> None:
    """Change Numba in this process, for good."""
    ir.IRBuilder.extract_value = _at_hand(_kept(ir.IRBuilder.extract_value))
    ir.IRBuilder.add = _without(ir.IRBuilder.add, 0)
    ir.IRBuilder.mul = _without(ir.IRBuilder.mul, 1)
    ir.Function.descr_body = _describe
    for kind in WITHOUT_EFFECT:
        kind._get_reference = _noted(kind._get_reference)
    ir.Instruction._name = None
    ir.Instruction._set_name = _wish
    ir.Instruction.name = property(_name, ir.values.NamedValue._set_name)
    for name in ("as_data", "from_data", "as_return", "from_return"):
        setattr(models.StructModel, name, _as_it_is(getattr(models.StructModel, name)))


def _at_hand(usual: Callable[..., Any]) -> Callable[..., Any]:
    """A part that has been put in is at hand."""

    def extract_value(self: Any, whole: Any, place: Any, name: str = "") -> Any:
        wanted = list(place) if isinstance(place, (list, tuple)) else [place]
        at = whole
        while isinstance(at, ir.instructions.InsertValue):
            put = list(at.indices)
            common = min(len(wanted), len(put))
            if put[:common] != wanted[:common]:
                at = at.aggregate
            elif len(put) > common:
                break
            elif len(wanted) > common:
                return extract_value(self, at.value, wanted[common:], name)
            else:
                return at.value
        return usual(self, whole, wanted, name)

    return extract_value


def _kept(usual: Callable[..., Any]) -> Callable[..., Any]:
    """A part that was taken out earlier in a block is at hand, too."""

    def extract_value(self: Any, whole: Any, place: list[int], name: str = "") -> Any:
        block = self.block
        if self._anchor != len(block.instructions):
            return usual(self, whole, place, name)
        known = block.__dict__.setdefault("parts", {})
        key = (id(whole), *place)
        if key not in known:
            known[key] = usual(self, whole, place, name)
        return known[key]

    return extract_value


def _without(usual: Callable[..., Any], neutral: int) -> Callable[..., Any]:
    """What changes nothing is not computed."""

    def compute(self: Any, one: Any, other: Any, *more: Any, **flags: Any) -> Any:
        if isinstance(one, ir.Constant) and one.constant == neutral:
            return other
        if isinstance(other, ir.Constant) and other.constant == neutral:
            return one
        return usual(self, one, other, *more, **flags)

    return compute


def _as_it_is(usual: Callable[..., Any]) -> Callable[..., Any]:
    """What looks alike in memory and at work stays as it is."""

    def method(self: Any, builder: Any, value: Any) -> Any:
        return value if self.get_data_type() == self.get_value_type() else usual(self, builder, value)

    return method


def _noted(usual: Callable[..., str]) -> Callable[..., str]:
    def _get_reference(self: Any) -> str:
        self.is_read = True
        _asked.append(self)
        return usual(self)

    return _get_reference


def _describe(self: Any, buf: list[str]) -> None:
    """The body of a function, without values that nobody reads."""
    lines: dict[int, str] = {}
    _asked.clear()
    for block in self.blocks:
        for each in block.instructions:
            if not isinstance(each, WITHOUT_EFFECT) or hasattr(each, "is_read"):
                lines[id(each)] = str(each)
    while _asked:
        each = _asked.pop()
        if id(each) not in lines:
            lines[id(each)] = str(each)
    for block in self.blocks:
        buf.append(f"{block._format_name()}:\n")
        buf += [f"  {lines[id(each)]}\n" for each in block.instructions if id(each) in lines]


def _wish(self: Any, name: str) -> None:
    """An instruction is named when someone reads it."""
    self.wish = name


def _name(self: Any) -> str:
    if self._name is None:
        ir.values.NamedValue._set_name(self, self.wish)
    return str(self._name)
