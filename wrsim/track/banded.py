"""Symmetric systems with few diagonals: factors L D L^T, solutions, products, and the band of the inverse.

A matrix (n, n) with k diagonals below the main one is stored as its lower band (n, k + 1): number (i, j) at
[i, k - i + j]; what would lie left of the first column is 0. Factors overwrite a band: L without its unit diagonal, and
1/D in the last column. Loops of solutions and products have fixed lengths for k = 4 and 6, those of rails.
"""

from wrsim.jit import Array, Ints, inlined, kernel

RAIL, TWISTED_RAIL = 4, 6
"""Diagonals of a rail in bending, and of one with torsion."""


@kernel
def factorise_bands(a: Array) -> None:
    """Factors of a positive definite matrix, in place."""
    n, k = a.shape[0], a.shape[1] - 1
    for i in range(n):
        first = max(0, i - k)
        for j in range(first, i):
            total = a[i, k - i + j]
            for p in range(max(first, j - k), j):
                total -= a[i, k - i + p] * a[j, k - j + p]
            a[i, k - i + j] = total  # L D, until the diagonal is known
        whole = a[i, k]
        for j in range(first, i):
            of_l = a[i, k - i + j] * a[j, k]
            whole -= a[i, k - i + j] * of_l
            a[i, k - i + j] = of_l
        a[i, k] = 1.0 / whole


@kernel
def solve_bands(factors: Array, x: Array) -> None:
    """The solutions of two systems (2, n, k + 1) of rails in place of their right-hand sides x (2, n): side by side,
    for every number waits for the one before it."""
    if factors.shape[2] - 1 == RAIL:
        _solve(factors[0], factors[1], RAIL, x[0], x[1])
    else:
        _solve(factors[0], factors[1], TWISTED_RAIL, x[0], x[1])


@kernel
def subtract_product(a: Array, x: Array, out: Array) -> None:
    """Subtract a x from out; a: of rails."""
    if a.shape[1] - 1 == RAIL:
        _subtract_product(a, RAIL, x, out)
    else:
        _subtract_product(a, TWISTED_RAIL, x, out)


@inlined
def _solve(a: Array, b: Array, k: int, x: Array, y: Array) -> None:
    n = a.shape[0]
    for i in range(min(k, n)):
        for j in range(i):
            x[i] -= a[i, k - i + j] * x[j]
            y[i] -= b[i, k - i + j] * y[j]
    for i in range(k, n):
        first, second = x[i], y[i]
        for j in range(k):
            first -= a[i, j] * x[i - k + j]
            second -= b[i, j] * y[i - k + j]
        x[i], y[i] = first, second
    for i in range(n - 1, max(n - k, 0) - 1, -1):
        x[i] *= a[i, k]
        y[i] *= b[i, k]
        for j in range(i + 1, n):
            x[i] -= a[j, k - j + i] * x[j]
            y[i] -= b[j, k - j + i] * y[j]
    for i in range(n - k - 1, -1, -1):
        first, second = x[i] * a[i, k], y[i] * b[i, k]
        for j in range(k):  # from the farthest below
            first -= a[i + k - j, j] * x[i + k - j]
            second -= b[i + k - j, j] * y[i + k - j]
        x[i], y[i] = first, second


@inlined
def _subtract_product(a: Array, k: int, x: Array, out: Array) -> None:
    n = a.shape[0]
    for i in range(min(k, n)):
        out[i] -= a[i, k] * x[i]
        for j in range(i):
            out[i] -= a[i, k - i + j] * x[j]
            out[j] -= a[i, k - i + j] * x[i]
    for i in range(k, n):
        value, total = x[i], a[i, k] * x[i]
        for j in range(k):
            number = a[i, j]
            total += number * x[i - k + j]
            out[i - k + j] -= number * value
        out[i] -= total


@kernel
def invert_band(factors: Array, inverse: Array) -> None:
    """Write the numbers of the inverse that lie in the band (K. Takahashi, J. Fagan and M.-S. Chin, Proc. 8th PICA
    Conference, 1973, 63), from the last row on."""
    n, k = factors.shape[0], factors.shape[1] - 1
    for i in range(n - 1, -1, -1):
        last = min(i + k, n - 1)
        for j in range(last, i - 1, -1):
            total = factors[i, k] if i == j else 0.0
            for p in range(i + 1, last + 1):
                known = inverse[p, k - p + j] if p >= j else inverse[j, k - j + p]
                total -= factors[p, k - p + i] * known
            inverse[j, k - j + i] = total


@kernel
def quadratic_form(band: Array, places: Ints, x: Array, y: Array) -> float:
    """x^T a y for vectors whose only numbers, (m,), stand at these places within the band of a."""
    k = band.shape[1] - 1
    total = 0.0
    for i in range(x.shape[0]):
        for j in range(y.shape[0]):
            row, column = max(places[i], places[j]), min(places[i], places[j])
            total += x[i] * y[j] * band[row, k - row + column]
    return total
