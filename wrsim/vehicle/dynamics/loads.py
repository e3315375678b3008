"""What acts on the bodies of a vehicle besides suspension and contacts: loads, carried masses, drive and efforts.

Loads. A force at a point of a body, along the axes of the track where the point is, or along those of the body (of a
wheelset: which do not spin). It follows a table over the time or over the distance of the point: linear between the
rows, constant before the first and behind the last.

Carried masses. A mass that follows the track frame without oscillating presses on its body with m (g - a_f), a_f = V^2
dt/ds: the part along t is left to the train that moves it, the other two act at the centre of mass of the body, with
the moment of the lateral part at its height above. The speed at which the cant changes adds no force.

Drive. What holds a vehicle's speed acts like a spring and damper to a point that runs along the track as the speed of
the run says, s_0(t): with the distance s of its reference body and e = s_0 - s, the force is

    M (w^2 e + 2 w e_t) + (M + sum J / r^2) s_0_tt,    w = ``DRIVE_RATE``,

M the mass of the vehicle, J and r inertia about the axle and radius of its wheelsets: what accelerates it does not wait
for a lag. Either it pulls the reference body along the track, as the coupler of a train does, or it comes as equal
moments on the axles, with the reaction on the bodies that hold them. In a train each driven vehicle has a point of its
own; those that are not driven have nothing, and their masses are in M of the driven ones.

Efforts. Moments of motors and brakes on single axles by tables over the time or over the distance of the (first)
vehicle's origin, positive forward, with the same reaction. A negative one is a brake: it is against the rotation, and
fades as the wheelset stops, M omega / ``BRAKE_FADE`` below that rate.

Geared motors. A moment M asked of such an axle is what its motor gives, M / n, times the ratio n of the gear (negative
where the rotor turns against the axle). Against the case of the gear, which pitches at p = e.omega_case about its
lateral axis e, the hollow axle turns at u and the rotor at n u, and the wheelset at w = a.(omega_axle - omega_case)
about its own, a. The kinetic energy of what turns and the twist delta of the hollow axle are

    J_h (u + p)^2 / 2 + J_r (n u + p)^2 / 2,    delta_t = u - w,    T = k delta + c delta_t,

J_h of hollow axle and large wheel, J_r of the rotor. Written in the momentum that belongs to u, J v with J = J_h + n^2
J_r, v = u + sigma p and sigma = (J_h + n J_r) / J, the energy is

    J v^2 / 2 + J_c p^2 / 2,    J_c = J_h J_r (1 - n)^2 / J,

without a product of v and p: J v_t = M - T, and J_c counts with the inertia of the case about e. T a acts on the
wheelset, -M / n e on the body of the motor, and on the case M / n e - T a - sigma (M - T) e. What turns also keeps its
direction: the momentum J_r (n u + p) of the rotor times the rate of the motor's axis is a moment on the motor, that of
the rest on the case; J_c has its own there. Where motor and case are one body, momentum and energy are kept exactly;
else e is the direction of the motor's axis as well, but in its own gyroscopic moment. delta and v are unknowns
of their own.

Slip control. What is asked of an axle, drive and efforts together, is given in full while its slip speed in the
direction of the moment, w = +-(omega r - v), is below half of a limit, and from there linearly less, nothing at the
limit w_1 = w_0 + c V. So no moment of its own lets an axle slip by more. The axle's omega is that against its boxes, v
the speed of its middle.
"""

from typing import NamedTuple

from wrsim.jit import Array, Record, Records, inlined, kernel, record
from wrsim.jit.frames import VECTOR, BodyMotion, CurveNodes, accumulate, get_body, put, vec, vec_at
from wrsim.jit.linalg import Vec, components, cross, dot, from_components, mixed, scale, sub
from wrsim.jit.root import neighbours
from wrsim.track.path_kernel import frame_at, locate
from wrsim.vehicle.dynamics.kinematics import SPIN
from wrsim.vehicle.dynamics.suspension import apply, material_point

