"""Eight floats and eight truth values as types of Numba, and what `lane_functions` does with them, in LLVM."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.imputils import lower_builtin, lower_cast
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import models, register_model

from srs_ik.kernels.algebra.lane_functions import (
    LANES,
    as_bits,
    as_mask,
    eight_of,
    gather,
    one_of,
    root,
    scatter,
    where,
    whole_number,
)


class EightType(types.Type):  # type: ignore[misc]
    """Eight floats."""

    def __init__(self) -> None:
        super().__init__("Eight")


class MaskType(types.Type):  # type: ignore[misc]
    """Eight truth values."""

    def __init__(self) -> None:
        super().__init__("Mask")


EIGHT = EightType()
MASK = MaskType()
POINTER = types.CPointer(types.float64)
FLOATS = ir.VectorType(ir.DoubleType(), LANES)
BITS = ir.VectorType(ir.IntType(1), LANES)
NOTHING = ir.Constant(FLOATS, ir.Undefined)
LANE = [ir.Constant(ir.IntType(32), i) for i in range(LANES)]


@register_model(EightType)
class EightModel(models.PrimitiveModel):  # type: ignore[misc]
    """A vector of doubles."""

    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, FLOATS)


@register_model(MaskType)
class MaskModel(models.PrimitiveModel):  # type: ignore[misc]
    """A vector of bits."""

    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, BITS)


@lower_cast(types.Number, EightType)
def eight_equal(context: Any, builder: Any, source: Any, target: Any, value: Any) -> Any:
    """A number as eight equal floats."""
    first = builder.insert_element(NOTHING, context.cast(builder, value, source, types.float64), LANE[0])
    return builder.shuffle_vector(first, NOTHING, ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES))


def teach(operation: Callable[..., Any], kinds: tuple[Any, ...], result: Any, generate: Callable[..., Any]) -> None:
    """Teach Numba what an operation of Python is on operands of some kinds, of which one at least is not a number."""

    def fits(given: Any, kind: Any) -> bool:
        return given == kind or (kind in (EIGHT, types.intp, types.float64) and isinstance(given, types.Number))

    @infer_global(operation)
    class Template(AbstractTemplate):  # type: ignore[misc]
        def generic(self, args: Any, kws: Any) -> Any:
            plain = EIGHT in kinds and all(isinstance(a, types.Number) for a in args)
            if plain or len(args) != len(kinds) or not all(map(fits, args, kinds)):
                return None
            return signature(result, *kinds)

    @lower_builtin(operation, *kinds)
    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        value = generate(builder, *args)
        return context.get_dummy_value() if value is None else value


def of_llvm(name: str) -> Callable[..., Any]:
    """An intrinsic function of LLVM with one argument, a float or eight."""

    def generate(builder: Any, x: Any) -> Any:
        suffix = f"v{LANES}f64" if x.type == FLOATS else "f64"
        kind = ir.FunctionType(x.type, [x.type])
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.{suffix}"), [x])

    return generate


def _eight_of(builder: Any, *figures: Any) -> Any:
    x = NOTHING
    for i, figure in zip(LANE, figures, strict=True):
        x = builder.insert_element(x, figure, i)
    return x


def _gather(builder: Any, figures: Any, place: Any, stride: Any) -> Any:
    x = NOTHING
    for i in LANE:
        x = builder.insert_element(x, builder.load(builder.gep(figures, [place])), i)
        place = builder.add(place, stride)
    return x


def _scatter(builder: Any, figures: Any, place: Any, stride: Any, x: Any) -> None:
    with builder.if_else(builder.icmp_signed("==", stride, ir.Constant(stride.type, 1))) as (in_a_row, apart):
        with in_a_row:
            # Eight stores would be put together to some that what is read next as one has to wait for.
            there = builder.bitcast(builder.gep(figures, [place]), FLOATS.as_pointer())
            builder.store(x, there, align=8)
        with apart:
            for i in LANE:
                builder.store(builder.extract_element(x, i), builder.gep(figures, [place]))
                place = builder.add(place, stride)


teach(operator.add, (EIGHT, EIGHT), EIGHT, lambda builder, a, b: builder.fadd(a, b))
teach(operator.sub, (EIGHT, EIGHT), EIGHT, lambda builder, a, b: builder.fsub(a, b))
teach(operator.mul, (EIGHT, EIGHT), EIGHT, lambda builder, a, b: builder.fmul(a, b))
teach(operator.truediv, (EIGHT, EIGHT), EIGHT, lambda builder, a, b: builder.fdiv(a, b))
teach(operator.neg, (EIGHT,), EIGHT, lambda builder, a: builder.fneg(a))
teach(operator.lt, (EIGHT, EIGHT), MASK, lambda builder, a, b: builder.fcmp_ordered("<", a, b))
teach(operator.gt, (EIGHT, EIGHT), MASK, lambda builder, a, b: builder.fcmp_ordered(">", a, b))
teach(operator.and_, (MASK, MASK), MASK, lambda builder, a, b: builder.and_(a, b))
teach(operator.or_, (MASK, MASK), MASK, lambda builder, a, b: builder.or_(a, b))
teach(abs, (EIGHT,), EIGHT, of_llvm("fabs"))
teach(root, (EIGHT,), EIGHT, of_llvm("sqrt"))
teach(root, (types.float64,), types.float64, of_llvm("sqrt"))
teach(whole_number, (EIGHT,), EIGHT, of_llvm("rint"))
teach(where, (MASK, EIGHT, EIGHT), EIGHT, lambda builder, condition, a, b: builder.select(condition, a, b))
teach(where, (types.boolean, types.float64, types.float64), types.float64, lambda builder, *args: builder.select(*args))
teach(
    as_bits, (MASK,), types.intp, lambda builder, a: builder.zext(builder.bitcast(a, ir.IntType(LANES)), ir.IntType(64))
)
teach(as_mask, (types.intp,), MASK, lambda builder, a: builder.bitcast(builder.trunc(a, ir.IntType(LANES)), BITS))
teach(eight_of, (types.float64,) * LANES, EIGHT, _eight_of)
teach(one_of, (EIGHT, types.intp), types.float64, lambda builder, x, i: builder.extract_element(x, i))
teach(gather, (POINTER, types.intp, types.intp), EIGHT, _gather)
teach(scatter, (POINTER, types.intp, types.intp, EIGHT), types.none, _scatter)
