"""Bicubic splines of a table of coefficients, four of them at a time (`jit.lanes`)."""

from typing import Any

from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

from wrsim.jit.arena import Array
from wrsim.jit.cache import CONFIG
from wrsim.jit.lanes import FOUR, LANE, LANES, WORD, load, spread

WEIGHTS = (
    (1 / 6, -1 / 2, 1 / 2, -1 / 6),
    (2 / 3, 0.0, -1.0, 1 / 2),
    (1 / 6, 1 / 2, 1 / 2, -1 / 2),
    (0.0, 0.0, 0.0, 1 / 6),
)
"""Of the four coefficients around a place z of a step, 0 to 1: cubic B-splines, by powers of z."""
SLOPES = tuple((b, 2.0 * c, 3.0 * d, 0.0) for _a, b, c, d in WEIGHTS)
"""The same of the derivative by z."""

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


def _weights(position: float, powers: Any) -> tuple[int, list[float]]:
    """The first coefficient that counts at a place, and the weights of four."""
    i = int(position)
    z = position - i
    return i, [a + z * (b + z * (c + z * d)) for a, b, c, d in powers]


def _terms(
    table: Array, u: float, u_z: float, lo: float, v: float, v_z: float, v_rate: float, hi: float, w: float,
    w_z: float, w_rate: float,
) -> tuple[float, float, float, float]:  # fmt: skip
    (low, low_u, low_v), (high, high_u, high_v) = _with_slopes(table, u, v), _with_slopes(table, u, w)
    return hi * high - lo * low, hi * high_u - lo * low_u, low + v_rate * low_v, high + w_rate * high_v


def _terms_in_row(
    row: Array, lo: float, v: float, v_z: float, v_rate: float, hi: float, w: float, w_z: float, w_rate: float
) -> tuple[float, float, float]:
    (low, low_v), (high, high_v) = _with_slope_in_row(row, v), _with_slope_in_row(row, w)
    return hi * high - lo * low, low + v_rate * low_v, high + w_rate * high_v


def _differences(table: Array, ends: tuple[Array, ...], places: tuple[Array, ...]) -> tuple[float, ...]:
    lo, v, _, hi, w, _ = ends
    return tuple(
        sum(
            hi[k] * _with_slopes(table, u[k], w[k])[0] - lo[k] * _with_slopes(table, u[k], v[k])[0]
            for k in range(lo.size)
        )
        for u in places[::2]
    )


def _differences_in_row(table: Array, ends: tuple[Array, ...], places: tuple[Array, ...]) -> tuple[float, ...]:
    lo, v, _, hi, w, _ = ends
    row = table[-1]
    in_row = sum(
        hi[k] * _with_slope_in_row(row, w[k])[0] - lo[k] * _with_slope_in_row(row, v[k])[0] for k in range(lo.size)
    )
    return (in_row, *_differences(table, ends, places))


