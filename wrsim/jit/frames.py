"""Frames, bodies in motion and curves as tuples, and the records that hold vectors and bodies.

Records lie in the workspace (`jit.records`): ``bodies[i].velocity.x`` reads and writes in place, compiled or not.
"""

from typing import Any, NamedTuple

from wrsim.jit import Array, Record, inlined, record
from wrsim.jit.linalg import Vec, add, cross, sub

VECTOR = record("""
    x [unit] first component
    y [unit] second component
    z [unit] third component
""")
"""A vector in the axes and the unit of the field that holds it."""
BODY = record(
    """
    position [m]     centre of mass
    velocity [m/s]   velocity of that
    forward  [1]     axes, unit vectors: forward, ...
    left     [1]     ... to the left, of a wheelset along the axle, ...
    up       [1]     ... and up
    omega    [rad/s] angular velocity
    """,
    position=VECTOR, velocity=VECTOR, forward=VECTOR, left=VECTOR, up=VECTOR, omega=VECTOR,
)  # fmt: skip
"""A rigid body in motion, in global axes: a `BodyMotion`."""


class Frame(NamedTuple):
    """Origin [m] and orthonormal axes: tangent t, n to the left, b up; in global axes."""

    origin: Vec
    t: Vec
    n: Vec
    b: Vec


class BodyMotion(NamedTuple):
    """A rigid body in motion, in global axes: centre of mass [m], its velocity [m/s], axes, angular velocity [rad/s].
    left: towards the left side; of a wheelset along the axle."""

    position: Vec
    velocity: Vec
    forward: Vec
    left: Vec
    up: Vec
    omega: Vec


class CurveNodes(NamedTuple):
    """A space curve: its nodes, (n,) records NODE of ``track.path_kernel``, and the arclength between them [m]."""

    nodes: Any
    step: float


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
