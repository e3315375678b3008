"""From the leading edge to the trailing one: tractions that stick with three flexibilities and slide with one.

Where a surface point sticks, its traction grows by the rigid slip of the way it goes, over the flexibilities L1
(along), L2 (across) and L3 (across, of the turning phi x): small creepages then give Kalker's linear forces. Three
different ones would turn a sliding traction away from the slip, so where the point slides its traction follows with
one, (L1 + L2) / 2, and is cut back to the bound: full sliding is opposite to the slip.

From one cell to the next a traction q may stick up to a part s of the way and slides for the rest. With l the bound
here and l + dl there, g the change of a traction that sticks all along,

    s = R / (R + E),   R = l^2 - |q|^2 + 2 max(l dl - q.g, 0),   E = max(|q + g|^2 - (l + dl)^2, 0):

1 where q + g is within the bound, 0 where q is at the bound and goes on outwards, and the place of the crossing where q
leaves the bound and comes back to it. So tractions and forces are continuous in all creepages. In the first cell, where
the bound rises as a root, l is the cell's own.

Strip theory has tractions at the bound behind the zone that it knows. There a traction first rises with the bound (by
(|q|/l)^8 of that where it is a little below), with l the bound it has come to: else its growth and that of the bound,
which are nearly the same, would decide on sticking by chance.
"""

from math import pi, sqrt

from wrsim.contact.creep.flexibility import Rolling
from wrsim.jit import Array, Record, Records, inlined, kernel

STEP_X, STEP_Y, TURN, BOUND, START_X, START_Y, STUCK, TRACTION_X, TRACTION_Y, FX, FY, MZ = range(12)
"""Rows of the scratch array."""

TINY = 1e-30  # a bound [Pa] below which strips only slide; also a rest in R, that s is 1 where nothing slips


@inlined
def largest_traction(strip: Record) -> float:
    """Peak of the semi-ellipse along a strip that holds its mu N [Pa]: mu p where the pressure is one itself."""
    return 2.0 * strip.mu * strip.N / (pi * max(strip.a * strip.ds, 1e-300))


@inlined
def begin(work: Array, i: int, bound: float, stuck: float, x: float, y: float, fx: float, fy: float, mz: float) -> None:
    """Write what `march` finds of strip i. bound: largest traction [Pa]; stuck: place over a where the march begins, 1
    at the leading edge; x, y: tractions before that, fx, fy, mz: what comes to the sums over cells, over the bound."""
    work[BOUND, i], work[STUCK, i], work[START_X, i], work[START_Y, i] = bound, stuck, x, y
    work[FX, i], work[FY, i], work[MZ, i] = fx, fy, mz


@inlined
def advance(
    qx: float, qy: float, gx: float, gy: float, hx: float, hy: float, part: float, before: float, limit: float,
    rise: float, lift: float,
) -> tuple[float, float, float, float]:  # fmt: skip
    """From the traction q of one cell, with the bound ``before``, to the next one: what it would be with all the slip,
    its share within ``limit``, and the factor by which q follows the bound. g, h: change where it sticks, slides; part:
    of the way behind the start; rise: of the bound over itself, lift: that of tractions that stick."""
    utilisation = min((qx * qx + qy * qy) * (1.0 / (before * before)), 1.0)
    utilisation *= utilisation
    bound_factor = 1.0 + (1.0 - part) * rise + part * lift * utilisation * utilisation
    px, py = bound_factor * qx, bound_factor * qy
    last = before * (1.0 + (1.0 - part) * rise + part * lift)
    inwards = last * (limit - last) - px * gx - py * gy
    room = max(last * last - px * px - py * py, 0.0) + 2.0 * max(inwards, 0.0) + TINY
    ex, ey = px + gx, py + gy
    s = room / (room + max(ex * ex + ey * ey - limit * limit, 0.0))
    tx = px + s * gx + (1.0 - s) * hx
    ty = py + s * gy + (1.0 - s) * hy
    return tx, ty, min(limit / sqrt(max(tx * tx + ty * ty, TINY)), 1.0), bound_factor


