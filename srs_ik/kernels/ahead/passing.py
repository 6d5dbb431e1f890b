"""How values pass from kernel to kernel: what has been put together is not taken apart, and not written if nobody asks.

A named tuple of work space has dozens of parts, which Numba passes one by one. To find them in a value that was made of
them a moment ago was half of the instructions that LLVM had to read, and values that nobody
reads a quarter of the rest.
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
