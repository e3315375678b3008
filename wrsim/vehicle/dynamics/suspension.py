"""Forces of all suspension elements of a vehicle, in one loop over a table of elements.

Each element joins a point of a first body to a point of a second one. After the bodies come the track frame and the
guide frame (``dynamics.vehicle_forces``).

- FIELD: three springs and dampers along the axes of the first body, and rotational ones about them. With d the vector
  between the two points in these axes the force on the second body is f0 - k d - c d_t. Both bodies take the force at
  the second body's point: the field turns with the first body. So the element has a potential (d.k d/2 - f0.d), and
  keeps momentum and angular momentum to round-off, at any angle. The rotational springs have the potential
  sum_i w_i (1 - e_i.e'_i) of the axes e of the first and e' of the second body, w = (kx + ky + kz)/2 - k: their moments
  are k times the angle while this is small. Their preload m0 has the potential -(m0_x z.y' + m0_y x.z' + m0_z y.x').
- SHEAR: half of the element is a field of the first body, half one of the second. Placed at the middle of a flexible
  column (a coil spring) of height h with bending stiffness k_b = E I / h about both axes and shear stiffness 12 E I /
  h^3 this is a beam clamped at both ends; the moment of the load about the shifted ends is shared equally.
- AXIS: one spring and damper along one axis of the first body, as FIELD.
- LINE: one spring and damper along the line between the two points (rods, links).

Springs of AXIS and LINE may be tables of force against travel, dampers tables of force against velocity. A damper may
have a stiffness in series (Maxwell): the extension x of its damping part is an unknown of its own,

    force = k_s (e - x),   x_t = force / c    (or from the table, velocity against force),

which the solver integrates with everything else.

AXIS and LINE may have a slider beside spring and damper (``dynamics.friction``). PLANE is a slider alone, in the plane
across one axis of the first body. The bound of a slider's force is constant, or it grows with the force of an element
(its normal force): those that ask another one come last.
"""

from typing import Any, NamedTuple

from wrsim.jit import Array, Record, Records, inlined, kernel, record
from wrsim.jit.frames import VECTOR, BodyMotion, accumulate, get_body, point_velocity, put, vec
from wrsim.jit.linalg import ZERO, Vec, add, components, cross, dot, from_components, mixed, norm, scale, shifted, sub
from wrsim.vehicle.dynamics.friction import MOVING, NO_SLIDER, relaxed_force, slide, slider_force

FIELD, SHEAR, AXIS, LINE, PLANE = range(5)
"""Kinds of elements."""

ELEMENT = record(
    """
    k               [N/m]       stiffness of AXIS and LINE
    c               [N s/m]     their damping
    force_0         [N]         their force at rest
    length          [m]         length of a LINE at rest
    series          [N/m]       stiffness in series with the damper
    stick           [N/m]       stiffness of a slider (AXIS, LINE, PLANE) where it sticks
    stick_damping   [N s/m]     damping of a slider where it sticks
    bound           [N]         constant part of the bound of a slider's force
    loss            [W]         power that dampers and friction take at the last evaluation
    added           [N]         force of a control: of an AXIS on the second body along the axis, of a LINE tension
    kind            [int]       FIELD, SHEAR, AXIS, LINE or PLANE
    first           [int]       number of the first body
    second          [int]       number of the second body
    direction       [int]       axis of an AXIS, or across a PLANE
    state           [int]       number of the damping part's unknown, or -1
    spring_start    [int]       first row of the spring's table
    spring_rows     [int]       number of its rows; 0: none
    damper_start    [int]       first row of the damper's table
    damper_rows     [int]       number of its rows; 0: none
    slider          [int]       kind of the slider (``dynamics.friction``)
    slip            [int]       number of the slider's first unknown
    normal          [int]       element whose force makes the rest of the bound, or -1
    relaxed         [int]       MOVING, or how unknowns have come to rest: then they stand where their rates go
    point_1         [m]         point in the first body's axes
    point_2         [m]         point in the second body's axes
    stiffness       [N/m]       stiffness of a field (FIELD, SHEAR) along the first body's axes
    damping         [N s/m]     its damping
    preload         [N]         its force at rest
    turning         [N m/rad]   its stiffness about these axes
    turning_preload [N m]       its moment at rest
    turning_damping [N m s/rad] its damping about them
    load            [1]         factors of the reading of ``normal`` in the bound
    """,
    point_1=VECTOR, point_2=VECTOR, stiffness=VECTOR, damping=VECTOR, preload=VECTOR, turning=VECTOR,
    turning_preload=VECTOR, turning_damping=VECTOR, load=VECTOR,
)  # fmt: skip

