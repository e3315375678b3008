"""Influence of strips on each other: displacement and curvature at a strip's centre, with their derivatives.

f(a, s) = int sqrt((a^2 - x^2)/(x^2 + s^2)) dx over -a..a. It is of degree one in (a, s), so with fa = df/d(ln a)
follow s f_s = f - fa and f_ss = f/(a^2 + s^2) - (f - fa)/s^2: integrals over a strip's width need no more than f and
fa at its middle, besides the logarithm that f has at s = 0.
"""

from math import log, sqrt

from wrsim.core.compiling import inlined, kernel
from wrsim.core.contact.strips.records import touching

NEAR = 4  # neighbours over which the bend of f counts
# Gauss-Legendre on 0..1
NODES = (0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970262)
WEIGHTS = (0.17392742256872692, 0.32607257743127307, 0.32607257743127307, 0.17392742256872692)


@inlined
def potentials(a, s):
    """f(a, s) and its derivative with respect to ln a.

    f = 2 p (K - E), fa = 2 a^2 K / p, p^2 = a^2 + s^2, with the polynomials for the complete elliptic integrals K and
    E of Abramowitz and Stegun 17.3.34 and 17.3.36 (errors below 2e-8).
    """
    square = a * a + s * s
    p = sqrt(square)
    m = s * s / square
    ln = -log(max(m, 1e-30))
    k = (
        1.38629436112
        + m * (0.09666344259 + m * (0.03590092383 + m * (0.03742563713 + m * 0.01451196212)))
        + ln * (0.5 + m * (0.12498593597 + m * (0.06880248576 + m * (0.03328355346 + m * 0.00441787012))))
    )
    e = (
        1.0
        + m * (0.44325141463 + m * (0.06260601220 + m * (0.04757383546 + m * 0.01736506451)))
        + ln * m * (0.24998368310 + m * (0.09200180037 + m * (0.04069697526 + m * 0.00526449639)))
    )
    return 2.0 * p * (k - e), 2.0 * a * a * k / p


@kernel
def over_strip(a, s, w):
    """Integrals over s - w/2 .. s + w/2, s >= w: of f and f/(a^2 + s^2), and their derivatives by ln a."""
    f, fa = potentials(a, s)
    a2 = a * a
    s2 = s * s
    r2 = 1.0 / (a2 + s2)
    # the part that goes with the logarithm is integrated exactly, the rest to second order
    share = a2 * r2
    hi, lo = s + 0.5 * w, s - 0.5 * w
    bend = w * w * w / 24.0
    logarithm = hi * (log(hi) - 1.0) - lo * (log(lo) - 1.0) - w * log(s) + bend / s2
    f_s = (f - fa) / s
    f_ss = f * r2 - f_s / s
    g_ss = f_ss * r2 - 4.0 * s * f_s * r2 * r2 - 2.0 * f * r2 * r2 + 8.0 * s2 * f * r2 * r2 * r2
    u = w * f + bend * f_ss - 2.0 * a * share * logarithm
    c = w * f * r2 + bend * g_ss - 2.0 / a * share * logarithm
    ua = w * fa - 2.0 * a * share * logarithm
    ca = w * (fa - 2.0 * a2 * f * r2) * r2 + 2.0 / a * share * logarithm
    return u, c, ua, ca


@kernel
def own(a, w):
    """The same integrals over the strip itself, s = 0 in its middle, for any a/w."""
    half = 0.5 * w
    inner = min(half, a)
    a2 = a * a
    u = c = ua = ca = 0.0
    # near the middle, the logarithm exactly and the smooth rest by Gauss
    for i in range(4):
        s = inner * NODES[i]
        weight = 2.0 * inner * WEIGHTS[i]
        f, fa = potentials(a, s)
        r2 = 1.0 / (a2 + s * s)
        ln = log(s / a)
        u += weight * (f + 2.0 * a * ln)
        ua += weight * (fa + 2.0 * a * ln)
        c += weight * (f * r2 + 2.0 / a * ln)
        ca += weight * ((fa - 2.0 * a2 * f * r2) * r2 - 2.0 / a * ln)
    integral = 2.0 * inner * (log(inner / a) - 1.0)
    u -= 2.0 * a * integral
    ua -= 2.0 * a * integral
    c -= 2.0 / a * integral
    ca += 2.0 / a * integral
    if half > inner:
        # beyond s = a, by Gauss in ln s
        stretch = log(half / inner)
        for i in range(4):
            s = inner * (half / inner) ** NODES[i]
            weight = 2.0 * stretch * WEIGHTS[i] * s
            f, fa = potentials(a, s)
            r2 = 1.0 / (a2 + s * s)
            u += weight * f
            ua += weight * fa
            c += weight * f * r2
            ca += weight * (fa - 2.0 * a2 * f * r2) * r2
    return u, c, ua, ca


