"""How the frame of the track runs along the line: pieces of constant acceleration, one behind the other.

    s(t) = s_i + v_i (t - t_i) + a_i (t - t_i)^2 / 2,    v(t) = v_i + a_i (t - t_i)

from the beginning t_i of a piece to that of the next. The last piece has no end; a constant speed is one piece.
"""

from wrsim.core.arena import record
from wrsim.core.compiling import kernel
from wrsim.core.root import between

PIECE = record("time distance speed acceleration")
"""Beginning of a piece [s], distance along the centre line [m] and speed [m/s] there, acceleration in it [m/s2]."""


@kernel
def motion_at(t, pieces):
    """Distance [m], speed [m/s] and acceleration [m/s2] at time t; pieces: records PIECE in the order of time."""
    low, _high, _part = between(pieces["time"], t)
    piece = pieces[low]
    since = t - piece.time
    speed = piece.speed + piece.acceleration * since
    return piece.distance + since * (piece.speed + 0.5 * piece.acceleration * since), speed, piece.acceleration
