"""Creep forces of one lobe: its equivalent ellipse, its mean creepages, the model of the user's choice."""

from math import pi, sqrt
from typing import NamedTuple

from wrsim.contact.arrays import SCRATCH, Arrays
from wrsim.contact.creep.fastrip import fastrip
from wrsim.contact.creep.fastsim import PARABOLA_PEAK, fastsim, fastsim_blended
from wrsim.contact.creep.flexibility import (
    Creepages,
    Ellipse,
    Flexibilities,
    Rolling,
    ellipse_of,
    flexibilities,
    kalker_coefficients,
)
from wrsim.contact.creep.friction import set_friction
from wrsim.contact.creep.history import change_of_friction
from wrsim.contact.creep.laws import FASTRIP, FASTSIM, LINEAR, POLACH, SHEN_HEDRICK_ELKINS
from wrsim.contact.creep.linear import linear_creep
from wrsim.contact.creep.polach import polach
from wrsim.jit import Array, Record, Records, inlined, kernel

GAP_TOLERANCE = 1e-6  # of a strip's width: strips farther apart are not contiguous
FULL_WEIGHT_RATIO = 4.0  # from a quarter of the wheel's largest pressure amplitude on a lobe counts in full


@kernel
def creep_forces(a: Arrays, speed: float, count: int, i: int) -> None:
    """Write Fx, Fy, Mz of the strips of lobe i of ``count``; speed: of the wheel along the rail [m/s]. Coupled lobes
    share the ellipse and the mean creepages by their coupling. The ellipse has the area of the patch and its aspect,
    length over width."""
    model, lobes, strips = a.model[0], a.patches, a.strips[i]
    lobe = lobes[i]
    n = lobe.n_strips
    largest = set_friction(speed, a.call[0], model.least_speed, strips, n)
    lobe.temperature = model.bulk
    for j in range(n):
        strips[j].temperature = model.bulk
    if model.history:
        largest = 0.0
        for j in range(n):
            strips[j].mu = max(strips[j].mu + change_of_friction(model, model.bulk), 0.0)
            largest = max(largest, strips[j].mu)
    if n == 0 or lobe.N <= 0.0 or largest <= 0.0:
        for j in range(n):
            strips[j].Fx = strips[j].Fy = strips[j].Mz = 0.0
        return
    ellipse, mean, normal = _joint(lobes, a.strips, count, i)
    direction = 1.0 if speed >= 0.0 else -1.0
    law = model.tangential
    if law == POLACH:
        _spread_polach(a.creep, model, strips, n, normal, mean, ellipse, direction)
        return
    soft = flexibilities(a.creep, ellipse, model.G)
    if law == LINEAR:
        # Kalker's linear forces know the area, not the load: a lobe about to lift off has to lose its grip
        grip = 1.0
        for j in range(count):
            grip = min(grip, FULL_WEIGHT_RATIO * lobe.amplitude / max(lobes[j].amplitude, 1e-300))
        soft = Flexibilities(soft.l1 / grip, soft.l2 / grip, soft.l3 / grip)
    if model.slope_k0 != 1.0 or model.slope_beta > 0.0:
        soft = _reduced(a.creep, model, strips, n, normal, mean, ellipse, soft)
    soft = Flexibilities(soft.l1 + model.layer, soft.l2 + model.layer, soft.l3 + model.layer)
    cells = a.shape.shape[0] if a.work.shape[0] > SCRATCH else 0
    slip = a.work[SCRATCH + i * cells : SCRATCH + (i + 1) * cells]
    first = SCRATCH + (lobes.shape[0] + 2 * i) * cells
    on = Rolling(strips, n, soft, direction, a.shape, a.work, slip, a.work[first : first + 2 * cells])
    peak = PARABOLA_PEAK if model.parabolic else 1.0
    rolling = sqrt(speed * speed + model.least_speed * model.least_speed)
    if law == FASTSIM and model.blended:
        fastsim_blended(on, model, peak, rolling)
    elif law == FASTSIM:
        fastsim(on, mean, peak)
    elif law == FASTRIP:
        fastrip(on, model, ellipse.a, rolling)
    else:
        linear_creep(on, mean, 1.0 if law == SHEN_HEDRICK_ELKINS else 0.0)
    if model.history:
        for j in range(n):
            lobe.temperature = max(lobe.temperature, strips[j].temperature)


