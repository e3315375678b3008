"""FASTSIM on strips (Kalker 1982), with the creepage and the spin of each strip.

In the simplified theory a surface point yields in proportion to the traction on it, with one flexibility each for
longitudinal creepage, lateral creepage and spin,

    L1 = 8 a / (3 C11 G),   L2 = 8 a / (3 C22 G),   L3 = pi a sqrt(a/b) / (4 C23 G),

chosen so that small creepages give Kalker's linear forces on the ellipse of semi-axes a, b. Every strip is followed
from its leading edge; where the traction would exceed the bound it slides. Creepages come per strip (they already
contain the spin's share y phi); their mean over the patch works through L1 and L2, the deviation from it through L3,
which on a flat patch with constant spin is Kalker's original.

Bound: mu times the pressure, a semi-ellipse along the strip ("elliptic"), or the parabola of the same force
("parabolic"). Kalker's own bound is one paraboloid over the whole ellipse, which takes the strips' forces from
the edges to the middle; here every strip keeps its mu N, because friction is a matter of the place.
"""

from math import pi, sqrt

from wrsim.core.compiling import inlined, kernel
from wrsim.core.contact.layout import DS, ETA, FORCE, FX, FY, MU, MZ, PHI, XI, A

PARABOLA_PEAK = 0.375 * pi  # of the parabola over that of the semi-ellipse of equal force


@kernel
def kalker_coefficients(creep, aspect):
    """C11, C22, C23 for a patch of aspect a/b.

    creep: (20, 3) rows at min(a/b, b/a) = .1 ... 1, first a < b, then a > b in the same order. Beyond 0.1 the
    coefficients go on with their asymptotic powers.
    """
    wide = aspect <= 1.0
    g = aspect if wide else 1.0 / aspect
    offset = 0 if wide else 10
    x = min(max(10.0 * g - 1.0, 0.0), 9.0)
    i = min(int(x), 8)
    r = x - i
    c11 = creep[offset + i, 0] + r * (creep[offset + i + 1, 0] - creep[offset + i, 0])
    c22 = creep[offset + i, 1] + r * (creep[offset + i + 1, 1] - creep[offset + i, 1])
    c23 = creep[offset + i, 2] + r * (creep[offset + i + 1, 2] - creep[offset + i, 2])
    if g < 0.1:
        slender = 0.1 / max(g, 1e-6)
        if wide:
            c23 /= sqrt(slender)
        else:
            c11 *= slender
            c22 *= slender
            c23 *= slender * sqrt(slender)
    return c11, c22, c23


@kernel
def flexibilities(creep, aspect, area, shear_modulus):
    """L1, L2, L3 [m/Pa] for the ellipse of the given area [m2] and aspect a/b."""
    a = sqrt(area * aspect / pi)
    c11, c22, c23 = kalker_coefficients(creep, aspect)
    return (
        8.0 * a / (3.0 * c11 * shear_modulus),
        8.0 * a / (3.0 * c22 * shear_modulus),
        pi * a * sqrt(aspect) / (4.0 * c23 * shear_modulus),
    )


@kernel
def blended(l1, l2, l3, a, aspect, xi, eta, phi, limit):
    """L1, L2, L3 at small creepages, Kalker's one flexibility for all at large ones.

    With three of them full sliding is not opposite to the slip: tractions follow (xi / L1, eta / L2). With one,

        L = sqrt((xi L1)^2 + (eta L2)^2 + (phi c L3)^2) / sqrt(xi^2 + eta^2 + (phi c)^2),   c = sqrt(ab),

    they are, but small creepages together do not meet the linear theory. In between by u, the size of the linear
    force over mu N: smoothly from the three at u = 1 to the one at u = 6.
    a, aspect: of the equivalent ellipse; xi, eta, phi: mean creepages; limit: mu N [N].
    """
    turn = phi * a / sqrt(aspect)
    along = xi / l1
    across = eta / l2
    spin = 0.09375 * pi * sqrt(aspect) * turn / l3  # C23 G phi c over 8 a / 3
    linear = 8.0 / 3.0 * a * a * a / aspect * sqrt(along * along + across * across + spin * spin)
    part = min(max((linear - limit) / (5.0 * max(limit, 1e-300)), 0.0), 1.0)
    if part == 0.0:
        return l1, l2, l3
    part *= part * (3.0 - 2.0 * part)
    sizes = (xi * l1) ** 2 + (eta * l2) ** 2 + (turn * l3) ** 2
    one = sqrt(sizes / (xi * xi + eta * eta + turn * turn))
    return l1 + part * (one - l1), l2 + part * (one - l2), l3 + part * (one - l3)


