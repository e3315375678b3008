"""Vectors, frames, bodies and curves: the tuples that kernels compute with.

They are made inside of kernels and cost nothing there: the compiler keeps their numbers in registers. Their numbers
must all be floats (``Vec(1.0, 0.0, 0.0)``, not ``Vec(1, 0, 0)``).
"""

from math import sqrt
from typing import Any, NamedTuple

from wrsim.core.compiling import inlined


class Vec(NamedTuple):
    """A vector: its components along x, y, z of whatever axes are spoken of."""

    x: float
    y: float
    z: float


class Frame(NamedTuple):
    """Origin [m] and orthonormal axes: tangent t, n to the left, b up; in global axes."""

    origin: Vec
    t: Vec
    n: Vec
    b: Vec


class Body(NamedTuple):
    """A rigid body in motion, in global axes: centre of mass [m], its velocity [m/s], axes, angular velocity [rad/s].

    left: towards the left side; of a wheelset along the axle.
    """

    position: Vec
    velocity: Vec
    forward: Vec
    left: Vec
    up: Vec
    omega: Vec


class Curve(NamedTuple):
    """A space curve: its table (n, 11), see ``core.track.path``, and the arclength between rows [m]."""

    table: Any
    step: float


@inlined
def add(a, b):
    """a + b."""
    return Vec(a.x + b.x, a.y + b.y, a.z + b.z)


@inlined
def sub(a, b):
    """a - b."""
    return Vec(a.x - b.x, a.y - b.y, a.z - b.z)


@inlined
def scale(s, a):
    """s a."""
    return Vec(s * a.x, s * a.y, s * a.z)


@inlined
def shifted(a, s, d):
    """a + s d."""
    return Vec(a.x + s * d.x, a.y + s * d.y, a.z + s * d.z)


@inlined
def dot(a, b):
    """a . b."""
    return a.x * b.x + a.y * b.y + a.z * b.z


@inlined
def cross(a, b):
    """a x b."""
    return Vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


@inlined
def norm(a):
    """Length of a."""
    return sqrt(a.x * a.x + a.y * a.y + a.z * a.z)


@inlined
def combined(c, t, n, b):
    """c.x t + c.y n + c.z b: the vector that has the components c along three axes."""
    return Vec(
        c.x * t.x + c.y * n.x + c.z * b.x,
        c.x * t.y + c.y * n.y + c.z * b.y,
        c.x * t.z + c.y * n.z + c.z * b.z,
    )


@inlined
def components(a, t, n, b):
    """(a . t, a . n, a . b): components along three axes."""
    return Vec(dot(a, t), dot(a, n), dot(a, b))


@inlined
def point_velocity(body, point):
    """Velocity [m/s] of the body's material at a global point: v + omega x r."""
    return add(body.velocity, cross(body.omega, sub(point, body.position)))


@inlined
def read(row, k):
    """The vector in row[k : k + 3]."""
    return Vec(row[k], row[k + 1], row[k + 2])


@inlined
def write(row, k, a):
    """Write a vector to row[k : k + 3]."""
    row[k] = a.x
    row[k + 1] = a.y
    row[k + 2] = a.z


@inlined
def accumulate(row, a):
    """Add a vector to row[:3]."""
    row[0] += a.x
    row[1] += a.y
    row[2] += a.z


@inlined
def read_body(row):
    """The body in a row of 18 numbers."""
    return Body(read(row, 0), read(row, 3), read(row, 6), read(row, 9), read(row, 12), read(row, 15))


@inlined
def write_body(row, body):
    """Write a body to a row of 18 numbers, in the order of its fields."""
    write(row, 0, body.position)
    write(row, 3, body.velocity)
    write(row, 6, body.forward)
    write(row, 9, body.left)
    write(row, 12, body.up)
    write(row, 15, body.omega)
