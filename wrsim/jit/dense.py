"""Small dense systems, solved in place; vectors."""

from wrsim.jit import Array, kernel, reassociating_kernel


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
        f0, f1, f2, f3 = a[i, c], a[i + 1, c], a[i + 2, c], a[i + 3, c]
        if start <= c:
            a[i, c] = a[i + 1, c] = a[i + 2, c] = a[i + 3, c] = 0.0
        if f0 != 0.0 or f1 != 0.0 or f2 != 0.0 or f3 != 0.0:
            for j in range(start, end):
                above = a[c, j]
                a[i, j] -= f0 * above
                a[i + 1, j] -= f1 * above
                a[i + 2, j] -= f2 * above
                a[i + 3, j] -= f3 * above
        i += 4
    while i < last:
        f0 = a[i, c]
        if start <= c:
            a[i, c] = 0.0
        for j in range(start, end):
            a[i, j] -= f0 * a[c, j]
        i += 1


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
