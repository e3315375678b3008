"""FASTSIM on strips (Kalker 1982), with the creepage and the spin of each strip.

In the simplified theory a surface point yields in proportion to the traction on it, with one flexibility each for
longitudinal creepage, lateral creepage and spin,

    L1 = 8 a / (3 C11 G),   L2 = 8 a / (3 C22 G),   L3 = pi a sqrt(a/b) / (4 C23 G),

chosen so that small creepages give Kalker's linear forces on the ellipse of semi-axes a, b. Every strip is followed
from its leading edge; where the traction would exceed the bound it slides. Creepages come per strip (they already
contain the spin's share y phi).

With three flexibilities throughout (`fastsim`) the mean of the creepages over the patch works through L1 and L2, the
deviation from it through L3, which on a flat patch with constant spin is Kalker's original. With three where the
surfaces stick and one where they slide (`fastsim_blended`, see `march`) each strip's own creepages work through L1 and
L2, and L3 is left with the turning phi x. Small creepages give Kalker's forces either way.

Bound: mu times the pressure, a semi-ellipse along the strip ("elliptic"), or the parabola of the same force
("parabolic"). Kalker's own bound is one paraboloid over the whole ellipse, which takes the strips' forces from
the edges to the middle; here every strip keeps its mu N, because friction is a matter of the place.
"""

from math import pi, sqrt

from wrsim.core.contact.tangential.flexibility import Creepages, Flexibilities
from wrsim.core.contact.tangential.march import (
    BOUND,
    FX,
    FY,
    MZ,
    START_X,
    START_Y,
    STUCK,
    hold_power,
    largest_traction,
    march,
)
from wrsim.core.jit.arena import Array, Records
from wrsim.core.jit.compiling import kernel

PARABOLA_PEAK = 0.375 * pi  # of the parabola over that of the semi-ellipse of equal force


@kernel
def fastsim(
    strips: Records,
    n: int,
    peak: float,
    mean: Creepages,
    soft: Flexibilities,
    direction: float,
    shape: Array,
    work: Array,
) -> None:
    """Tangential tractions of n strips.

    peak: of the bound over that of the semi-ellipse of equal force, 1 for the elliptic bound, PARABOLA_PEAK for the
    parabolic one; mean, soft: mean creepages and flexibilities; direction: +1 rolling along +x, -1 backwards; shape:
    (cells,) means of sqrt(1 - X^2), or of 1 - X^2 for the parabola, over each cell, X = x / x_L from the leading edge
    on (means, so that full sliding gives mu N exactly); work: (9, >= n) scratch. Reads a, ds, N, mu, xi, eta, phi of
    each strip (creepages of the wheel against the rail) and writes Fx, Fy, Mz: forces on the wheel [N] and their moment
    about the strip's centre [N m].
    """
    cells = shape.shape[0]
    step_x, step_y, turn = work[0], work[1], work[2]
    bound = work[3]
    qx, qy = work[4], work[5]
    fx, fy, mz = work[6], work[7], work[8]
    dx = 2.0 / cells
    for i in range(n):
        strip = strips[i]
        a = strip.a
        step_x[i] = -(mean.xi / soft.l1 + (strip.xi - mean.xi) / soft.l3) * a * dx
        step_y[i] = -(mean.eta / soft.l2 + (strip.eta - mean.eta) / soft.l3) * a * dx
        turn[i] = -direction * strip.phi / soft.l3 * a * a * dx
        bound[i] = peak * largest_traction(strip)
        qx[i] = qy[i] = 0.0
        fx[i] = fy[i] = mz[i] = 0.0
    for j in range(cells):
        x = 1.0 - (j + 0.5) * dx
        # from centre to centre of the cells, from the edge to the first centre
        part = 1.0 if j > 0 else 0.5
        middle = x + 0.5 * part * dx
        for i in range(n):
            tx = qx[i] + part * step_x[i]
            ty = qy[i] + part * (step_y[i] + middle * turn[i])
            limit = bound[i] * shape[j]
            scale = min(limit / sqrt(max(tx * tx + ty * ty, 1e-300)), 1.0)
            tx *= scale
            ty *= scale
            qx[i] = tx
            qy[i] = ty
            fx[i] += tx
            fy[i] += ty
            mz[i] += x * ty
    for i in range(n):
        strip = strips[i]
        cell = dx * strip.a * strip.ds
        strip.Fx = fx[i] * cell
        strip.Fy = fy[i] * cell
        strip.Mz = direction * mz[i] * cell * strip.a
    hold_power(strips, n)


@kernel
def fastsim_blended(
    strips: Records, n: int, peak: float, soft: Flexibilities, direction: float, shape: Array, work: Array
) -> None:
    """The same with three flexibilities where the surfaces stick and one where they slide.

    Arguments as in `fastsim`; work: (12, >= n) scratch.
    """
    bound, start_x, start_y, stuck = work[BOUND], work[START_X], work[START_Y], work[STUCK]
    fx, fy, mz = work[FX], work[FY], work[MZ]
    for i in range(n):
        bound[i] = peak * largest_traction(strips[i])
        start_x[i] = start_y[i] = 0.0
        stuck[i] = 1.0
        fx[i] = fy[i] = mz[i] = 0.0
    march(strips, n, soft, 0.0, direction, shape, work)
