"""Influence of strips on each other: displacement and curvature at a strip's centre, with their derivatives.

f(a, s) = int sqrt((a^2 - x^2)/(x^2 + s^2)) dx over -a..a. It is of degree one in (a, s), so with fa = df/d(ln a)
follow s f_s = f - fa and f_ss = f/(a^2 + s^2) - (f - fa)/s^2: integrals over a strip's width need no more than f and
fa at its middle, besides the logarithm that f has at s = 0.
"""

from math import log, sqrt

from wrsim.core.compiling import inlined, kernel
from wrsim.core.contact.strips.layout import (
    A_,
    A_MATRIX,
    B_,
    B_MATRIX,
    DA_MATRIX,
    DB_MATRIX,
    LOBE,
    NB_,
    NO_,
    O_,
    Q_,
    SLOT,
    WIDTH_,
)

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


@kernel
def assemble(v, index, n, m, matrices):
    """Influence of strip j on the centre of strip i, for displacement and curvature, with derivatives by ln a_j.

    index (n,): places of the strips in contact; m: places. Within a lobe the strips stand at equal distances, so the
    two neighbours at the same distance share a value; strips of other lobes act over their straight distance, with
    the cosine of the angle between the normals.
    """
    am, bm, da, db = matrices[A_MATRIX], matrices[B_MATRIX], matrices[DA_MATRIX], matrices[DB_MATRIX]
    slot = v[SLOT]
    for k in range(m):
        slot[k] = -1.0
    for i in range(n):
        slot[int(index[i])] = i
    several = v[LOBE, 0] != v[LOBE, m - 1]
    for j in range(n):
        kj = int(index[j])
        a, w, lobe = v[A_, kj], v[WIDTH_, kj], v[LOBE, kj]
        a2 = a * a
        am[j, j], bm[j, j], da[j, j], db[j, j] = own(a, w)
        for distance in range(1, m):
            up, down = kj + distance, kj - distance
            above = up < m and v[LOBE, up] == lobe
            below = down >= 0 and v[LOBE, down] == lobe
            if not above and not below:
                break
            iu = int(slot[up]) if above else -1
            il = int(slot[down]) if below else -1
            if iu < 0 and il < 0:
                continue
            s = distance * w
            if distance <= NEAR:
                u, c, ua, ca = over_strip(a, s, w)
            else:
                f, fa = potentials(a, s)
                r2 = 1.0 / (a2 + s * s)
                u, c, ua, ca = w * f, w * f * r2, w * fa, w * (fa - 2.0 * a2 * f * r2) * r2
            if iu >= 0:
                am[iu, j], da[iu, j], bm[iu, j], db[iu, j] = u, ua, c, ca
            if il >= 0:
                am[il, j], da[il, j], bm[il, j], db[il, j] = u, ua, c, ca
        if not several:
            continue
        for i in range(n):
            ki = int(index[i])
            if v[LOBE, ki] == lobe:
                continue
            facing = max(v[NO_, ki] * v[NO_, kj] + v[NB_, ki] * v[NB_, kj], 0.0)
            s = sqrt((v[O_, ki] - v[O_, kj]) ** 2 + (v[B_, ki] - v[B_, kj]) ** 2)
            if s > NEAR * w:
                f, fa = potentials(a, s)
                r2 = 1.0 / (a2 + s * s)
                u, c, ua, ca = w * f, w * f * r2, w * fa, w * (fa - 2.0 * a2 * f * r2) * r2
            else:
                u, c, ua, ca = over_strip(a, max(s, 0.75 * w), w)
            am[i, j], da[i, j], bm[i, j], db[i, j] = facing * u, facing * ua, facing * c, facing * ca


@kernel
def displacement_at(v, k, index, n):
    """Displacement (times pi E*) that the strips in contact cause at place k, which is not one of them."""
    total = 0.0
    for j in range(n):
        kj = int(index[j])
        a, w = v[A_, kj], v[WIDTH_, kj]
        if v[LOBE, kj] == v[LOBE, k]:
            facing = 1.0
            s = abs(k - kj) * w
        else:
            facing = max(v[NO_, k] * v[NO_, kj] + v[NB_, k] * v[NB_, kj], 0.0)
            s = max(sqrt((v[O_, k] - v[O_, kj]) ** 2 + (v[B_, k] - v[B_, kj]) ** 2), 0.75 * w)
        if s > (NEAR + 0.5) * w:
            f, _fa = potentials(a, s)
            total += facing * v[Q_, kj] * w * f
        else:
            u, _c, _ua, _ca = over_strip(a, s, w)
            total += facing * v[Q_, kj] * u
    return total


@kernel
def displacement_beside(v, o, b, no, nb, index, n):
    """Displacement (times pi E*) that the strips in contact cause at a point (o, b) with normal (no, nb) off them."""
    total = 0.0
    for j in range(n):
        k = int(index[j])
        facing = max(v[NO_, k] * no + v[NB_, k] * nb, 0.0)
        s = max(sqrt((v[O_, k] - o) ** 2 + (v[B_, k] - b) ** 2), 0.5 * v[WIDTH_, k])
        f, _fa = potentials(v[A_, k], s)
        total += facing * v[Q_, k] * v[WIDTH_, k] * f
    return total
