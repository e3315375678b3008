"""Newton's method for the half lengths and the factors of the strip model, at given places of the strips.

Unknowns are a^2 of every strip in contact, in which u is nearly linear, and the factors k of every lobe; see
`core.contact.strips.model` for the equations.
"""

from math import sqrt

from wrsim.core.compiling import inlined, kernel
from wrsim.core.contact.strips.records import FACTORS, touching
from wrsim.core.dense import solve_pivoted

LONGEST_STEP = 0.8  # in ln a and in the factors
OVERSHOOT, SMALLEST_SQUARE = -0.3, 0.1  # of a^2 after a step over a^2 before: left at once below; kept at least
LEAST_FACTOR = 0.3
MOST_FACTOR = 8.0
EVENNESS = 0.005  # weight with which neighbouring factors are kept alike


@inlined
def _factor_at(place):
    """Number of the factor before a place and the share r of the next one."""
    f = min(int(place.at), FACTORS - 2)
    return place.lobe * FACTORS + f, place.at - f


@inlined
def _is_first(f):
    """Whether a factor is its lobe's first one."""
    return f % FACTORS == 0


@inlined
def _is_last(f):
    """Whether a factor is its lobe's last one."""
    return f % FACTORS == FACTORS - 1


@kernel
def residuals(state, n, count, stiffness, deepest):
    """Misfits of all equations to ``step``; returns the largest, relative to the deepest penetration.

    n: strips in contact; count: lobes; stiffness: pi E* [Pa].
    """
    places, spans, factors, step = state.places, state.spans, state.factors, state.step
    # amplitudes and the weights of the second condition
    for i in range(count):
        spans[i].weight = 0.0
        spans[i].loaded = 0
    for i in range(n):
        place = touching(places, i)
        f, r = _factor_at(place)
        place.q = place.hertz * ((1.0 - r) * factors[f] + r * factors[f + 1])
        place.weight = place.q * place.a * place.a
        spans[place.lobe].weight += place.weight
        spans[place.lobe].loaded = 1
    for i in range(n):
        place = touching(places, i)
        place.weight /= spans[place.lobe].weight
    largest = 0.0
    step[: n + count * FACTORS] = 0.0
    for i in range(n):
        u = c = 0.0
        for j in range(n):
            q = touching(places, j).q
            u += state.u[i, j] * q
            c += state.c[i, j] * q
        place = touching(places, i)
        step[i] = u / stiffness - place.d
        place.misfit = c * place.r_t / stiffness - 1.0
        largest = max(largest, abs(step[i]))
        f, r = _factor_at(place)
        step[n + f] += (1.0 - r) * place.weight * place.misfit
        step[n + f + 1] += r * place.weight * place.misfit
    largest /= deepest
    for f in range(count * FACTORS):
        if spans[f // FACTORS].loaded:
            before = factors[f if _is_first(f) else f - 1]
            after = factors[f if _is_last(f) else f + 1]
            step[n + f] += EVENNESS * (2.0 * factors[f] - before - after)
        largest = max(largest, 0.1 * abs(step[n + f]))
    return largest


@kernel
def newton_step(state, n, count, stiffness, shortest):
    """One step from the misfits in ``step``. Strips that become shorter than ``shortest`` [m] leave the contact."""
    _differentiate(state, n, count, stiffness)
    places, factors, step = state.places, state.factors, state.step
    solve_pivoted(state.jacobian, n + count * FACTORS, step)
    for i in range(count):
        # no lobe grows or changes its factors by too much at once
        largest = 0.0
        for f in range(i * FACTORS, (i + 1) * FACTORS):
            largest = max(largest, abs(step[n + f]) / factors[f])
        for j in range(n):
            if touching(places, j).lobe == i:
                largest = max(largest, -step[j])
        share = min(1.0, LONGEST_STEP / largest) if largest > 0.0 else 1.0
        for f in range(i * FACTORS, (i + 1) * FACTORS):
            factors[f] = min(max(factors[f] - share * step[n + f], LEAST_FACTOR), MOST_FACTOR)
        for j in range(n):
            place = touching(places, j)
            if place.lobe != i:
                continue
            square = 1.0 - 2.0 * share * step[j]
            # a step that just overshoots lets no strip go: the next one tells
            square = max(square, SMALLEST_SQUARE) if square > OVERSHOOT else 0.0
            place.a *= sqrt(square)
            if place.a < shortest:
                place.a = 0.0
                place.let_go += 1


@kernel
def _differentiate(state, n, count, stiffness):
    """Derivatives of all equations by ln a and the factors, to ``jacobian``."""
    places, jacobian = state.places, state.jacobian
    size = n + count * FACTORS
    jacobian[:n, n:size] = 0.0
    jacobian[n:size, :size] = 0.0
    for i in range(n):
        place = touching(places, i)
        f, r = _factor_at(place)
        scale = place.weight * place.r_t / stiffness
        row0, row1 = n + f, n + f + 1
        part0, part1 = (1.0 - r) * scale, r * scale
        for j in range(n):
            other = touching(places, j)
            jacobian[i, j] = state.du[i, j] * other.q / stiffness
            jacobian[row0, j] += part0 * state.dc[i, j] * other.q
            jacobian[row1, j] += part1 * state.dc[i, j] * other.q
            g, r = _factor_at(other)
            by0, by1 = n + g, n + g + 1
            u = state.u[i, j] * other.hertz
            jacobian[i, by0] += u * (1.0 - r) / stiffness
            jacobian[i, by1] += u * r / stiffness
            c = state.c[i, j] * other.hertz
            jacobian[row0, by0] += part0 * c * (1.0 - r)
            jacobian[row0, by1] += part0 * c * r
            jacobian[row1, by0] += part1 * c * (1.0 - r)
            jacobian[row1, by1] += part1 * c * r
    for f in range(count * FACTORS):
        row = n + f
        if state.spans[f // FACTORS].loaded == 0:
            jacobian[row, :size] = 0.0
            jacobian[row, row] = 1.0
            state.step[row] = 0.0
            continue
        jacobian[row, row] += 2.0 * EVENNESS
        beside_before, beside_after = row if _is_first(f) else row - 1, row if _is_last(f) else row + 1
        jacobian[row, beside_before] -= EVENNESS
        jacobian[row, beside_after] -= EVENNESS
