"""Elastic bodies and axles: modes of vibration on top of the rigid motion.

A body deforms by u(p) = sum_k phi_k(p) eta_k and turns locally by theta(p) = sum_k psi_k(p) eta_k, both in the body's
axes. The modes are those of the free body, so they move neither its centre nor its mean orientation (Buckens' frame:
O. P. Agrawal and A. A. Shabana, Comput. Struct. 21 (1985) 1303) and weight does no work on them; with deformations
small beside the body the rigid equations stay as they are, and

    m_k (eta_k_tt + 2 zeta_k omega_k eta_k_t + omega_k^2 eta_k) = sum over attachments of phi_k . F + psi_k . M - f_k

with f_k, what the preload does to the mode: in the design position the body has its given shape. Forces act at
attachments, which move with both motions. Changes of inertia by the deformation, and products of velocities of the
deformation and angular velocities, are left out, but for those of a wheelset's spin: with Omega about the axle e, polar
moments of inertia J_d of its sections and the sums g_k = sum J_d psi_k and G_kl = sum J_d e . (psi_k x psi_l)

    on mode k:  -Omega (e . (g_k x omega) + sum_l G_kl eta_l_t),      on the wheelset:  -Omega sum_k eta_k_t g_k x e.

Axes of a wheelset do not spin, so its modes are bending in two planes that stand still.
"""

from wrsim.jit import Array, Records, inlined, kernel, record
from wrsim.jit.frames import VECTOR, BodyMotion, accumulate, get_body, point_velocity, put_body, vec
from wrsim.jit.linalg import ZERO, Vec, add, cross, dot, from_components, scale, shifted, sub
from wrsim.vehicle.dynamics.kinematics import SPIN
from wrsim.vehicle.dynamics.suspension import in_body_axes, material_point

MODE = record(
    """
    stiffness  [1/s2] omega^2
    damping    [1/s]  2 zeta omega
    mass       [kg]   modal mass m
    rest       [N]    force f of the preload
    coordinate [int]  number of eta [m] among the coordinates
    body       [int]  number of the body
    first      [int]  number of the body's first mode
    count      [int]  number of the body's modes
    turning    [kg m] g of a wheelset
    """,
    turning=VECTOR,
)
"""A mode of an elastic body."""

ATTACHMENT = record(
    """
    body  [int] number of the body
    first [int] number of the body's first mode
    count [int] number of the body's modes
    spins [int] 1: the body is an axle
    point [m]   place in the body's axes
    """,
    point=VECTOR,
)
"""A point of an elastic body."""


@inlined
def _shape(shapes: Array, j: int, k: int) -> tuple[Vec, Vec]:
    """Displacement and turn of the attachment j for a unit of the mode k of its body."""
    row = shapes[j, k]
    return Vec(row[0], row[1], row[2]), Vec(row[3], row[4], row[5])


@kernel
def attached(
    body: BodyMotion, j: int, q: Array, q_t: Array, modes: Records, attachments: Records, shapes: Array
) -> BodyMotion:
    """The attachment j of a body as a body of its own. shapes (attachments, modes, 6): displacement and turn."""
    attachment = attachments[j]
    moved, turned, velocity, rate = ZERO, ZERO, ZERO, ZERO
    for k in range(attachment.count):
        coordinate = modes[attachment.first + k].coordinate
        shift, turn = _shape(shapes, j, k)
        moved, velocity = shifted(moved, q[coordinate], shift), shifted(velocity, q_t[coordinate], shift)
        turned, rate = shifted(turned, q[coordinate], turn), shifted(rate, q_t[coordinate], turn)
    f, left, up = body.forward, body.left, body.up
    place = add(material_point(body, attachment.point), from_components(moved, f, left, up))
    moving = add(point_velocity(body, place), from_components(velocity, f, left, up))
    about = from_components(turned, f, left, up)
    omega = add(body.omega, from_components(rate, f, left, up))
    return BodyMotion(place, moving, _turned(f, about), _turned(left, about), _turned(up, about), omega)


