"""Bicubic splines of a table of coefficients, four of them at a time.

LLVM does not find the four columns that lie side by side behind numba's bounds, so sums are written in vectors here.
"""

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

from wrsim.jit.arena import Array
from wrsim.jit.cache import CONFIG

WEIGHTS = (
    (1 / 6, -1 / 2, 1 / 2, -1 / 6),
    (2 / 3, 0.0, -1.0, 1 / 2),
    (1 / 6, 1 / 2, 1 / 2, -1 / 2),
    (0.0, 0.0, 0.0, 1 / 6),
)
"""Of the four coefficients around a place z of a step, 0 to 1: cubic B-splines, by powers of z."""
SLOPES = tuple((b, 2.0 * c, 3.0 * d, 0.0) for _a, b, c, d in WEIGHTS)
"""The same of the derivative by z."""

WORD, LANE, DOUBLE = ir.IntType(64), ir.IntType(32), ir.DoubleType()
FOUR, LANES = ir.VectorType(DOUBLE, 4), ir.VectorType(LANE, 4)
FUSED = ("contract",)  # a product and a sum in one, where the processor can


def _with_slopes(table: Array, u: float, v: float) -> tuple[float, float, float]:
    (i, rows), (_, turned) = _weights(u, WEIGHTS), _weights(u, SLOPES)
    (j, columns), (_, leaning) = _weights(v, WEIGHTS), _weights(v, SLOPES)
    value = by_u = by_v = 0.0
    for p in range(4):
        for q in range(4):
            value += rows[p] * columns[q] * table[i + p, j + q]
            by_u += turned[p] * columns[q] * table[i + p, j + q]
            by_v += rows[p] * leaning[q] * table[i + p, j + q]
    return value, by_u, by_v


def _with_slope_in_row(row: Array, v: float) -> tuple[float, float]:
    (j, columns), (_, leaning) = _weights(v, WEIGHTS), _weights(v, SLOPES)
    return sum(columns[q] * row[j + q] for q in range(4)), sum(leaning[q] * row[j + q] for q in range(4))


def _weights(position: float, powers: Any, z: float = -1.0) -> tuple[int, list[float]]:
    """The first coefficient that counts at a place, and the weights of four; z: where in its step the place lies."""
    i = int(position)
    z = position - i if z < 0.0 else z
    return i, [a + z * (b + z * (c + z * d)) for a, b, c, d in powers]


def _difference(
    table: Array, u: float, u_z: float, lo: float, v: float, v_z: float, hi: float, w: float, w_z: float
) -> float:
    return hi * _with_slopes(table, u, w)[0] - lo * _with_slopes(table, u, v)[0]


def _difference_in_row(row: Array, lo: float, v: float, v_z: float, hi: float, w: float, w_z: float) -> float:
    return hi * _with_slope_in_row(row, w)[0] - lo * _with_slope_in_row(row, v)[0]


class Sum:
    """Writes the sum of coefficients of a table around places."""

    def __init__(self, context: Any, builder: Any, kind: Any, table: Any) -> None:
        array = make_array(kind)(context, builder, table)
        self.builder, self.data, self.width = builder, array.data, builder.extract_value(array.shape, kind.ndim - 1)

    def weights(self, position: Any, powers: Any, z: Any = None) -> tuple[Any, Any]:
        """As `_weights`, four side by side."""
        i = self.builder.fptosi(position, WORD)
        z = self.spread(self.builder.fsub(position, self.builder.sitofp(i, DOUBLE)) if z is None else z)
        *others, values = (FOUR(list(column)) for column in zip(*powers, strict=True))
        for constant in reversed(others):
            values = self.add(self.times(values, z), constant)
        return i, values

    def columns(self, i: Any, j: Any, *weights: Any) -> list[Any]:
        """Four columns from j on, each the sum of four rows from i on, by each of these weights."""
        place = self.builder.add(self.builder.mul(i, self.width), j)
        sums = [FOUR([0.0] * 4)] * len(weights)
        for p in range(4):
            row = self.load(place)
            for w, of_rows in enumerate(weights):
                weight = self.builder.shuffle_vector(of_rows, of_rows, LANES([p] * 4))
                sums[w] = self.add(sums[w], self.times(row, weight))
            place = self.builder.add(place, self.width)
        return sums

    def load(self, place: Any) -> Any:
        """Four numbers from a place on."""
        address = self.builder.gep(self.data, [place])
        return self.builder.load(self.builder.bitcast(address, FOUR.as_pointer()), align=8)

    def spread(self, x: Any) -> Any:
        """A number four times."""
        x = self.builder.insert_element(ir.Constant(FOUR, ir.Undefined), x, LANE(0))
        return self.builder.shuffle_vector(x, x, LANES([0] * 4))

    def times(self, a: Any, b: Any) -> Any:
        return self.builder.fmul(a, b, flags=FUSED)

    def add(self, a: Any, b: Any) -> Any:
        return self.builder.fadd(a, b, flags=FUSED)

    def step(self, lo: Any, start: Any, hi: Any, end: Any) -> Any:
        """hi end - lo start, added up."""
        hi, lo = self.times(self.spread(hi), end), self.times(self.spread(lo), start)
        return self.total(self.builder.fsub(hi, lo, flags=FUSED))

    def total(self, x: Any) -> Any:
        """The sum of four."""
        one, two, three, four = (self.builder.extract_element(x, LANE(p)) for p in range(4))
        return self.builder.fadd(self.builder.fadd(one, three), self.builder.fadd(two, four))


