"""Axle boxes: bodies that turn freely about the axle of their wheelset, as the arms of a primary suspension do.

An axle box sits on the axle at the lateral place y and has one coordinate of its own, its pitch a about the axle,
counted like the pitch of other bodies. It moves with the wheelset but for the spin. What suspension elements do to it,
the force F and the moment M at its middle on the axle, goes to the wheelset but for the part of M along the axle e,
which turns the box:

    wheelset: F,  y e x F + M - (M.e) e;      box: I (a_t + heading_t sin(roll))_t = M.e

with the box's inertia I about the axle; heading_t sin(roll), which changes with the track alone, is left out of the
acceleration. The bearing has no friction. Mass and the other inertias of the box count among those of the wheelset: its
centre lies on the axle. What lies further out on an arm is to be shared between axle and frame by the lever.
"""

from wrsim.core.body.rigid_body import pitched
from wrsim.core.jit.arena import Record, record
from wrsim.core.jit.compiling import kernel
from wrsim.core.linalg import BodyMotion, accumulate, add, cross, dot, point_velocity, scale, shifted, vec

AXLE_BOX = record("inertia lateral", "wheelset coordinate")
"""Inertia about the axle [kg m2], place on the axle [m]; body it sits on, number of its pitch among the coordinates."""


@kernel
def on_axle(box: Record, wheelset: BodyMotion, pitch: float, rate: float) -> BodyMotion:
    """The box as a body; wheelset: a body that does not spin; pitch [rad] and its rate."""
    arm = scale(box.lateral, wheelset.left)
    at = add(wheelset.position, arm)
    turning = shifted(wheelset.omega, rate, wheelset.left)
    whole = BodyMotion(at, point_velocity(wheelset, at), wheelset.forward, wheelset.left, wheelset.up, turning)
    return pitched(whole, pitch)


@kernel
def hand_over(box: Record, wheelset: BodyMotion, wrench: Record, onto: Record) -> float:
    """Add what acts on the box, but for the moment about the axle, to the wrench ``onto`` of its wheelset.

    Returns the acceleration of its pitch [rad/s2].
    """
    force, moment = vec(wrench.force), vec(wrench.moment)
    about = dot(moment, wheelset.left)
    accumulate(onto.force, force)
    accumulate(onto.moment, cross(scale(box.lateral, wheelset.left), force))
    accumulate(onto.moment, shifted(moment, -about, wheelset.left))
    return about / box.inertia
