"""Hertz's contact where the gap is a slanted paraboloid, the first guess of the strip model."""

from math import pi, sqrt
from typing import NamedTuple

from wrsim.jit import kernel

ECCENTRICITY_EXPONENT = 1.27  # power of the gap's ratio of curvatures that gives the ellipse's ratio of axes


class SlantedEllipse(NamedTuple):
    """Contact over a slanted paraboloid."""

    half_length: float  # of the strip in its middle [m]
    half_width: float  # [m]
    factor: float  # k of (strip-amplitude)
    stretch: float  # slope of the line of the strips' middles over that of the ridge


@kernel
def hertz_ellipse(ratio: float, slope: float, depth: float, curvature: float) -> SlantedEllipse:
    """Hertz's ellipse (strip-hertz) over an overlap this deep whose ridge leans by ``slope`` along the rail and bends
    ``ratio`` times as much across as along, ``curvature`` [1/m].

    Integrals by the arithmetic-geometric mean (Abramowitz and Stegun 17.6).
    """
    across = ratio + slope * slope
    apart = sqrt((across - 1.0) ** 2 + 4.0 * slope * slope)
    most, least = 0.5 * (1.0 + across + apart), 0.5 * (1.0 + across - apart)  # principal curvatures, over that along
    thin = (least / most) ** (0.5 * ECCENTRICITY_EXPONENT)
    p, q, power, part = 1.0, thin, 1.0, 0.5
    eccentricity = max(1.0 - thin * thin, 1e-12)
    for _ in range(8):
        c = 0.5 * (p - q)
        p, q = 0.5 * (p + q), sqrt(p * q)
        part += power * c * c / eccentricity
        power *= 2.0
    integral = 0.5 * pi / p
    long = 2.0 * depth / (least * curvature) * part  # squares of both half axes
    short = long * thin * thin
    lean = (1.0 - least) / apart if apart > 0.0 else 0.0  # square of the cosine between x and the shorter axis
    in_x = 1.0 / long + (1.0 / short - 1.0 / long) * lean
    half_length = 1.0 / sqrt(in_x)
    more = (1.0 / (thin * thin) - 1.0) / max(apart, 1e-9)
    return SlantedEllipse(
        half_length, sqrt(in_x * long * short), 2.0 * depth / (curvature * sqrt(short) * integral * half_length),
        more / (1.0 + more * (1.0 - least)),
    )  # fmt: skip
