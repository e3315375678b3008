"""The contacts of both wheels of a wheelset.

Arrays come in an arena (core.arena) in the order named below: wheels and rails, then those of each wheel's contact,
`core.contact.arrays.Arrays`.
"""

from wrsim.core import stages
from wrsim.core.arena import record, records, vector
from wrsim.core.body.wheel_pose import set_pose, wheel_origin, wheel_wrench
from wrsim.core.compiling import inlined, kernel
from wrsim.core.contact.arrays import ARRAYS as ARRAYS_OF_A_WHEEL
from wrsim.core.contact.arrays import Arrays, results, settings_of
from wrsim.core.contact.records import CONTACT
from wrsim.core.linalg import ZERO, Curve, add
from wrsim.core.track.path import NODE, frame, locate

# arrays of the arena, the left wheel first where there are two
SIDES, RAILS, CONTACTS = 0, 1, 3
ARRAYS = CONTACTS + 2 * ARRAYS_OF_A_WHEEL
POSE = Arrays._fields.index("pose")

WHEEL = record("side half_spacing s step rail_n rail_b rail_n_t rail_b_t")
"""+1 left, -1 right; H/2 [m]; distance along the rail (a guess, updated) and step of its path [m]; the motion of the
piece of rail under the wheel along n and b: displacement [m] and velocity [m/s]."""

OK, OFF_TRACK = 0, 1024


@kernel
def contact_forces(body, buffer, index):
    """Force and moment of both wheels' contacts at the centre of mass, and a status."""
    wheels = records(buffer, index, SIDES, WHEEL)
    force = moment = ZERO
    status = OK
    for i in range(2):
        wheel = wheels[i]
        rail = Curve(records(buffer, index, RAILS + i, NODE), wheel.step)
        push, turn, bits = _one_wheel(body, wheel, rail, buffer, _arrays_of_wheel(index, i))
        force, moment = add(force, push), add(moment, turn)
        status |= bits
    return force, moment, status


@inlined
def _arrays_of_wheel(index, i):
    """The part of the index that belongs to the contact of the left (0) or the right (1) wheel."""
    first = CONTACTS + i * ARRAYS_OF_A_WHEEL
    return index[first : first + ARRAYS_OF_A_WHEEL]


@inlined
def wheel_total(buffer, index, i):
    """Resultants of the left (0) or right (1) wheel's contact: a record TOTAL."""
    return results(buffer, _arrays_of_wheel(index, i))[0]


@kernel
def _one_wheel(body, wheel, rail, buffer, arrays):
    """Force, moment and status of one wheel's contact on its rail; arrays: the part of the index that is its own."""
    s, bad = locate(rail, wheel_origin(body, wheel.side, wheel.half_spacing), wheel.s)
    if bad != 0:
        return ZERO, ZERO, OFF_TRACK
    wheel.s = s
    at = frame(rail, s)
    pose = vector(buffer, arrays, POSE)
    set_pose(body, at, wheel.side, wheel.half_spacing, pose)
    # the rail's piece has moved away by so much, and moves with the wheel along the track
    pose[1] -= wheel.side * wheel.rail_n
    pose[2] -= wheel.rail_b
    pose[7] -= wheel.side * wheel.rail_n_t
    pose[8] -= wheel.rail_b_t
    settings_of(buffer, arrays).place = s
    status = stages.run(CONTACT, buffer, arrays)
    force, moment = wheel_wrench(body, at, wheel.side, wheel.half_spacing, results(buffer, arrays)[0])
    return force, moment, status
