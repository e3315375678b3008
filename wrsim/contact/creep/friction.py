"""The coefficient of friction of each strip: by zone of the rail (fric-zone) and by slip speed (fric-fall).

The speed of the rigid slip depends on the motion alone, so the coefficient cannot jump, and in full sliding it is the
true slip. In adhesion, where the true slip is less, mu is a little too low.

Along a rail the numbers of that law may change: rows of a table (n, 7), a place [m] and ``mu`` to ``fall_decay`` of
CALL in their order. Between two rows each number changes by 3 x^2 - 2 x^3, beyond the ends none does.
"""

from math import exp, sqrt

from wrsim.jit import Array, Record, Records, inlined, kernel
from wrsim.jit.root import neighbours


@inlined
def set_law(table: Array, place: float, call: Record) -> None:
    """Write the numbers that hold at a place [m] into the record CALL."""
    low, high, x = neighbours(table[:, 0], place)
    part = x * x * (3.0 - 2.0 * x)
    call.mu = table[low, 1] + part * (table[high, 1] - table[low, 1])
    call.mu_gauge = table[low, 2] + part * (table[high, 2] - table[low, 2])
    call.zone_start = table[low, 3] + part * (table[high, 3] - table[low, 3])
    call.zone_end = table[low, 4] + part * (table[high, 4] - table[low, 4])
    call.fall_ratio = table[low, 5] + part * (table[high, 5] - table[low, 5])
    call.fall_decay = table[low, 6] + part * (table[high, 6] - table[low, 6])


@kernel
def set_friction(speed: float, call: Record, least_speed: float, strips: Records, n: int) -> float:
    """Write mu of n strips, whose creepages, half lengths and normals are set; speed: of rolling, least_speed:
    below which it is regularised [m/s]. Returns the largest."""
    rise = call.mu_gauge - call.mu
    ramp = 1.0 / max(call.zone_end - call.zone_start, 1e-9)
    kept = call.fall_ratio
    decay = -call.fall_decay * sqrt(speed * speed + least_speed * least_speed)
    largest = 0.0
    for i in range(n):
        strip = strips[i]
        mu = call.mu
        if rise != 0.0:
            # tan(angle / 2) rises with the angle and needs no arcus
            part = min(max((-strip.no / (1.0 + strip.nb) - call.zone_start) * ramp, 0.0), 1.0)
            mu += rise * part * part * (3.0 - 2.0 * part)
        if kept < 1.0:
            turn = strip.phi * strip.a
            slip = sqrt(strip.xi * strip.xi + strip.eta * strip.eta + turn * turn / 3.0)
            mu *= kept + (1.0 - kept) * exp(decay * slip)
        strip.mu = mu
        largest = max(largest, mu)
    return largest
