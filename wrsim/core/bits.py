"""The bits of a double as a whole number, and back: for tables whose rows are told by exponent and first digits."""

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic


def _bits_of(x):
    """The 64 bits of a number as a whole number."""
    return int(np.float64(x).view(np.int64))


def _number_of(bits):
    """The number with these bits."""
    return float(np.int64(bits).view(np.float64))


@intrinsic
def _bits_compiled(_context, x):
    """As `_bits_of`."""
    return types.int64(types.float64), lambda _c, builder, _s, args: builder.bitcast(args[0], ir.IntType(64))


@intrinsic
def _number_compiled(_context, bits):
    """As `_number_of`."""
    return types.float64(types.int64), lambda _c, builder, _s, args: builder.bitcast(args[0], ir.DoubleType())


bits_of, number_of = (
    (_bits_of, _number_of) if numba.config.DISABLE_JIT else (_bits_compiled, _number_compiled)
)  # fmt: skip
