"""Numbers side by side in code that is written for LLVM: it does not find them behind numba's bounds."""

from typing import Any

from llvmlite import ir

WORD, LANE, DOUBLE = ir.IntType(64), ir.IntType(32), ir.DoubleType()
FOUR, LANES = ir.VectorType(DOUBLE, 4), ir.VectorType(LANE, 4)


def address(builder: Any, data: Any, place: Any, count: int = 4) -> Any:
    """Where so many numbers lie, from a place of the data on."""
    return builder.bitcast(builder.gep(data, [place]), ir.VectorType(DOUBLE, count).as_pointer())


def load(builder: Any, data: Any, place: Any, count: int = 4) -> Any:
    """So many numbers from a place of the data on."""
    return builder.load(address(builder, data, place, count), align=8)


def spread(builder: Any, x: Any, count: int = 4) -> Any:
    """A number so many times."""
    x = builder.insert_element(ir.Constant(ir.VectorType(DOUBLE, count), ir.Undefined), x, LANE(0))
    return builder.shuffle_vector(x, x, ir.VectorType(LANE, count)([0] * count))