LOAD = record(
    """
    s     [m]   distance of the point (a guess, updated)
    body  [int] number of the body
    axes  [int] axes of the force: TRACK_AXES or BODY_AXES
    over  [int] argument of the table: OVER_TIME or OVER_DISTANCE
    start [int] first row of the table
    rows  [int] number of rows of the table
    point [m]   place in the body's axes
    force [N]   force along its axes at the last evaluation
    """,
    point=VECTOR,
    force=VECTOR,
)
"""A force at a point of a body by a table."""

TRACK_AXES, BODY_AXES = range(2)
"""Axes of a load."""

OVER_TIME, OVER_DISTANCE = range(2)
"""What the table of a load goes over."""

CARRIED = record("""
    mass   [kg]  mass
    height [m]   height above the centre of mass of its body
    body   [int] number of the body
""")

AXLE = record("""
    radius    [m]         mean radius of the wheels
    requested [N m]       moment requested at the last evaluation
    moment    [N m]       moment given
    twisting  [N m]       half the difference of the moments on the wheels, left less right
    slip      [m/s]       slip speed
    speed     [m/s]       speed of the middle
    power     [W]         power of the moments and their reaction
    shaft     [N m]       moment that comes to the wheelset
    loss      [W]         power that the damping of the hollow axle takes
    ratio     [1]         turns of a geared motor for one of the axle, negative where it turns the other way
    rotor     [kg m2]     inertia of the rotor
    turning   [kg m2]     inertia of all that turns as the hollow axle sees it
    stiffness [N m/rad]   stiffness between hollow axle and wheelset
    damping   [N m s/rad] damping between them
    body      [int]       number of the wheelset
    holder    [int]       body that takes the reaction (the case of the gear), or -1
    unit      [int]       number of the vehicle
    motor     [int]       body of the motor
    gear      [int]       number of the first unknown of the geared motor, or -1 without one
""")

UNIT = record("""
    mass    [kg]  mass that the drive moves
    inertia [kg]  that mass and the inertia of what turns over its radius squared
    ahead   [m]   distance of the reference body behind the track frame
    s       [m]   distance of the reference body (a guess, updated)
    force   [N]   force of the drive at the last evaluation
    body    [int] number of the reference body
    axles   [int] number of axles
    driven  [int] 1: the vehicle is driven
""")
"""A vehicle, alone or in a train; one that moves along the track alone has no axles."""

EFFORT = record("""
    side  [1]   wheels that the moment acts on: +1 left, -1 right, 0 both
    axle  [int] number of the axle
    over  [int] argument of the table: OVER_TIME or OVER_DISTANCE
    start [int] first row of the table (x, moment)
    rows  [int] number of rows of the table
""")
"""A moment on an axle by a table."""

FREE, TRAIN, WHEELS = range(3)
"""Kinds of drive."""

DRIVE_RATE = 1.0  # [1/s]
BRAKE_FADE = 0.5  # [rad/s]


class ReferenceMotion(NamedTuple):
    """Where the track frame is along the track [m], its speed [m/s] and acceleration [m/s2]."""

    distance: float
    speed: float
    acceleration: float


class Efforts(NamedTuple):
    """Efforts, records EFFORT, and the tables (., 2) of all of them."""

    rows: Records
    tables: Array


@inlined
def _between(tables: Array, start: int, count: int, x: float) -> tuple[int, int, float]:
    """The rows of a table between which x lies, and the part of the way from one to the other."""
    low, high, part = neighbours(tables[start : start + count, 0], x)
    return start + low, start + high, part


@inlined
def _at(tables: Array, start: int, count: int, x: float) -> Vec:
    """The vector at x by the rows (x, vector) of a table; beyond its ends it stays."""
    low, high, part = _between(tables, start, count, x)
    return mixed(1.0 - part, vec_at(tables[low], 1), part, vec_at(tables[high], 1))


