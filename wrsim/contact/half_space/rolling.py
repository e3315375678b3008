"""Tractions of half-spaces in steady rolling: the loop around contact.half_space.rolling_kernel."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

import numpy as np

from wrsim.contact.half_space import rolling_kernel as rolling
from wrsim.contact.half_space.influence import Operator
from wrsim.jit import Array

NEWTON_STEPS = 80
KRYLOV_STEPS = 40
MOST_WORK = 1e8  # elements times products after which rolling is given up as not converged: some 10 to 20 s
KRYLOV_TOLERANCE = 0.05
STEP_OF_MAP = 0.4  # rho over the inverse of an element's own slip
CIRCLE_C11 = 4.12  # Kalker's coefficient of a circular patch, nu = 1/4


@dataclass(frozen=True)
class Traction:
    """Tractions on the wheel (2, rows, columns) [Pa], slip over the rolling speed, adhesion 1, slip 2, yield 3."""

    q: Array
    slip: Array
    state: Array
    steps: int
    products: int
    error: float
    converged: bool


def solve_rolling(
    operator: Operator,
    bound: Array,
    rigid_slip: Array,
    forward: float = 1.0,
    tolerance: float = 1e-4,
    start: Array | None = None,
    yield_stress: float = inf,
    hardening: float = 0.0,
) -> Traction:
    """Tractions of steady rolling.

    bound: largest traction mu p of every element, zero outside contact, (rows, columns) [Pa]; rigid_slip: over the
    rolling speed, (2, rows, columns), of the wheel relative to the rail; forward: +1 when rolling towards larger x;
    tolerance: largest error of a traction over the largest bound; start: tractions to begin with; yield_stress [Pa] of
    a layer between the bodies and its rise with the plastic slip, hardening [Pa/m].
    """
    shape, largest = rigid_slip.shape, float(bound.max())
    q = np.zeros(shape)
    state, ratio, n = np.zeros(bound.shape), np.zeros(bound.shape), np.zeros(shape)
    if largest <= 0.0:
        return Traction(q, rigid_slip, state, 0, 0, 0.0, True)
    self_slip = operator.self_slip()
    # the sum of a run times dx over a typical compliance is a traction
    scale = 1.0 / (np.sqrt(bound.size) * self_slip)
    unscale = operator.dx / scale
    layer = yield_stress, hardening * operator.dx
    equations = rolling.Equations(bound, STEP_OF_MAP / self_slip, scale, forward, *layer, state, n, ratio)
    if start is not None and start.shape == shape:
        rolling.move(q, start, 1.0, bound)
    else:
        least = np.minimum(bound, yield_stress)
        rolling.march_columns(rigid_slip, least, _flexibility(operator, bound), operator.dx, forward, q)
    products = 0

    def correction(v: Array) -> Array:
        """From the unknowns of the preconditioned system to a change of q."""
        return unscale * sticking * operator.inverse.traction(sticking * v) + sliding * v

    def product(flat: Array) -> Array:
        nonlocal products
        products += 1
        d = correction(flat.reshape(shape))
        rolling.derivative(equations, d, operator.slip(d, forward), out)
        return out.reshape(-1)

    rhs, out = np.zeros(shape), np.zeros(shape)
    space = np.empty((2, KRYLOV_STEPS, q.size))
    errors: list[float] = []
    for step in range(NEWTON_STEPS):
        slip = operator.slip(q, forward) + rigid_slip
        products += 1
        errors.append(rolling.evaluate(equations, q, slip, rhs) / largest)
        converged = errors[-1] < tolerance
        if converged or products * bound.size > MOST_WORK:
            return Traction(q, slip, state, step, products, errors[-1], converged)
        sticking = (state == rolling.ADHESION).astype(np.float64)
        sliding = (state >= rolling.SLIP).astype(np.float64)
        change = _least_residual(product, rhs.reshape(-1), *space).reshape(shape)
        # where a few elements swing between two states a shorter step breaks the circle
        swinging = step > 5 and errors[-1] > 0.3 * errors[-3]
        rolling.move(q, correction(change), (0.5 if step % 3 else 0.8) if swinging else 1.0, bound)
    return Traction(q, slip, state, NEWTON_STEPS, products, errors[-1], False)


def _least_residual(product: Callable[[Array], Array], b: Array, z: Array, w: Array) -> Array:
    """x with product(x) about b; b is destroyed; z, w: scratch (steps, n)."""
    x = np.zeros_like(b)
    first = np.sqrt((b * b).sum())
    for k in range(len(z) if first > 0.0 else 0):
        z[k] = w[k - 1] if k > 0 else b / first
        w[k] = product(z[k])
        if rolling.extend(z, w, k, x, b) <= KRYLOV_TOLERANCE * first:
            break
    return x


def _flexibility(operator: Operator, bound: Array) -> float:
    """Displacement over traction of a circle of the patch's area [m/Pa], after the simplified theory."""
    radius = np.sqrt(float(np.count_nonzero(bound)) * operator.dx * operator.ds / np.pi)
    c = operator.compliance
    return float(8.0 * radius / (3.0 * CIRCLE_C11) * np.pi * (c.normal + c.tangential)) + c.layer
