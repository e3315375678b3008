"""Steady motion of a whole vehicle along a track: all bodies turn together about the axis of the curve, poses held.

At the place of the reference body the track frame moves at V t and turns at w = V (rotation per metre). A body at r
then moves at v = V t + w x (r - r_0), turns at w (a wheelset in addition about its axle), and takes the force m w x v
and the moment w x L. On straight track nothing accelerates. How fast w itself changes in a transition is left out.
"""

from wrsim.core.body.kinematics import SPIN, X, Y, Z, add_generalised_forces, kinematics
from wrsim.core.body.rigid_body import PITCH, pitched, rates_of
from wrsim.core.jit.arena import Array, Records
from wrsim.core.jit.compiling import kernel
from wrsim.core.linalg import CurveNodes, Vec, add, components, cross, from_components, scale, sub
from wrsim.core.track.path import frame_at, frame_rates, locate


@kernel
def follow_together(
    q: Array, spins: Array, curve: CurveNodes, reference: int, guess: float, speed: float, q_t: Array
) -> tuple[Vec, float, int]:
    """Write the rates of all bodies in steady motion with the poses q.

    spins: angular velocity about its axle of each wheelset [rad/s], beyond that of the turning; wheelsets come first
    among the bodies. reference: body whose place counts; guess [m]: where to look for it.
    q_t: (6 n,) to fill. Returns (angular velocity w [rad/s], distance [m], status of ``locate``).
    """
    own = q[6 * reference : 6 * reference + 6]
    s, status = locate(curve, Vec(own[X], own[Y], own[Z]), guess)
    track = frame_at(curve, s)
    turning, _roll = frame_rates(curve, s)
    omega = scale(speed, turning)
    for k in range(q_t.shape[0] // 6):
        own = q[6 * k : 6 * k + 6]
        rates = q_t[6 * k : 6 * k + 6]
        arm = sub(Vec(own[X], own[Y], own[Z]), track.origin)
        velocity = add(scale(speed, track.t), cross(omega, arm))
        rates[Z], rates[X], rates[Y] = velocity.z, velocity.x, velocity.y
        rates_of(own, omega, rates)
        if k < spins.shape[0]:
            rates[SPIN] += spins[k]
    return omega, s, status


@kernel
def together_inertia(q: Array, q_t: Array, omega: Vec, inertia: Records, wheelsets: int, out: Array) -> None:
    """Generalised forces (6 n,) that the steady motion takes.

    omega: the turning of all [rad/s]; inertia: (n,) records INERTIA; wheelsets: bodies before this number have axes
    that do not spin with them.
    """
    out[:] = 0.0
    for k in range(inertia.shape[0]):
        own = q[6 * k : 6 * k + 6]
        body = kinematics(own, q_t[6 * k : 6 * k + 6])
        axes = pitched(body, own[PITCH] if k >= wheelsets else 0.0)
        turn = components(body.omega, axes.forward, axes.left, axes.up)
        about = inertia[k]
        momentum = from_components(
            Vec(about.xx * turn.x, about.yy * turn.y, about.zz * turn.z), axes.forward, axes.left, axes.up
        )
        force = scale(about.mass, cross(omega, body.velocity))
        add_generalised_forces(body, force, cross(omega, momentum), out[6 * k : 6 * k + 6])
