"""Bicubic splines of a table of coefficients, four of them at a time.

LLVM does not find the four columns that lie side by side behind numba's bounds, so sums are written in vectors here.
"""

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

from wrsim.core.jit.arena import Array
from wrsim.core.jit.cache import CONFIG

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


def _python(of_u: Any, of_v: Any) -> Any:
    def value(table: Array, u: float, v: float) -> float:
        (i, rows), (j, columns) = _weights(u, of_u), _weights(v, of_v)
        total = 0.0
        for p in range(4):
            for q in range(4):
                total += rows[p] * columns[q] * table[i + p, j + q]
        return total

    return value


def _weights(at: float, powers: Any) -> tuple[int, list[float]]:
    """The first coefficient that counts at a place, and the weights of four."""
    i = int(at)
    z = at - i
    return i, [a + z * (b + z * (c + z * d)) for a, b, c, d in powers]


def _difference(table: Array, u: float, lo: float, v: float, hi: float, w: float) -> float:
    return hi * spline(table, u, w) - lo * spline(table, u, v)


def _difference_in_row(row: Array, lo: float, v: float, hi: float, w: float) -> float:
    (i, start), (j, end) = _weights(v, WEIGHTS), _weights(w, WEIGHTS)
    return sum(hi * end[p] * row[j + p] - lo * start[p] * row[i + p] for p in range(4))


class Sum:
    """Writes the sum of coefficients of a table around places."""

    def __init__(self, context: Any, builder: Any, kind: Any, table: Any) -> None:
        own = make_array(kind)(context, builder, table)
        self.builder, self.data, self.width = builder, own.data, builder.extract_value(own.shape, kind.ndim - 1)

    def weights(self, at: Any, powers: Any) -> tuple[Any, Any]:
        """As `_weights`, four side by side."""
        i = self.builder.fptosi(at, WORD)
        z = self.spread(self.builder.fsub(at, self.builder.sitofp(i, DOUBLE)))
        *others, found = (FOUR(list(column)) for column in zip(*powers, strict=True))
        for constant in reversed(others):
            found = self.add(self.times(found, z), constant)
        return i, found

    def columns(self, rows: tuple[Any, Any], j: Any) -> Any:
        """Four columns from j on, each the sum of four rows by their weights."""
        i, weights = rows
        place = self.builder.add(self.builder.mul(i, self.width), j)
        total = None
        for p in range(4):
            weight = self.builder.shuffle_vector(weights, weights, LANES([p] * 4))
            part = self.times(self.load(place), weight)
            total = part if total is None else self.add(total, part)
            place = self.builder.add(place, self.width)
        return total

    def load(self, place: Any) -> Any:
        """Four numbers from a place on."""
        at = self.builder.gep(self.data, [place])
        return self.builder.load(self.builder.bitcast(at, FOUR.as_pointer()), align=8)

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


def _compiled(of_u: Any, of_v: Any) -> Any:
    @intrinsic
    def value(_context: Any, table: Any, u: Any, v: Any) -> Any:
        def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
            own = Sum(context, builder, table, args[0])
            j, columns = own.weights(args[2], of_v)
            return own.total(own.times(own.columns(own.weights(args[1], of_u), j), columns))

        return types.float64(table, types.float64, types.float64), code

    return value


@intrinsic
def _difference_compiled(_context: Any, table: Any, u: Any, lo: Any, v: Any, hi: Any, w: Any) -> Any:
    def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        own = Sum(context, builder, table, args[0])
        rows, (i, start), (j, end) = (own.weights(at, WEIGHTS) for at in (args[1], args[3], args[5]))
        start, end = own.times(own.columns(rows, i), start), own.times(own.columns(rows, j), end)
        return own.step(args[2], start, args[4], end)

    return types.float64(table, *[types.float64] * 5), code


@intrinsic
def _difference_in_row_compiled(_context: Any, row: Any, lo: Any, v: Any, hi: Any, w: Any) -> Any:
    def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        own = Sum(context, builder, row, args[0])
        (i, start), (j, end) = (own.weights(at, WEIGHTS) for at in (args[2], args[4]))
        return own.step(args[1], own.times(own.load(i), start), args[3], own.times(own.load(j), end))

    return types.float64(row, *[types.float64] * 4), code


_made = _python if CONFIG.DISABLE_JIT else _compiled
spline: Any = _made(WEIGHTS, WEIGHTS)
"""spline(table, u, v): value at the place u steps along the rows and v along the columns of a C-contiguous table, in
whose rows u to u + 3 and columns v to v + 3 the coefficients lie that count."""
spline_by_u: Any = _made(SLOPES, WEIGHTS)
"""Its derivative by u."""
spline_by_v: Any = _made(WEIGHTS, SLOPES)
"""Its derivative by v."""
difference: Any = _difference if CONFIG.DISABLE_JIT else _difference_compiled
"""difference(table, u, lo, v, hi, w): hi times the value at (u, w) less lo times that at (u, v)."""
difference_in_row: Any = _difference_in_row if CONFIG.DISABLE_JIT else _difference_in_row_compiled
"""difference_in_row(row, lo, v, hi, w): the same of a spline of one argument."""
