"""Small dense systems, solved in place."""

from wrsim.core.compiling import kernel


@kernel
def factorise(a, n):
    """LU decomposition in place; the diagonal dominates, so there is no pivoting."""
    for c in range(n):
        inverse = 1.0 / a[c, c]
        for i in range(c + 1, n):
            f = a[i, c] * inverse
            a[i, c] = f
            for j in range(c + 1, n):
                a[i, j] -= f * a[c, j]


@kernel
def substitute(lu, n, x):
    """Solve with a decomposition; x holds the right-hand side and receives the solution."""
    for i in range(1, n):
        total = x[i]
        for j in range(i):
            total -= lu[i, j] * x[j]
        x[i] = total
    for i in range(n - 1, -1, -1):
        total = x[i]
        for j in range(i + 1, n):
            total -= lu[i, j] * x[j]
        x[i] = total / lu[i, i]


@kernel
def substitute_columns(lu, n, x):
    """Solve with a decomposition for n right-hand sides, the columns of x; row operations run along memory."""
    for i in range(1, n):
        for j in range(i):
            f = lu[i, j]
            for c in range(n):
                x[i, c] -= f * x[j, c]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            f = lu[i, j]
            for c in range(n):
                x[i, c] -= f * x[j, c]
        inverse = 1.0 / lu[i, i]
        for c in range(n):
            x[i, c] *= inverse


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