WRENCH = record(
    """
    force  [N]   force
    moment [N m] moment about the centre of mass
    """,
    force=VECTOR,
    moment=VECTOR,
)
"""Resultant of the forces on a body, in global axes."""

READING = record(
    """
    force  [N] force on the second body in the first body's axes; of a LINE tension in x
    travel [m] travel in these axes; of a LINE extension in x
    """,
    force=VECTOR,
    travel=VECTOR,
)


@inlined
def interpolate(tables: Array, start: int, count: int, x: float) -> float:
    """Piecewise linear function of the rows (x, y); beyond its ends it goes on with the slope there."""
    i = start
    while i < start + count - 2 and x > tables[i + 1, 0]:
        i += 1
    slope = (tables[i + 1, 1] - tables[i, 1]) / (tables[i + 1, 0] - tables[i, 0])
    return tables[i, 1] + slope * (x - tables[i, 0])


@inlined
def material_point(body: BodyMotion, point: Any) -> Vec:
    """Global place of a point given in the body's axes."""
    return add(body.position, from_components(point, body.forward, body.left, body.up))


@inlined
def apply(wrench: Record, body: BodyMotion, point: Vec, force: Vec) -> None:
    """Add a force that acts on a body at a global point."""
    accumulate(wrench.force, force)
    accumulate(wrench.moment, cross(sub(point, body.position), force))


@inlined
def in_body_axes(body: BodyMotion, a: Vec) -> Vec:
    """Components of a vector in the body's axes."""
    return components(a, body.forward, body.left, body.up)


class Suspension(NamedTuple):
    """What elements compute in, of a whole vehicle.

    bodies: records BODY, the frames last; tables: (., 2); inner, inner_t: extensions of the damping parts in series
    with a spring [m] and unknowns of sliders, and their rates, to be filled; wrenches: a record WRENCH per body, added
    to; readings: a record READING per element, to be filled.
    """

    bodies: Records
    tables: Array
    inner: Array
    inner_t: Array
    wrenches: Records
    readings: Records


@inlined
def _ends(on: Suspension, element: Record) -> tuple[BodyMotion, BodyMotion, Vec]:
    """The two bodies of an element, and its point on the second one."""
    second = get_body(on.bodies[element.second])
    return get_body(on.bodies[element.first]), second, material_point(second, element.point_2)


@inlined
def _act(on: Suspension, element: Record, first: BodyMotion, second: BodyMotion, point: Vec, along: Vec) -> None:
    """A force in the axes of the first body, at the second one's point: on the second body, and back on the first."""
    force = from_components(along, first.forward, first.left, first.up)
    apply(on.wrenches[element.second], second, point, force)
    apply(on.wrenches[element.first], first, point, scale(-1.0, force))


@inlined
def _seen_from(first: BodyMotion, second: BodyMotion, end: Vec, point: Any) -> tuple[Vec, Vec]:
    """Vector from a point of the first body to the second body's point ``end``, and the velocity of the second body's
    material there against the first one's; in the first body's axes."""
    d = sub(end, material_point(first, point))
    u = sub(point_velocity(second, end), point_velocity(first, end))
    return in_body_axes(first, d), in_body_axes(first, u)


