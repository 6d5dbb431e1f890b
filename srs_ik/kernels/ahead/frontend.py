"""From Python to LLVM: Numba translates entries and the kernels behind them, and leaves the rest to `backend`.

Numba itself optimises each kernel again within every kernel that calls it. Here each is made shorter once, and none is
taken into its callers until all are translated: that takes a tenth of the time.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from functools import partial
from itertools import count
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils, compiler
from numba.core.bytecode import FunctionIdentity
from numba.core.codegen import CodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target
from numba.extending import overload
from numba.np import arrayobj

from srs_ik.kernels import entries
from srs_ik.kernels.ahead.borrow import make_borrow
from srs_ik.kernels.ahead.lean import make_lean
from srs_ik.kernels.ahead.passes import Halves
from srs_ik.kernels.ahead.quick import make_finding, make_quick
from srs_ik.kernels.ahead.signatures import Argument, Entry

_ELEMENTS = {"float": types.float64, "int": types.int64, "byte": types.int8, "bool": types.bool_}
_BYTE, _WORD, _FLOAT = ir.IntType(8), ir.IntType(64), ir.DoubleType()
_IN_C = {"float": _FLOAT, "int": _WORD, "byte": _BYTE, "bool": _BYTE}


def _refuse_shapes(given: Any, wanted: Any) -> None:
    """What an assignment of an array that does not fit comes to."""
    raise ValueError("arrays of different sizes")


@overload(_refuse_shapes)
def _refuse_any_shapes(given: Any, wanted: Any) -> Callable[..., Any]:
    def refuse(given: Any, wanted: Any) -> None:
        raise ValueError("arrays of different sizes")

    return refuse


def _no_address(builder: Any, address: int, info: str) -> Any:
    """A function that is called is an object of no value, and nothing else of this process has an address later on."""
    if info != "CPUDispatcher":
        raise TypeError(f"a kernel cannot refer to a {info} of the process that compiles it")
    return ir.Constant(_BYTE.as_pointer(), None)


NUMBERS = 10**6
"""More functions than there are kernels."""

Written = tuple[str, set[str]]
"""A module as LLVM reads it, and the names that other modules use of it."""


class _Untouched(CodeLibrary):
    """Code of a function as Numba writes it: neither optimised, nor linked, nor run.

    Functions that are written together share a module, and with it what they say of those that they call.
    """

    written: list[str]
    shared: list[Any]

    def create_ir_module(self, name: str) -> Any:
        return self.shared[0] if self.shared else super().create_ir_module(name)

    def add_ir_module(self, ir_module: Any) -> None:
        if not self.shared:
            self.written.append(str(ir_module))

    def add_linking_library(self, library: Any) -> None:
        pass

    def finalize(self) -> None:
        pass

    def get_function(self, name: str) -> Any:
        raise NotImplementedError

    get_llvm_str = get_asm_str = get_function


class Frontend:
    """Numba, made to translate only; `found` is called whenever the types of one more function are known.

    What it has compiled in this process before must not be asked for again.
    """

    def __init__(self, found: Callable[[Frontend], None] = lambda frontend: None) -> None:
        make_quick()
        make_finding()
        make_lean()
        make_borrow()
        self._found = found
        self._waiting: list[Callable[[], str]] = []
        self._halves = Halves(self._wait)
        self._halves.install()
        self._written: list[str] = []
        self._context = cpu_target.target_context
        self._typing = cpu_target.typing_context
        codegen = self._context.codegen()
        self._shared: list[Any] = []
        codegen._library_class = type("Untouched", (_Untouched,), {"written": self._written, "shared": self._shared})
        self._context.get_executable = lambda library, descriptor, environment: [].append
        self._context.add_dynamic_addr = _no_address
        # Numba's own words name the sizes, for which half a library of strings would have to be compiled.
        arrayobj.raise_with_shape_context = _refuse_shapes
        self._flags = compiler.Flags()
        self._flags.nrt = True
        self._flags.error_model = "numpy"
        self._flags.no_cpython_wrapper = True
        self._flags.no_cfunc_wrapper = True
        self._typing.refresh()
        self._context.refresh()
        (self._runtime,) = self._written
        self._written.clear()

    def find_types(self, entry: Entry, symbol: str) -> None:
        """Find the types of an entry, which is to be a C function of a name, and of its kernels."""
        function = getattr(importlib.import_module(f"{entries.__name__}.{entry.room}"), entry.name)
        kinds = tuple(map(numba_type, entry.arguments))
        with global_compiler_lock:
            compiled = compiler.compile_extra(
                self._typing, self._context, function.py_func, kinds, None, self._flags, {}
            )
        self._wait(partial(self._export, entry, compiled, symbol))

    def _wait(self, write: Callable[[], str]) -> None:
        self._waiting.append(write)
        self._found(self)

    def waiting(self) -> int:
        """How many functions have types and no code yet."""
        return len(self._waiting)

    def take(self, most: int) -> Callable[[], Written]:
        """The call that writes the code of those functions that have waited longest, which then wait no longer."""
        taken = self._waiting[:most]
        del self._waiting[:most]
        return partial(self._finished, taken)

    def runtime(self) -> str:
        """What all code may call: a module in which everything is meant for others."""
        return self._runtime

    def _finished(self, taken: list[Callable[[], str]]) -> Written:
        self._halves.postponing = False
        # Where calls are made in this process, what Numba wrote for the last one is out of this one's reach.
        self._context.cached_internal_func.clear()
        self._shared.append(self._context.codegen()._create_empty_module("kernels"))
        # Numbers of functions that Numba has to find while it writes must not tell how far other processes are.
        before, FunctionIdentity._unique_ids = FunctionIdentity._unique_ids, count(NUMBERS)
        with global_compiler_lock:
            names = {write() for write in taken}
        FunctionIdentity._unique_ids = before
        self._halves.postponing = True
        return str(self._shared.pop()), names

    def _export(self, entry: Entry, compiled: Any, symbol: str) -> str:
        """A C function: pointers, then sizes that are not fixed, scalars, and where to write the results."""
        library = self._context.codegen().create_library(symbol)
        module = library.create_ir_module(symbol)
        arguments: list[Any] = []
        for a in entry.arguments:
            arguments.append(_IN_C[a.element].as_pointer() if a.shape else _IN_C[a.element])
        arguments += [_WORD] * len(entry.sizes)
        arguments += [_IN_C[kind].as_pointer() for kind in entry.results]
        function = ir.Function(module, ir.FunctionType(ir.IntType(32), arguments), symbol)
        builder = ir.IRBuilder(function.append_basic_block())
        count = len(entry.arguments)
        sizes = dict(zip(entry.sizes, function.args[count:], strict=False))
        given = [
            self._given(builder, a, kind, value, sizes)
            for a, kind, value in zip(entry.arguments, compiled.signature.args, function.args, strict=False)
        ]
        called = self._context.declare_function(module, compiled.fndesc)
        status, result = self._context.call_conv.call_function(
            builder, called, compiled.signature.return_type, compiled.signature.args, given
        )
        with cgutils.if_unlikely(builder, status.is_error):
            builder.ret(ir.Constant(ir.IntType(32), 1))
        self._write(builder, entry, compiled.signature.return_type, result, function.args[count + len(sizes) :])
        builder.ret(ir.Constant(ir.IntType(32), 0))
        library.add_ir_module(module)
        return symbol

    def _given(self, builder: Any, argument: Argument, kind: Any, value: Any, sizes: dict[str, Any]) -> Any:
        if argument.shape is None:
            return builder.icmp_unsigned("!=", value, _BYTE(0)) if argument.element == "bool" else value
        array = self._context.make_array(kind)(self._context, builder)
        shape = [sizes[n] if isinstance(n, str) else _WORD(n) for n in argument.shape]
        item = self._context.get_abi_sizeof(self._context.get_data_type(kind.dtype))
        strides = [_WORD(item)]
        for n in reversed(shape[1:]):
            strides.insert(0, builder.mul(strides[0], n))
        arrayobj.populate_array(array, data=value, shape=shape, strides=strides, itemsize=_WORD(item), meminfo=None)
        return array._getvalue()

    def _write(self, builder: Any, entry: Entry, kind: Any, result: Any, places: Any) -> None:
        found = tuple(kind) if isinstance(kind, types.BaseTuple) else () if kind is types.none else (kind,)
        wanted = tuple(_ELEMENTS[each] for each in entry.results)
        if found != wanted:
            raise TypeError(f"{entry.room}.{entry.name} returns {kind}, and its line in the table says {wanted}")
        values = cgutils.unpack_tuple(builder, result) if isinstance(kind, types.BaseTuple) else [result]
        for each, value, place in zip(entry.results, values, places, strict=False):
            builder.store(builder.zext(value, _BYTE) if each == "bool" else value, place)


def numba_type(argument: Argument) -> Any:
    """The type of an argument, as Numba names it."""
    element = _ELEMENTS[argument.element]
    return types.Array(element, len(argument.shape), "C") if argument.shape else element