@inlined
def _from_afar(a, s, w):
    """The same integrals where f hardly bends over the strip."""
    f, fa = potentials(a, s)
    r2 = 1.0 / (a * a + s * s)
    return w * f, w * f * r2, w * fa, w * (fa - 2.0 * a * a * f * r2) * r2


@inlined
def _write(state, i, j, factor, integrals):
    """The influence of the j-th strip in contact on the i-th."""
    u, c, ua, ca = integrals
    state.u[i, j], state.c[i, j], state.du[i, j], state.dc[i, j] = factor * u, factor * c, factor * ua, factor * ca


@inlined
def _facing(one, other):
    """Cosine of the angle between two normals, not negative."""
    return max(one.no * other.no + one.nb * other.nb, 0.0)


@inlined
def _distance(one, other):
    """Between two centres [m]."""
    return sqrt((one.o - other.o) ** 2 + (one.b - other.b) ** 2)


@kernel
def assemble(state, n, m):
    """Influence of strip j on the centre of strip i, for displacement and curvature, with derivatives by ln a_j.

    n: strips in contact; m: places. Within a lobe the strips stand at equal distances, so the two neighbours at the
    same distance share a value; strips of other lobes act over their straight distance, with the cosine of the angle
    between the normals.
    """
    places = state.places
    for k in range(m):
        places[k].slot = -1
    for i in range(n):
        touching(places, i).slot = i
    several = places[0].lobe != places[m - 1].lobe
    for j in range(n):
        source = touching(places, j)
        k, a, w = places[j].touching, source.a, source.ds
        _write(state, j, j, 1.0, own(a, w))
        for distance in range(1, m):
            up, down = k + distance, k - distance
            above = up < m and places[up].lobe == source.lobe
            below = down >= 0 and places[down].lobe == source.lobe
            if not above and not below:
                break
            upper = places[up].slot if above else -1
            lower = places[down].slot if below else -1
            if upper < 0 and lower < 0:
                continue
            integrals = over_strip(a, distance * w, w) if distance <= NEAR else _from_afar(a, distance * w, w)
            if upper >= 0:
                _write(state, upper, j, 1.0, integrals)
            if lower >= 0:
                _write(state, lower, j, 1.0, integrals)
        if not several:
            continue
        for i in range(n):
            target = touching(places, i)
            if target.lobe == source.lobe:
                continue
            s = _distance(target, source)
            integrals = _from_afar(a, s, w) if s > NEAR * w else over_strip(a, max(s, 0.75 * w), w)
            _write(state, i, j, _facing(target, source), integrals)


@kernel
def displacement_at(places, k, n):
    """Displacement (times pi E*) that the strips in contact cause at place k, which is not one of them."""
    total = 0.0
    target = places[k]
    for j in range(n):
        source = touching(places, j)
        w = source.ds
        if source.lobe == target.lobe:
            facing = 1.0
            s = abs(k - places[j].touching) * w
        else:
            facing = _facing(target, source)
            s = max(_distance(target, source), 0.75 * w)
        if s > (NEAR + 0.5) * w:
            f, _fa = potentials(source.a, s)
            total += facing * source.q * w * f
        else:
            u, _c, _ua, _ca = over_strip(source.a, s, w)
            total += facing * source.q * u
    return total


@kernel
def displacement_beside(places, row, n):
    """Displacement (times pi E*) that the strips in contact cause at a row of the table, which is none of them."""
    total = 0.0
    for j in range(n):
        source = touching(places, j)
        f, _fa = potentials(source.a, max(_distance(source, row), 0.5 * source.ds))
        total += _facing(source, row) * source.q * source.ds * f
    return total
