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
            a[i, c] *= inverse
        i = c + 1
        while i < n - 3:
            # four rows at once: each number of the pivot's row is read once for all
            f0, f1, f2, f3 = a[i, c], a[i + 1, c], a[i + 2, c], a[i + 3, c]
            if f0 != 0.0 or f1 != 0.0 or f2 != 0.0 or f3 != 0.0:
                for j in range(c + 1, n):
                    upper = a[c, j]
                    a[i, j] -= f0 * upper
                    a[i + 1, j] -= f1 * upper
                    a[i + 2, j] -= f2 * upper
                    a[i + 3, j] -= f3 * upper
            i += 4
        while i < n:
            f0 = a[i, c]
            for j in range(c + 1, n):
                a[i, j] -= f0 * a[c, j]
            i += 1


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
