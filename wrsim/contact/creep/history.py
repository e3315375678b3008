"""The march of `contact.creep.march` with a bound that depends on what a surface point has gone through on its way from
the leading edge: the heat of friction, and the plastic slip of a layer (creep-heat), (hs-yield).

The traction of a cell depends on cells ahead of it alone, so nothing is iterated. A cell is marched twice: the slip of
the first time, which hardly depends on the bound, gives its own heat and plastic slip, for which friction and yield
stress are solved in closed form.
"""

from math import sqrt

from wrsim.contact.creep.flexibility import Rolling
from wrsim.contact.creep.march import BOUND, FX, FY, MZ, START_X, START_Y, STUCK, TINY, advance, limit_dissipation
from wrsim.jit import Array, Record, inlined, kernel

HEAT = 0  # row of the scratch array: heat of the cells of one strip [J/m2]
RESIDUAL = 0.1  # of a yield stress that falls (CONTACT)
AT_CENTRE = sqrt(2.0)  # weight of the heat of a cell at its centre


@inlined
def change_of_friction(model: Record, temperature: float) -> float:
    """What a temperature [degC] adds to a coefficient of friction."""
    change = model.heat_slope * (temperature - model.heat_from)
    return min(max(change, min(model.heat_change, 0.0)), max(model.heat_change, 0.0))


@inlined
def friction_in_heat(cold: float, model: Record, temperature: float, heating: float) -> float:
    """Coefficient mu = cold + change(temperature + heating mu): linear in mu, held between its ends; heating: what a
    place's own heat adds to its temperature, over mu [K]."""
    hot = temperature + heating * cold
    rest = 1.0 - model.heat_slope * heating
    if rest > 0.0:
        hot = model.heat_from + (hot - model.heat_from) / rest
    elif hot > model.heat_from:
        hot = 1e30  # every degree brings more than a degree
    return max(cold + change_of_friction(model, hot), 0.0)


@inlined
def hardened(limit: float, size: float, hardening: float, least: float, bound: float) -> float:
    """Yield stress behind a place where a trial traction of this size is cut back to it, but for ``bound``."""
    if size <= limit or bound <= limit:
        return limit
    return min(max((limit + hardening * size) / (1.0 + hardening), least), bound)


@kernel
def heat_before(heat: Array, j: int) -> float:
    """Sum of the heat of the cells ahead of cell j by their weights at its centre (creep-heat)."""
    total = 0.0
    for m in range(j):
        total += 2.0 * (sqrt(j - m + 0.5) - sqrt(j - m - 0.5)) * heat[m]
    return total


@kernel
def march_with_history(on: Rolling, model: Record, rising: bool, speed: float) -> None:
    """Tangential forces of the strips, each set by `begin`, with their temperatures and mean coefficients of friction.
    speed: of rolling, above 0 [m/s]; otherwise as `march`."""
    strips, n, soft, direction, shape, work, slip, traction = on
    cells = shape.shape[0]
    dx = 2.0 / cells
    mean = 0.5 * (soft.l1 + soft.l2)
    base = change_of_friction(model, model.bulk)
    heat = work[HEAT]
    for i in range(n):
        strip = strips[i]
        bound = work[BOUND, i]
        if bound <= TINY:
            strip.Fx = strip.Fy = strip.Mz = 0.0
            continue
        cold, stuck, x0, y0 = strip.mu - base, work[STUCK, i], work[START_X, i], work[START_Y, i]
        way = dx * strip.a
        warming = model.warming * sqrt(speed / way)
        step_x, step_y = -strip.xi * way / (soft.l1 * bound), -strip.eta * way / (soft.l2 * bound)
        turn = -direction * strip.phi * strip.a * way / (soft.l3 * bound)
        yields, hardening = model.yield_stress / bound, model.hardening * mean
        least = RESIDUAL * yields
        fx, fy, mz, friction, whole, total = work[FX, i], work[FY, i], work[MZ, i], 0.0, 0.0, 0.0
        qx = qy = before = 0.0
        release = 1.0 if stuck >= 1.0 else -1.0
        for j in range(cells):
            x = 1.0 - (j + 0.5) * dx
            part = min(max((stuck - x) / dx, 0.0), 1.0)
            gx, gy, ty = part * step_x, part * step_y, part * (x + 0.5 * part * dx) * turn
            hx, hy = gx * soft.l1 / mean, (gy * soft.l2 + ty * soft.l3) / mean
            gy += ty
            temperature = model.bulk + warming * heat_before(heat, j)
            mu = friction_in_heat(cold, model, temperature, 0.0)
            # from the slip on the way between two centres to that of the cell
            per_slip = mean * bound * bound * min(part + 0.5, 1.0) / max(part, TINY)
            limit = min(shape[j] * mu / strip.mu, yields)
            if j == 0:
                before = limit
                qx, qy = x0 * limit, y0 * limit
            px, py, last = qx, qy, before
            if release < 0.0 and x < stuck:
                # of the work that creep has stored in the adhesion zone of strip theory
                stored = (fx * step_x * soft.l1 + fy * step_y * soft.l2) / mean
                release = min(max(2.0 * stored / max(px * px + py * py, TINY), 0.0), 1.0)
            for trial in range(2):
                limit = max(limit, TINY)
                rise = limit / max(last, TINY) - 1.0
                free_x, free_y, scale, lifted = advance(
                    px, py, gx, gy, hx, hy, part, max(last, TINY), limit, rise, max(rise, 0.0) if rising else 0.0
                )
                qx, qy = free_x * scale, free_y * scale
                if x >= stuck:
                    qx, qy = x0 * limit, y0 * limit
                # the slip over the flexibility: what has not become traction
                rigid = qx * (free_x - lifted * px) + qy * (free_y - lifted * py)
                follows = 1.0 + (1.0 - part) * rise
                slid = rigid - release * (qx * (qx - follows * px) + qy * (qy - follows * py))
                heat[j] = per_slip * max(slid, 0.0) if x < stuck else 0.0
                if trial == 0:
                    heating = warming * AT_CENTRE * heat[j] / max(mu, TINY)
                    mu = friction_in_heat(cold, model, temperature, heating)
                    limit = shape[j] * mu / strip.mu
                    yields = hardened(yields, sqrt(free_x * free_x + free_y * free_y), hardening, least, limit)
                    limit = min(limit, yields)
            before = limit
            strip.temperature = max(strip.temperature, temperature + warming * AT_CENTRE * heat[j])
            fx += qx
            fy += qy
            mz += x * qy
            friction += shape[j] * mu
            whole += shape[j]
            total += limit
            if slip.shape[0] > 0:
                slip[j, i] = 0.0 if x >= stuck else sqrt(qx * qx + qy * qy) / limit
            if traction.shape[0] > 0:
                traction[j, i], traction[cells + j, i] = bound * qx, bound * qy
        strip.mu = friction / whole
        force = bound * way * strip.ds * min(total / sqrt(max(fx * fx + fy * fy, TINY)), 1.0)
        strip.Fx = force * fx
        strip.Fy = force * fy
        strip.Mz = direction * force * mz * strip.a
    limit_dissipation(strips, n)
