"""Many arrays in one: a numba call costs about 0.1 us for every array that it is handed, so all arrays of a
wheelset lie in one buffer and an index gives their places.

index: (K, 4) int64 rows: offset, then up to three sizes (0 where there is no such dimension). Records (``record``) lie
in the same buffer of doubles; the size of a record is their last dimension.
"""

import re
from math import prod
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core.cgutils import unpack_tuple
from numba.extending import intrinsic
from numba.np.arrayobj import make_array, populate_array
from numpy.typing import NDArray

from wrsim.jit.cache import CONFIG
from wrsim.jit.compiling import inlined

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]
Record = np.record
Records = NDArray[np.void]
"""Of signatures: arrays, a record (`record`), arrays of records."""

NUMBER = np.dtype(np.float64)


MEANINGS: dict[int, dict[str, tuple[str, str]]] = {}
"""Unit and meaning of the fields of records, by the identity of the type."""


def record(fields: str, **parts: Any) -> Any:
    """Type of a record of 8-byte numbers; ``row.name`` reads and writes, compiled or not.

    fields: a line each, ``name [unit] meaning``; the unit ``[int]`` makes a whole number, a name among ``parts`` has
    that type, of another record.
    """
    rows = [re.fullmatch(r"(\w+) +\[(.+?)\] *(.*)", line.strip()) for line in fields.strip().split("\n")]
    if not all(rows):
        raise ValueError(f"a field needs name, [unit] and meaning: {fields}")
    texts = {name: (unit, meaning) for name, unit, meaning in (row.groups() for row in rows if row)}
    kinds = [(name, parts.get(name, "i8" if unit == "int" else "f8")) for name, (unit, _) in texts.items()]
    kind = np.dtype((np.record, np.dtype(kinds, align=True)))
    MEANINGS[id(kind)] = texts
    return kind


def _view(buffer: Array, offset: int, shape: tuple[int, ...], kind: Any) -> Any:
    """Array of this kind and shape in the buffer, from ``offset`` on."""
    return buffer[offset : offset + prod(shape) * kind.itemsize // 8].view(kind).reshape(shape)


@intrinsic
def _view_compiled(_context: Any, buffer: Any, offset: Any, shape: Any, kind: Any) -> Any:
    """As `_view`; numba's own slices, views and new shapes take ten times as long."""
    array = types.Array(kind.dtype, len(shape), "C")

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        word = context.get_value_type(types.intp)
        size = context.get_abi_sizeof(context.get_data_type(kind.dtype))
        result = make_array(array)(context, builder)
        place = builder.gep(make_array(buffer)(context, builder, args[0]).data, [args[1]])
        shapes = unpack_tuple(builder, args[2])
        strides = [word(size)]
        for length in reversed(shapes[1:]):
            strides.insert(0, builder.mul(strides[0], length))
        data = builder.bitcast(place, result.data.type)
        populate_array(result, data, shapes, strides, word(size), None)
        return result._getvalue()

    return array(buffer, types.intp, shape, kind), code


view: Any = _view if CONFIG.DISABLE_JIT else _view_compiled


def _bits_of(x: float) -> int:
    """The 64 bits of a number as a whole number."""
    return int(np.float64(x).view(np.int64))


def _number_of(bits: int) -> float:
    """The number with these bits."""
    return float(np.int64(bits).view(np.float64))


@intrinsic
def _bits_compiled(_context: Any, x: Any) -> Any:
    """As `_bits_of`."""
    return types.int64(types.float64), lambda _c, builder, _s, args: builder.bitcast(args[0], ir.IntType(64))


@intrinsic
def _number_compiled(_context: Any, bits: Any) -> Any:
    """As `_number_of`."""
    return types.float64(types.int64), lambda _c, builder, _s, args: builder.bitcast(args[0], ir.DoubleType())


bits_of: Any
number_of: Any
bits_of, number_of = (_bits_of, _number_of) if CONFIG.DISABLE_JIT else (_bits_compiled, _number_compiled)


def _take(buffer: Array, place: int) -> bool:
    """Mark a place where 0 stands; whether it was not marked yet: of several threads one takes it."""
    before, buffer[place] = buffer[place], 1.0
    return bool(before == 0.0)


@intrinsic
def _take_compiled(_context: Any, buffer: Any, place: Any) -> Any:
    """As `_take`."""

    def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        word = ir.IntType(64)
        number = builder.gep(make_array(buffer)(context, builder, args[0]).data, [args[1]])
        one = word(_bits_of(1.0))
        before = builder.atomic_rmw("xchg", builder.bitcast(number, word.as_pointer()), one, "monotonic")
        return builder.icmp_signed("==", before, word(0))

    return types.boolean(buffer, types.intp), code


take: Any = _take if CONFIG.DISABLE_JIT else _take_compiled


@inlined
def vector(buffer: Array, index: Ints, k: int) -> Array:
    """Array number k as (n,)."""
    return view(buffer, index[k, 0], (index[k, 1],), NUMBER)


@inlined
def matrix(buffer: Array, index: Ints, k: int) -> Array:
    """Array number k as (n, m)."""
    return view(buffer, index[k, 0], (index[k, 1], index[k, 2]), NUMBER)


@inlined
def block(buffer: Array, index: Ints, k: int) -> Array:
    """Array number k as (n, m, l)."""
    return view(buffer, index[k, 0], (index[k, 1], index[k, 2], index[k, 3]), NUMBER)


@inlined
def records(buffer: Array, index: Ints, k: int, kind: Any) -> Records:
    """Array number k as (n,) records of this kind."""
    return view(buffer, index[k, 0], (index[k, 1],), kind)


@inlined
def record_rows(buffer: Array, index: Ints, k: int, kind: Any) -> Records:
    """Array number k as (n, m) records of this kind."""
    return view(buffer, index[k, 0], (index[k, 1], index[k, 2]), kind)
