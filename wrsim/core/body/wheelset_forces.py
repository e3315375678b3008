"""The contacts of both wheels of a wheelset.

Arrays come in an arena (core.arena) in the order named below: scalars and rails, then those of each wheel,
`core.contact.wheel_rail.Arrays`.
"""

from wrsim.core.arena import matrix, vector
from wrsim.core.body.wheel_pose import add_forces, set_pose, wheel_origin
from wrsim.core.compiling import kernel
from wrsim.core.contact.wheel_rail import ARRAYS as ARRAYS_OF_A_WHEEL
from wrsim.core.contact.wheel_rail import results, wheel_rail
from wrsim.core.track.path import frame, locate

# arrays of the arena
SCALARS, LEFT_RAIL, RIGHT_RAIL, FORCE, MOMENT, LEFT = range(6)
RIGHT = LEFT + ARRAYS_OF_A_WHEEL
ARRAYS = RIGHT + ARRAYS_OF_A_WHEEL

# scalars: distances along the rails (guesses, updated), steps of the rails' paths, H/2
# and the motion of the piece of rail under the left wheel, then the right one: displacement and velocity along n and b
S_LEFT, S_RIGHT, STEP_LEFT, STEP_RIGHT, HALF_SPACING, RAIL_MOTION = range(6)
RAIL_NUMBERS = 4  # of one rail
SCALAR_COUNT = RAIL_MOTION + 2 * RAIL_NUMBERS

OK, OFF_TRACK = 0, 1024


@kernel
def contact_forces(body, buffer, index):
    """Add the contacts of both wheels to the force and the moment in the arena; returns a status.

    body: 18 numbers of ``core.body.kinematics.kinematics``.
    """
    scalars = vector(buffer, index, SCALARS)
    half = scalars[HALF_SPACING]
    status = _one_side(body, 1, half, matrix(buffer, index, LEFT_RAIL), S_LEFT, scalars, buffer, index, LEFT)
    status |= _one_side(body, -1, half, matrix(buffer, index, RIGHT_RAIL), S_RIGHT, scalars, buffer, index, RIGHT)
    return status


@kernel
def _one_side(body, side, half, path, place, scalars, buffer, index, first):
    """Contact of one wheel on its rail; adds to the arena's force and moment. Returns a status."""
    step = scalars[place - S_LEFT + STEP_LEFT]
    x, y, z = wheel_origin(body, side, half)
    s, bad = locate(path, step, x, y, z, scalars[place])
    if bad != 0:
        return OFF_TRACK
    scalars[place] = s
    rail_frame = frame(path, step, s)
    pose = vector(buffer, index, first + 6)
    set_pose(body, rail_frame, side, half, pose)
    # the rail's piece has moved away by so much, and moves with the wheel along the track
    rail = RAIL_MOTION + (place - S_LEFT) * RAIL_NUMBERS
    pose[1] -= side * scalars[rail]
    pose[2] -= scalars[rail + 1]
    pose[7] -= side * scalars[rail + 2]
    pose[8] -= scalars[rail + 3]
    own = index[first : first + ARRAYS_OF_A_WHEEL]
    status = wheel_rail(buffer, own)
    total = results(buffer, own)[0]
    add_forces(body, rail_frame, side, half, total, vector(buffer, index, FORCE), vector(buffer, index, MOMENT))
    return status
