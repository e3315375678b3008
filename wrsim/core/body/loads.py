"""What acts on the bodies of a vehicle besides suspension and contacts: loads, carried masses, the drive.

Loads. A force at a point of a body, along the axes of the track where the point is, or along those of the body (of a
wheelset: which do not spin). It follows a table over the time or over the distance of the point: linear between the
rows, constant before the first and behind the last.

Carried masses. A mass that follows the track frame without oscillating presses on its body with m (g - a_f), a_f = V^2
dt/ds: the part along t is left to the train that moves it, the other two act at the centre of mass of the body, with
the moment of the lateral part at its height above. The speed at which the cant changes adds no force.

Drive. What holds the vehicle's speed acts like a spring and damper to a point that runs along the track at constant
speed: with the distance s of the reference body and e = s_0 + V t - s, the force is M (w^2 e + 2 w (V - s_t)),
w = ``DRIVE_RATE``, M the mass of the vehicle. Either it pulls the reference body along the track, as the coupler of a
train does, or it comes as equal moments on the axles, with the reaction on the bodies that hold them.
"""

from wrsim.core.arena import record
from wrsim.core.body.suspension import apply, material_point
from wrsim.core.compiling import inlined, kernel
from wrsim.core.linalg import (
    VECTOR,
    Vec,
    accumulate,
    combined,
    components,
    cross,
    dot,
    get_body,
    mixed,
    put,
    read,
    scale,
    sub,
    vec,
)
from wrsim.core.track.path import frame, locate

LOAD = record("s", "body axes over start rows", at=VECTOR, force=VECTOR)
"""Distance of the point (a guess, updated) [m]; its body; axes of the force; what its table goes over; first row and
number of rows of its table; point in the body's axes [m]; force along its axes at the state asked for last [N]."""

TRACK_AXES, BODY_AXES = range(2)
"""Axes of a load."""

OVER_TIME, OVER_DISTANCE = range(2)
"""What the table of a load goes over."""

CARRIED = record("mass height", "body")
"""A carried mass [kg] and its height above the centre of its body [m]."""

AXLE = record("radius", "body holder")
"""A driven axle: mean radius of its wheels [m]; the body that takes the reaction, or -1."""

FREE, TRAIN, WHEELS = range(3)
"""Kinds of drive."""

DRIVE_RATE = 1.0  # [1/s]


@inlined
def _at(tables, start, count, x):
    """The vector at x by the rows (x, vector) of a table; beyond its ends it stays."""
    low, high = start, start + count - 1
    if x <= tables[low, 0]:
        return read(tables[low], 1)
    if x >= tables[high, 0]:
        return read(tables[high], 1)
    while high - low > 1:
        middle = (low + high) // 2
        if x < tables[middle, 0]:
            high = middle
        else:
            low = middle
    part = (x - tables[low, 0]) / (tables[high, 0] - tables[low, 0])
    return mixed(1.0 - part, read(tables[low], 1), part, read(tables[high], 1))


@kernel
def add_loads(t, bodies, loads, tables, centre, wrenches):
    """Add the loads at time t; tables: (., 4) of all of them. Returns the status of ``locate``."""
    for j in range(loads.shape[0]):
        load = loads[j]
        body = get_body(bodies[load.body])
        point = material_point(body, vec(load.at))
        s, bad = locate(centre, point, load.s)
        if bad != 0:
            return bad
        load.s = s
        along = _at(tables, load.start, load.rows, s if load.over == OVER_DISTANCE else t)
        put(load.force, along)
        if load.axes == BODY_AXES:
            force = combined(along, body.forward, body.left, body.up)
        else:
            track = frame(centre, s)
            force = combined(along, track.t, track.n, track.b)
        apply(wrenches[load.body], body, point, force)
    return 0


@kernel
def add_carried(track, carried, gravity, wrenches):
    """Add what masses that follow the track frame press on their bodies with; track: its frame as a body."""
    pressing = sub(Vec(0.0, 0.0, -gravity), cross(track.omega, track.velocity))
    across = components(pressing, track.forward, track.left, track.up)
    for j in range(carried.shape[0]):
        load = carried[j]
        force = scale(load.mass, Vec(0.0, across.y, across.z))
        wrench = wrenches[load.body]
        accumulate(wrench.force, combined(force, track.forward, track.left, track.up))
        accumulate(wrench.moment, scale(-load.height * force.y, track.forward))  # b x n = -t


@kernel
def add_drive(t, vehicle, bodies, axles, centre, wrenches):
    """Add what holds the vehicle's speed; returns the status of ``locate``.

    vehicle: a record VEHICLE of core.body.vehicle_forces; keeps the distance of its reference body.
    """
    body = get_body(bodies[vehicle.reference])
    s, bad = locate(centre, body.position, vehicle.s_reference)
    if bad != 0:
        return bad
    vehicle.s_reference = s
    vehicle.drive_force = 0.0
    if vehicle.drive == FREE:
        return 0
    track = frame(centre, s)
    behind = vehicle.start + vehicle.ahead + vehicle.speed * t - s
    slower = vehicle.speed - dot(body.velocity, track.t)
    pull = vehicle.mass * DRIVE_RATE * (DRIVE_RATE * behind + 2.0 * slower)
    vehicle.drive_force = pull
    if vehicle.drive == TRAIN:
        accumulate(wrenches[vehicle.reference].force, scale(pull, track.t))
        return 0
    for j in range(axles.shape[0]):
        axle = axles[j]
        torque = scale(pull * axle.radius / axles.shape[0], vec(bodies[axle.body].left))
        accumulate(wrenches[axle.body].moment, torque)
        if axle.holder >= 0:
            accumulate(wrenches[axle.holder].moment, scale(-1.0, torque))
    return 0