class Sum:
    """Writes the sum of coefficients of a table around places."""

    def __init__(self, context: Any, builder: Any, kind: Any, table: Any) -> None:
        array = make_array(kind)(context, builder, table)
        self.builder, self.data, self.height = builder, array.data, builder.extract_value(array.shape, 0)
        self.width = builder.extract_value(array.shape, kind.ndim - 1)

    def weights(self, position: Any, powers: Any, z: Any) -> tuple[Any, Any]:
        """As `_weights`, four side by side; z: where in its step the place lies."""
        i = self.builder.fptosi(position, WORD)
        z = spread(self.builder, z)
        *others, values = (FOUR(list(column)) for column in zip(*powers, strict=True))
        for constant in reversed(others):
            values = self.add(self.times(values, z), constant)
        return i, values

    def columns(self, i: Any, j: Any, *weights: Any) -> list[Any]:
        """Four columns from j on, each the sum of four rows from i on, by each of these weights."""
        place = self.builder.add(self.builder.mul(i, self.width), j)
        sums = [FOUR([0.0] * 4)] * len(weights)
        for p in range(4):
            row = load(self.builder, self.data, place)
            for w, of_rows in enumerate(weights):
                weight = self.builder.shuffle_vector(of_rows, of_rows, LANES([p] * 4))
                sums[w] = self.add(sums[w], self.times(row, weight))
            place = self.builder.add(place, self.width)
        return sums

    def times(self, a: Any, b: Any) -> Any:
        return self.builder.fmul(a, b, flags=FUSED)

    def add(self, a: Any, b: Any) -> Any:
        return self.builder.fadd(a, b, flags=FUSED)

    def totals(self, *vectors: Any) -> list[Any]:
        """The sums of up to four vectors."""
        a, b, c, d = (*vectors, *[FOUR([0.0] * 4)] * (4 - len(vectors)))
        shuffled = self.builder.shuffle_vector
        ab, cd = (
            self.add(shuffled(x, y, LANES([0, 4, 2, 6])), shuffled(x, y, LANES([1, 5, 3, 7])))
            for x, y in ((a, b), (c, d))
        )
        sums = self.add(shuffled(ab, cd, LANES([0, 1, 4, 5])), shuffled(ab, cd, LANES([2, 3, 6, 7])))
        return [self.builder.extract_element(sums, LANE(p)) for p in range(len(vectors))]

    def scaled(self, x: Any, vector: Any) -> Any:
        """A number times four."""
        return self.times(spread(self.builder, x), vector)

    def less(self, a: Any, b: Any) -> Any:
        return self.builder.fsub(a, b, flags=FUSED)


def _numbers_of(context: Any, builder: Any, kind: Any, arrays: Any, k: Any) -> list[Any]:
    """Element k of each of a tuple of arrays."""
    made = (make_array(kind.dtype)(context, builder, builder.extract_value(arrays, p)) for p in range(len(kind)))
    return [builder.load(builder.gep(array.data, [k])) for array in made]


@intrinsic
def _terms_compiled(
    _context: Any, table: Any, u: Any, u_z: Any, lo: Any, v: Any, v_z: Any, v_rate: Any, hi: Any, w: Any, w_z: Any,
    w_rate: Any,
) -> Any:  # fmt: skip
    kind = types.UniTuple(types.float64, 4)

    def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        sums = Sum(context, builder, table, args[0])
        (i, rows), (_, turned) = (sums.weights(args[1], powers, args[2]) for powers in (WEIGHTS, SLOPES))
        shares, by_u, ends = [], [], []
        for share, position, z, rate in (args[3:7], args[7:11]):
            (j, columns), (_, leaning) = (sums.weights(position, powers, z) for powers in (WEIGHTS, SLOPES))
            level, turn = sums.columns(i, j, rows, turned)
            scaled = sums.scaled(share, columns)
            shares.append(sums.times(level, scaled))
            by_u.append(sums.times(turn, scaled))
            ends.append(sums.times(level, sums.add(columns, sums.scaled(rate, leaning))))
        (low, high), (low_u, high_u) = shares, by_u
        return context.make_tuple(builder, kind, sums.totals(sums.less(high, low), sums.less(high_u, low_u), *ends))

    return kind(table, *[types.float64] * 10), code


@intrinsic
def _terms_in_row_compiled(
    _context: Any, row: Any, lo: Any, v: Any, v_z: Any, v_rate: Any, hi: Any, w: Any, w_z: Any, w_rate: Any
) -> Any:  # fmt: skip
    kind = types.UniTuple(types.float64, 3)

    def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        sums = Sum(context, builder, row, args[0])
        shares, ends = [], []
        for share, position, z, rate in (args[1:5], args[5:9]):
            (j, columns), (_, leaning) = (sums.weights(position, powers, z) for powers in (WEIGHTS, SLOPES))
            level = load(builder, sums.data, j)
            shares.append(sums.times(level, sums.scaled(share, columns)))
            ends.append(sums.times(level, sums.add(columns, sums.scaled(rate, leaning))))
        return context.make_tuple(builder, kind, sums.totals(sums.less(shares[1], shares[0]), *ends))

    return kind(row, *[types.float64] * 8), code


