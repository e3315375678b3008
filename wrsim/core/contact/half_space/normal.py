"""Normal contact of half-spaces on a grid: steps of a preconditioned conjugate gradient method with bounds.

Wanted are pressures p >= 0 with deformed gaps e = A p - pen >= 0 and p e = 0 in every element: the minimum of
1/2 p A p - pen p over p >= 0, A the influence matrix, pen the undeformed interpenetration at the prescribed approach.
Conjugate gradients run on the elements in contact; elements that would pull leave, elements that would overlap enter
(Polonsky and Keer, Wear 231, 1999). Preconditioned in Fourier space with the inverse symbol of A, |k| E*/2
(Vollebregt, Tribology Transactions 57, 2014), six to ten iterations reach 1e-4.

The convolutions A p are done by the caller (wrsim.contact.half_space.solvers); everything here is one pass over the
grid. Arrays are (rows, columns); ``contact`` is 1.0 in contact, 0.0 outside.
"""

from math import sqrt

from wrsim.core.compiling import kernel


@kernel
def first_guess(pen, level, p, contact):
    """Semi-elliptic pressures sqrt(pen - level) where pen > level, else zero."""
    for j in range(pen.shape[0]):
        for i in range(pen.shape[1]):
            h = pen[j, i] - level
            p[j, i] = sqrt(h) if h > 0.0 else 0.0
            contact[j, i] = 1.0 if h > 0.0 else 0.0


@kernel
def residual(e, contact, r):
    """r = e in contact, else zero. Returns the largest abs(r) and the deepest overlap outside contact."""
    largest = 0.0
    overlap = 0.0
    for j in range(e.shape[0]):
        for i in range(e.shape[1]):
            if contact[j, i] > 0.0:
                r[j, i] = e[j, i]
                largest = max(largest, abs(e[j, i]))
            else:
                r[j, i] = 0.0
                overlap = max(overlap, -e[j, i])
    return largest, overlap


@kernel
def direction(z, r, r_last, contact, rho_last, t):
    """Next search direction t = z + beta t on the contact (Polak and Ribiere); z: preconditioned residual.

    rho_last: z r of the last step, not positive for a fresh start. Keeps r in r_last. Returns z r.
    """
    rho = 0.0
    change = 0.0
    for j in range(r.shape[0]):
        for i in range(r.shape[1]):
            if contact[j, i] > 0.0:
                rho += z[j, i] * r[j, i]
                change += z[j, i] * (r[j, i] - r_last[j, i])
            r_last[j, i] = r[j, i]
    beta = max(change / rho_last, 0.0) if rho_last > 0.0 else 0.0
    for j in range(r.shape[0]):
        for i in range(r.shape[1]):
            t[j, i] = z[j, i] + beta * t[j, i] if contact[j, i] > 0.0 else 0.0
    return rho


@kernel
def advance(p, e, t, at, contact):
    """Step to the minimum along t; at: A t. Elements that would pull leave the contact with p = 0.

    Updates e by the unclipped step. Returns the number of elements that left; then e must be computed anew.
    """
    rt = 0.0
    tat = 0.0
    for j in range(p.shape[0]):
        for i in range(p.shape[1]):
            if contact[j, i] > 0.0:
                rt += e[j, i] * t[j, i]
                tat += t[j, i] * at[j, i]
    if tat <= 0.0:
        return 0
    tau = rt / tat
    left = 0
    for j in range(p.shape[0]):
        for i in range(p.shape[1]):
            e[j, i] -= tau * at[j, i]
            if contact[j, i] > 0.0:
                p[j, i] -= tau * t[j, i]
                if p[j, i] < 0.0:
                    p[j, i] = 0.0
                    contact[j, i] = 0.0
                    left += 1
    return left


@kernel
def admit(e, contact, tolerance):
    """Elements that overlap by more than the tolerance enter the contact. Returns their number."""
    entered = 0
    for j in range(e.shape[0]):
        for i in range(e.shape[1]):
            if contact[j, i] == 0.0 and e[j, i] < -tolerance:
                contact[j, i] = 1.0
                entered += 1
    return entered


@kernel
def summarise(p, dx, ds, starts, ends, total):
    """Area, peak and edges of a pressure field, better than by counting elements.

    Near its edge a pressure rises with the root of the distance, so p^2 extrapolated linearly from the two outermost
    elements of a row (at centres dx apart) vanishes at the edge, within the two elements' width. Writes per row the
    first and last edge, in elements from the first column's outer side (starts = ends = 0 in rows without contact),
    for the longest run of a row; total: area [m2], p0, sum of p dx ds, elements in contact, length [m].
    """
    columns = p.shape[1]
    area = 0.0
    peak = 0.0
    force = 0.0
    count = 0
    longest = 0.0
    for j in range(p.shape[0]):
        starts[j] = 0.0
        ends[j] = 0.0
        i = 0
        while i < columns:
            if p[j, i] <= 0.0:
                i += 1
                continue
            first = i
            while i < columns and p[j, i] > 0.0:
                force += p[j, i]
                peak = max(peak, p[j, i])
                i += 1
            last = i - 1
            count += i - first
            lo = first + 0.5 - _to_edge(p[j, first], p[j, min(first + 1, last)])
            hi = last + 0.5 + _to_edge(p[j, last], p[j, max(last - 1, first)])
            area += hi - lo
            if hi - lo > ends[j] - starts[j]:
                starts[j] = lo
                ends[j] = hi
        longest = max(longest, ends[j] - starts[j])
    total[0] = area * dx * ds
    total[1] = peak
    total[2] = force * dx * ds
    total[3] = count
    total[4] = longest * dx


@kernel
def _to_edge(outer, inner):
    """Distance from the outermost centre to the edge, in elements."""
    rise = inner * inner - outer * outer
    if rise <= 0.0:
        return 0.5
    return min(outer * outer / rise, 1.0)
