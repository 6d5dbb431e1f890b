"""Numba's search for types without what it would ask twice: half of its time.

Constraints are asked again only where a type that they have read has changed since, a kernel's type for some arguments
is remembered, and nobody walks through bytecode that does nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from types import TracebackType
from typing import Any

from numba.core import bytecode, byteflow, errors, typeinfer, types
from numba.core.utils import PYVERSION, chain_exception


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
