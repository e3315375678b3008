"""The two problems of contact on a grid of a half-space: pressures at a given approach, tractions in steady rolling.

Loops around the kernels of core.contact.half_space.normal and core.contact.half_space.rolling; nothing here knows
wheels or rails.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.half_space.influence import HalfSpaceOperator
from wrsim.core.contact.half_space import normal, rolling

Array = NDArray[np.float64]

FIRST_LEVEL = 0.45  # of the approach: where the first guess of the pressure begins
NORMAL_STEPS = 200
NEWTON_STEPS = 80
KRYLOV_STEPS = 40
MOST_WORK = 1e8  # elements times products after which rolling is given up as not converged: some 10 to 20 s
KRYLOV_TOLERANCE = 0.05
STEP_OF_MAP = 0.4  # rho of the natural map over the inverse of an element's own slip


@dataclass(frozen=True)
class Pressure:
    """Pressures (rows, columns) [Pa], the deformed gap [m], steps taken, and the largest error over the approach."""

    p: Array
    gap: Array
    steps: int
    error: float
    converged: bool


@dataclass(frozen=True)
class Traction:
    """Tractions on the wheel (2, rows, columns) [Pa], slip over the rolling speed, adhesion (1) or slip (2)."""

    q: Array
    slip: Array
    state: Array
    steps: int
    products: int
    error: float
    converged: bool


def solve_normal(
    operator: HalfSpaceOperator, pen: Array, tolerance: float = 1e-4, start: Array | None = None
) -> Pressure:
    """Pressures that make the surfaces touch without overlap.

    pen: undeformed interpenetration (rows, columns) [m]; tolerance: largest error of the gap over the approach, the
    largest of pen; start: pressures to begin with.
    """
    approach = float(pen.max())
    p, contact = np.zeros_like(pen), np.zeros_like(pen)
    if approach <= 0.0:
        return Pressure(p, -pen, 0, 0.0, True)
    if start is not None and start.shape == pen.shape and start.max() > 0.0:
        p[:] = start
        contact[:] = start > 0.0
        e = operator.normal(p)
    else:
        normal.first_guess(pen, FIRST_LEVEL * approach, p, contact)
        e = operator.normal(p)
        scale = float((p * pen).sum() / (p * e).sum())
        p *= scale
        e *= scale
    e -= pen
    r, r_last, t = np.zeros_like(pen), np.zeros_like(pen), np.zeros_like(pen)
    rho = 0.0
    error = np.inf
    for step in range(NORMAL_STEPS):
        largest, overlap = normal.residual(e, contact, r)
        error = max(largest, overlap) / approach
        if error < tolerance:
            return Pressure(p, e, step, error, True)
        rho = normal.direction(operator.near_pressure(r), r, r_last, contact, rho, t)
        if normal.advance(p, e, t, operator.normal(t), contact):
            e = operator.normal(p)
            e -= pen
        normal.admit(e, contact, 0.5 * tolerance * approach)
    return Pressure(p, e, NORMAL_STEPS, error, False)


def solve_rolling(
    operator: HalfSpaceOperator,
    bound: Array,
    rigid_slip: Array,
    forward: float = 1.0,
    tolerance: float = 1e-4,
    start: Array | None = None,
) -> Traction:
    """Tractions of steady rolling.

    bound: largest traction mu p of every element, zero outside contact, (rows, columns) [Pa]; rigid_slip: over the
    rolling speed, (2, rows, columns), of the wheel relative to the rail; forward: +1 when rolling towards larger x;
    tolerance: largest error of a traction over the largest bound.
    """
    shape = rigid_slip.shape
    largest = float(bound.max())
    q, state = np.zeros(shape), np.zeros_like(bound)
    if largest <= 0.0:
        return Traction(q, rigid_slip, state, 0, 0, 0.0, True)
    nx, ns, ratio, rhs = np.zeros_like(bound), np.zeros_like(bound), np.zeros_like(bound), np.zeros(shape)
    rho = STEP_OF_MAP / operator.self_slip()
    scale = 1.0 / (np.sqrt(bound.size) * operator.self_slip())
    # scaled as tractions: the sum of a run times dx over a typical compliance
    if start is not None and start.shape == shape:
        rolling.update(q, start, 1.0, bound)
    else:
        first_guess(operator, bound, rigid_slip, forward, q)
    change, adhering, out, work = np.zeros(shape), np.zeros(shape), np.zeros(shape), np.zeros(shape)
    products = 0
    errors: list[float] = []

    def correction(v: Array) -> Array:
        """From the unknowns of the preconditioned system to a change of q."""
        rolling.pick(v, state, rolling.ADHESION, adhering)
        rolling.join(operator.near_traction(adhering) * unscale, v, state, change)
        return change

    def product(flat: Array) -> Array:
        nonlocal products
        products += 1
        d = correction(flat.reshape(shape))
        rolling.derivative(d, operator.slip(d, forward), rho, scale, forward, state, nx, ns, ratio, out)
        return out.ravel()

    unscale = operator.dx / scale
    basis = np.empty((KRYLOV_STEPS + 1, q.size))
    for step in range(NEWTON_STEPS):
        slip = operator.slip(q, forward)
        products += 1
        slip += rigid_slip
        worst, _, _ = rolling.natural_map(
            q[0], q[1], slip[0], slip[1], bound, rho, scale, forward, state, nx, ns, ratio, rhs
        )
        errors.append(worst / largest)
        if errors[-1] < tolerance:
            return Traction(q, slip, state, step, products, errors[-1], True)
        if products * bound.size > MOST_WORK:
            return Traction(q, slip, state, step, products, errors[-1], False)
        _gmres(product, rhs.ravel(), basis, KRYLOV_TOLERANCE, work.ravel())
        work[:] = correction(work)
        # where a few elements swing between two states a shorter step breaks the circle
        swinging = step > 5 and errors[-1] > 0.3 * errors[-3]
        rolling.update(q, work, (0.5 if step % 3 else 0.8) if swinging else 1.0, bound)
    return Traction(q, slip, state, NEWTON_STEPS, products, errors[-1], False)


def _gmres(product: Callable[[Array], Array], b: Array, basis: Array, tolerance: float, x: Array) -> None:
    """Generalised minimal residuals from zero, without restart, to a relative tolerance. basis: (steps + 1, n)."""
    steps = len(basis) - 1
    columns, y = np.zeros((steps, steps + 1)), np.zeros(steps)
    cosines, sines, g = np.zeros(steps), np.zeros(steps), np.zeros(steps + 1)
    size = float(np.sqrt((b * b).sum()))
    x[:] = 0.0
    if size == 0.0:
        return
    g[0] = size
    np.divide(b, size, out=basis[0])
    done = 0
    while done < steps:
        basis[done + 1] = product(basis[done])
        rolling.orthogonalise(basis, done, columns[done])
        residual = rolling.rotate(columns[done], done, cosines, sines, g)
        done += 1
        if residual <= tolerance * size:
            break
    rolling.combine(basis, columns, done, g, y, x)


def first_guess(operator: HalfSpaceOperator, bound: Array, rigid_slip: Array, forward: float, q: Array) -> None:
    """Tractions after the simplified theory, with the flexibility of a circle of the patch's area (nu = 1/4)."""
    area = float(np.count_nonzero(bound)) * operator.dx * operator.ds
    c = operator.compliance
    flexibility = 8.0 * np.sqrt(area / np.pi) / (3.0 * 4.12) * np.pi * (c.normal + c.tangential)
    rolling.march(rigid_slip[0], rigid_slip[1], bound, flexibility, flexibility, operator.dx, forward, q)
