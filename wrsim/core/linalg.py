"""Vectors, frames, bodies and curves: the tuples that kernels compute with, and the records that keep them.

Tuples are made inside of kernels and cost nothing there: the compiler keeps their numbers in registers. Their numbers
must all be floats (``Vec(1.0, 0.0, 0.0)``, not ``Vec(1, 0, 0)``). Records lie in the arena
(``core.jit.arena.records``): ``bodies[i].velocity.x`` reads and writes in place, compiled or not.
"""

from math import sqrt
from typing import Any, NamedTuple

from wrsim.core.jit.arena import Array, Record, record
from wrsim.core.jit.compiling import inlined

VECTOR = record("x y z")
BODY = record(position=VECTOR, velocity=VECTOR, forward=VECTOR, left=VECTOR, up=VECTOR, omega=VECTOR)


class Vec(NamedTuple):
    """A vector: its components along x, y, z of whatever axes are spoken of."""

    x: float
    y: float
    z: float


ZERO = Vec(0.0, 0.0, 0.0)


class Frame(NamedTuple):
    """Origin [m] and orthonormal axes: tangent t, n to the left, b up; in global axes."""

    origin: Vec
    t: Vec
    n: Vec
    b: Vec


class BodyMotion(NamedTuple):
    """A rigid body in motion, in global axes: centre of mass [m], its velocity [m/s], axes, angular velocity [rad/s].

    left: towards the left side; of a wheelset along the axle.
    """

    position: Vec
    velocity: Vec
    forward: Vec
    left: Vec
    up: Vec
    omega: Vec


class CurveNodes(NamedTuple):
    """A space curve: its nodes, (n,) records NODE of ``core.track.path``, and the arclength between them [m]."""

    nodes: Any
    step: float


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
    return Vec(
        c.x * t.x + c.y * n.x + c.z * b.x,
        c.x * t.y + c.y * n.y + c.z * b.y,
        c.x * t.z + c.y * n.z + c.z * b.z,
    )


@inlined
def components(a: Vec, t: Vec, n: Vec, b: Vec) -> Vec:
    """(a . t, a . n, a . b): components along three axes."""
    return Vec(dot(a, t), dot(a, n), dot(a, b))


@inlined
def point_velocity(body: BodyMotion, point: Vec) -> Vec:
    """Velocity [m/s] of the body's material at a global point: v + omega x r."""
    return add(body.velocity, cross(body.omega, sub(point, body.position)))


@inlined
def vec_at(row: Array, k: int) -> Vec:
    """The vector in row[k : k + 3] of an array."""
    return Vec(row[k], row[k + 1], row[k + 2])


@inlined
def put_at(row: Array, k: int, a: Vec) -> None:
    """Write a vector to row[k : k + 3] of an array."""
    row[k] = a.x
    row[k + 1] = a.y
    row[k + 2] = a.z


@inlined
def vec(row: Record) -> Vec:
    """The vector that a VECTOR record holds."""
    return Vec(row.x, row.y, row.z)


@inlined
def put(row: Record, a: Vec) -> None:
    """Write a vector to a VECTOR record."""
    row.x = a.x
    row.y = a.y
    row.z = a.z


@inlined
def accumulate(row: Record, a: Vec) -> None:
    """Add a vector to a VECTOR record."""
    row.x += a.x
    row.y += a.y
    row.z += a.z


@inlined
def get_body(row: Record) -> BodyMotion:
    """The body that a BODY record holds."""
    return BodyMotion(
        vec(row.position), vec(row.velocity), vec(row.forward), vec(row.left), vec(row.up), vec(row.omega)
    )


@inlined
def put_body(row: Record, body: BodyMotion) -> None:
    """Write a body to a BODY record."""
    put(row.position, body.position)
    put(row.velocity, body.velocity)
    put(row.forward, body.forward)
    put(row.left, body.left)
    put(row.up, body.up)
    put(row.omega, body.omega)