@inlined
def largest_traction(row):
    """Peak of the semi-ellipse along a strip that holds its mu N [Pa]: mu p where the pressure is one itself."""
    return 2.0 * row[MU] * row[FORCE] / (pi * max(row[A] * row[DS], 1e-300))


@kernel
def fastsim(strips, n, peak, xi0, eta0, l1, l2, l3, direction, shape, work):
    """Tangential tractions of n strips.

    peak: of the bound over that of the semi-ellipse of equal force, 1 for the elliptic bound, PARABOLA_PEAK for the
    parabolic one; xi0, eta0: mean creepages; direction: +1 rolling along +x, -1 backwards; shape: (cells,) means of
    sqrt(1 - X^2), or of 1 - X^2 for the parabola, over each cell, X = x / x_L from the leading edge on (means, so that
    full sliding gives mu N exactly); work: (9, >= n) scratch. Reads A, DS, FORCE, MU, XI, ETA, PHI of each strip
    (creepages of the wheel against the rail) and writes FX, FY, MZ: forces on the wheel [N] and their moment about the
    strip's centre [N m].
    """
    cells = shape.shape[0]
    step_x = work[0]
    step_y = work[1]
    turn = work[2]
    bound = work[3]
    qx = work[4]
    qy = work[5]
    dx = 2.0 / cells
    for i in range(n):
        a = strips[i, A]
        step_x[i] = -(xi0 / l1 + (strips[i, XI] - xi0) / l3) * a * dx
        step_y[i] = -(eta0 / l2 + (strips[i, ETA] - eta0) / l3) * a * dx
        turn[i] = -direction * strips[i, PHI] / l3 * a * a * dx
        bound[i] = peak * largest_traction(strips[i])
        qx[i] = 0.0
        qy[i] = 0.0
        strips[i, FX] = 0.0
        strips[i, FY] = 0.0
        strips[i, MZ] = 0.0
    fx = work[6]
    fy = work[7]
    mz = work[8]
    for i in range(n):
        fx[i] = 0.0
        fy[i] = 0.0
        mz[i] = 0.0
    for j in range(cells):
        x = 1.0 - (j + 0.5) * dx
        # from centre to centre of the cells, from the edge to the first centre
        part = 1.0 if j > 0 else 0.5
        middle = x + 0.5 * part * dx
        for i in range(n):
            tx = qx[i] + part * step_x[i]
            ty = qy[i] + part * (step_y[i] + middle * turn[i])
            limit = bound[i] * shape[j]
            size2 = tx * tx + ty * ty
            scale = limit / sqrt(max(size2, 1e-300))
            scale = min(scale, 1.0)
            tx *= scale
            ty *= scale
            qx[i] = tx
            qy[i] = ty
            fx[i] += tx
            fy[i] += ty
            mz[i] += x * ty
    for i in range(n):
        a = strips[i, A]
        cell = dx * a * strips[i, DS]
        strips[i, FX] = fx[i] * cell
        strips[i, FY] = fy[i] * cell
        strips[i, MZ] = direction * mz[i] * cell * a
    hold_power(strips, n)


@kernel
def hold_power(strips, n):
    """Moments as near to the ones given as keeps the creep's power over all strips from being positive.

    C22 makes the moment of eta, C23 the lateral force of phi. In slender patches (a/b above some 10) with next to no
    slip the two differ so much that, with hardly anything else to dissipate, their powers would not cancel.
    """
    power = 0.0
    spins = 0.0
    for i in range(n):
        phi = strips[i, PHI]
        power += strips[i, FX] * strips[i, XI] + strips[i, FY] * strips[i, ETA] + strips[i, MZ] * phi
        spins += phi * phi
    if power > 0.0 and spins > 0.0:
        for i in range(n):
            strips[i, MZ] -= power * strips[i, PHI] / spins
