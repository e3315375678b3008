"""The contacts of a vehicle's wheels on their rails: of one wheel, and of all of them.

One wheel on one rail is computed in the axes (t, o, b) of its rail, o outward. On the left side o = n and the axes are
right-handed; on the right side o = -n. Vectors keep their geometry; the components of angular velocities and moments
change sign once more there (they are pseudovectors), so the formulae hold on both sides and mirrored states give
mirrored forces to round-off.

Arrays lie in a workspace (jit.arena), wheel after wheel, the left one of a wheelset before the right one. Of
each: a record WHEEL, the nodes of its rail, and those of its contact, `contact.arrays.Arrays`. A wheel writes to
its own arrays alone, so neither order nor threads change a bit.
"""

from wrsim.contact.arrays import ARRAYS as ARRAYS_OF_A_CONTACT
from wrsim.contact.arrays import Arrays, call_of, results
from wrsim.contact.records import CONTACT, WheelPose
from wrsim.contact.strips.records import MEMO
from wrsim.jit import Array, Ints, Record, inlined, kernel, parallel, prange, record, records, stages, vector
from wrsim.jit.arena import take
from wrsim.jit.frames import BODY, VECTOR, BodyMotion, CurveNodes, Frame, get_body, point_velocity, put, put_at
from wrsim.jit.linalg import ZERO, Vec, add, components, cross, from_components, scale, shifted, sub
from wrsim.track.path_kernel import NODE, bends, frame_at, locate

# arrays of one wheel
WHEEL_RECORD, RAIL, IN_CONTACT = range(3)
ARRAYS = IN_CONTACT + ARRAYS_OF_A_CONTACT
POSE, LOBES, MEMO_PLACE = (Arrays._fields.index(name) for name in ("pose", "patches", "memo"))

WHEEL = record(
    """
    taken        [1]     0: no thread has taken this wheel yet
    side         [1]     +1 left, -1 right
    half_spacing [m]     H/2
    beside       [m]     distance from the wheelset's middle of the point beside which the rail's section is taken
    s            [m]     distance along the rail (a guess, updated)
    step         [m]     step of the rail's path
    rail_n       [m]     displacement of the rail under the wheel along n
    rail_b       [m]     displacement along b
    rail_n_t     [m/s]   velocity of the rail along n
    rail_b_t     [m/s]   velocity along b
    slope_n      [1]     slope of the displacement along n over the track
    slope_b      [1]     slope of the displacement along b
    angle        [rad]   angle by which the wheel has rolled
    budget       [1]     of the first wheel: what the strips of all wheels may take (``strips.newton``); 0: anything
    yield_nn     [m/N]   compliance of the rail on sleepers: along n, ...
    yield_nb     [m/N]   ... coupling ...
    yield_bb     [m/N]   ... and along b
    free_n       [m]     displacement of that rail along n without the wheel's force
    free_b       [m]     displacement along b without it
    held_n       [1]     factor of the unknown along n itself (1 at rest, ``dynamics.vehicle_forces``)
    held_b       [1]     factor of the unknown along b
    rate_n       [1/s2]  rate of the unknown along n
    rate_b       [1/s2]  rate of the unknown along b
    status       [int]   status of the contact
    body         [-]     body of the wheelset
    force        [N]     force at its centre of mass, in global axes
    moment       [N m]   moment about it
    """,
    body=BODY,
    force=VECTOR,
    moment=VECTOR,
)
"""A wheel, the rail under it, and what its contact does to the wheelset."""

OK, OFF_TRACK = 0, 1024

ONE_WHEEL, IN_TURN, SIDE_BY_SIDE = 4, 5, 6
"""Numbers of the stages below (jit.stages), behind those of a contact."""


@inlined
def wheel_origin(body: BodyMotion, side: float, half_spacing: float) -> Vec:
    """Wheel profile origin on the axle, global. side: +1 left, -1 right; half_spacing: H/2 [m]."""
    return shifted(body.position, side * half_spacing, body.left)


