"""Hertz's contact of a slanted parabolic ground, the first guess of the strip model."""

from math import pi, sqrt
from typing import NamedTuple

from wrsim.jit.compiling import kernel

EXCENTRIC = 1.27  # power of the gap's ratio of curvatures that gives the ellipse's


class SlantedEllipse(NamedTuple):
    """Contact of a slanted parabolic ground: half length [m] of the strip in its middle, half of its width [m], factor
    k, and how much farther apart along x the middles of its strips lie than the ridge."""

    half_length: float
    half_width: float
    factor: float
    stretch: float


@kernel
def hertz_ellipse(ratio, slope, depth, bend):
    """Hertz's ellipse over a ground this deep whose ridge is bent ``ratio`` times as much across as along, and leans.

    slope: of the ridge's place along x; bend: curvature along [1/m]. With both principal curvatures of the gap, c1
    along the longer axis: b/a by a power of their ratio, a^2 = 2 d/c1 (K - E)/(e^2 K), p0 = E* d/(b K) (Johnson,
    Contact Mechanics, 4.2), the integrals by the arithmetic-geometric mean (Abramowitz and Stegun 17.6).
    """
    across = ratio + slope * slope
    apart = sqrt((across - 1.0) ** 2 + 4.0 * slope * slope)
    most, least = 0.5 * (1.0 + across + apart), 0.5 * (1.0 + across - apart)
    thin = (least / most) ** (0.5 * EXCENTRIC)
    p, q, power, part = 1.0, thin, 1.0, 0.5
    excentric = max(1.0 - thin * thin, 1e-12)
    for _ in range(8):
        c = 0.5 * (p - q)
        p, q = 0.5 * (p + q), sqrt(p * q)
        part += power * c * c / excentric
        power *= 2.0
    integral = 0.5 * pi / p
    long = 2.0 * depth / (least * bend) * part  # squares of both half axes
    short = long * thin * thin
    lean = (1.0 - least) / apart if apart > 0.0 else 0.0  # square of the cosine between x and the shorter axis
    in_x = 1.0 / long + (1.0 / short - 1.0 / long) * lean
    half_length = 1.0 / sqrt(in_x)
    more = (1.0 / (thin * thin) - 1.0) / max(apart, 1e-9)
    return SlantedEllipse(
        half_length, sqrt(in_x * long * short), 2.0 * depth / (bend * sqrt(short) * integral * half_length),
        more / (1.0 + more * (1.0 - least)),
    )  # fmt: skip
