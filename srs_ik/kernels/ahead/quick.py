"""Numba's translation without what it would find out again and again.

Nothing here changes what a kernel means: sizes of types, types of calls and ways to pass arguments are remembered,
variables are found by a shorter way, functions have short names, and nobody looks for garbage.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from functools import cache
from types import TracebackType
from typing import Any

from llvmlite import ir as llvm
from numba.core import base, bytecode, byteflow, config, errors, ir, typeinfer, types
from numba.core.runtime import nrtdynmod
from numba.core.utils import PYVERSION, chain_exception


def make_quick() -> None:
    """Change Numba in this process, for good: it is to translate kernels and nothing else from now on."""
    # Most of what is made is kept to the end: looking for garbage all the while finds little.
    gc.disable()
    nrtdynmod._define_atomic_inc_dec = _define_count
    ir.Inst._rec_list_vars = _variables_of
    errors.WarningsFixer.catch_warnings = _catch_nothing  # type: ignore[attr-defined]
    types.Type.__eq__ = _same_type  # type: ignore[method-assign]
    base.BaseContext.get_abi_sizeof = _known_sizes(base.BaseContext.get_abi_sizeof)
    base.BaseContext.get_arg_packer = _known_packers(base.BaseContext.get_arg_packer)
    base.BaseContext.mangler = _short_names(base.BaseContext.mangler)
    base._has_loc = cache(base._has_loc)
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


def _catch_nothing(self: Any, filename: str | None = None, lineno: int | None = None) -> Any:
    """There is nobody to warn."""
    return nullcontext()


def _same_type(self: Any, other: Any) -> bool:
    """Most types are compared with themselves."""
    return self is other or (self.__class__ is other.__class__ and self.key == other.key)


def _variables_of(_: Any, value: Any) -> list[Any]:
    """The variables in an instruction or in a part of one."""
    kind = type(value)
    if kind is ir.Var:
        return [value]
    if kind is str or kind is ir.Loc or kind is int or value is None:
        return []
    if isinstance(value, ir.Inst):
        return value.list_vars()
    if isinstance(value, dict):
        value = value.values()
    elif not isinstance(value, (list, tuple)):
        return []
    found: list[Any] = []
    for each in value:
        if type(each) is not str and type(each) is not ir.Loc:
            found += _variables_of(_, each)
    return found


def _known_sizes(find: Callable[..., Any]) -> Callable[..., Any]:
    """Numba has LLVM parse a module for each size that it asks for."""
    known: dict[str, int] = {}

    def get_abi_sizeof(self: Any, kind: Any) -> int:
        name = str(kind)
        if name not in known:
            known[name] = find(self, kind)
        return known[name]

    return get_abi_sizeof


def _short_names(usual: Callable[..., str]) -> Callable[..., str]:
    """A function and its environment are known by a number: names that spell out types were a quarter of all text."""

    def mangler(self: Any, name: str, kinds: Any, *, abi_tags: Any = (), uid: int | None = None) -> str:
        if uid is None:
            return usual(self, name, kinds, abi_tags=abi_tags)
        own = name.rpartition(".")[2]
        return f"{own}.environment.{uid}" if name.startswith(".NumbaEnv") else f"{own}.{uid}"

    return mangler


def _known_packers(find: Callable[..., Any]) -> Callable[..., Any]:
    """How arguments are passed depends on their types alone."""
    known: dict[tuple[Any, ...], Any] = {}

    def get_arg_packer(self: Any, kinds: Any) -> Any:
        key = tuple(kinds)
        if key not in known:
            known[key] = find(self, key)
        return known[key]

    return get_arg_packer


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
    errors.new_error_context = typeinfer.new_error_context = _Context  # type: ignore[attr-defined]
    if PYVERSION == (3, 11):
        bytecode._unpack_opargs = _without_caches(bytecode._unpack_opargs)
    byteflow.Flow._run_handle_exception = _go_on(byteflow.Flow._run_handle_exception)


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


class _Context:
    """Says of errors where they happened, as Numba's own does that is written as a generator."""

    __slots__ = ("_given", "_named", "_words")

    def __init__(self, words: str, *given: Any, **named: Any) -> None:
        self._words, self._given, self._named = words, given, named

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        if isinstance(error, errors.NumbaError):
            error.add_context(errors._format_msg(self._words, self._given, self._named))  # type: ignore[attr-defined]


def _without_caches(usual: Callable[..., Any]) -> Callable[..., Any]:
    """Room in bytecode where the interpreter keeps what it learns is a third of all instructions."""

    def _unpack_opargs(code: bytes) -> Iterator[tuple[int, int, int | None, int]]:
        last = None
        for offset, opcode, argument, following in usual(code):
            if opcode:
                if last is not None:
                    yield last
                last = offset, opcode, argument, following
            elif last is not None:
                last = *last[:3], following
        if last is not None:
            yield last

    return _unpack_opargs


def _go_on(usual: Callable[..., Any]) -> Callable[..., Any]:
    """Functions without `try` and `with` go on with the next instruction."""

    def _run_handle_exception(self: Any, runner: Any, state: Any) -> Any:
        return usual(self, runner, state) if self._bytecode.exception_entries else state.advance_pc()

    return _run_handle_exception
