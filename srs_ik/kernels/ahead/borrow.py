"""Which variables of a kernel borrow: somebody else keeps their arrays for as long as they live, so that nobody counts.

Numba counts a reference up and down for each array that a variable gets, and a named tuple of work space has dozens.
Arrays of a caller are the caller's to keep, and so are views of them. What a kernel allocates, gets from a call or
returns is its own, and counted.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from numba.core import ir, typed_passes, types
from numba.core.runtime.context import NRTContext

_VIEWS = {"build_tuple", "cast", "exhaust_iter", "getattr", "getitem", "phi", "static_getitem", "undef"}
"""What makes a value of other values and allocates nothing: attributes of kernels' arrays are views, too."""

_KEPT = (ir.Arg, ir.Const, ir.FreeVar, ir.Global)
"""What outlives the function."""

_known: dict[Any, bool] = {}


class Holders(NamedTuple):
    """The variables of a function that hold references: those that count them, and those that do not."""

    owners: set[str]
    borrowers: set[str]


_now: list[Any] = [Holders(set(), set()), True]
"""Who holds references in the function that is being written, and whether these are counted in the statement."""


def make_borrow() -> None:
    """Change Numba in this process, for good."""
    typed_passes.NativeLowering.run_pass = _told(typed_passes.NativeLowering.run_pass)
    NRTContext.incref = _where_counted(NRTContext.incref)
    NRTContext.decref = _where_counted(NRTContext.decref)


def holds_references(context: Any, kind: Any) -> bool:
    """Whether values of a type hold references."""
    if kind not in _known:
        _known[kind] = context.data_model_manager[kind].contains_nrt_meminfo()
    return _known[kind]


def is_counted(context: Any, kind: Any, name: str) -> bool:
    """Whether a variable of the function that is being written counts references."""
    return holds_references(context, kind) and name not in _now[0].borrowers


def look_at(statement: Any) -> None:
    """The code of a statement comes next."""
    _now[1] = not isinstance(statement, ir.Assign) or statement.target.name not in _now[0].borrowers


def holders(state: Any) -> Holders:
    """Who holds references in a function that has types."""
    if state.get("holders") is None:
        state["holders"] = _found(state)
    return state["holders"]


def _found(state: Any) -> Holders:
    held: set[str] = set()
    own: set[str] = set()
    takers: dict[str, list[str]] = {}
    for block in state.func_ir.blocks.values():
        for each in block.find_insts((ir.Assign, ir.Return)):
            name = each.value.name if isinstance(each, ir.Return) else each.target.name
            if not holds_references(state.targetctx, state.typemap[name]):
                continue
            held.add(name)
            if isinstance(each, ir.Return) or _allocates(each.value, state):
                own.add(name)
            elif not isinstance(each.value, _KEPT):
                for source in [each.value] if isinstance(each.value, ir.Var) else each.value.list_vars():
                    takers.setdefault(source.name, []).append(name)
    left = list(own)
    while left:
        new = set(takers.get(left.pop(), ())) - own
        own |= new
        left += new
    return Holders(own, held - own)


def _allocates(value: Any, state: Any) -> bool:
    """Whether a value that holds references may be nobody else's."""
    if not isinstance(value, ir.Expr):
        return not isinstance(value, (ir.Var, *_KEPT))
    if value.op == "call":
        return not isinstance(state.typemap[value.func.name], types.NamedTupleClass)
    if value.op == "getitem" and holds_references(state.targetctx, state.typemap[value.index.name]):
        # Items at the places that an array names are copied.
        return True
    return value.op not in _VIEWS


def _told(usual: Callable[..., Any]) -> Callable[..., Any]:
    def run_pass(self: Any, state: Any) -> Any:
        # In the middle of a function, Numba may have to write another one.
        before = _now[:]
        _now[:] = holders(state), True
        try:
            return usual(self, state)
        finally:
            _now[:] = before

    return run_pass


def _where_counted(usual: Callable[..., Any]) -> Callable[..., Any]:
    def count(self: Any, builder: Any, kind: Any, value: Any) -> None:
        if _now[1]:
            usual(self, builder, kind, value)

    return count
