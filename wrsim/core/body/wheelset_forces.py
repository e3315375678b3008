"""All forces on one wheelset on its track in one call: what the multibody solver asks for at every stage.

Arrays come in an arena (core.arena) in the order named below: scalars and paths, then fourteen arrays for each wheel as
`core.contact.wheel_rail.wheel_rail` takes them.
"""

from wrsim.core.arena import block, matrix, vector
from wrsim.core.body.carrier import carrier_forces
from wrsim.core.body.kinematics import generalised_forces, kinematics
from wrsim.core.body.wheel_pose import add_forces, set_pose, wheel_origin
from wrsim.core.compiling import kernel
from wrsim.core.contact.wheel_rail import wheel_rail
from wrsim.core.track.path import frame, locate

# arrays of the arena
SCALARS, CARRIER, CENTRE, LEFT_RAIL, RIGHT_RAIL, FORCE, MOMENT, LEFT, RIGHT = 0, 1, 2, 3, 4, 5, 6, 7, 21
ARRAYS = 35
ARRAYS_OF_A_WHEEL = 14
TOTAL = 13  # place of the resultants among them

# scalars: distances along the centre line and the rails (guesses, updated), steps of the paths, H/2
# and the motion of the piece of rail under the left wheel, then the right one: displacement and velocity along n and b
S_CENTRE, S_LEFT, S_RIGHT, STEP_CENTRE, STEP_LEFT, STEP_RIGHT, HALF_SPACING, RAIL_MOTION = range(8)
RAIL_NUMBERS = 4  # of one rail
SCALAR_COUNT = RAIL_MOTION + 2 * RAIL_NUMBERS

OK, OFF_TRACK = 0, 1024


@kernel
def wheelset_forces(t, q, q_t, out, buffer, index):
    """Generalised forces (6,) on a wheelset at time t.

    q, q_t: (6,) see core.body.kinematics; buffer, index: the arena. The distances along the paths are refined from
    their last values to round-off, so the result depends on the state alone.
    Returns a status: 0, or the sum of the contact's STATUS bits, or OFF_TRACK when there is no place on the track.
    """
    scalars = vector(buffer, index, SCALARS)
    force = vector(buffer, index, FORCE)
    moment = vector(buffer, index, MOMENT)
    body = kinematics(q, q_t)
    centre = matrix(buffer, index, CENTRE)
    s, bad = locate(centre, scalars[STEP_CENTRE], body[0], body[1], body[2], scalars[S_CENTRE])
    if bad != 0:
        for i in range(6):
            out[i] = 0.0
        return OFF_TRACK
    scalars[S_CENTRE] = s
    own = frame(centre, scalars[STEP_CENTRE], s)
    fx, fy, fz, mx, my, mz = carrier_forces(t, body, own, centre, scalars[STEP_CENTRE], vector(buffer, index, CARRIER))
    force[0], force[1], force[2] = fx, fy, fz
    moment[0], moment[1], moment[2] = mx, my, mz
    status = contact_forces(body, buffer, index)
    generalised_forces(body, force, moment, out)
    return status


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
    total = vector(buffer, index, first + TOTAL)
    status = wheel_rail(
        matrix(buffer, index, first),
        matrix(buffer, index, first + 1),
        block(buffer, index, first + 2),
        matrix(buffer, index, first + 3),
        vector(buffer, index, first + 4),
        vector(buffer, index, first + 5),
        pose,
        matrix(buffer, index, first + 7),
        matrix(buffer, index, first + 8),
        block(buffer, index, first + 9),
        matrix(buffer, index, first + 10),
        matrix(buffer, index, first + 11),
        block(buffer, index, first + 12),
        total,
    )
    add_forces(body, rail_frame, side, half, total, vector(buffer, index, FORCE), vector(buffer, index, MOMENT))
    return status
