"""Normal contact of half-spaces on a grid (hs-normal): steps of a preconditioned conjugate gradient method with bounds.

Conjugate gradients run on the elements in contact; elements that would pull leave, elements that would overlap enter
(Polonsky and Keer, Wear 231, 1999). Preconditioned in Fourier space with the inverse symbol of A, |k| E*/2
(Vollebregt, Tribology Transactions 57, 2014), six to ten iterations reach 1e-4.

The convolutions A p are done by wrsim.contact.half_space.normal; everything here is one pass over the elements.
"""

from typing import Any, NamedTuple

from wrsim.jit import Array, kernel


class Descent(NamedTuple):
    """State of the method, arrays (elements,): pressure, gap after deformation, whether in contact, ... residual: gap
    in contact, else zero; last: residual one step before; direction: of the search."""

    p: Any
    gap: Any
    contact: Any
    residual: Any
    last: Any
    direction: Any


@kernel
def errors(d: Descent) -> tuple[float, float]:
    """Write the residual. Returns its largest size and the deepest overlap outside contact [m]."""
    largest = 0.0
    overlap = 0.0
    for i in range(d.p.size):
        if d.contact[i]:
            d.residual[i] = d.gap[i]
            largest = max(largest, abs(d.gap[i]))
        else:
            d.residual[i] = 0.0
            overlap = max(overlap, -d.gap[i])
    return largest, overlap


@kernel
def turn(d: Descent, z: Array, rho_last: float) -> float:
    """Next direction t = z + beta t on the contact (Polak and Ribiere); z: preconditioned residual. rho_last: z r of
    the last step, not positive for a fresh start. Returns z r."""
    rho = 0.0
    change = 0.0
    for i in range(z.size):
        if d.contact[i]:
            rho += z[i] * d.residual[i]
            change += z[i] * (d.residual[i] - d.last[i])
        d.last[i] = d.residual[i]
    beta = max(change / rho_last, 0.0) if rho_last > 0.0 else 0.0
    for i in range(z.size):
        d.direction[i] = z[i] + beta * d.direction[i] if d.contact[i] else 0.0
    return rho


@kernel
def advance(d: Descent, product: Array) -> int:
    """Step to the minimum along t; product: A t. Elements that would pull leave the contact with p = 0. The gap
    changes by the unclipped step. Returns the number of elements that left; then it must be computed anew."""
    rt = 0.0
    tat = 0.0
    for i in range(product.size):
        if d.contact[i]:
            rt += d.gap[i] * d.direction[i]
            tat += d.direction[i] * product[i]
    if tat <= 0.0:
        return 0
    tau = rt / tat
    left = 0
    for i in range(product.size):
        d.gap[i] -= tau * product[i]
        if d.contact[i]:
            d.p[i] -= tau * d.direction[i]
            if d.p[i] < 0.0:
                d.p[i] = 0.0
                d.contact[i] = False
                left += 1
    return left


@kernel
def admit(d: Descent, tolerance: float) -> None:
    """Elements that overlap by more than the tolerance [m] enter the contact."""
    for i in range(d.p.size):
        if d.gap[i] < -tolerance:
            d.contact[i] = True