def _sums(context: Any, builder: Any, table: Any, kinds: Any, args: Any, step: Any, count: int) -> list[Any]:
    """Sums over all ends of what ``step(sums, k, low, high)`` gives, so many vectors; low, high: column and weights,
    with their shares, of both ends."""
    sums = Sum(context, builder, table, args[0])
    kept = [cgutils.alloca_once(builder, FOUR) for _ in range(count)]
    for place in kept:
        builder.store(FOUR([0.0] * 4), place)
    first = make_array(kinds.dtype)(context, builder, builder.extract_value(args[1], 0))
    with cgutils.for_range(builder, builder.extract_value(first.shape, 0)) as loop:
        lo, v, v_z, hi, w, w_z = _numbers_of(context, builder, kinds, args[1], loop.index)
        (i, start), (j, end) = sums.weights(v, WEIGHTS, v_z), sums.weights(w, WEIGHTS, w_z)
        terms = step(sums, loop.index, (i, sums.scaled(lo, start)), (j, sums.scaled(hi, end)))
        for place, (low, high) in zip(kept, terms, strict=True):
            builder.store(sums.less(sums.add(builder.load(place), high), low), place)
    return sums.totals(*map(builder.load, kept))


def _differences_code(in_row: bool) -> Any:
    """Types and code of `_differences`, or of `_differences_in_row`."""

    def differences(_context: Any, table: Any, ends: Any, places: Any) -> Any:
        count = len(places) // 2
        kind = types.UniTuple(types.float64, count + in_row)

        def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
            def step(sums: Sum, k: Any, low: Any, high: Any) -> Any:
                if in_row:
                    last = builder.mul(sums.width, builder.sub(sums.height, WORD(1)))
                    rows = (builder.add(last, column) for column, _ in (low, high))
                    yield [
                        sums.times(load(builder, sums.data, row), shares)
                        for row, (_, shares) in zip(rows, (low, high), strict=True)
                    ]
                numbers = _numbers_of(context, builder, places, args[2], k)
                for p in range(count):
                    row, weights = sums.weights(numbers[2 * p], WEIGHTS, numbers[2 * p + 1])
                    yield [sums.times(sums.columns(row, column, weights)[0], shares) for column, shares in (low, high)]

            return context.make_tuple(builder, kind, _sums(context, builder, table, ends, args, step, count + in_row))

        return kind(table, ends, places), code

    return differences


terms: Any
terms_in_row: Any
differences: Any
differences_in_row: Any
if CONFIG.DISABLE_JIT:
    terms, terms_in_row = _terms, _terms_in_row
    differences, differences_in_row = _differences, _differences_in_row
else:
    terms, terms_in_row = _terms_compiled, _terms_in_row_compiled
    differences, differences_in_row = (intrinsic(_differences_code(in_row)) for in_row in (False, True))
"""Of a C-contiguous table, in whose rows u to u + 3 and columns v to v + 3 the coefficients lie that count at (u, v)
steps along rows and columns, or of a row of one.

terms(table, u, u_z, lo, v, v_z, v_rate, hi, w, w_z, w_rate): hi times the value at w less lo times that at v, the same
of their slopes by u; value and rate times slope at v, and at w. terms_in_row(row, lo, ...): without slopes by u.
differences(table, ends, places): at each of some places hi times the value at w less lo times that at v, added up over
all ends, (lo, v, v_z, hi, w, w_z), arrays; places: (u, u_z) of each, one behind the other, arrays; _z: what of a
position is beyond its last whole number of steps. differences_in_row: ahead of these the same in the table's last
row.
"""
