"""Steady rolling of half-spaces with Coulomb friction on a grid: steps of a semismooth Newton method.

Wanted are tractions q on the wheel, |q| <= g = mu p, such that the slip s of every element (hs-slip) vanishes where
|q| < g and is opposite to q where |q| = g (Kalker 1990, chapter 4: the material of an element was one element further
ahead a moment ago). The rigid slip w is that of each element, so creepage and spin may vary over a curved patch.

Both conditions in one are (hs-coulomb). Where |q - rho s| <= g that is s = 0 (adhesion), else q = g n,
n = (q - rho s)/|q - rho s| (slip). Newton's steps are solved by GMRES with convolutions in Fourier space
(wrsim.contact.half_space.rolling). In adhesion the equations of a row are summed up from the leading end of each run,
which turns differences into displacements and lets the inverse symbol of A precondition them.

A layer that yields (hs-yield) bounds tractions by min(mu p, tau_c): tau_c rises by h = k dx times the slip from element
to element that yields, from its leading end on. There q = tau + h |s| with tau of the element ahead, and with
|q - rho s| = |q| + rho |s| the bound is g = (rho tau + h |q - rho s|) / (rho + h).

Vectors are (2, rows, columns) along x and s, scalars (rows, columns), x rising with the column.
"""

from math import sqrt
from typing import Any, NamedTuple

from wrsim.contact.creep.history import AT_CENTRE, RESIDUAL, friction_in_heat, heat_before
from wrsim.jit import Array, Record, kernel

OUTSIDE, ADHESION, SLIP, YIELD = 0.0, 1.0, 2.0, 3.0


class Equations(NamedTuple):
    """F of (hs-coulomb) and its derivative.

    bound: mu p [Pa], zero outside contact; rho [Pa]; scale: of the sums over runs in adhesion [Pa]; forward: +1 when x
    rises towards the leading edge, else -1; yield_stress [Pa] of a layer, inf where none yields, and how much it rises
    over an element per plastic slip, hardening times dx [Pa]. At the last tractions, written by `evaluate`: state
    (OUTSIDE, ADHESION, SLIP, YIELD), and in slip or yield n and ratio = g / |q - rho s|.
    """

    bound: Any
    rho: float
    scale: float
    forward: float
    yield_stress: float
    hardening: float
    state: Any
    n: Any
    ratio: Any


@kernel
def evaluate(eq: Equations, q: Array, slip: Array, rhs: Array) -> float:
    """State of every element and the right hand side -F of Newton's equations. rhs: in adhesion the sum of -s from the
    leading end of the run times ``scale``, in slip or yield g n - q. Returns the largest error, as a traction."""
    rows, columns = eq.bound.shape
    worst = 0.0
    least = RESIDUAL * eq.yield_stress  # there YIELD ends
    for j in range(rows):
        sum_x = 0.0
        sum_s = 0.0
        limit = eq.yield_stress
        for m in range(columns):
            i = columns - 1 - m if eq.forward > 0.0 else m
            g = eq.bound[j, i]
            eq.state[j, i] = OUTSIDE
            rhs[0, j, i] = 0.0
            rhs[1, j, i] = 0.0
            if g <= 0.0:
                sum_x = 0.0
                sum_s = 0.0
                limit = eq.yield_stress
                continue
            zx = q[0, j, i] - eq.rho * slip[0, j, i]
            zs = q[1, j, i] - eq.rho * slip[1, j, i]
            size = sqrt(zx * zx + zs * zs)
            if size <= min(g, limit):
                eq.state[j, i] = ADHESION
                sum_x -= slip[0, j, i]
                sum_s -= slip[1, j, i]
                rhs[0, j, i] = eq.scale * sum_x
                rhs[1, j, i] = eq.scale * sum_s
                worst = max(worst, eq.rho * abs(slip[0, j, i]), eq.rho * abs(slip[1, j, i]))
            else:
                eq.state[j, i] = SLIP
                sum_x = 0.0
                sum_s = 0.0
                eq.n[0, j, i] = zx / size
                eq.n[1, j, i] = zs / size
                if limit < g:
                    limit = (eq.rho * limit + eq.hardening * size) / (eq.rho + eq.hardening)
                    if least < limit < g:
                        eq.state[j, i] = YIELD
                    limit = min(max(limit, least), g)
                    g = limit
                eq.ratio[j, i] = g / size
                rhs[0, j, i] = g * eq.n[0, j, i] - q[0, j, i]
                rhs[1, j, i] = g * eq.n[1, j, i] - q[1, j, i]
                worst = max(worst, abs(rhs[0, j, i]), abs(rhs[1, j, i]))
    return worst


