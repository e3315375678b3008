"""The contacts of a vehicle's wheels on their rails: of one wheel, and of all of them.

Arrays come in an arena (core.jit.arena), wheel after wheel, the left one of a wheelset before the right one. Of each: a
record WHEEL, the nodes of its rail, and those of its contact, `core.contact.arrays.Arrays`. A wheel writes to its own
arrays alone, so the order in which they are asked, or the thread that asks, changes no bit.
"""

from wrsim.core.body.wheel_pose import set_pose, wheel_origin, wheel_wrench
from wrsim.core.contact.arrays import ARRAYS as ARRAYS_OF_A_CONTACT
from wrsim.core.contact.arrays import Arrays, results, settings_of
from wrsim.core.contact.records import CONTACT
from wrsim.core.jit import stages
from wrsim.core.jit.arena import Array, Ints, Record, record, records, vector
from wrsim.core.jit.compiling import inlined, kernel, parallel, prange
from wrsim.core.linalg import BODY, VECTOR, ZERO, CurveNodes, get_body, put
from wrsim.core.track.path import NODE, bends, frame_at, locate

# arrays of the arena of one wheel
OWN, RAIL, IN_CONTACT = range(3)
ARRAYS = IN_CONTACT + ARRAYS_OF_A_CONTACT
POSE = Arrays._fields.index("pose")

WHEEL = record(
    "side half_spacing s step rail_n rail_b rail_n_t rail_b_t", "status", body=BODY, force=VECTOR, moment=VECTOR
)  # fmt: skip
"""+1 left, -1 right; H/2 [m]; distance along the rail (a guess, updated) and step of its path [m]; the motion of the
piece of rail under the wheel along n and b: displacement [m] and velocity [m/s]; the body of the wheelset. What comes
out: force [N] and moment [N m] at its centre of mass, in global axes, and a status."""

OK, OFF_TRACK = 0, 1024

ONE_WHEEL, IN_TURN, SIDE_BY_SIDE = 4, 5, 6
"""Numbers of the stages below (core.jit.stages), behind those of a contact."""


@kernel
def one_wheel(buffer: Array, index: Ints) -> int:
    """Force and moment of one wheel's contact, written to its record; a status. index: the part that is its own."""
    wheel = records(buffer, index, OWN, WHEEL)[0]
    rail = CurveNodes(records(buffer, index, RAIL, NODE), wheel.step)
    body = get_body(wheel.body)
    put(wheel.force, ZERO)
    put(wheel.moment, ZERO)
    s, bad = locate(rail, wheel_origin(body, wheel.side, wheel.half_spacing), wheel.s)
    if bad != 0:
        wheel.status = OFF_TRACK
        return OFF_TRACK
    wheel.s = s
    at = frame_at(rail, s)
    arrays = index[IN_CONTACT:]
    pose = vector(buffer, arrays, POSE)
    set_pose(body, at, wheel.side, wheel.half_spacing, pose)
    # the rail's piece has moved away by so much, and moves with the wheel along the track
    pose[1] -= wheel.side * wheel.rail_n
    pose[2] -= wheel.rail_b
    pose[7] -= wheel.side * wheel.rail_n_t
    pose[8] -= wheel.rail_b_t
    settings = settings_of(buffer, arrays)
    settings.place = s
    twist, to_left, up = bends(rail, s, at)
    settings.twist, settings.bow_o, settings.bow_b = wheel.side * twist, wheel.side * to_left, up
    wheel.status = stages.run(CONTACT, buffer, arrays)
    force, moment = wheel_wrench(body, at, wheel.side, wheel.half_spacing, results(buffer, arrays)[0])
    put(wheel.force, force)
    put(wheel.moment, moment)
    return wheel.status


@kernel
def in_turn(buffer: Array, index: Ints) -> int:
    """All wheels, one after the other. index: that of the first wheel and of all behind it."""
    for i in range(index.shape[0] // ARRAYS):
        stages.run(ONE_WHEEL, buffer, index[i * ARRAYS : (i + 1) * ARRAYS])
    return OK


@parallel
def in_parallel(buffer: Array, index: Ints) -> int:
    """As `in_turn`, on as many threads as numba is set to use."""
    for i in prange(index.shape[0] // ARRAYS):
        stages.run(ONE_WHEEL, buffer, index[i * ARRAYS : (i + 1) * ARRAYS])
    return OK


STAGES = {ONE_WHEEL: one_wheel, IN_TURN: in_turn, SIDE_BY_SIDE: in_parallel}


@inlined
def wheel_record(buffer: Array, index: Ints, i: int) -> Record:
    """The record WHEEL of the wheel number i; index: as in `in_turn`."""
    return records(buffer, index[i * ARRAYS :], OWN, WHEEL)[0]


@inlined
def wheel_total(buffer: Array, index: Ints, i: int) -> Record:
    """Resultants of this wheel's contact: a record TOTAL."""
    return results(buffer, index[i * ARRAYS + IN_CONTACT : (i + 1) * ARRAYS])[0]