@inlined
def _reduced(
    creep: Array, model: Record, strips: Records, n: int, normal: float, mean: Creepages, ellipse: Ellipse,
    soft: Flexibilities,
) -> Flexibilities:  # fmt: skip
    """Flexibilities over the factor k of the slope reduction (creep-slope), spin at the end of the ellipse included."""
    friction = load = 0.0
    for i in range(n):
        friction += strips[i].mu * strips[i].N
        load += strips[i].N
    eta = mean.eta + mean.phi * ellipse.a
    eta = eta if abs(eta) > abs(mean.eta) else mean.eta
    total = sqrt(mean.xi * mean.xi + eta * eta)
    c11 = kalker_coefficients(creep, ellipse.aspect).c11
    area = pi * ellipse.a * ellipse.b
    eps = model.G * area * model.slope_k0 * c11 * total * load / (4.0 * friction * normal)
    alpha = model.slope_alpha_inf
    k = model.slope_k0 * (alpha + (1.0 - alpha) / (1.0 + model.slope_beta * eps))
    return Flexibilities(soft.l1 / k, soft.l2 / k, soft.l3 / k)


class ContiguousStrips(NamedTuple):
    """Strips beside one another without a gap: the first one behind them, their largest half length [m] and their
    amplitude, largest pressure over that."""

    end: int
    longest: float
    amplitude: float


@inlined
def _contiguous_strips(strips: Records, first: int, n: int) -> ContiguousStrips:
    """The contiguous strips from a strip on."""
    longest = pressure = 0.0
    j = first
    while j < n:
        strip = strips[j]
        if j > first and strip.s - 0.5 * strip.ds > strips[j - 1].s + (0.5 + GAP_TOLERANCE) * strips[j - 1].ds:
            break
        longest, pressure = max(longest, strip.a), max(pressure, strip.p)
        j += 1
    return ContiguousStrips(j, longest, pressure / max(longest, 1e-300))


@kernel
def _joint(lobes: Records, strips: Records, count: int, i: int) -> tuple[Ellipse, Creepages, float]:
    """Ellipse, mean creepages and normal force of lobe i and its share of those that it is coupled to. A lobe may touch
    in several intervals, with gaps between. Each counts by its length and width; one that is about to lift off for as
    little as it carries."""
    lobe = lobes[i]
    area = width = longest = normal = xi = eta = phi = 0.0
    largest_amplitude = 0.0
    m = 0
    while m < lobe.n_strips:
        contiguous = _contiguous_strips(strips[i], m, lobe.n_strips)
        m, largest_amplitude = contiguous.end, max(largest_amplitude, contiguous.amplitude)
    for j in range(count):
        other = lobes[j]
        share = 1.0
        if j != i:
            share = 0.0
            if lobe.partner == j:
                share = lobe.coupling
            if other.partner == i:
                share = max(share, other.coupling)
        if share == 0.0 or other.N <= 0.0:
            continue
        m = 0
        while m < other.n_strips:
            contiguous = _contiguous_strips(strips[j], m, other.n_strips)
            part = share * min(contiguous.amplitude / largest_amplitude, 1.0)
            longest = max(longest, 2.0 * part * contiguous.longest)
            for k in range(m, contiguous.end):
                strip = strips[j, k]
                area += 2.0 * part * strip.a * strip.ds
                width += part * strip.ds
                normal += part * strip.N
                xi += part * strip.N * strip.xi
                eta += part * strip.N * strip.eta
                phi += part * strip.N * strip.phi
            m = contiguous.end
    return ellipse_of(area, longest / width), Creepages(xi / normal, eta / normal, phi / normal), normal


@kernel
def _spread_polach(
    creep: Array, model: Record, strips: Records, n: int, normal: float, mean: Creepages, ellipse: Ellipse,
    direction: float,
) -> None:  # fmt: skip
    """Polach's forces (creep-polach), over the strips in proportion to their mu N; normal: force on the ellipse [N]."""
    friction = load = 0.0
    for i in range(n):
        friction += strips[i].mu * strips[i].N
        load += strips[i].N
    stiffness = model.G * load / (normal * friction)
    # rolling backwards is the mirror image x -> -x: xi, phi and Fx, Mz change sign
    forward = Creepages(direction * mean.xi, mean.eta, direction * mean.phi)
    coefficients = kalker_coefficients(creep, ellipse.aspect)
    fx, fy, mz = polach(forward, ellipse, coefficients, stiffness, model.kA, model.kS)
    for i in range(n):
        strip = strips[i]
        limit = strip.mu * strip.N
        strip.Fx = direction * fx * limit
        strip.Fy = fy * limit
        strip.Mz = direction * mz * limit