@kernel
def _one_direction(on: Suspension, element: Record, travel: float, rate: float) -> float:
    """Restoring force of a spring and damper in one direction; travel [m], rate [m/s]."""
    force = element.k * travel
    if element.spring_rows > 0:
        force = interpolate(on.tables, element.spring_start, element.spring_rows, travel)
    start, count = element.damper_start, element.damper_rows
    if element.state < 0:
        damper = interpolate(on.tables, start, count, rate) if count > 0 else element.c * rate
        element.loss = damper * rate
        force += damper
    elif element.relaxed != MOVING:
        on.inner_t[element.state] = travel
    else:
        damper = element.series * (travel - on.inner[element.state])
        slow = interpolate(on.tables, start, count, damper) if count > 0 else damper / element.c
        on.inner_t[element.state] = slow
        element.loss = damper * slow
        force += damper
    return force


@inlined
def _bound(on: Suspension, element: Record) -> float:
    """Bound of a slider's force [N]."""
    if element.normal < 0:
        return element.bound
    return element.bound + max(0.0, dot(vec(element.load), vec(on.readings[element.normal].force)))


@kernel
def _field(on: Suspension, element: Record, sign: float, share: float, reading: Record) -> None:
    """A field of the first body that acts on the second one (sign +1), or the other way round (sign -1). share: of the
    element. Adds force and travel to the reading, in the axes of the body whose field it is."""
    a, b = element.first, element.second
    point_a, point_b = vec(element.point_1), vec(element.point_2)
    if sign < 0.0:
        a, b, point_a, point_b = b, a, point_b, point_a
    first, second = get_body(on.bodies[a]), get_body(on.bodies[b])
    point = material_point(second, point_b)
    d, u = _seen_from(first, second, point, point_a)
    f0, k, c = element.preload, element.stiffness, element.damping
    f = Vec(
        share * (sign * f0.x - k.x * d.x - c.x * u.x),
        share * (sign * f0.y - k.y * d.y - c.y * u.y),
        share * (sign * f0.z - k.z * d.z - c.z * u.z),
    )
    element.loss += share * (c.x * u.x * u.x + c.y * u.y * u.y + c.z * u.z * u.z)
    accumulate(reading.force, scale(sign, f))
    accumulate(reading.travel, scale(sign * share, d))
    force = from_components(f, first.forward, first.left, first.up)
    apply(on.wrenches[b], second, point, force)
    apply(on.wrenches[a], first, point, scale(-1.0, force))


@kernel
def _axis(on: Suspension, element: Record, reading: Record) -> None:
    """A spring and damper along one axis of the first body."""
    first, second, point = _ends(on, element)
    d, u = _seen_from(first, second, point, element.point_1)
    ex, ey, ez = 1.0 * (element.direction == 0), 1.0 * (element.direction == 1), 1.0 * (element.direction == 2)
    along = Vec(ex, ey, ez)
    travel = dot(d, along)
    f = element.force_0 - _one_direction(on, element, travel, dot(u, along)) + element.added
    put(reading.force, scale(f, along))
    if element.slider != NO_SLIDER:
        f -= slider_force(element, _bound(on, element), travel, dot(u, along), on.inner, on.inner_t)
        put(reading.force, scale(f, along))
    put(reading.travel, scale(travel, along))
    _act(on, element, first, second, point, scale(f, along))


@kernel
def _line(on: Suspension, element: Record, reading: Record) -> None:
    """A spring and damper along the line between its two points; reading: tension and extension."""
    first, second, end = _ends(on, element)
    start = material_point(first, element.point_1)
    d = sub(end, start)
    length = norm(d)
    along = scale(1.0 / length, d)
    rate = dot(along, sub(point_velocity(second, end), point_velocity(first, start)))
    extension = length - element.length
    tension = _one_direction(on, element, extension, rate) - element.force_0 + element.added
    put(reading.force, Vec(tension, 0.0, 0.0))
    if element.slider != NO_SLIDER:
        tension += slider_force(element, _bound(on, element), extension, rate, on.inner, on.inner_t)
        put(reading.force, Vec(tension, 0.0, 0.0))
    put(reading.travel, Vec(extension, 0.0, 0.0))
    apply(on.wrenches[element.first], first, start, scale(tension, along))
    apply(on.wrenches[element.second], second, end, scale(-tension, along))


