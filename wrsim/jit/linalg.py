"""Vectors: tuples that kernels compute with.

They are made inside of kernels and cost nothing there: the compiler keeps their numbers in registers. Their numbers
must all be floats (``Vec(1.0, 0.0, 0.0)``, not ``Vec(1, 0, 0)``).
"""

from math import sqrt
from typing import Any, NamedTuple

from wrsim.jit import inlined


class Vec(NamedTuple):
    """A vector: its components along x, y, z of whatever axes are spoken of."""

    x: float
    y: float
    z: float


ZERO = Vec(0.0, 0.0, 0.0)


@inlined
def add(a: Any, b: Vec) -> Vec:
    """a + b."""
    return Vec(a.x + b.x, a.y + b.y, a.z + b.z)


@inlined
def sub(a: Any, b: Any) -> Vec:
    """a - b."""
    return Vec(a.x - b.x, a.y - b.y, a.z - b.z)


@inlined
def scale(s: float, a: Vec) -> Vec:
    """s a."""
    return Vec(s * a.x, s * a.y, s * a.z)


@inlined
def shifted(a: Vec, s: float, d: Vec) -> Vec:
    """a + s d."""
    return Vec(a.x + s * d.x, a.y + s * d.y, a.z + s * d.z)


@inlined
def mixed(r: float, a: Any, s: float, b: Any) -> Vec:
    """r a + s b."""
    return Vec(r * a.x + s * b.x, r * a.y + s * b.y, r * a.z + s * b.z)


@inlined
def dot(a: Vec, b: Vec) -> float:
    """a . b."""
    return a.x * b.x + a.y * b.y + a.z * b.z


@inlined
def cross(a: Vec, b: Vec) -> Vec:
    """a x b."""
    return Vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


@inlined
def norm(a: Vec) -> float:
    """Length of a."""
    return sqrt(a.x * a.x + a.y * a.y + a.z * a.z)


@inlined
def from_components(c: Any, t: Vec, n: Vec, b: Vec) -> Vec:
    """c.x t + c.y n + c.z b: the vector that has the components c along three axes."""
    return Vec(c.x * t.x + c.y * n.x + c.z * b.x, c.x * t.y + c.y * n.y + c.z * b.y, c.x * t.z + c.y * n.z + c.z * b.z)


@inlined
def components(a: Vec, t: Vec, n: Vec, b: Vec) -> Vec:
    """(a . t, a . n, a . b): components along three axes."""
    return Vec(dot(a, t), dot(a, n), dot(a, b))
