"""A pose of a wheel or a wheelset, and what it carries there."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Pose:
    """A pose of one wheel or of a wheelset on straight track, and the load that it carries there.

    Parameters
    ----------
    name : str
        For tables and pictures; poses without one are named after what sets them apart.
    lateral : float
        Lateral shift of the wheelset's centre, positive to the left [m].
    yaw : float
        Angle of attack, positive to the left [rad].
    load : float
        Vertical force of the wheel, or of the whole wheelset, on the track [N].
    roll : float
        Of one wheel, positive lifts the left wheel [rad]; a wheelset finds its own.
    wheel_angle : float
        By which wheels out of round have rolled [rad].
    """

    name: str = ""
    lateral: float = 0.0
    yaw: float = 0.0
    load: float = 0.0
    roll: float = 0.0
    wheel_angle: float = 0.0
