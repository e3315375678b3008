"""Small dense systems, solved in place."""

from wrsim.core.compiling import kernel


@kernel
def factorise(a, n, pivot):
    """LU factors of a with row pivots, in place; ``pivot`` (n,) receives the rows that were exchanged."""
    for c in range(n):
        p = c
        for i in range(c + 1, n):
            if abs(a[i, c]) > abs(a[p, c]):
                p = i
        pivot[c] = p
        if p != c:
            for j in range(n):
                a[c, j], a[p, j] = a[p, j], a[c, j]
        inverse = 1.0 / a[c, c] if a[c, c] != 0.0 else 0.0
        for i in range(c + 1, n):
            f = a[i, c] * inverse
            a[i, c] = f
            if f != 0.0:
                for j in range(c + 1, n):
                    a[i, j] -= f * a[c, j]


@kernel
def solve_factorised(a, n, pivot, x):
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
