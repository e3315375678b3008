"""FASTSIM on strips (Kalker 1982), with the creepage and the spin of each strip: (creep-flex), (creep-fastsim).

Every strip is followed from its leading edge; where the traction would exceed the bound it slides. Creepages come per
strip (they already contain the spin's share y phi).

With three flexibilities throughout (`fastsim`) the mean of the creepages over the patch works through L1 and L2, the
deviation from it through L3, which on a flat patch with constant spin is Kalker's original. With three where the
surfaces stick and one where they slide (`fastsim_blended`, see `march`) each strip's own creepages work through L1 and
L2, and L3 is left with the turning phi x. Small creepages give Kalker's forces either way.

Kalker's own bound is one paraboloid over the whole ellipse, which takes the strips' forces from the edges to the
middle; here every strip keeps its mu N, because friction is a matter of the place.
"""

from math import pi, sqrt

from wrsim.contact.creep.flexibility import Creepages, Rolling
from wrsim.contact.creep.history import march_with_history
from wrsim.contact.creep.march import TINY, begin, largest_traction, limit_dissipation, march
from wrsim.jit import Record, kernel

PARABOLA_PEAK = 0.375 * pi  # of the parabola over that of the semi-ellipse of equal force


@kernel
def fastsim(on: Rolling, mean: Creepages, peak: float) -> None:
    """Tangential forces of the strips, with three flexibilities throughout. mean: creepages over the patch; peak: of
    the bound over that of the semi-ellipse of equal force, 1 for the elliptic bound, PARABOLA_PEAK for the parabolic
    one."""
    strips, n, soft, direction, shape, work, slip, traction = on
    cells = shape.shape[0]
    step_x, step_y, turn = work[0], work[1], work[2]
    bound = work[3]
    qx, qy = work[4], work[5]
    fx, fy, mz = work[6], work[7], work[8]
    dx = 2.0 / cells
    for i in range(n):
        strip = strips[i]
        a = strip.a
        step_x[i] = -(mean.xi / soft.l1 + (strip.xi - mean.xi) / soft.l3) * a * dx
        step_y[i] = -(mean.eta / soft.l2 + (strip.eta - mean.eta) / soft.l3) * a * dx
        turn[i] = -direction * strip.phi / soft.l3 * a * a * dx
        bound[i] = peak * largest_traction(strip)
        qx[i] = qy[i] = 0.0
        fx[i] = fy[i] = mz[i] = 0.0
    for j in range(cells):
        x = 1.0 - (j + 0.5) * dx
        # from centre to centre of the cells, from the edge to the first centre
        part = 1.0 if j > 0 else 0.5
        middle = x + 0.5 * part * dx
        for i in range(n):
            tx = qx[i] + part * step_x[i]
            ty = qy[i] + part * (step_y[i] + middle * turn[i])
            limit = bound[i] * shape[j]
            scale = min(limit / sqrt(max(tx * tx + ty * ty, 1e-300)), 1.0)
            tx *= scale
            ty *= scale
            qx[i] = tx
            qy[i] = ty
            fx[i] += tx
            fy[i] += ty
            mz[i] += x * ty
        if slip.shape[0] > 0:
            for i in range(n):
                slip[j, i] = sqrt(qx[i] * qx[i] + qy[i] * qy[i]) / max(bound[i] * shape[j], TINY)
        if traction.shape[0] > 0:
            for i in range(n):
                traction[j, i], traction[cells + j, i] = qx[i], qy[i]
    for i in range(n):
        strip = strips[i]
        cell = dx * strip.a * strip.ds
        strip.Fx = fx[i] * cell
        strip.Fy = fy[i] * cell
        strip.Mz = direction * mz[i] * cell * strip.a
    limit_dissipation(strips, n)


@kernel
def fastsim_blended(on: Rolling, model: Record, peak: float, speed: float) -> None:
    """The same (creep-fastsim) with three flexibilities where the surfaces stick and one where they slide. speed: of
    rolling [m/s]."""
    for i in range(on.n):
        begin(on.work, i, peak * largest_traction(on.strips[i]), 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if model.history:
        march_with_history(on, model, False, speed)
    else:
        march(on, False)
