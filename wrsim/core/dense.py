"""Small dense systems, solved in place."""

from wrsim.core.compiling import kernel


@kernel
def solve_pivoted(a, n, x):
    """Gaussian elimination with row pivots; a is destroyed, x receives the solution."""
    for c in range(n):
        pivot = c
        for i in range(c + 1, n):
            if abs(a[i, c]) > abs(a[pivot, c]):
                pivot = i
        if pivot != c:
            for j in range(c, n):
                a[c, j], a[pivot, j] = a[pivot, j], a[c, j]
            x[c], x[pivot] = x[pivot], x[c]
        inverse = 1.0 / a[c, c]
        for i in range(c + 1, n):
            f = a[i, c] * inverse
            if f != 0.0:
                for j in range(c + 1, n):
                    a[i, j] -= f * a[c, j]
                x[i] -= f * x[c]
    for i in range(n - 1, -1, -1):
        total = x[i]
        for j in range(i + 1, n):
            total -= a[i, j] * x[j]
        x[i] = total / a[i, i]