@kernel
def _plane(on: Suspension, element: Record, reading: Record) -> None:
    """A slider in the plane across one axis of the first body."""
    first, second, point = _ends(on, element)
    d, u = _seen_from(first, second, point, element.point_1)
    a = Vec(0.0, 1.0, 0.0) if element.direction == 0 else Vec(1.0, 0.0, 0.0)
    b = Vec(0.0, 1.0, 0.0) if element.direction == 2 else Vec(0.0, 0.0, 1.0)
    e, v = Vec(dot(d, a), dot(d, b), 0.0), Vec(dot(u, a), dot(u, b), 0.0)
    bound, i = _bound(on, element), element.slip
    z = sub(e, Vec(on.inner[i], on.inner[i + 1], 0.0))
    if element.relaxed != MOVING:
        pull = relaxed_force(element, bound, z)
        slip = shifted(e, -1.0 / element.stick, pull)
    else:
        pull, slip, element.loss = slide(element, bound, z, v)
    on.inner_t[i], on.inner_t[i + 1] = slip.x, slip.y
    f = mixed(-pull.x, a, -pull.y, b)
    put(reading.force, f)
    put(reading.travel, mixed(e.x, a, e.y, b))
    _act(on, element, first, second, point, f)


@kernel
def _turning(on: Suspension, element: Record) -> None:
    """Rotational springs and dampers about the axes of the first body, if the element has any."""
    k, c = element.turning, element.turning_damping
    if k.x + k.y + k.z + (c.x + c.y + c.z) == 0.0:
        return
    first, second = get_body(on.bodies[element.first]), get_body(on.bodies[element.second])
    half = 0.5 * (k.x + k.y + k.z)
    # on the second body: sum of w e' x e
    moment = scale(half - k.x, cross(second.forward, first.forward))
    moment = shifted(moment, half - k.y, cross(second.left, first.left))
    moment = shifted(moment, half - k.z, cross(second.up, first.up))
    m0 = element.turning_preload
    moment = shifted(moment, m0.x, cross(second.left, first.up))
    moment = shifted(moment, m0.y, cross(second.up, first.forward))
    moment = shifted(moment, m0.z, cross(second.forward, first.left))
    rate = in_body_axes(first, sub(second.omega, first.omega))
    damping = Vec(c.x * rate.x, c.y * rate.y, c.z * rate.z)
    element.loss += dot(damping, rate)
    moment = sub(moment, from_components(damping, first.forward, first.left, first.up))
    accumulate(on.wrenches[element.second].moment, moment)
    accumulate(on.wrenches[element.first].moment, scale(-1.0, moment))


@kernel
def suspension_forces(on: Suspension, elements: Records) -> None:
    """Add the forces and moments of all elements, records ELEMENT, at the centres of mass to the wrenches."""
    for late in range(2):
        waiting = 0
        for i in range(elements.shape[0]):
            element = elements[i]
            if (late == 1) != (element.normal >= 0 and element.normal != i):
                waiting += 1
                continue
            reading = on.readings[i]
            element.loss = 0.0
            put(reading.force, ZERO)
            put(reading.travel, ZERO)
            if element.kind == LINE:
                _line(on, element, reading)
            elif element.kind == AXIS:
                _axis(on, element, reading)
            elif element.kind == PLANE:
                _plane(on, element, reading)
            elif element.kind == SHEAR:
                _field(on, element, 1.0, 0.5, reading)
                _field(on, element, -1.0, 0.5, reading)
                _turning(on, element)
            else:
                _field(on, element, 1.0, 1.0, reading)
                _turning(on, element)
        if waiting == 0:
            break
