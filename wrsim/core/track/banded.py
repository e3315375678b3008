"""Symmetric systems with few diagonals: factors L D L^T, solutions, products, and the band of the inverse.

A matrix (n, n) with k diagonals below the main one is stored as its lower band (n, k + 1): number (i, j) at
[i, k - i + j]. Factors overwrite a band: L without its unit diagonal, and 1/D in the last column.
"""

from wrsim.core.jit import Array, kernel


@kernel
def factorise(a: Array) -> None:
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
def solve(factors: Array, x: Array) -> None:
    """The solution in place of the right-hand side x (n,)."""
    n, k = factors.shape[0], factors.shape[1] - 1
    for i in range(n):
        total = x[i]
        for j in range(max(0, i - k), i):
            total -= factors[i, k - i + j] * x[j]
        x[i] = total
    for i in range(n - 1, -1, -1):
        x[i] *= factors[i, k]
    for i in range(n - 1, -1, -1):
        value = x[i]
        for j in range(max(0, i - k), i):
            x[j] -= factors[i, k - i + j] * value


@kernel
def subtract_product(a: Array, x: Array, out: Array) -> None:
    """Subtract a x from out."""
    n, k = a.shape[0], a.shape[1] - 1
    for i in range(n):
        total = a[i, k] * x[i]
        for j in range(max(0, i - k), i):
            number = a[i, k - i + j]
            total += number * x[j]
            out[j] -= number * x[i]
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
def quadratic_form(band: Array, places: Array, x: Array, y: Array) -> float:
    """x^T a y for vectors whose only numbers, (m,), stand at these places within the band of a."""
    k = band.shape[1] - 1
    total = 0.0
    for i in range(x.shape[0]):
        for j in range(y.shape[0]):
            row, column = int(max(places[i], places[j])), int(min(places[i], places[j]))
            total += x[i] * y[j] * band[row, k - row + column]
    return total
