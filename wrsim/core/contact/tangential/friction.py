"""The coefficient of friction of each strip: by zone of the rail and by slip speed.

Zones: up to one contact angle the top of the rail, from another one on its gauge corner, a smooth ramp between. Slip:

    mu = mu_0 ((1 - A) exp(-B w) + A)

falls from mu_0 at rest to A mu_0 (Polach 2005). w is the speed of the rigid slip, as a mean over the strip,
w = V sqrt(xi^2 + eta^2 + (phi a)^2 / 3): it depends on the motion alone, so the coefficient cannot jump, and in full
sliding it is the true slip. In adhesion, where the true slip is less, mu is a little too low.
"""

from math import exp, sqrt

from wrsim.core.compiling import kernel
from wrsim.core.contact.layout import (
    ETA,
    FALL_DECAY,
    FALL_RATIO,
    FRICTION,
    FRICTION_GAUGE,
    LEAST_SPEED,
    MU,
    NB,
    NO,
    PHI,
    XI,
    ZONE_END,
    ZONE_START,
    A,
)


@kernel
def set_friction(pose, settings, strips, n):
    """Write MU of n strips, whose creepages, half lengths and normals are set. Returns the largest."""
    top = settings[FRICTION]
    rise = settings[FRICTION_GAUGE] - top
    start = settings[ZONE_START]
    ramp = 1.0 / max(settings[ZONE_END] - start, 1e-9)
    kept = settings[FALL_RATIO]
    decay = -settings[FALL_DECAY] * sqrt(pose[6] * pose[6] + settings[LEAST_SPEED] * settings[LEAST_SPEED])
    largest = 0.0
    for i in range(n):
        mu = top
        if rise != 0.0:
            # tan(angle / 2) rises with the angle and needs no arcus
            part = min(max((-strips[i, NO] / (1.0 + strips[i, NB]) - start) * ramp, 0.0), 1.0)
            mu += rise * part * part * (3.0 - 2.0 * part)
        if kept < 1.0:
            turn = strips[i, PHI] * strips[i, A]
            slip = sqrt(strips[i, XI] * strips[i, XI] + strips[i, ETA] * strips[i, ETA] + turn * turn / 3.0)
            mu *= kept + (1.0 - kept) * exp(decay * slip)
        strips[i, MU] = mu
        largest = max(largest, mu)
    return largest
