"""Creep forces of one lobe: its equivalent ellipse, its mean creepages, the model of the user's choice."""

from wrsim.core.compiling import kernel
from wrsim.core.contact.records import FASTRIP, FASTSIM, POLACH, SHEN_HEDRICK_ELKINS
from wrsim.core.contact.tangential.fastrip import fastrip
from wrsim.core.contact.tangential.fastsim import PARABOLA_PEAK, fastsim, fastsim_blended
from wrsim.core.contact.tangential.flexibility import (
    Creepages,
    Flexibilities,
    ellipse_of,
    flexibilities,
    kalker_coefficients,
)
from wrsim.core.contact.tangential.friction import set_friction
from wrsim.core.contact.tangential.linear import linear_creep
from wrsim.core.contact.tangential.polach import polach

FIRM = 4.0  # from a quarter of the wheel's largest pressure amplitude on a lobe counts in full


@kernel
def creep_forces(creep, shape, settings, speed, lobes, strips, count, i, work):
    """Write Fx, Fy, Mz of the strips of lobe i; speed: of the wheel along the rail [m/s].

    Coupled lobes share the ellipse and the mean creepages by their coupling. The ellipse has the area of the patch and
    its aspect, length over width.
    """
    lobe, own = lobes[i], strips[i]
    n = lobe.n_strips
    largest = set_friction(speed, settings, own, n)
    if n == 0 or lobe.N <= 0.0 or largest <= 0.0:
        for j in range(n):
            own[j].Fx = own[j].Fy = own[j].Mz = 0.0
        return
    ellipse, mean, normal = _joint(lobes, strips, count, i)
    direction = 1.0 if speed >= 0.0 else -1.0
    model = settings.tangential
    if model == POLACH:
        _spread_polach(creep, settings, own, n, normal, mean, ellipse, direction)
        return
    soft = flexibilities(creep, ellipse, settings.G)
    if model == FASTSIM:
        peak = PARABOLA_PEAK if settings.parabolic else 1.0
        if settings.blended:
            fastsim_blended(own, n, peak, soft, direction, shape, work)
        else:
            fastsim(own, n, peak, mean, soft, direction, shape, work)
    elif model == FASTRIP:
        fastrip(own, n, ellipse.a, soft, direction, shape, work)
    elif model == SHEN_HEDRICK_ELKINS:
        linear_creep(own, n, mean, soft, direction, 1.0)
    else:
        # Kalker's linear forces know the area, not the load: a lobe about to lift off has to lose its grip
        grip = 1.0
        for j in range(count):
            grip = min(grip, FIRM * lobe.amplitude / max(lobes[j].amplitude, 1e-300))
        linear_creep(own, n, mean, Flexibilities(soft.l1 / grip, soft.l2 / grip, soft.l3 / grip), direction, 0.0)


@kernel
def _joint(lobes, strips, count, i):
    """Ellipse, mean creepages and normal force of lobe i and its share of those that it is coupled to."""
    lobe = lobes[i]
    area = width = longest = normal = xi = eta = phi = 0.0
    for j in range(count):
        other = lobes[j]
        share = 1.0
        if j != i:
            share = 0.0
            if lobe.partner == j:
                share = lobe.coupling
            if other.partner == i:
                share = max(share, other.coupling)
            # a lobe about to lift off counts for as little as it carries
            share *= min(other.amplitude / lobe.amplitude, 1.0)
        if share == 0.0 or other.N <= 0.0:
            continue
        area += share * other.area
        width += share * other.width
        longest = max(longest, share * other.length)
        normal += share * other.N
        for m in range(other.n_strips):
            strip = strips[j, m]
            xi += share * strip.N * strip.xi
            eta += share * strip.N * strip.eta
            phi += share * strip.N * strip.phi
    return ellipse_of(area, longest / width), Creepages(xi / normal, eta / normal, phi / normal), normal


@kernel
def _spread_polach(creep, settings, strips, n, normal, mean, ellipse, direction):
    """Polach's forces, over the strips in proportion to their mu N; normal: force on the ellipse [N]."""
    friction = own = 0.0
    for i in range(n):
        friction += strips[i].mu * strips[i].N
        own += strips[i].N
    stiffness = settings.G * own / (normal * friction)
    # rolling backwards is the mirror image x -> -x: xi, phi and Fx, Mz change sign
    forward = Creepages(direction * mean.xi, mean.eta, direction * mean.phi)
    coefficients = kalker_coefficients(creep, ellipse.aspect)
    fx, fy, mz = polach(forward, ellipse, coefficients, stiffness, settings.kA, settings.kS)
    for i in range(n):
        strip = strips[i]
        limit = strip.mu * strip.N
        strip.Fx = direction * fx * limit
        strip.Fy = fy * limit
        strip.Mz = direction * mz * limit