@inlined
def _turned(axis: Vec, about: Vec) -> Vec:
    """An axis turned by a small angle; to second order, so that it stays a unit vector to fourth."""
    once = cross(about, axis)
    return shifted(add(axis, once), 0.5, cross(about, once))


@kernel
def deform(
    q: Array, q_t: Array, modes: Records, attachments: Records, shapes: Array, bodies: Records, place: int
) -> None:
    """Write all attachments as bodies, behind ``place`` others."""
    for j in range(attachments.shape[0]):
        body = get_body(bodies[attachments[j].body])
        put_body(bodies[place + j], attached(body, j, q, q_t, modes, attachments, shapes))


@kernel
def push_modes(
    j: int, body: BodyMotion, force: Vec, moment: Vec, modes: Records, attachments: Records, shapes: Array, out: Array
) -> None:
    """Add the accelerations of the modes by a force and a moment at the attachment j of a body."""
    attachment = attachments[j]
    f, m = in_body_axes(body, force), in_body_axes(body, moment)
    for k in range(attachment.count):
        mode = modes[attachment.first + k]
        shift, turn = _shape(shapes, j, k)
        out[mode.coordinate] += (dot(shift, f) + dot(turn, m)) / mode.mass


@kernel
def hand_over_forces(
    modes: Records, attachments: Records, shapes: Array, bodies: Records, wrenches: Records, place: int, out: Array
) -> None:
    """Hand what acts on the attachments, behind ``place`` other bodies, over to their bodies and modes."""
    for j in range(attachments.shape[0]):
        wrench, i = wrenches[place + j], attachments[j].body
        body, force, moment = get_body(bodies[i]), vec(wrench.force), vec(wrench.moment)
        turning = cross(sub(vec(bodies[place + j].position), body.position), force)
        if attachments[j].spins != 0:  # each section of an axle spins about its own middle
            turning = shifted(turning, -dot(turning, body.left), body.left)
        accumulate(wrenches[i].force, force)
        accumulate(wrenches[i].moment, add(moment, turning))
        push_modes(j, body, force, moment, modes, attachments, shapes, out)


@kernel
def vibrate(
    q: Array, q_t: Array, modes: Records, gyroscopic: Array, bodies: Records, wrenches: Records, out: Array
) -> None:
    """Write the accelerations of all modes without forces but those at rest, and the gyroscopic ones of wheelsets;
    adds their moments. gyroscopic (modes, modes of a body): G [kg m2/m2]."""
    for k in range(modes.shape[0]):
        mode = modes[k]
        coordinate = mode.coordinate
        out[coordinate] = -mode.stiffness * q[coordinate] - mode.damping * q_t[coordinate] - mode.rest / mode.mass
        if mode.turning.x == 0.0 and mode.turning.z == 0.0:
            continue
        body, spin = get_body(bodies[mode.body]), q_t[6 * mode.body + SPIN]
        g = from_components(mode.turning, body.forward, body.left, body.up)
        held = dot(body.left, cross(g, body.omega))
        for j in range(mode.count):
            held += gyroscopic[k, j] * q_t[modes[mode.first + j].coordinate]
        out[coordinate] -= spin * held / mode.mass
        accumulate(wrenches[mode.body].moment, scale(-spin * q_t[coordinate], cross(g, body.left)))


@inlined
def wheel_on_axle(seat: BodyMotion, arm: float, spin: float) -> BodyMotion:
    """The wheelset that a rigid one would have to be to move the wheel at its attachment as the elastic one does.

    seat: the attachment; arm: place of the wheel on the axle [m]; spin: angular velocity of the wheel about it [rad/s].
    """
    place = shifted(seat.position, -arm, seat.left)
    velocity = point_velocity(seat, place)
    return BodyMotion(place, velocity, seat.forward, seat.left, seat.up, shifted(seat.omega, spin, seat.left))


@inlined
def at_wheel(wheel: BodyMotion, arm: float, force: Vec, moment: Vec) -> tuple[Vec, Vec]:
    """Place of the wheel on its axle, and the moment about it of what acts on it; wheel: as `wheel_on_axle` gives it;
    force and moment: at its position."""
    place = shifted(wheel.position, arm, wheel.left)
    return place, add(moment, cross(sub(wheel.position, place), force))
