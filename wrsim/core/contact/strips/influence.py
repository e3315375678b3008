"""Integrals of a strip's influence over its width, from functions of one argument.

f(a, s) = int sqrt((a^2 - x^2)/(x^2 + s^2)) dx over -a..a is of degree one in (a, s). With t = z/a its primitives are

    int_0^z f ds = a^2 PHI(t),    int_0^z f/(a^2 + s^2) ds = PSI(t),    PHI' = f(1, t),    PSI' = f(1, t)/(1 + t^2),

so a strip of any width, near or far, acts on a centre by differences of two values. `wrsim.contact.strip_influence`
makes the table: every octave of t from 2^LOWEST to 2^HIGHEST is cut into 2^CUTS equal pieces, and a row holds the
cubics of PHI and PSI over a piece. Number and place in a piece stand in the bits of t: no logarithm, no branch, so that
the compiler takes several strips at once. Below the first piece t counts as its start, beyond the last as its end.
"""

from wrsim.core.bits import bits_of, number_of
from wrsim.core.compiling import filling, inlined, summing
from wrsim.core.contact.strips.records import CURVE, FROM, INVERSE, PUSH, TO

LOWEST, HIGHEST, CUTS = -36, 16, 6
PIECES = (HIGHEST - LOWEST) << CUTS
_SHIFT = 52 - CUTS  # bits of a double behind those that tell the piece
_FIRST = (1023 + LOWEST) << CUTS
_WITHIN = (1 << _SHIFT) - 1
_ONE = 1023 << 52
_EXPONENT = 2047 << 52
_LARGEST = 2046 << 52
_IN_AN_OCTAVE = 2.0**CUTS
_START, _END = 2.0**LOWEST, 2.0**HIGHEST * (1.0 - 2.0**-20)


@inlined
def _piece(t):
    """Number of the piece that holds t, and the place in it, 0 to 1."""
    bits = bits_of(min(_END, max(_START, t)))
    return (bits >> _SHIFT) - _FIRST, number_of((bits & _WITHIN) << CUTS | _ONE) - 1.0


@inlined
def primitives(table, t):
    """PHI(t) and PSI(t), t >= 0."""
    i, z = _piece(t)
    return (
        table[i, 0] + z * (table[i, 1] + z * (table[i, 2] + z * table[i, 3])),
        table[i, 4] + z * (table[i, 5] + z * (table[i, 6] + z * table[i, 7])),
    )


@inlined
def potential(table, t):
    """f(1, t)."""
    i, z = _piece(t)
    # pieces in a unit of t
    per_piece = number_of(_LARGEST - (bits_of(max(_START, t)) & _EXPONENT)) * _IN_AN_OCTAVE
    return (table[i, 1] + z * (2.0 * table[i, 2] + z * (3.0 * table[i, 3]))) * per_piece


@summing
def pressed_by(table, vectors, first, last, s):
    """Displacement at s and its curvature, both times pi E*, under strips that follow each other."""
    u = c = 0.0
    for j in range(first, last):
        lo, hi = (vectors[FROM, j] - s) * vectors[INVERSE, j], (vectors[TO, j] - s) * vectors[INVERSE, j]
        p0, c0 = primitives(table, abs(lo))
        p1, c1 = primitives(table, abs(hi))
        p0, c0 = (-p0, -c0) if lo < 0.0 else (p0, c0)
        p1, c1 = (-p1, -c1) if hi < 0.0 else (p1, c1)
        u += vectors[PUSH, j] * (p1 - p0)
        c += vectors[CURVE, j] * (c1 - c0)
    return u, c


@filling
def find_presses(table, begin, end, inverse, first, last, s, u, du):
    """Of ``find_terms`` what is due to PHI alone."""
    for j in range(first, last):
        lo, hi = (begin[j] - s) * inverse[j], (end[j] - s) * inverse[j]
        t0, t1 = abs(lo), abs(hi)
        p0, _c0 = primitives(table, t0)
        p1, _c1 = primitives(table, t1)
        u[j] = (-p1 if hi < 0.0 else p1) - (-p0 if lo < 0.0 else p0)
        du[j] = hi * potential(table, t1) - lo * potential(table, t0)


@filling
def find_terms(table, begin, end, inverse, first, last, s, u, c, du, dc, f0, f1, g0, g1):
    """What the derivatives at s by strips that follow each other are made of, each (>= last,); begin, end, inverse:
    both ends and 1/a of the strips.

    Differences of PHI and of PSI; how they change with the logarithm of 1/a; f(1, t) at both ends, the same over
    1 + t^2.
    """
    for j in range(first, last):
        lo, hi = (begin[j] - s) * inverse[j], (end[j] - s) * inverse[j]
        t0, t1 = abs(lo), abs(hi)
        p0, c0 = primitives(table, t0)
        p1, c1 = primitives(table, t1)
        p0, c0 = (-p0, -c0) if lo < 0.0 else (p0, c0)
        p1, c1 = (-p1, -c1) if hi < 0.0 else (p1, c1)
        at_lo, at_hi = potential(table, t0), potential(table, t1)
        less_lo, less_hi = at_lo / (1.0 + t0 * t0), at_hi / (1.0 + t1 * t1)
        u[j], c[j] = p1 - p0, c1 - c0
        du[j], dc[j] = hi * at_hi - lo * at_lo, hi * less_hi - lo * less_lo
        f0[j], f1[j], g0[j], g1[j] = at_lo, at_hi, less_lo, less_hi