@kernel
def add_loads(t: float, bodies: Records, loads: Records, tables: Array, centre: CurveNodes, wrenches: Records) -> int:
    """Add the loads at time t; tables: (., 4) of all of them. Returns the status of ``locate``."""
    for j in range(loads.shape[0]):
        load = loads[j]
        body = get_body(bodies[load.body])
        point = material_point(body, vec(load.point))
        s, bad = locate(centre, point, load.s)
        if bad != 0:
            return bad
        load.s = s
        along = _at(tables, load.start, load.rows, s if load.over == OVER_DISTANCE else t)
        put(load.force, along)
        if load.axes == BODY_AXES:
            force = from_components(along, body.forward, body.left, body.up)
        else:
            track = frame_at(centre, s)
            force = from_components(along, track.t, track.n, track.b)
        apply(wrenches[load.body], body, point, force)
    return 0


@kernel
def add_carried(track: BodyMotion, carried: Records, gravity: float, wrenches: Records) -> None:
    """Add what masses that follow the track frame press on their bodies with; track: its frame as a body."""
    pressing = sub(Vec(0.0, 0.0, -gravity), cross(track.omega, track.velocity))
    across = components(pressing, track.forward, track.left, track.up)
    for j in range(carried.shape[0]):
        load = carried[j]
        force = scale(load.mass, Vec(0.0, across.y, across.z))
        wrench = wrenches[load.body]
        accumulate(wrench.force, from_components(force, track.forward, track.left, track.up))
        accumulate(wrench.moment, scale(-load.height * force.y, track.forward))  # b x n = -t


@kernel
def add_drive(
    reference: ReferenceMotion, drive: int, units: Records, bodies: Records, axles: Records, centre: CurveNodes,
    wrenches: Records,
) -> int:  # fmt: skip
    """Add the pull that holds the speed of every vehicle, or ask its axles for it; returns the status of ``locate``.
    drive: its kind; units: records UNIT, which keep where their reference bodies are."""
    for k in range(units.shape[0]):
        unit = units[k]
        body = get_body(bodies[unit.body])
        s, bad = locate(centre, body.position, unit.s)
        if bad != 0:
            return bad
        unit.s = s
        pull = 0.0
        if drive != FREE and unit.driven != 0:
            track = frame_at(centre, s)
            slower = reference.speed - dot(body.velocity, track.t)
            pull = unit.mass * DRIVE_RATE * (DRIVE_RATE * (reference.distance + unit.ahead - s) + 2.0 * slower)
            pull += unit.inertia * reference.acceleration
            if drive == TRAIN or unit.axles == 0:
                accumulate(wrenches[unit.body].force, scale(pull, track.t))
        unit.force = pull
    for j in range(axles.shape[0]):
        unit = units[axles[j].unit]
        axles[j].requested = unit.force * axles[j].radius / unit.axles if drive == WHEELS else 0.0
    return 0


