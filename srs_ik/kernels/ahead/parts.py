"""Structures as values: their parts are at hand for as long as nobody asks where they lie.

Numba gives each structure, and thus each array that is looked at, a place in memory, which it clears, writes and reads
part by part: this was half of the text that LLVM had to read, and all of it was thrown away again.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from llvmlite import ir
from numba.core import cgutils
from numba.core.datamodel import models, packer
from numba.cpython import slicing
from numba.np import arrayobj


def make_parts() -> None:
    """Change Numba in this process, for good."""
    proxy = cgutils._StructProxy
    proxy.__init__ = _begin(proxy.__init__)
    proxy.__getattr__ = _field(proxy.__getattr__)
    proxy.__getitem__ = _read(proxy.__getitem__)
    proxy.__setitem__ = _write(proxy.__setitem__)
    proxy._getvalue = _all(proxy._getvalue)
    arrayobj.make_array = _array
    models.BooleanModel.from_data = _truth
    slicing.fix_index = _index(slicing.fix_index)
    slicing.fix_slice = _slice(slicing.fix_slice)
    slicing.get_slice_length = _length(slicing.get_slice_length)
    slicing.fix_stride = _stride(slicing.fix_stride)
    packer.ArgPacker.assign_names = _leave_nameless


def _begin(usual: Callable[..., None]) -> Callable[..., None]:
    def __init__(self: Any, context: Any, builder: Any, value: Any = None, ref: Any = None) -> None:
        self._whole = None
        if ref is not None or not isinstance(self, cgutils.ValueStructProxy):
            usual(self, context, builder, value, ref)
            return
        self._context, self._builder = context, builder
        self._datamodel = context.data_model_manager[self._fe_type]
        self._be_type = self._get_be_type(self._datamodel)
        self._whole = self._be_type(None) if value is None else value
        self._home, self._is_known_elsewhere = builder.block, False

    return __init__


def _settle(proxy: Any) -> None:
    """Give a structure a place in memory after all.

    What it holds is written where it begins: in the block in which all of its parts were set so far.
    """
    builder = proxy._builder
    whole, proxy._whole = proxy._whole, None
    with builder.goto_entry_block():
        place = builder.alloca(proxy._be_type)
    proxy._value = proxy._outer_ref = place
    if builder.block is proxy._home:
        builder.store(whole, place)
        return
    if proxy._is_known_elsewhere:
        raise NotImplementedError("a structure that is changed in another block than it begins in, after it was read")
    with builder.goto_block(proxy._home):
        builder.store(whole, place)


def _field(usual: Callable[..., Any]) -> Callable[..., Any]:
    def __getattr__(self: Any, field: str) -> Any:
        if field in ("_value", "_outer_ref") and self._whole is not None:
            _settle(self)
            return self._value
        return usual(self, field)

    return __getattr__


def _read(usual: Callable[..., Any]) -> Callable[..., Any]:
    def __getitem__(self: Any, index: int) -> Any:
        whole = self._whole
        if whole is None:
            return usual(self, index)
        self._is_known_elsewhere |= self._builder.block is not self._home
        return self._builder.extract_value(whole, index)

    return __getitem__


def _write(usual: Callable[..., None]) -> Callable[..., None]:
    def __setitem__(self: Any, index: int, value: Any) -> None:
        if self._whole is None or self._builder.block is not self._home or self._is_known_elsewhere:
            usual(self, index, value)
        else:
            self._whole = self._builder.insert_value(self._whole, value, index)

    return __setitem__


def _all(usual: Callable[..., Any]) -> Callable[..., Any]:
    def _getvalue(self: Any) -> Any:
        if self._whole is None:
            return usual(self)
        self._is_known_elsewhere |= self._builder.block is not self._home
        return self._whole

    return _getvalue


@cache
def _array(kind: Any) -> Any:
    """The structure of an array, whose shape needs no place in memory either."""
    return cgutils.create_struct_proxy(kind.as_array)


def _truth(self: Any, builder: Any, value: Any) -> Any:
    """A byte as a truth value, without a branch."""
    return builder.icmp_unsigned("!=", value, value.type(0))


def _index(usual: Callable[..., Any]) -> Callable[..., Any]:
    """An index that is known is counted from one end or the other."""

    def fix_index(builder: Any, index: Any, size: Any) -> Any:
        return index if isinstance(index, ir.Constant) and index.constant >= 0 else usual(builder, index, size)

    return fix_index


def _is_plain(part: Any) -> bool:
    """Whether a slice takes one item after another."""
    return isinstance(part.step, ir.Constant) and part.step.constant == 1


def _slice(usual: Callable[..., None]) -> Callable[..., None]:
    """Ends of a slice are brought into the array without branches."""

    def fix_slice(builder: Any, part: Any, size: Any) -> None:
        if not _is_plain(part):
            _settle(part)
            usual(builder, part, size)
            return
        for end in ("start", "stop"):
            at = slicing.fix_index(builder, getattr(part, end), size)
            if not isinstance(at, ir.Constant):
                at = builder.select(builder.icmp_signed("<", at, size.type(0)), size.type(0), at)
            setattr(part, end, builder.select(builder.icmp_signed(">=", at, size), size, at))

    return fix_slice


def _length(usual: Callable[..., Any]) -> Callable[..., Any]:
    def get_slice_length(builder: Any, part: Any) -> Any:
        if not _is_plain(part):
            return usual(builder, part)
        length = builder.sub(part.stop, part.start)
        return builder.select(builder.icmp_signed("<=", length, length.type(0)), length.type(0), length)

    return get_slice_length


def _stride(usual: Callable[..., Any]) -> Callable[..., Any]:
    def fix_stride(builder: Any, part: Any, stride: Any) -> Any:
        return stride if _is_plain(part) else usual(builder, part, stride)

    return fix_stride


def _leave_nameless(self: Any, arguments: Any, names: Any) -> None:
    """Arguments are known by their number: names that spell out places in tuples were a tenth of all text."""
