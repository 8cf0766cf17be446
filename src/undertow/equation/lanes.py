"""Four numbers side by side in compiled code: loads, stores, sums and products of one vector register.

numba's compiler leaves four equal statements in a row as four, however it is asked; its types are open, though, and a
register of four doubles is one more of them. Where a processor has shorter registers the compiler splits them.

Belongs here: the type and its few operations. Does not belong here: what is computed (taylor_series.py).
"""

# mypy: disable-error-code="no-untyped-def, misc, untyped-decorator, import-untyped, no-untyped-call"

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import extending
from numba.core import cgutils, types

intrinsic: Any = extending.intrinsic
"""Untyped: numba declares what a call from Python would look like, and there is none."""

LANES = 4
_DOUBLE, _VECTOR = ir.DoubleType(), ir.VectorType(ir.DoubleType(), LANES)
_EXACT_OR_FUSED = ("contract",)
"""A product and a sum may become one instruction, rounded once."""


class Four(types.Type):
    """numba's type of four doubles side by side."""

    def __init__(self) -> None:
        super().__init__(name="Four")


four = Four()


@extending.register_model(Four)
class FourModel(extending.models.PrimitiveModel):
    """Four doubles are one vector for the compiler."""

    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _VECTOR)


def _place(context, builder, signature, args):
    """Where the four numbers of array[row, column : column + 4] stand."""
    kind = signature.args[0]
    array = context.make_array(kind)(context, builder, args[0])
    stride = cgutils.unpack_tuple(builder, array.strides, 2)[0]
    row = builder.mul(args[1], stride)
    column = builder.mul(args[2], ir.Constant(args[2].type, 8))
    start = builder.ptrtoint(array.data, row.type)
    return builder.inttoptr(builder.add(start, builder.add(row, column)), _VECTOR.as_pointer())


def _spread(builder, number):
    """The same number four times."""
    one = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), number, ir.Constant(ir.IntType(32), 0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(one, ir.Constant(_VECTOR, ir.Undefined), zeros)


@intrinsic
def load(context: Any, array: Any, row: Any, column: Any) -> Any:
    """Four numbers of array (n, m) from [row, column] on, the places unsigned."""

    def build(context, builder, signature, args):
        return builder.load(_place(context, builder, signature, args), align=8)

    return four(array, types.uint64, types.uint64), build


@intrinsic
def store(context: Any, array: Any, row: Any, column: Any, numbers: Any) -> Any:
    """Put four numbers into array (n, m) from [row, column] on, the places unsigned."""

    def build(context, builder, signature, args):
        builder.store(args[3], _place(context, builder, signature, args[:3]), align=8)
        return context.get_dummy_value()

    return types.void(array, types.uint64, types.uint64, four), build


@intrinsic
def times(context: Any, factor: Any, numbers: Any) -> Any:
    """factor x numbers."""

    def build(context, builder, signature, args):
        return builder.fmul(_spread(builder, args[0]), args[1], flags=_EXACT_OR_FUSED)

    return four(types.float64, four), build


@intrinsic
def plus(context: Any, some: Any, others: Any) -> Any:
    """some + others, lane by lane."""

    def build(context, builder, signature, args):
        return builder.fadd(args[0], args[1], flags=_EXACT_OR_FUSED)

    return four(four, four), build


@intrinsic
def plus_times(context: Any, some: Any, factor: Any, others: Any) -> Any:
    """some + factor x others, lane by lane."""

    def build(context, builder, signature, args):
        product = builder.fmul(_spread(builder, args[1]), args[2], flags=_EXACT_OR_FUSED)
        return builder.fadd(args[0], product, flags=_EXACT_OR_FUSED)

    return four(four, types.float64, four), build


@intrinsic
def none(context: Any) -> Any:
    """Four zeros."""

    def build(context, builder, signature, args):
        return ir.Constant(_VECTOR, [0.0] * LANES)

    return four(), build


@intrinsic
def with_first(context: Any, numbers: Any, first: Any) -> Any:
    """The four numbers with another first one."""

    def build(context, builder, signature, args):
        return builder.insert_element(args[0], args[1], ir.Constant(ir.IntType(32), 0))

    return four(four, types.float64), build