@kernel
def march(on: Rolling, rising: bool) -> None:
    """Tangential forces of the strips, each set by `begin`. rising: whether tractions rise with the bound."""
    strips, n, soft, direction, shape, work, slip, traction = on
    cells = shape.shape[0]
    dx = 2.0 / cells
    per_cell = 1.0 / dx
    step_x, step_y, turn = work[STEP_X], work[STEP_Y], work[TURN]
    bound, start_x, start_y, stuck = work[BOUND], work[START_X], work[START_Y], work[STUCK]
    qx, qy = work[TRACTION_X], work[TRACTION_Y]  # over the largest bound, as everything in the march
    fx, fy, mz = work[FX], work[FY], work[MZ]
    # flexibility that sticks over the one that slides
    slide = 2.0 / (soft.l1 + soft.l2)
    slide_x, slide_y, slide_turn = soft.l1 * slide, soft.l2 * slide, soft.l3 * slide
    per_x, per_y, per_turn = -dx / soft.l1, -dx / soft.l2, -direction * dx / soft.l3
    for i in range(n):
        strip = strips[i]
        share = strip.a / bound[i] if bound[i] > TINY else 0.0
        step_x[i] = per_x * strip.xi * share
        step_y[i] = per_y * strip.eta * share
        turn[i] = per_turn * strip.phi * strip.a * share
        qx[i] = start_x[i] * shape[0]
        qy[i] = start_y[i] * shape[0]
    for j in range(cells):
        x = 1.0 - (j + 0.5) * dx
        limit = shape[j]
        before = shape[j - 1] if j > 0 else limit
        rise = limit / before - 1.0
        lift = max(rise, 0.0) if rising else 0.0
        for i in range(n):
            # the part of the way from the centre of the last cell that lies behind the start
            part = min(max((stuck[i] - x) * per_cell, 0.0), 1.0)
            middle = x + 0.5 * part * dx
            gx = part * step_x[i]
            gy, ty = part * step_y[i], part * middle * turn[i]
            hx, hy = slide_x * gx, slide_y * gy + slide_turn * ty
            gy += ty
            tx, ty, scale, _follows = advance(qx[i], qy[i], gx, gy, hx, hy, part, before, limit, rise, lift)
            before_start = x >= stuck[i]
            tx = start_x[i] * limit if before_start else tx * scale
            ty = start_y[i] * limit if before_start else ty * scale
            qx[i] = tx
            qy[i] = ty
            fx[i] += tx
            fy[i] += ty
            mz[i] += x * ty
        if slip.shape[0] > 0:
            for i in range(n):
                slip[j, i] = 0.0 if x >= stuck[i] else sqrt(qx[i] * qx[i] + qy[i] * qy[i]) / limit
        if traction.shape[0] > 0:
            for i in range(n):
                traction[j, i], traction[cells + j, i] = bound[i] * qx[i], bound[i] * qy[i]
    for i in range(n):
        strip = strips[i]
        force = bound[i] * dx * strip.a * strip.ds
        # the cells do not end where the march begins: a rest of rounding
        limit = 0.5 * pi / dx
        force *= min(limit / sqrt(max(fx[i] * fx[i] + fy[i] * fy[i], TINY)), 1.0)
        strip.Fx = force * fx[i]
        strip.Fy = force * fy[i]
        strip.Mz = direction * force * mz[i] * strip.a
    limit_dissipation(strips, n)


@kernel
def limit_dissipation(strips: Records, n: int) -> None:
    """Moments as near to the ones given as keeps the creep's power over all strips from being positive. C22 makes the
    moment of eta, C23 the lateral force of phi. In slender patches (a/b above some 10) with next to no slip the two
    differ so much that, with hardly anything else to dissipate, their powers would not cancel."""
    power = 0.0
    spins = 0.0
    for i in range(n):
        strip = strips[i]
        power += strip.Fx * strip.xi + strip.Fy * strip.eta + strip.Mz * strip.phi
        spins += strip.phi * strip.phi
    if power > 0.0 and spins > 0.0:
        for i in range(n):
            strips[i].Mz -= power * strips[i].phi / spins
