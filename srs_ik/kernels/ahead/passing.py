"""How values pass from kernel to kernel: an array as its data and its sizes, from which the rest follows.

Numba passes seven words for a row and nine for a matrix, and dozens of arrays stand in a named tuple of work space. To
take all of that apart and put it together again was the larger part of the instructions that LLVM had to read.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.datamodel import models
from numba.np.numpy_support import as_dtype

_FIELDS = ("meminfo", "parent", "nitems", "itemsize", "data", "shape", "strides")
_WORD = ir.IntType(64)


def make_short() -> None:
    """Change Numba in this process, for good."""
    model = models.ArrayModel
    model.get_argument_type = _short(model.get_argument_type, _argument_type)
    model.as_argument = _short(model.as_argument, _as_argument)
    model.from_argument = _short(model.from_argument, _from_argument)
    ir.IRBuilder.extract_value = _extract(ir.IRBuilder.extract_value)
    for name in ("as_data", "from_data", "as_return", "from_return"):
        setattr(models.StructModel, name, _as_it_is(getattr(models.StructModel, name)))


def _short(usual: Callable[..., Any], short: Callable[..., Any]) -> Callable[..., Any]:
    """Arrays whose items lie one behind the other pass as few words."""

    def method(self: Any, *args: Any) -> Any:
        kind = self.fe_type
        return (short if type(kind) is types.Array and kind.layout == "C" and kind.ndim else usual)(self, *args)

    return method


def _argument_type(model: Any) -> tuple[Any, ...]:
    meminfo, data = (model._models[_FIELDS.index(name)].get_argument_type() for name in ("meminfo", "data"))
    return (meminfo, data, *[_WORD] * model.fe_type.ndim)


def _as_argument(model: Any, builder: Any, value: Any) -> tuple[Any, ...]:
    meminfo, data, shape = (_FIELDS.index(name) for name in ("meminfo", "data", "shape"))
    sizes = [builder.extract_value(value, [shape, i]) for i in range(model.fe_type.ndim)]
    return (builder.extract_value(value, meminfo), builder.extract_value(value, data), *sizes)


def _from_argument(model: Any, builder: Any, given: Any) -> Any:
    meminfo, data, *sizes = given
    kind = model.get_value_type()
    item = as_dtype(model.fe_type.dtype).itemsize
    # What is the same for all arrays of a type stands in a constant, the rest is put into it.
    fixed = {"parent": None, "itemsize": item, "strides": [ir.Undefined] * (len(sizes) - 1) + [item]}
    parts = zip(_FIELDS, kind.elements, strict=True)
    array = ir.Constant(kind, [ir.Constant(part, fixed.get(field, ir.Undefined)) for field, part in parts])
    step = _WORD(item)
    steps: list[Any] = []
    for size in reversed(sizes[1:]):
        step = builder.mul(step, size)
        steps.insert(0, step)
    count = sizes[0]
    for size in sizes[1:]:
        count = builder.mul(count, size)
    for field, value in (("meminfo", meminfo), ("nitems", count), ("data", data)):
        array = builder.insert_value(array, value, _FIELDS.index(field))
    for field, values in (("shape", sizes), ("strides", steps)):
        for i, value in enumerate(values):
            array = builder.insert_value(array, value, [_FIELDS.index(field), i])
    return array


def _as_it_is(usual: Callable[..., Any]) -> Callable[..., Any]:
    """What looks alike in memory and at work is not taken apart."""

    def method(self: Any, builder: Any, value: Any) -> Any:
        return value if self.get_data_type() == self.get_value_type() else usual(self, builder, value)

    return method


def _extract(usual: Callable[..., Any]) -> Callable[..., Any]:
    """What has been put in is at hand."""

    def extract_value(self: Any, whole: Any, place: Any, name: str = "") -> Any:
        wanted = list(place) if isinstance(place, (list, tuple)) else [place]
        at = whole
        while isinstance(at, ir.instructions.InsertValue):
            common = min(len(wanted), len(at.indices))
            if list(at.indices[:common]) != wanted[:common]:
                at = at.aggregate
            elif len(at.indices) > common:
                break
            elif len(wanted) > common:
                return extract_value(self, at.value, wanted[common:], name)
            else:
                return at.value
        return usual(self, whole, wanted, name)

    return extract_value
