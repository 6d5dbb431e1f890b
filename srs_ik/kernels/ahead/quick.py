"""Numba's translation without what it would find out again and again.

Nothing here changes what a kernel means: types of calls are remembered, constraints are asked again only where what
they have read has changed, functions have short names, and nobody looks for garbage.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from typing import Any

from llvmlite import ir as llvm
from numba.core import base, config, errors, typeinfer, types
from numba.core.runtime import nrtdynmod
from numba.core.utils import chain_exception


def make_quick() -> None:
    """Change Numba in this process, for good: it is to translate kernels and nothing else from now on."""
    # Most of what is made is kept to the end: looking for garbage all the while finds little.
    gc.disable()
    nrtdynmod._define_atomic_inc_dec = _define_count
    base.BaseContext.mangler = _short_names(base.BaseContext.mangler)
    types.Function.get_call_type = _known_call_types(types.Function.get_call_type)  # type: ignore[method-assign]
    types.Dispatcher.get_call_type = _known_call_types(types.Dispatcher.get_call_type)  # type: ignore[method-assign]


def _define_count(module: Any, op: str, ordering: str) -> Any:
    """The function that counts a reference up or down ("add", "sub") and returns how many there are then.

    What kernels allocate stays in the thread that called them: its references need no atomic counting.
    """
    word = llvm.IntType(config.MACHINE_BITS)
    function = llvm.Function(module, llvm.FunctionType(word, [word.as_pointer()]), name=f"nrt_atomic_{op}")
    builder = llvm.IRBuilder(function.append_basic_block())
    count = getattr(builder, op)(builder.load(function.args[0]), llvm.Constant(word, 1))
    builder.store(count, function.args[0])
    builder.ret(count)
    return function


def _short_names(usual: Callable[..., str]) -> Callable[..., str]:
    """A function and its environment are known by a number: names that spell out types were a quarter of all text."""

    def mangler(self: Any, name: str, kinds: Any, *, abi_tags: Any = (), uid: int | None = None) -> str:
        if uid is None:
            return usual(self, name, kinds, abi_tags=abi_tags)
        own = name.rpartition(".")[2]
        return f"{own}.environment.{uid}" if name.startswith(".NumbaEnv") else f"{own}.{uid}"

    return mangler


def _known_call_types(find: Callable[..., Any]) -> Callable[..., Any]:
    """The type of a call of a function depends on the types of its arguments alone."""
    known: dict[Any, Any] = {}

    def get_call_type(self: Any, context: Any, args: Any, kws: Any) -> Any:
        if kws:
            return find(self, context, args, kws)
        key = (id(self), tuple(args))
        if key not in known:
            # The code that stands for some types stays the same: others are forked at any time to write calls of it.
            before = dict(self.__dict__.get("_impl_keys", ()))
            # With the function, lest another one gets its number.
            known[key] = (self, find(self, context, args, kws))
            self.__dict__.get("_impl_keys", {}).update(before)
        return known[key][1]

    return get_call_type


def make_finding() -> None:
    """Change Numba in this process, for good: it is to translate kernels and nothing else from now on."""
    types.Type.__hash__ = _known_hash(types.Type.__hash__)  # type: ignore[method-assign]
    typeinfer.TypeVarMap.__getitem__ = _noted
    typeinfer.TypeInferer.add_type = _add_type
    typeinfer.TypeInferer.get_state_token = _state
    typeinfer.ConstraintNetwork.propagate = _propagate


def _known_hash(usual: Callable[..., int]) -> Callable[..., int]:
    """The hash of a type of nested tuples is that of all in it."""

    def __hash__(self: Any) -> int:
        known = self.__dict__.get("_hash")
        if known is None:
            known = self._hash = usual(self)
        return int(known)

    return __hash__


_reads: list[dict[str, tuple[Any, Any]]] = [{}]
"""Variables that the constraint at work has read, with the types that they had then."""


def _noted(self: Any, name: str) -> Any:
    """A variable, which is made where it is new."""
    found = self.get(name)
    if found is None:
        found = typeinfer.TypeVar(self.context, name)
        dict.__setitem__(self, name, found)
    if name not in _reads[0]:
        _reads[0][name] = found, found.type
    return found


def _add_type(self: Any, name: str, kind: Any, loc: Any, unless_locked: bool = False) -> None:
    """What a constraint adds to is nothing that it has read."""
    variable = self.typevars.get(name)
    if variable is None:
        variable = typeinfer.TypeVar(self.context, name)
        dict.__setitem__(self.typevars, name, variable)
    if unless_locked and variable.locked:
        return
    before = variable.type
    unified = variable.add_type(kind, loc=loc)
    if unified is not before and unified != before:
        self.propagate_refined_type(name, unified)


def _state(self: Any) -> list[Any]:
    return [variable.type for variable in self.typevars.values()]


def _propagate(self: Any, inferer: Any) -> list[Any]:
    """Ask all constraints but those that would answer what they have answered before."""
    found = []
    # A call may be of a function whose types have to be found before.
    outside = _reads[0]
    for each in self.constraints:
        reads = each.__dict__.get("reads")
        if reads is not None and all(variable.type is kind for variable, kind in reads):
            continue
        _reads[0] = {}
        each.reads = None
        try:
            each(inferer)
        except errors.ForceLiteralArg as error:
            found.append(error)
        except errors.TypingError as error:
            new = errors.TypingError(str(error), loc=each.loc, highlighting=False)
            found.append(chain_exception(new, error))
        else:
            each.reads = list(_reads[0].values())
    _reads[0] = outside
    return found