@kernel
def add_efforts(
    t: float, q_t: Array, vehicle: Record, origin: float, parts: Records, bodies: Records, efforts: Efforts,
    axles: Records, wrenches: Records, out: Array,
) -> None:  # fmt: skip
    """Add the moments on the axles: what the drive asks of them and the efforts. vehicle: a record VEHICLE of
    dynamics.vehicle_forces; origin: distance of the (first) vehicle's origin [m]. out: where the rates of the unknowns
    of geared motors go."""
    for j in range(axles.shape[0]):
        axles[j].twisting = 0.0
    for j in range(efforts.rows.shape[0]):
        effort = efforts.rows[j]
        x = origin if effort.over == OVER_DISTANCE else t
        low, high, part = _between(efforts.tables, effort.start, effort.rows, x)
        moment = (1.0 - part) * efforts.tables[low, 1] + part * efforts.tables[high, 1]
        axle = axles[effort.axle]
        twist = parts[axle.body].twist
        if moment < 0.0:
            spin = q_t[6 * axle.body + SPIN]
            if twist >= 0:
                spin += 0.5 * effort.side * q_t[twist]
            moment *= min(max(spin / BRAKE_FADE, -1.0), 1.0)
        axle.requested += moment
        axle.twisting += 0.5 * effort.side * moment
    for j in range(axles.shape[0]):
        axle = axles[j]
        body = get_body(bodies[axle.body])
        speed = dot(body.velocity, body.forward)
        axle.slip, axle.speed = axle.radius * q_t[6 * axle.body + SPIN] - speed, speed
        axle.moment = axle.requested
        limit = vehicle.slip_speed + vehicle.slip_creepage * abs(speed)
        if limit > 0.0:
            slip = axle.slip if axle.requested > 0.0 else -axle.slip
            axle.moment *= min(max(2.0 - 2.0 * slip / limit, 0.0), 1.0)
        axle.power, axle.shaft, axle.loss = 0.0, axle.moment, 0.0
        if axle.gear >= 0:
            _turn_gear(axle, q_t, vehicle.relaxed != 0, bodies, wrenches, out)
        elif axle.moment != 0.0:
            torque = scale(axle.moment, body.left)
            accumulate(wrenches[axle.body].moment, torque)
            axle.power = axle.moment * q_t[6 * axle.body + SPIN] + dot(torque, body.omega)
            if axle.holder >= 0:
                accumulate(wrenches[axle.holder].moment, scale(-1.0, torque))
                axle.power -= dot(torque, vec(bodies[axle.holder].omega))
        if axle.twisting != 0.0:
            axle.power += axle.twisting * q_t[parts[axle.body].twist]


@kernel
def _turn_gear(axle: Record, q_t: Array, relaxed: bool, bodies: Records, wrenches: Records, out: Array) -> None:
    """Add what a geared motor does to its wheelset, its own body and the case of its gear; write the rates of its
    unknowns, twist and momentum of the hollow axle over its inertia, or where they have come to once relaxed."""
    twist, turning = axle.gear, axle.gear + 1
    about, case, motor = get_body(bodies[axle.body]), get_body(bodies[axle.holder]), get_body(bodies[axle.motor])
    n = axle.ratio
    sigma = 1.0 + n * (1.0 - n) * axle.rotor / axle.turning
    pitch = dot(case.left, case.omega)
    spin = q_t[6 * axle.body + SPIN] + dot(about.left, sub(about.omega, case.omega))
    rate, axle.loss = q_t[turning], 0.0
    if relaxed:
        rate = spin + sigma * pitch
        out[twist], out[turning] = axle.moment / axle.stiffness, rate
    else:
        twisting = rate - sigma * pitch - spin
        axle.shaft = axle.stiffness * q_t[twist] + axle.damping * twisting
        axle.loss = axle.damping * twisting * twisting
        out[twist], out[turning] = twisting, (axle.moment - axle.shaft) / axle.turning
    stator = axle.moment / n
    rotor = n * (rate - sigma * pitch) + pitch
    of_rotor = axle.rotor * rotor
    of_rest = sigma * axle.turning * rate - of_rotor
    onto = wrenches[axle.holder]
    accumulate(wrenches[axle.body].moment, scale(axle.shaft, about.left))
    accumulate(onto.moment, scale(-axle.shaft, about.left))
    accumulate(onto.moment, scale(stator - sigma * (axle.moment - axle.shaft), case.left))
    accumulate(onto.moment, scale(-of_rest, cross(case.omega, case.left)))
    accumulate(wrenches[axle.motor].moment, scale(-stator, case.left))
    accumulate(wrenches[axle.motor].moment, scale(-of_rotor, cross(motor.omega, motor.left)))
    axle.power = stator * (rotor - dot(case.left, motor.omega))
