"""Numba's LLVM without what kernels have no use for: half of its instructions.

Kernels catch no exception, so that a failed call is a failed caller and nothing else. Their variables are set before
they are read, and most hold no references, so that no slot has to be filled with zeros first, looked at before it is
written, or cleared behind it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

from numba.core import ir, lowering, types
from numba.core.analysis import must_use_alloca
from numba.core.callconv import RETCODE_OK, CPUCallConv, Status

from srs_ik.kernels.ahead.borrow import holds_references, is_counted, look_at

FAILURE = "excinfo"
"""What Numba calls the argument by which a function tells of its failure."""


def make_lean() -> None:
    """Change Numba in this process, for good: it is to translate kernels and nothing else from now on."""
    CPUCallConv.call_function = _plain_call(CPUCallConv.call_function)
    CPUCallConv.decorate_function = _once(CPUCallConv.decorate_function)
    CPUCallConv.return_status_propagate = _plain_failure(CPUCallConv.return_status_propagate)
    lowering.Lower.lower_block = _lower_block
    lowering.Lower._find_singly_assigned_variable = _without_slots
    lowering.Lower.incref = _where_counted(lowering.Lower.incref)
    lowering.Lower.decref = _where_counted(lowering.Lower.decref)
    lowering.Lower.alloca = _slot(lowering.Lower.alloca)
    lowering.Lower.storevar = _store(lowering.Lower.storevar)
    lowering.Lower.delvar = _delete(lowering.Lower.delvar)


def _plain_call(usual: Callable[..., Any]) -> Callable[..., Any]:
    """A call whose failure goes to where the caller's own would; its result has a slot that nobody fills before."""

    def call_function(
        self: Any, builder: Any, callee: Any, resty: Any, argtys: Any, args: Any, attrs: Any = None
    ) -> Any:
        given = builder.function.args
        if attrs is not None or isinstance(resty, types.misc.Optional) or len(given) < 2 or given[1].name != FAILURE:
            return usual(self, builder, callee, resty, argtys, args, attrs)
        slot = _entry_alloca(builder, self.get_return_type(resty).pointee)
        passed = self._get_arg_packer(argtys).as_arguments(builder, args)
        code = builder.call(callee, [slot, given[1], *passed])
        failed = builder.icmp_signed("!=", code, RETCODE_OK)
        status = Status(code, None, None, failed, None, None, None, given[1])
        return status, self.context.get_returned_value(builder, resty, builder.load(slot))

    return call_function


def _once(usual: Callable[..., None]) -> Callable[..., None]:
    """A function is told once of its arguments, however many call it in a module."""

    def decorate_function(self: Any, function: Any, *of: Any, **more: Any) -> None:
        if self._get_excinfo_argument(function).name != FAILURE:
            usual(self, function, *of, **more)

    return decorate_function


def _plain_failure(usual: Callable[..., Any]) -> Callable[..., Any]:
    """What failed has told of it already, where it shares its caller's argument for that."""

    def return_status_propagate(self: Any, builder: Any, status: Any) -> None:
        if status.excinfoptr is self._get_excinfo_argument(builder.function):
            self._return_errcode_raw(builder, status.code)
        else:
            usual(self, builder, status)

    return return_status_propagate


def _entry_alloca(builder: Any, kind: Any, name: str = "") -> Any:
    with builder.goto_entry_block():
        return builder.alloca(kind, name=name)


def _where_counted(count: Callable[..., Any]) -> Callable[..., Any]:
    """References are counted where a value can hold any."""

    def incref_or_decref(self: Any, kind: Any, value: Any) -> None:
        if holds_references(self.context, kind):
            count(self, kind, value)

    return incref_or_decref


def _lower_block(self: Any, block: Any) -> None:
    self.pre_block(block)
    for each in block.body:
        self.loc = each.loc
        look_at(each)
        if isinstance(each, ir.Assign):
            name = each.target.name
            self.storevar(self.lower_assign(self.typeof(name), each), name)
        else:
            self.lower_inst(each)
    self.post_block(block)


def _without_slots(self: Any) -> None:
    """A variable that is assigned in one place needs no slot: every place that reads it comes behind."""
    places: Counter[str] = Counter()
    for block in self.blocks.values():
        places.update(each.target.name for each in block.find_insts(ir.Assign))
    slots = must_use_alloca(self.blocks)
    self._blk_local_varmap = {}
    self._singly_assigned_vars = {
        name
        for name, count in places.items()
        if count == 1 and name not in slots and not is_counted(self.context, self.typeof(name), name)
    }


def _slot(usual: Callable[..., Any]) -> Callable[..., Any]:
    def alloca(self: Any, name: str, kind: Any) -> Any:
        if is_counted(self.context, kind, name):
            return usual(self, name, kind)
        return _entry_alloca(self.builder, self.context.get_value_type(kind), name)

    return alloca


def _store(usual: Callable[..., Any]) -> Callable[..., Any]:
    def storevar(self: Any, value: Any, name: str, argidx: Any = None) -> None:
        kind = self.typeof(name)
        if name in self._singly_assigned_vars or is_counted(self.context, kind, name):
            usual(self, value, name, argidx)
        else:
            self._alloca_var(name, kind)
            self.builder.store(value, self.varmap[name])

    return storevar


def _delete(usual: Callable[..., Any]) -> Callable[..., Any]:
    def delvar(self: Any, name: str) -> None:
        if is_counted(self.context, self.typeof(name), name):
            usual(self, name)
        elif name not in self._blk_local_varmap:
            self._singly_assigned_vars.discard(name)

    return delvar