@inlined
def _in_rail(a: Vec, rail: Frame, side: float) -> Vec:
    """Components of a vector in the rail's axes (t, o, b)."""
    local = components(a, rail.t, rail.n, rail.b)
    return Vec(local.x, side * local.y, local.z)


@inlined
def pose_of(body: BodyMotion, rail: Frame, side: float, half_spacing: float) -> WheelPose:
    """Pose and motion of one wheel in its rail's axes. rail: frame of the rail at the section beside the wheel
    (track.path_kernel.frame_at)."""
    origin = wheel_origin(body, side, half_spacing)
    turning = components(body.omega, rail.t, rail.n, rail.b)
    return WheelPose(
        _in_rail(sub(origin, rail.origin), rail, side),
        _in_rail(scale(side, body.left), rail, side),
        _in_rail(point_velocity(body, origin), rail, side),
        Vec(side * turning.x, turning.y, side * turning.z),
    )


@kernel
def set_pose(body: BodyMotion, rail: Frame, side: float, half_spacing: float, pose: Array) -> None:
    """Write the pose and motion of one wheel to ``pose`` (POSE,), see contact.records."""
    motion = pose_of(body, rail, side, half_spacing)
    put_at(pose, 0, motion.origin)
    put_at(pose, 3, motion.axle)
    put_at(pose, 6, motion.velocity)
    put_at(pose, 9, motion.omega)


@kernel
def wheel_wrench(body: BodyMotion, rail: Frame, side: float, half_spacing: float, total: Record) -> tuple[Vec, Vec]:
    """Force and moment at the centre of mass, in global axes, of one wheel's contact; total: a record TOTAL."""
    f = Vec(total.Ft, side * total.Fo, total.Fb)
    m = Vec(side * total.Mt, total.Mo, side * total.Mb)
    force = from_components(f, rail.t, rail.n, rail.b)
    arm = scale(side * half_spacing, body.left)
    return force, add(from_components(m, rail.t, rail.n, rail.b), cross(arm, force))


@kernel
def one_wheel(buffer: Array, index: Ints) -> int:
    """Force and moment of one wheel's contact, written to its record; a status. index: the part that is its own."""
    wheel = records(buffer, index, WHEEL_RECORD, WHEEL)[0]
    rail = CurveNodes(records(buffer, index, RAIL, NODE), wheel.step)
    body = get_body(wheel.body)
    put(wheel.force, ZERO)
    put(wheel.moment, ZERO)
    s, bad = locate(rail, wheel_origin(body, wheel.side, wheel.beside), wheel.s)
    if bad != 0:
        wheel.status = OFF_TRACK
        return OFF_TRACK
    wheel.s = s
    frame = frame_at(rail, s)
    arrays = index[IN_CONTACT:]
    pose = vector(buffer, arrays, POSE)
    set_pose(body, frame, wheel.side, wheel.half_spacing, pose)
    # the rail's piece has moved away by so much, and moves with the wheel along the track
    pose[1] -= wheel.side * wheel.rail_n
    pose[2] -= wheel.rail_b
    pose[7] -= wheel.side * wheel.rail_n_t
    pose[8] -= wheel.rail_b_t
    call = call_of(buffer, arrays)
    call.place, call.wheel_angle = s, wheel.angle
    twist, to_left, up = bends(rail, s, frame)
    call.twist, call.bow_o, call.bow_b = wheel.side * twist, wheel.side * to_left, up
    wheel.status = stages.run(CONTACT, buffer, arrays)
    total = results(buffer, arrays)[0]
    force, moment = wheel_wrench(body, frame, wheel.side, wheel.half_spacing, total)
    # a rail that is bent down ahead of the wheel or behind it turns the force about the axle: what it takes from the
    # motion along the track is the work on the moving rail
    along = scale(-wheel.side * total.Fo * wheel.slope_n - total.Fb * wheel.slope_b, frame.t)
    put(wheel.force, add(force, along))
    put(wheel.moment, add(moment, cross(scale(wheel.side * wheel.half_spacing, body.left), along)))
    return wheel.status


