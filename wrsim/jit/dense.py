"""Small dense systems, solved in place; vectors."""

from typing import Any

from numba import types
from numba.core.cgutils import for_range_slice
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

from wrsim.jit import Array, kernel, reassociating_kernel
from wrsim.jit.cache import CONFIG
from wrsim.jit.lanes import WORD, address, load, spread


@kernel
def copy(n: int, source: Array, target: Array) -> None:
    """Put the first n numbers of one vector into another: numba copies slices at five times the code."""
    for i in range(n):
        target[i] = source[i]


@kernel
def factorise(a: Array, n: int, pivot: Array) -> None:
    """LU factors of a with row pivots, in place; ``pivot`` (n,) receives the rows that were exchanged."""
    for c in range(n):
        pivot[c] = _exchange(a, c, n)
        inverse = 1.0 / a[c, c] if a[c, c] != 0.0 else 0.0
        for i in range(c + 1, n):
            a[i, c] *= inverse
        _subtract(a, c, c + 1, n, c + 1, n)


@kernel
def invert(a: Array, n: int, pivot: Array) -> None:
    """The inverse of a, in place, by Gauss and Jordan with row pivots; pivot: (n,) scratch."""
    for c in range(n):
        pivot[c] = _exchange(a, c, n)
        inverse = 1.0 / a[c, c] if a[c, c] != 0.0 else 0.0
        a[c, c] = 1.0
        for j in range(n):
            a[c, j] *= inverse
        _subtract(a, c, 0, c, 0, n)
        _subtract(a, c, c + 1, n, 0, n)
    for c in range(n - 1, -1, -1):
        p = int(pivot[c])
        if p != c:
            for i in range(n):
                a[i, c], a[i, p] = a[i, p], a[i, c]


@kernel
def _exchange(a: Array, c: int, n: int) -> int:
    """Exchange row c with the one at or below it that has the largest number in column c; returns which that was."""
    p = c
    for i in range(c + 1, n):
        if abs(a[i, c]) > abs(a[p, c]):
            p = i
    if p != c:
        for j in range(n):
            a[c, j], a[p, j] = a[p, j], a[c, j]
    return p


@kernel
def _subtract(a: Array, c: int, first: int, last: int, start: int, end: int) -> None:
    """Subtract row c times a[i, c] from the rows i = first to last, in the columns from start to end; column c, where
    it is one of these, counts as zero before."""
    i = first
    while i < last - 3:
        # four rows at once: each number of row c is read once for all
        four = a[i, c], a[i + 1, c], a[i + 2, c], a[i + 3, c]
        if four[0] != 0.0 or four[1] != 0.0 or four[2] != 0.0 or four[3] != 0.0:
            _subtract_from(a, c, i, start, end, four)
        if start <= c:
            for p in range(4):
                a[i + p, c] = -four[p] * a[c, c]
        i += 4
    while i < last:
        one = (a[i, c],)
        _subtract_from(a, c, i, start, end, one)
        if start <= c:
            a[i, c] = -one[0] * a[c, c]
        i += 1


def _from_rows(a: Array, c: int, i: int, start: int, end: int, factors: tuple[float, ...]) -> None:
    """Subtract row c times each factor from the rows from i on, in the columns from start to end."""
    for p, factor in enumerate(factors):
        a[i + p, start:end] -= factor * a[c, start:end]


@intrinsic
def _from_rows_compiled(_context: Any, a: Any, c: Any, i: Any, start: Any, end: Any, factors: Any) -> Any:
    """As `_from_rows`, eight columns at a time, then four, then one."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        table, c, i, start, end, factors = args
        array = make_array(signature.args[0])(context, builder, table)
        numbers = [builder.mul(k, builder.extract_value(array.shape, 1)) for k in (c, i)]
        above, row = (builder.gep(array.data, [number]) for number in numbers)
        rows = [row]
        for _ in signature.args[5].types[1:]:
            rows.append(builder.gep(rows[-1], [builder.extract_value(array.shape, 1)]))
        for count in (8, 4, 1):
            rest = builder.sub(end, builder.srem(builder.sub(end, start), WORD(count)))
            shares = [spread(builder, builder.extract_value(factors, p), count) for p in range(len(rows))]
            with for_range_slice(builder, start, rest, WORD(count)) as (j, _):
                x = load(builder, above, j, count)
                for row, share in zip(rows, shares, strict=True):
                    left = builder.fsub(load(builder, row, j, count), builder.fmul(share, x))
                    builder.store(left, address(builder, row, j, count), align=8)
            start = rest
        return context.get_dummy_value()

    return types.none(a, *[types.int64] * 4, factors), code


_subtract_from: Any = _from_rows if CONFIG.DISABLE_JIT else _from_rows_compiled


@kernel
def multiply(a: Array, n: int, x: Array, out: Array) -> None:
    """Write a x to out (n,)."""
    for i in range(n):
        out[i] = _row_product(a, i, n, x)


@reassociating_kernel
def _row_product(a: Array, i: int, n: int, x: Array) -> float:
    """Row i of a times x."""
    total = 0.0
    for j in range(n):
        total += a[i, j] * x[j]
    return total


@kernel
def solve_factorised(a: Array, n: int, pivot: Array, x: Array) -> None:
    """The solution of the system whose factors ``factorise`` left, in place of the right-hand side x."""
    for c in range(n):
        p = int(pivot[c])
        if p != c:
            x[c], x[p] = x[p], x[c]
    for i in range(n):
        total = x[i]
        for j in range(i):
            total -= a[i, j] * x[j]
        x[i] = total
    for i in range(n - 1, -1, -1):
        total = x[i]
        for j in range(i + 1, n):
            total -= a[i, j] * x[j]
        x[i] = total / a[i, i] if a[i, i] != 0.0 else 0.0
