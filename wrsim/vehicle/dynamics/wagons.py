"""Vehicles of a train that move along the track alone, with one degree of freedom each.

Both pivots of a wagon, at s +- a from its middle, are on the centre line r(s). Its axes lie along the chord between
them, its left across the mean of n at both. With the chord's length L and the tangents t_1 ahead and t_2 behind

    r' = (t_1 + t_2) / 2,    w = e x (t_1 - t_2) / L    (wagon-rates)

are velocity of its origin and angular velocity in its direction e per metre of way; what turns about e itself in a
transition of cant is left out. Forces F and moments M of couplings at its ends, and its weight, do work along them:

    m s_tt = r'.(F - m g z) + w.M - R - B,

with running and curve resistance R = a + b |v| + c v^2 + m g k |kappa| where they are asked for, and the force B of the
brake. So the energy of a train is kept, also in curves. The coordinate is m times the way since the start: its rate is
the momentum, its "force" the force, on a mass of 1.

A brake follows steps of the asked share of its largest force by changes d_i at the times t_i. A command comes to the
wagon after the delay x / c along the pipe, and the force goes to its new value with the time constant T:

    B = B_0 sum_i d_i (1 - exp(-(t - t_i - x / c) / T)),    t > t_i + x / c.    (wagon-brake)

Resistance and brake act against the motion and fade below ``FADE``, so that a wagon comes to a stand.
"""

from math import exp

from wrsim.jit import Array, Records, kernel, record
from wrsim.jit.frames import VECTOR, BodyMotion, CurveNodes, put, put_body, vec
from wrsim.jit.linalg import Vec, add, cross, dot, norm, scale, sub
from wrsim.track.path_kernel import frame_at

WAGON = record(
    """
    mass       [kg]       mass
    place      [m]        distance of its middle at the start
    half       [m]        half the distance of its pivots
    constant   [N]        running resistance that does not change with the speed
    linear     [N s/m]    part that grows with the speed
    square     [N s2/m2]  part that grows with its square
    curve      [m]        curve resistance over weight and curvature
    brake      [N]        largest force of the brake
    delay      [s]        time from a command to the beginning of its force
    filling    [s]        time constant of the brake
    loss       [W]        power that resistance and brake take at the last evaluation
    coordinate [int]      number of its coordinate
    along      [1]        velocity of its origin over its speed
    turning    [rad/m]    angular velocity over its speed
    """,
    along=VECTOR,
    turning=VECTOR,
)

FADE = 0.25
"""Speed below which brake and resistance fade [m/s]: that of a wheel of 0.5 m radius at ``loads.BRAKE_FADE``."""


@kernel
def place_wagons(q: Array, q_t: Array, wagons: Records, curve: CurveNodes, bodies: Records, first: int) -> None:
    """Write the motion of every wagon to its body, from ``first`` on, and its rates (wagon-rates) to its record."""
    for k in range(wagons.shape[0]):
        wagon = wagons[k]
        s, speed = wagon.place + q[wagon.coordinate] / wagon.mass, q_t[wagon.coordinate] / wagon.mass
        ahead, behind = frame_at(curve, s + wagon.half), frame_at(curve, s - wagon.half)
        chord = sub(ahead.origin, behind.origin)
        length = norm(chord)
        forward = scale(1.0 / length, chord)
        up = cross(forward, add(ahead.n, behind.n))
        up = scale(1.0 / norm(up), up)
        along = scale(0.5, add(ahead.t, behind.t))
        turning = scale(1.0 / length, cross(forward, sub(ahead.t, behind.t)))
        put(wagon.along, along)
        put(wagon.turning, turning)
        middle = scale(0.5, add(ahead.origin, behind.origin))
        motion = BodyMotion(middle, scale(speed, along), forward, cross(up, forward), up, scale(speed, turning))
        put_body(bodies[first + k], motion)


@kernel
def add_forces_on_wagons(
    t: float, q_t: Array, gravity: float, wagons: Records, steps: Array, wrenches: Records, first: int, out: Array
) -> None:
    """Write the force along the track on every wagon, under its wrench, from ``first`` on. steps: rows (time [s],
    change of the share) of the brakes."""
    for k in range(wagons.shape[0]):
        wagon, wrench = wagons[k], wrenches[first + k]
        force, speed = vec(wrench.force), q_t[wagon.coordinate] / wagon.mass
        weight = wagon.mass * gravity
        pull = dot(vec(wagon.along), Vec(force.x, force.y, force.z - weight))
        pull += dot(vec(wagon.turning), vec(wrench.moment))
        against = wagon.constant + wagon.linear * abs(speed) + wagon.square * speed * speed
        against += weight * wagon.curve * abs(wagon.turning.z)
        for i in range(steps.shape[0] if wagon.brake > 0.0 else 0):
            since = t - steps[i, 0] - wagon.delay
            if since > 0.0:
                against += wagon.brake * steps[i, 1] * (1.0 - exp(-since / wagon.filling))
        against *= min(max(speed / FADE, -1.0), 1.0)
        wagon.loss = against * speed
        out[wagon.coordinate] = pull - against