@kernel
def in_turn(buffer: Array, index: Ints) -> int:
    """All wheels, one after the other. index: that of the first wheel and of all behind it.

    With a budget each may take its `share`.
    """
    count = index.shape[0] // ARRAYS
    bounded = count > 0 and wheel_record(buffer, index, 0).budget > 0.0
    left, behind = (wheel_record(buffer, index, 0).budget, reserve(buffer, index)) if bounded else (0.0, 0.0)
    for i in range(count):
        memo = memo_of(buffer, index, i)
        if bounded:
            behind -= memo.reserve
            memo.budget, memo.work = share(left, memo.reserve, behind), 0.0
        stages.run(ONE_WHEEL, buffer, index[i * ARRAYS : (i + 1) * ARRAYS])
        left -= memo.work
    return OK


@kernel
def reserve(buffer: Array, index: Ints) -> float:
    """What of a budget is reserved for all wheels."""
    total = 0.0
    for i in range(index.shape[0] // ARRAYS):
        total += memo_of(buffer, index, i).reserve
    return total


@inlined
def share(left: float, reserve: float, behind: float) -> float:
    """Share of what is left of a budget: all but what is reserved behind, or in proportion where that is too much."""
    return left - behind * (1.0 if reserve + behind <= max(left, 0.0) else left / (reserve + behind))


@inlined
def memo_of(buffer: Array, index: Ints, i: int) -> Record:
    """The record MEMO of the wheel number i; index: as in `in_turn`."""
    return records(buffer, index[i * ARRAYS + IN_CONTACT : (i + 1) * ARRAYS], MEMO_PLACE, MEMO)[0]


@parallel
def in_parallel(buffer: Array, index: Ints) -> int:
    """As `in_turn`, on as many threads as numba is set to use. Each begins with the first wheel of its share and takes
    what no other has taken, also beyond it; then nothing is left for its other wheels."""
    count = index.shape[0] // ARRAYS
    for i in range(count):
        buffer[index[i * ARRAYS + WHEEL_RECORD, 0]] = 0.0
    for first in prange(count):
        for k in range(count):
            i = (first + k) % count
            place = index[i * ARRAYS + WHEEL_RECORD, 0]  # of its mark
            if buffer[place] == 0.0 and take(buffer, place):
                stages.run(ONE_WHEEL, buffer, index[i * ARRAYS : (i + 1) * ARRAYS])
    return OK


STAGES = {ONE_WHEEL: one_wheel, IN_TURN: in_turn, SIDE_BY_SIDE: in_parallel}


@inlined
def wheel_record(buffer: Array, index: Ints, i: int) -> Record:
    """The record WHEEL of the wheel number i; index: as in `in_turn`."""
    return records(buffer, index[i * ARRAYS :], WHEEL_RECORD, WHEEL)[0]


@inlined
def place_on_rail(buffer: Array, index: Ints, i: int) -> float:
    """Distance of the wheel number i along its rail [m], that of the last evaluation where it has no place."""
    wheel = wheel_record(buffer, index, i)
    rail = CurveNodes(records(buffer, index[i * ARRAYS :], RAIL, NODE), wheel.step)
    s, bad = locate(rail, wheel_origin(get_body(wheel.body), wheel.side, wheel.beside), wheel.s)
    return s if bad == 0 else wheel.s


@inlined
def pose_on_rail(buffer: Array, index: Ints, i: int) -> WheelPose:
    """Pose and motion of the wheel number i beside its rail, of which no displacement counts."""
    wheel = wheel_record(buffer, index, i)
    rail = CurveNodes(records(buffer, index[i * ARRAYS :], RAIL, NODE), wheel.step)
    frame = frame_at(rail, place_on_rail(buffer, index, i))
    return pose_of(get_body(wheel.body), frame, wheel.side, wheel.half_spacing)


@inlined
def wheel_total(buffer: Array, index: Ints, i: int) -> Record:
    """Resultants of this wheel's contact: a record TOTAL."""
    return results(buffer, index[i * ARRAYS + IN_CONTACT : (i + 1) * ARRAYS])[0]
