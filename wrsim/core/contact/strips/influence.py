"""Integrals of a strip's influence over its width, from functions of one argument.

f(a, s) = int sqrt((a^2 - x^2)/(x^2 + s^2)) dx over -a..a is of degree one in (a, s). With t = z/a its primitives are

    int_0^z f ds = a^2 PHI(t),    int_0^z f/(a^2 + s^2) ds = PSI(t),    PHI' = f(1, t),    PSI' = f(1, t)/(1 + t^2),

so a strip of any width, near or far, acts on a centre by differences of two values. `wrsim.contact.strip_influence`
makes the table: rows at equal steps of t/(1 + t) with PHI, PSI and their slopes over a row, for cubic Hermite
interpolation; behind them coefficients for small t (series in t^2 and t^2 ln t) and for large t (asymptotes).
"""

from math import log, pi

from wrsim.core.compiling import inlined

NODES = 1024
SMALL, LARGE = 0.1, 30.0
PHI_SERIES, PSI_SERIES, F_SERIES, FAR = NODES + 1, NODES + 3, NODES + 5, NODES + 7
TABLE_ROWS = NODES + 8


@inlined
def _series(table, first, q, ln):
    """The smooth part in powers of q and what goes with the logarithm."""
    return (
        table[first, 0]
        + q * (table[first, 1] + q * (table[first, 2] + q * table[first, 3]))
        + ln * (table[first + 1, 0] + q * (table[first + 1, 1] + q * (table[first + 1, 2] + q * table[first + 1, 3])))
    )


@inlined
def primitives(table, t):
    """PHI(t) and PSI(t), t >= 0."""
    if t < SMALL:
        if t < 1e-12:
            return 0.0, 0.0
        q, ln = t * t, log(t)
        return t * _series(table, PHI_SERIES, q, ln), t * _series(table, PSI_SERIES, q, ln)
    if t > LARGE:
        inverse = 1.0 / (t * t)
        return table[FAR, 0] + 0.5 * pi * (log(t) + 0.0625 * inverse), table[FAR, 1] - 0.25 * pi * inverse * (
            1.0 - 0.5625 * inverse
        )
    x = NODES * (t / (1.0 + t))
    i = int(x)
    r = x - i
    r2 = r * r
    r3 = r2 * r
    h01 = 3.0 * r2 - 2.0 * r3
    h10 = r3 - 2.0 * r2 + r
    h11 = r3 - r2
    return (
        table[i, 0] + h01 * (table[i + 1, 0] - table[i, 0]) + h10 * table[i, 1] + h11 * table[i + 1, 1],
        table[i, 2] + h01 * (table[i + 1, 2] - table[i, 2]) + h10 * table[i, 3] + h11 * table[i + 1, 3],
    )


@inlined
def potential(table, t):
    """f(1, t)."""
    if t < SMALL:
        return _series(table, F_SERIES, t * t, log(max(t, 1e-12)))
    if t > LARGE:
        return 0.5 * pi / t * (1.0 - 0.125 / (t * t))
    x = NODES * (t / (1.0 + t))
    i = int(x)
    r = x - i
    r2 = r * r
    d01 = 6.0 * (r - r2)
    slope = d01 * (table[i + 1, 0] - table[i, 0])
    slope += (3.0 * r2 - 4.0 * r + 1.0) * table[i, 1] + (3.0 * r2 - 2.0 * r) * table[i + 1, 1]
    return slope * NODES / ((1.0 + t) * (1.0 + t))