@intrinsic
def _with_slopes_compiled(_context: Any, table: Any, u: Any, v: Any) -> Any:
    kind = types.UniTuple(types.float64, 3)

    def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        sums = Sum(context, builder, table, args[0])
        (i, rows), (_, turned) = (sums.weights(args[1], powers) for powers in (WEIGHTS, SLOPES))
        (j, columns), (_, leaning) = (sums.weights(args[2], powers) for powers in (WEIGHTS, SLOPES))
        level, by_u = sums.columns(i, j, rows, turned)
        products = sums.times(level, columns), sums.times(by_u, columns), sums.times(level, leaning)
        return context.make_tuple(builder, kind, [sums.total(x) for x in products])

    return kind(table, types.float64, types.float64), code


@intrinsic
def _with_slope_in_row_compiled(_context: Any, row: Any, v: Any) -> Any:
    kind = types.UniTuple(types.float64, 2)

    def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        sums = Sum(context, builder, row, args[0])
        (j, columns), (_, leaning) = (sums.weights(args[1], powers) for powers in (WEIGHTS, SLOPES))
        level = sums.load(j)
        return context.make_tuple(builder, kind, [sums.total(sums.times(level, x)) for x in (columns, leaning)])

    return kind(row, types.float64), code


@intrinsic
def _difference_compiled(
    _context: Any, table: Any, u: Any, u_z: Any, lo: Any, v: Any, v_z: Any, hi: Any, w: Any, w_z: Any
) -> Any:
    def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        sums = Sum(context, builder, table, args[0])
        (k, rows), (i, start), (j, end) = (sums.weights(args[p], WEIGHTS, args[p + 1]) for p in (1, 4, 7))
        low, high = sums.columns(k, i, rows)[0], sums.columns(k, j, rows)[0]
        return sums.step(args[3], sums.times(low, start), args[6], sums.times(high, end))

    return types.float64(table, *[types.float64] * 8), code


@intrinsic
def _difference_in_row_compiled(_context: Any, row: Any, lo: Any, v: Any, v_z: Any, hi: Any, w: Any, w_z: Any) -> Any:
    def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        sums = Sum(context, builder, row, args[0])
        (i, start), (j, end) = (sums.weights(args[p], WEIGHTS, args[p + 1]) for p in (2, 5))
        return sums.step(args[1], sums.times(sums.load(i), start), args[4], sums.times(sums.load(j), end))

    return types.float64(row, *[types.float64] * 6), code


with_slopes: Any
with_slope_in_row: Any
difference: Any
difference_in_row: Any
if CONFIG.DISABLE_JIT:
    with_slopes, with_slope_in_row = _with_slopes, _with_slope_in_row
    difference, difference_in_row = _difference, _difference_in_row
else:
    with_slopes, with_slope_in_row = _with_slopes_compiled, _with_slope_in_row_compiled
    difference, difference_in_row = _difference_compiled, _difference_in_row_compiled
"""Of a C-contiguous table, in whose rows u to u + 3 and columns v to v + 3 the coefficients lie that count at (u, v)
steps along rows and columns, or of a row of one.

with_slopes(table, u, v), with_slope_in_row(row, v): value and derivatives by u and v, or by v;
difference(table, u, u_z, lo, v, v_z, hi, w, w_z), difference_in_row(row, lo, v, v_z, hi, w, w_z): hi times the value at
w less lo times that at v; _z: what of a place is beyond its last whole number of steps.
"""
