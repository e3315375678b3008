"""Creep forces of one lobe: its equivalent ellipse, its mean creepages, the model of the user's choice."""

from math import pi, sqrt

from wrsim.core.compiling import kernel
from wrsim.core.contact.layout import (
    ADHESION_FACTOR,
    AMPLITUDE,
    AREA,
    BLENDED,
    COUPLING,
    ETA,
    FASTRIP,
    FASTSIM,
    FORCE,
    FX,
    FY,
    LENGTH,
    MU,
    MZ,
    N_STRIPS,
    PARABOLIC,
    PARTNER,
    PHI,
    POLACH,
    SHEAR_MODULUS,
    SHEN_HEDRICK_ELKINS,
    SLIP_FACTOR,
    TANGENTIAL,
    WIDTH,
    XI,
    N,
)
from wrsim.core.contact.tangential.fastrip import fastrip
from wrsim.core.contact.tangential.fastsim import PARABOLA_PEAK, blended, fastsim, flexibilities, kalker_coefficients
from wrsim.core.contact.tangential.friction import set_friction
from wrsim.core.contact.tangential.linear import linear_creep
from wrsim.core.contact.tangential.polach import polach

FIRM = 4.0  # from a quarter of the wheel's largest pressure amplitude on a lobe counts in full


@kernel
def creep_forces(creep, shape, settings, pose, patches, strips, count, i, work):
    """Write FX, FY, MZ of the strips of lobe i.

    Coupled lobes share the ellipse and the mean creepages by their coupling. The ellipse has the area of the patch and
    its aspect, length over width.
    """
    n = int(patches[i, N_STRIPS])
    largest = set_friction(pose, settings, strips[i], n)
    if n == 0 or patches[i, N] <= 0.0 or largest <= 0.0:
        for j in range(n):
            strips[i, j, FX] = 0.0
            strips[i, j, FY] = 0.0
            strips[i, j, MZ] = 0.0
        return
    area = width = longest = normal = xi0 = eta0 = phi0 = 0.0
    for j in range(count):
        share = 1.0
        if j != i:
            share = 0.0
            if int(patches[i, PARTNER]) == j:
                share = patches[i, COUPLING]
            if int(patches[j, PARTNER]) == i:
                share = max(share, patches[j, COUPLING])
            # a lobe about to lift off counts for as little as it carries
            share *= min(patches[j, AMPLITUDE] / patches[i, AMPLITUDE], 1.0)
        if share == 0.0 or patches[j, N] <= 0.0:
            continue
        area += share * patches[j, AREA]
        width += share * patches[j, WIDTH]
        longest = max(longest, share * patches[j, LENGTH])
        normal += share * patches[j, N]
        for m in range(int(patches[j, N_STRIPS])):
            row = strips[j, m]
            xi0 += share * row[FORCE] * row[XI]
            eta0 += share * row[FORCE] * row[ETA]
            phi0 += share * row[FORCE] * row[PHI]
    xi0 /= normal
    eta0 /= normal
    phi0 /= normal
    aspect = longest / width
    direction = 1.0 if pose[6] >= 0.0 else -1.0
    model = int(settings[TANGENTIAL])
    if model == POLACH:
        _spread_polach(creep, settings, strips[i], n, normal, xi0, eta0, phi0, aspect, area, direction)
        return
    l1, l2, l3 = flexibilities(creep, aspect, area, settings[SHEAR_MODULUS])
    a = sqrt(area * aspect / pi)
    if model == FASTSIM:
        if settings[BLENDED] > 0.5:
            limit = 0.0
            for j in range(n):
                limit += strips[i, j, MU] * strips[i, j, FORCE]
            limit *= normal / patches[i, N]
            l1, l2, l3 = blended(l1, l2, l3, a, aspect, xi0, eta0, phi0, limit)
        peak = PARABOLA_PEAK if settings[PARABOLIC] > 0.5 else 1.0
        fastsim(strips[i], n, peak, xi0, eta0, l1, l2, l3, direction, shape, work)
    elif model == FASTRIP:
        fastrip(strips[i], n, a, l1, l2, l3, direction, shape, work)
    else:
        # Kalker's linear forces know the area, not the load: a lobe about to lift off has to lose its grip
        grip = 1.0
        if model != SHEN_HEDRICK_ELKINS:
            for j in range(count):
                grip = min(grip, FIRM * patches[i, AMPLITUDE] / max(patches[j, AMPLITUDE], 1e-300))
        linear_creep(strips[i], n, xi0, eta0, l1 / grip, l2 / grip, l3 / grip, direction, model == SHEN_HEDRICK_ELKINS)


@kernel
def _spread_polach(creep, settings, strips, n, normal, xi0, eta0, phi0, aspect, area, direction):
    """Polach's forces, over the strips in proportion to their mu N; normal: force on the ellipse [N]."""
    friction = own = 0.0
    for i in range(n):
        friction += strips[i, MU] * strips[i, FORCE]
        own += strips[i, FORCE]
    stiffness = settings[SHEAR_MODULUS] * own / (normal * friction)
    c11, c22, c23 = kalker_coefficients(creep, aspect)
    a = sqrt(area * aspect / pi)
    # rolling backwards is the mirror image x -> -x: xi, phi and Fx, Mz change sign
    fx, fy, mz = polach(
        direction * xi0, eta0, direction * phi0, a, a / aspect, c11, c22, c23, stiffness,
        settings[ADHESION_FACTOR], settings[SLIP_FACTOR],
    )  # fmt: skip
    for i in range(n):
        limit = strips[i, MU] * strips[i, FORCE]
        strips[i, FX] = direction * fx * limit
        strips[i, FY] = fy * limit
        strips[i, MZ] = direction * mz * limit
