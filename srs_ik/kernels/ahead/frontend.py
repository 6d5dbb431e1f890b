"""From Python to LLVM: Numba translates entries and the kernels behind them, and leaves the rest to `backend`.

Numba itself optimises each kernel again within every kernel that calls it. Here nothing is optimised and nothing linked
until all are translated: that takes a tenth of the time.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils, compiler
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target
from numba.extending import overload
from numba.np import arrayobj

from srs_ik.kernels import entries
from srs_ik.kernels.ahead.quick import make_quick, tidy
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


class _Untouched(JITCodeLibrary):
    """Code of a function as Numba translates it: neither optimised, nor linked, nor run."""

    found: list[Any]
    _finalized: bool

    def _optimize_functions(self, ll_module: Any) -> None:
        pass

    def finalize(self) -> None:
        if not self._finalized:
            self._finalized = True
            self.found.append(self)


class Frontend:
    """Numba, made to translate only. What it has compiled in this process before must not be asked for again."""

    def __init__(self) -> None:
        make_quick()
        self._context = cpu_target.target_context
        self._typing = cpu_target.typing_context
        self._libraries: list[Any] = []
        codegen = self._context.codegen()
        codegen._library_class = type("Untouched", (_Untouched,), {"found": self._libraries})
        # Functions are told apart by what would be called: any builtin of its own will do.
        self._context.get_executable = lambda library, descriptor, environment: [].append
        # Numba's own words name the sizes, for which half a library of strings would have to be compiled.
        arrayobj.raise_with_shape_context = _refuse_shapes
        self._flags = compiler.Flags()
        self._flags.nrt = True
        self._flags.error_model = "numpy"
        self._flags.no_cpython_wrapper = True
        self._flags.no_cfunc_wrapper = True
        self._typing.refresh()
        self._context.refresh()

    def translate(self, entry: Entry, variant: int, symbol: str) -> None:
        """Translate one variant of an entry, as a C function of a name."""
        function = getattr(importlib.import_module(f"{entries.__name__}.{entry.room}"), entry.name)
        absent = entry.variants[variant]
        kinds = tuple(types.none if a.absent_with in absent else numba_type(a) for a in entry.arguments)
        with global_compiler_lock:
            compiled = compiler.compile_extra(
                self._typing, self._context, function.py_func, kinds, None, self._flags, {}
            )
            compiled.library.finalize()
            library = self._context.codegen().create_library(symbol)
            module = library.create_ir_module(symbol)
            self._export(module, entry, compiled, symbol)
            library.add_ir_module(module)
            library.finalize()

    def bitcode(self) -> Iterator[bytes]:
        """All that has been translated, function by function."""
        for library in self._libraries:
            yield library._final_module.as_bitcode()

    def _export(self, module: Any, entry: Entry, compiled: Any, symbol: str) -> None:
        """A C function: pointers, then sizes that are not fixed, scalars, and where to write the results."""
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

    def _given(self, builder: Any, argument: Argument, kind: Any, value: Any, sizes: dict[str, Any]) -> Any:
        if kind is types.none:
            return self._context.get_dummy_value()
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
    """The type of an argument that is there, as Numba names it."""
    element = _ELEMENTS[argument.element]
    return types.Array(element, len(argument.shape), "C") if argument.shape else element


def translate_all(wanted: list[tuple[Entry, int, str]], tell: Callable[[int], None]) -> list[bytes]:
    """Translate variants of entries, each (entry, variant, symbol); `tell` is told how many are done."""
    frontend = Frontend()
    for done, each in enumerate(wanted, 1):
        frontend.translate(*each)
        tidy()
        tell(done)
    return list(frontend.bitcode())
