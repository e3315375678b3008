"""The coefficient of friction of each strip: by zone of the rail and by slip speed.

Zones: up to one contact angle the top of the rail, from another one on its gauge corner, a smooth ramp between. Slip:

    mu = mu_0 ((1 - A) exp(-B w) + A)

falls from mu_0 at rest to A mu_0 (Polach 2005). w is the speed of the rigid slip, as a mean over the strip,
w = V sqrt(xi^2 + eta^2 + (phi a)^2 / 3): it depends on the motion alone, so the coefficient cannot jump, and in full
sliding it is the true slip. In adhesion, where the true slip is less, mu is a little too low.
"""

from math import exp, sqrt

from wrsim.core.compiling import kernel


@kernel
def set_friction(speed, settings, strips, n):
    """Write mu of n strips, whose creepages, half lengths and normals are set; speed: of rolling [m/s].

    Returns the largest.
    """
    rise = settings.mu_gauge - settings.mu
    ramp = 1.0 / max(settings.zone_end - settings.zone_start, 1e-9)
    kept = settings.fall_ratio
    decay = -settings.fall_decay * sqrt(speed * speed + settings.least_speed * settings.least_speed)
    largest = 0.0
    for i in range(n):
        strip = strips[i]
        mu = settings.mu
        if rise != 0.0:
            # tan(angle / 2) rises with the angle and needs no arcus
            part = min(max((-strip.no / (1.0 + strip.nb) - settings.zone_start) * ramp, 0.0), 1.0)
            mu += rise * part * part * (3.0 - 2.0 * part)
        if kept < 1.0:
            turn = strip.phi * strip.a
            slip = sqrt(strip.xi * strip.xi + strip.eta * strip.eta + turn * turn / 3.0)
            mu *= kept + (1.0 - kept) * exp(decay * slip)
        strip.mu = mu
        largest = max(largest, mu)
    return largest
