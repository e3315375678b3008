"""Integrals of a strip's influence over its width, from functions of one argument.

f(a, s) = int sqrt((a^2 - x^2)/(x^2 + s^2)) dx over -a..a is of degree one in (a, s). With t = z/a its primitives are

    int_0^z f ds = a^2 PHI(t),    int_0^z f/(a^2 + s^2) ds = PSI(t),    PHI' = f(1, t),    PSI' = f(1, t)/(1 + t^2),

so a strip of any width, near or far, acts on a centre by differences of two values. `wrsim.contact.tables`
makes the table: every octave of t from 2^LOWEST to 2^HIGHEST is cut into 2^CUTS equal pieces, and a row holds the
cubics of PHI and PSI over a piece. Number and place in a piece stand in the bits of t: no logarithm, no branch, so that
the compiler takes several strips at once. Below the first piece t counts as its start, beyond the last as its end.

Beside the middle of a strip, at a shift x along it, f(a, x, s) = int sqrt((a^2 - t^2)/((x - t)^2 + s^2)) dt is f(a, s)
times

    sqrt(1 - y) (1 - y^2 (h0 + h1 y + h2 y^2 + h3 y^3)),    y = x^2/(a^2 + s^2 + x^2),

right to second order in x, because f_xx = -f/(a^2 + s^2) at x = 0, and far away, where it is 1/sqrt(x^2 + s^2). The h
are a^2/(a^2 + s^2) times cubics of s/sqrt(a^2 + s^2), ``BESIDE``, fitted to the integral and its first two derivatives
by x where x < 2.5 s (`campaigns/fit_shifted_influence.py` says how well). It is taken at the middle of the strip's
width.
"""

from math import sqrt

from wrsim.core.contact.strips.records import CURVE, FROM, INVERSE, MIDDLE, PUSH, TO
from wrsim.core.jit.arena import bits_of, number_of
from wrsim.core.jit.compiling import filling, inlined, summing

LOWEST, HIGHEST, CUTS = -36, 16, 6
PIECES = (HIGHEST - LOWEST) << CUTS
_SHIFT = 52 - CUTS  # bits of a double behind those that tell the piece
_FIRST = (1023 + LOWEST) << CUTS
_WITHIN = (1 << _SHIFT) - 1
_ONE = 1023 << 52
_EXPONENT = 2047 << 52
_LARGEST = 2046 << 52
_IN_AN_OCTAVE = 2.0**CUTS
BESIDE = (
    0.5553, 0.6855, -2.798, 2.0103, -1.2314, -3.1771, 18.5809, -14.7952, 13.0952, -17.4642, -20.4168, 25.5769,
    -11.8144, 13.1485, 20.1382, -21.6244,
)  # fmt: skip
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


@inlined
def _bent(t, inverse):
    """The four polynomials of ``BESIDE`` at abs(s)/a = t; inverse: 1/(1 + t^2)."""
    w = t * sqrt(inverse)
    c = BESIDE
    return (
        inverse * (c[0] + w * (c[1] + w * (c[2] + w * c[3]))),
        inverse * (c[4] + w * (c[5] + w * (c[6] + w * c[7]))),
        inverse * (c[8] + w * (c[9] + w * (c[10] + w * c[11]))),
        inverse * (c[12] + w * (c[13] + w * (c[14] + w * c[15]))),
    )


@inlined
def _beside(middle, inverse, x):
    """Of a strip whose middle lies so far away, and so far along x (both over a): y and z = 1 - y, the polynomial p and
    its derivative there, its four coefficients; inverse: 1/(1 + middle^2)."""
    m = 1.0 + middle * middle
    b0, b1, b2, b3 = _bent(abs(middle), inverse)
    z = m / (m + x * x)
    y = 1.0 - z
    p = 1.0 - y * y * (b0 + y * (b1 + y * (b2 + y * b3)))
    p_y = -y * (2.0 * b0 + y * (3.0 * b1 + y * (4.0 * b2 + y * 5.0 * b3)))
    return y, z, p, p_y, b0, b1, b2, b3


