"""FaStrip (Sichani, Enblom and Berg 2016): strip theory where the surfaces stick, FASTSIM's march where they slip.

Strip theory takes each strip for a rolling cylinder in plane strain. Its tractions (creep-fastrip) have constant
gradients of displacement in the zone of adhesion, the 2d behind the leading edge. They cancel the rigid slip
(xi, eta + phi x) there if

    alpha = (xi' / e, eta' / e + psi),   xi' = G xi / (2 (1 - nu) c),   eta' = G eta / (2 c),   psi = G phi / (2 c),

and the slip zone behind begins at the bound if |alpha| = 1: a quadratic equation for e, with the root
(creep-fastrip-e), valid for |psi| < 1; then |T| <= mu p throughout. A strip with e > a slips all along. Summed over an
ellipse this gives creep coefficients pi^2 / (4 (1 - nu)), pi^2 / 4 and pi sqrt(a/b) / 3, true for slender strips only.
FaStrip puts Kalker's coefficients in their place, with FASTSIM's flexibilities (creep-fastrip-e).

Behind the adhesion zone the tractions are followed as in FASTSIM, with one flexibility where they slide and with three
where they stick again (`march`).

With much spin (|psi| -> 1) strip theory has no answer. The adhesion zone is faded out from |psi| = 0.85 on; for
|psi| >= 1 the march starts at the leading edge from zero. An elastic layer takes of the zone its share in L1, and of
its tractions so much that small creepages give Kalker's forces: on a bed of springs alone tractions are FASTSIM's. The
slip zone then is longer than e: alpha is taken for the length that it has, so that what sticks still follows the rigid
slip. |alpha| is below 1 then, and no creepage at all is no place where the direction of a traction at the bound changes
by itself.
Not in the paper: the one flexibility and the sticking again, the fading, the layer, and that the longitudinal creepage
by spin works through L1 like the rest of it.
"""

from math import acos, asin, pi, sqrt

from wrsim.contact.creep.flexibility import Rolling
from wrsim.contact.creep.history import march_with_history
from wrsim.contact.creep.march import BOUND, START_X, START_Y, STUCK, TINY, begin, largest_traction, march
from wrsim.jit import Array, Record, inlined, kernel

FADING = 0.85  # |psi| from which on the adhesion zone of strip theory is taken back


@kernel
def fastrip(on: Rolling, model: Record, half_length: float, speed: float) -> None:
    """Tangential forces of the strips (creep-fastrip), elliptic bound; half_length: of the equivalent ellipse [m];
    speed: of rolling [m/s]."""
    strips, n, soft, direction, shape, work, _slip, traction = on
    dx = 2.0 / shape.shape[0]
    shift = 16.0 * half_length / (3.0 * pi * pi)
    share = 1.0 - model.layer / soft.l1
    reduction = _linear_share(share)
    for i in range(n):
        strip = strips[i]
        bound = largest_traction(strip)
        ax, ay, d, psi = 0.0, 0.0, 0.0, 0.0
        if bound > TINY:
            # all over a
            x = -shift * strip.xi / (soft.l1 * bound)
            y = -shift * strip.eta / (soft.l2 * bound)
            psi = -direction * 0.375 * half_length * strip.phi * strip.a / (soft.l3 * bound)
            ax, ay, d = _adhesion(x, y, psi, share, reduction)
        # what k_d takes from the bound in the adhesion zone; the march adds the rest
        fx = -ax * 0.5 * pi * d * d / dx
        fy = (psi - ay) * 0.5 * pi * d * d / dx
        begin(work, i, bound, 1.0 - 2.0 * d, ax, ay, fx, fy, fy * (1.0 - d))
    if model.history:
        march_with_history(on, model, True, speed)
    else:
        march(on, True)
    if traction.shape[0] > 0:
        for i in range(n):
            if work[BOUND, i] > TINY:
                psi = -direction * 0.375 * half_length * strips[i].phi * strips[i].a / (soft.l3 * work[BOUND, i])
                _add_adhesion(work[:, i], shape.shape[0], psi, traction[:, i])


@kernel
def _add_adhesion(row: Array, cells: int, psi: float, traction: Array) -> None:
    """Add the tractions of k_d in the adhesion zone: their means over the cells of a strip. row: of `march`."""
    d, dx = 0.5 * (1.0 - row[STUCK]), 2.0 / cells
    if d <= 0.0:
        return
    last = 0.25 * pi * d * d
    for j in range(cells):
        u = min(max((d - (j + 1) * dx) / d, -1.0), 1.0)
        primitive = 0.5 * d * d * (u * sqrt(1.0 - u * u) + asin(u))
        mean = row[BOUND] * (last - primitive) / dx
        last = primitive
        traction[j] -= row[START_X] * mean
        traction[cells + j] += (psi - row[START_Y]) * mean


@kernel
def _adhesion(x: float, y: float, psi: float, share: float, reduction: float) -> tuple[float, float, float]:
    """alpha and half length d of the adhesion zone over a (creep-fastrip-e); x, y: xi'/a, eta'/a; share: of the bodies
    in the flexibility; reduction: `_linear_share` of it."""
    size2 = x * x + y * y
    e = 1.0
    if abs(psi) < 1.0:
        root = sqrt(y * y + (1.0 - psi * psi) * x * x) - y * psi
        if size2 == 0.0:
            e = 0.0
        elif size2 < root:
            e = size2 / root
    # smooth, from 1 at FADING to 0 at |psi| = 1
    part = min(max((1.0 - abs(psi)) / (1.0 - FADING), 0.0), 1.0)
    kept = part * part * (3.0 - 2.0 * part)
    start = min(2.0 * kept, 1.0) * reduction
    kept *= share
    d = kept * (1.0 - e)
    ax, ay = x, y + psi * (1.0 - d)
    size = max(sqrt(ax * ax + ay * ay), 1.0 - d)
    if size > 0.0:
        ax /= size
        ay /= size
    elif psi != 0.0:
        ay = 1.0 if psi > 0.0 else -1.0
    return start * ax, start * ay, d


@inlined
def _linear_share(kept: float) -> float:
    """Factor on the tractions of an adhesion zone that begins with this half length over a, 0 to 1: with the march
    behind it an ellipse then has Kalker's forces at small creepages."""
    rest = 1.0 - kept
    if rest <= 0.0 or kept <= 0.0:
        return max(kept, 0.0)
    root = 2.0 * sqrt(kept * rest)
    area = 0.5 * (acos(1.0 - 2.0 * kept) - (1.0 - 2.0 * kept) * root) - 0.5 * pi * kept * kept
    return pi * (1.0 - rest * rest) / (area / rest + 2.0 * root)
