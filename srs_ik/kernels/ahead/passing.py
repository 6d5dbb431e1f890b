"""How values pass from kernel to kernel: what has been put together is not taken apart again.

A named tuple of work space has dozens of parts, which Numba passes one by one. To find them in a value that was made of
them a moment ago was half of the instructions that LLVM had to read.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core.datamodel import models


def make_passing() -> None:
    """Change Numba in this process, for good."""
    ir.IRBuilder.extract_value = _at_hand(ir.IRBuilder.extract_value)
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


def _as_it_is(usual: Callable[..., Any]) -> Callable[..., Any]:
    """What looks alike in memory and at work stays as it is."""

    def method(self: Any, builder: Any, value: Any) -> Any:
        return value if self.get_data_type() == self.get_value_type() else usual(self, builder, value)

    return method