@summing
def pressed_beside(table, vectors, first, last, s, x):
    """As ``pressed_by`` at (x, s), from strips whose middles lie apart along x."""
    u = c = 0.0
    for j in range(first, last):
        inverse_a = vectors[INVERSE, j]
        lo, hi = (vectors[FROM, j] - s) * inverse_a, (vectors[TO, j] - s) * inverse_a
        p0, c0 = primitives(table, abs(lo))
        p1, c1 = primitives(table, abs(hi))
        p0, c0 = (-p0, -c0) if lo < 0.0 else (p0, c0)
        p1, c1 = (-p1, -c1) if hi < 0.0 else (p1, c1)
        middle, xx = 0.5 * (lo + hi), (x - vectors[MIDDLE, j]) * inverse_a
        y, z, p, p_y, b0, b1, b2, b3 = _beside(middle, 1.0 / (1.0 + middle * middle), xx)
        p_yy = -(2.0 * b0 + y * (6.0 * b1 + y * (12.0 * b2 + y * 20.0 * b3)))
        g = 2.0 * z * p_y - p
        g_y = 2.0 * z * p_yy - 3.0 * p_y
        root = sqrt(z)
        curve = vectors[CURVE, j] * (c1 - c0) * z * root
        u += vectors[PUSH, j] * (p1 - p0) * root * p
        c -= curve * (g * (1.0 - 3.0 * y) + 2.0 * y * z * g_y)
    return u, c


@filling
def put_beside(begin, end, inverse, place, first, last, s, x, u, c, du, dc, f0, f1, g0, g1, t, cx):
    """Take what ``find_terms`` has written to (x, s); place: middles of the strips along x.

    Written besides: how displacement, over a^2, and c change with x/a. How the polynomials change with a is left out.
    """
    for j in range(first, last):
        middle, xx = (0.5 * (begin[j] + end[j]) - s) * inverse[j], (x - place[j]) * inverse[j]
        i = 1.0 / (1.0 + middle * middle)
        y, z, p, p_y, b0, b1, b2, b3 = _beside(middle, i, xx)
        p_yy = -(2.0 * b0 + y * (6.0 * b1 + y * (12.0 * b2 + y * 20.0 * b3)))
        p_yyy = -(6.0 * b1 + y * (24.0 * b2 + y * 60.0 * b3))
        g = 2.0 * z * p_y - p
        g_y = 2.0 * z * p_yy - 3.0 * p_y
        g_yy = 2.0 * z * p_yyy - 5.0 * p_yy
        w = g * (1.0 - 3.0 * y) + 2.0 * y * z * g_y
        w_y = g_y * (3.0 - 7.0 * y) - 3.0 * g + 2.0 * y * z * g_yy
        root = sqrt(z)
        by_u, by_c, by_c_y = root * p, -z * root * w, -root * (z * w_y - 1.5 * w)
        less = i * y
        du[j] = du[j] * by_u + less * root * g * u[j]
        t[j] = xx * c[j] * z * root * g
        cx[j] = c[j] * by_c_y * 2.0 * xx * z * z * i
        dc[j] = dc[j] * by_c + 2.0 * less * z * by_c_y * c[j]
        u[j] *= by_u
        c[j] *= by_c
        f0[j], f1[j], g0[j], g1[j] = f0[j] * by_u, f1[j] * by_u, g0[j] * by_c, g1[j] * by_c


@filling
def put_presses_beside(begin, end, inverse, place, first, last, s, x, u, du):
    """Of ``put_beside`` what is due to PHI alone."""
    for j in range(first, last):
        middle, xx = (0.5 * (begin[j] + end[j]) - s) * inverse[j], (x - place[j]) * inverse[j]
        i = 1.0 / (1.0 + middle * middle)
        y, z, p, p_y, _b0, _b1, _b2, _b3 = _beside(middle, i, xx)
        root = sqrt(z)
        du[j] = du[j] * root * p + i * y * root * (2.0 * z * p_y - p) * u[j]
        u[j] *= root * p