@kernel
def derivative(eq: Equations, d: Array, r: Array, out: Array) -> None:
    """out = F' d, d a change of q and r that of the slip."""
    rows, columns = eq.bound.shape
    for j in range(rows):
        sum_x = 0.0
        sum_s = 0.0
        rise = 0.0
        for m in range(columns):
            i = columns - 1 - m if eq.forward > 0.0 else m
            if eq.state[j, i] == ADHESION:
                sum_x += r[0, j, i]
                sum_s += r[1, j, i]
                out[0, j, i] = eq.scale * sum_x
                out[1, j, i] = eq.scale * sum_s
                continue
            sum_x = 0.0
            sum_s = 0.0
            if eq.state[j, i] >= SLIP:
                nx, ns = eq.n[0, j, i], eq.n[1, j, i]
                zx = d[0, j, i] - eq.rho * r[0, j, i]
                zs = d[1, j, i] - eq.rho * r[1, j, i]
                along = zx * nx + zs * ns
                out[0, j, i] = d[0, j, i] - eq.ratio[j, i] * (zx - along * nx)
                out[1, j, i] = d[1, j, i] - eq.ratio[j, i] * (zs - along * ns)
                if eq.state[j, i] == YIELD:
                    rise = (eq.rho * rise + eq.hardening * along) / (eq.rho + eq.hardening)
                    out[0, j, i] -= rise * nx
                    out[1, j, i] -= rise * ns
                else:
                    rise = 0.0
            else:
                rise = 0.0
                out[0, j, i] = 0.0
                out[1, j, i] = 0.0


@kernel
def move(q: Array, d: Array, share: float, bound: Array) -> None:
    """q += share d, brought back into the disc |q| <= g where it has left it."""
    for j in range(bound.shape[0]):
        for i in range(bound.shape[1]):
            x = q[0, j, i] + share * d[0, j, i]
            s = q[1, j, i] + share * d[1, j, i]
            size = sqrt(x * x + s * s)
            back = bound[j, i] / size if size > bound[j, i] else 1.0
            q[0, j, i] = back * x
            q[1, j, i] = back * s


@kernel
def march_columns(w: Array, bound: Array, flexibility: float, step: float, forward: float, q: Array) -> None:
    """A first guess: rigid slip w summed up from the leading end with one flexibility [m/Pa]; step: dx [m]. The
    simplified theory of rolling contact (Kalker 1982)."""
    rows, columns = bound.shape
    for j in range(rows):
        x = 0.0
        s = 0.0
        for m in range(columns):
            i = columns - 1 - m if forward > 0.0 else m
            g = bound[j, i]
            x -= w[0, j, i] * step / flexibility
            s -= w[1, j, i] * step / flexibility
            size = sqrt(x * x + s * s)
            if size > g:
                x *= g / size
                s *= g / size
            q[0, j, i] = x
            q[1, j, i] = s


@kernel
def extend(z: Array, w: Array, k: int, x: Array, r: Array) -> float:
    """A step of GMRES (Saad and Schultz 1986) without rotations (Walker and Zhou, Numer. Linear Algebra Appl. 1, 1994):
    vector k and its image join the space, both (steps, n), in which the residual is least. Plain loops: a threaded
    library would wait for busy cores.

    Makes w[k] orthogonal to those before it and of unit length, z[k] follows; x and the residual r advance along them.
    Returns the size of the residual.
    """
    for j in range(k):
        share = _product(w[j], w[k])
        for i in range(r.size):
            w[k, i] -= share * w[j, i]
            z[k, i] -= share * z[j, i]
    size = sqrt(_product(w[k], w[k]))
    if size > 0.0:
        for i in range(r.size):
            w[k, i] /= size
            z[k, i] /= size
    step = _product(w[k], r)
    for i in range(r.size):
        x[i] += step * z[k, i]
        r[i] -= step * w[k, i]
    return sqrt(_product(r, r))


@kernel
def _product(a: Array, b: Array) -> float:
    """a . b."""
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@kernel
def heat_rows(
    model: Record, speed: float, dx: float, forward: float, cold: Array, p: Array, q: Array, slip: Array, state: Array,
    heat: Array, friction: Array, temperature: Array,
) -> None:  # fmt: skip
    """Coefficients of friction and temperatures [degC] (rows, columns) by the heat of rows of elements (creep-heat).
    cold: coefficients before any heat; p, q [Pa], slip over the speed and state of a solution; heat: scratch of the
    elements of one row (columns,). Where elements slide their traction is taken to be that of the new coefficient."""
    rows, columns = p.shape
    warming = model.warming * sqrt(speed / dx)
    for j in range(rows):
        for m in range(columns):
            i = columns - 1 - m if forward > 0.0 else m
            before = heat_before(heat, m)
            way = dx * sqrt(slip[0, j, i] * slip[0, j, i] + slip[1, j, i] * slip[1, j, i])
            slides = p[j, i] * way if state[j, i] == SLIP else 0.0
            heating = warming * AT_CENTRE * slides
            friction[j, i] = friction_in_heat(cold[j, i], model, model.bulk + warming * before, heating)
            heat[m] = friction[j, i] * slides
            if state[j, i] == YIELD:
                heat[m] = sqrt(q[0, j, i] * q[0, j, i] + q[1, j, i] * q[1, j, i]) * way
            temperature[j, i] = model.bulk + warming * (before + AT_CENTRE * heat[m])
