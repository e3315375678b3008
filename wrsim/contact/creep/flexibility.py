"""Flexibilities of the simplified theory on the equivalent ellipse, from Kalker's creep coefficients (creep-flex)."""

from math import log, pi, sqrt
from typing import NamedTuple

from wrsim.jit import Array, Records, inlined, kernel

ASPECTS, SLENDEREST = 601, 1e-3  # rows of the table of creep coefficients, 100 a decade of a/b; a/b of the first one


class Creepages(NamedTuple):
    """Longitudinal and lateral creepage [1], spin [1/m]."""

    xi: float
    eta: float
    phi: float


class Ellipse(NamedTuple):
    """Half length a along the rail and half width b [m], and their ratio a/b."""

    a: float
    b: float
    aspect: float


class Coefficients(NamedTuple):
    """Kalker's creep coefficients."""

    c11: float
    c22: float
    c23: float


class Flexibilities(NamedTuple):
    """Displacement over traction for longitudinal creepage, lateral creepage and spin [m/Pa]."""

    l1: float
    l2: float
    l3: float


class Rolling(NamedTuple):
    """What the models of creep forces compute with.

    strips: records STRIP, the first n of them; soft: flexibilities of the equivalent ellipse; direction: +1 rolling
    along +x, -1 backwards; shape: (cells,) means over each cell of sqrt(1 - X^2), or of 1 - X^2 for the parabola, X = x
    / a from the leading edge on (means, so that full sliding gives mu N exactly); work: (12, >= n) scratch; slip:
    (cells, >= n), or no rows: tractions over their bound, 1 where they slide, 0 where strip theory lets them stick;
    traction: (2 cells, >= n), or no rows: along x, then across [Pa].
    They read a, ds, N, mu and the creepages xi, eta, phi of each strip, wheel against rail, and write Fx, Fy, Mz:
    forces on the wheel [N] and their moment about the strip's centre [N m].
    """

    strips: Records
    n: int
    soft: Flexibilities
    direction: float
    shape: Array
    work: Array
    slip: Array
    traction: Array


@inlined
def ellipse_of(area: float, aspect: float) -> Ellipse:
    """The ellipse of this area [m2] and aspect a/b."""
    a = sqrt(area * aspect / pi)
    return Ellipse(a, a / aspect, aspect)


@kernel
def kalker_coefficients(creep: Array, aspect: float) -> Coefficients:
    """C11, C22, C23 for a patch of aspect a/b, held between SLENDEREST and one over it. creep: (ASPECTS, 3) rows in
    equal steps of log(a/b) between the two, see `wrsim.contact.tables.creep_coefficients`."""
    held = min(max(aspect, SLENDEREST), 1.0 / SLENDEREST)
    place = 0.5 * (ASPECTS - 1) * (1.0 - log(held) / log(SLENDEREST))
    i = max(min(int(place), ASPECTS - 2), 0)
    r = place - i
    return Coefficients(
        creep[i, 0] + r * (creep[i + 1, 0] - creep[i, 0]),
        creep[i, 1] + r * (creep[i + 1, 1] - creep[i, 1]),
        creep[i, 2] + r * (creep[i + 1, 2] - creep[i, 2]),
    )


@kernel
def flexibilities(creep: Array, ellipse: Ellipse, shear_modulus: float) -> Flexibilities:
    """L1, L2, L3 on an ellipse (creep-flex)."""
    c = kalker_coefficients(creep, ellipse.aspect)
    return Flexibilities(
        8.0 * ellipse.a / (3.0 * c.c11 * shear_modulus),
        8.0 * ellipse.a / (3.0 * c.c22 * shear_modulus),
        pi * ellipse.a * sqrt(ellipse.aspect) / (4.0 * c.c23 * shear_modulus),
    )
