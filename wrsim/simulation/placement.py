"""States and poses on a track: of a wheelset; of a whole vehicle in its design position."""

from cmath import exp, phase
from math import asin
from typing import NamedTuple

import numpy as np

from wrsim.errors import SimulationError
from wrsim.simulation.force_law import COORDINATES, Array
from wrsim.simulation.law import VehicleOnTrack
from wrsim.track import path_kernel as path_kernels
from wrsim.track.path import Path
from wrsim.vehicle.bogies import wheelsets_beneath
from wrsim.vehicle.dynamics import kinematics as kernels

SPIN = COORDINATES.index("spin")


def state_on_track(
    path: Path,
    distance: float,
    *,
    speed: float,
    height: float,
    spin_rate: float,
    lateral: float = 0.0,
    yaw: float = 0.0,
    roll: float = 0.0,
) -> tuple[Array, Array]:
    """State (q, q_t), each (6,), of a wheelset that follows the track at a given pose.

    path: centre line; distance along it [m]; speed [m/s]; height of the axle above the track plane [m];
    spin_rate about the axle [rad/s]; lateral [m], yaw, roll [rad] against the track frame.
    """
    track = path_kernels.frame_at(path.curve, distance)
    turning, _ = path_kernels.frame_rates(path.curve, distance)
    q = np.zeros(6)
    q_t = np.zeros(6)
    pose = kernels.TrackPose(float(lateral), float(height), float(yaw), float(roll))
    kernels.place_on_track(track, turning, float(speed), pose, float(spin_rate), q, q_t)
    return q, q_t


class TrackPoses(NamedTuple):
    """Poses against the track, each (n,): distance, lateral, height above the track plane [m], yaw, roll [rad], and
    the rate of spin about the axle [rad/s]."""

    distance: Array
    lateral: Array
    height: Array
    yaw: Array
    roll: Array
    spin_rate: Array


def poses_as_far(path: Path, q: Array, q_t: Array, start: float = 0.0) -> TrackPoses:
    """Poses of sampled states (n, 6) along a centre line, up to the first one that has no place on the track.

    start: guess of the first distance [m]. Consecutive samples lie within some metres of each other.
    """
    out = np.zeros(len(q), kernels.PLACED)
    bad = kernels.poses_along(np.ascontiguousarray(q), np.ascontiguousarray(q_t), path.curve, float(start), out)
    placed = out[: bad if bad >= 0 else len(q)]
    return TrackPoses(*(placed[name].copy() for name in TrackPoses._fields))


def poses_on_track(path: Path, q: Array, q_t: Array, start: float = 0.0) -> TrackPoses:
    """The same of states that all have a place on the track. Raises SimulationError for one that has none."""
    poses = poses_as_far(path, q, q_t, start)
    if len(poses.distance) < len(q):
        raise SimulationError(f"sample {len(poses.distance)} has no place on the track")
    return poses


def design_state(law: VehicleOnTrack, *, lateral: float | Array = 0.0) -> tuple[Array, Array]:
    """State (q, q_t) of a vehicle that follows the track in its design position, its origin at the start of the law.

    Every wheelset lies at its own place along the track, ``lateral`` [m] to the left (each, or all alike), with the yaw
    of the guide frame; a body along the chord of the wheelsets beneath it, half of their mean shift to the left. The
    wheels touch the rails at most.
    """
    q, q_t = np.zeros(law.size), np.zeros(law.size)
    vehicle, track = law.vehicle, law.track
    wheelsets = len(vehicle.wheelsets)
    aside = np.broadcast_to(lateral, wheelsets)
    lower = np.mean([mounted.height - mounted.wheelset.mean_radius for mounted in vehicle.wheelsets])
    beneath = wheelsets_beneath(vehicle)
    for i, part in enumerate(vehicle.parts):
        coordinates = slice(6 * i, 6 * i + 6)
        place = law.start + part.centre[0]
        height, across = part.centre[2] - float(lower), part.centre[1]
        if i < wheelsets:
            spin, across = law.speed / vehicle.wheelsets[i].wheelset.mean_radius, across + float(aside[i])
            yaw = -vehicle.guide_ahead * float(track.curvature(place))
        else:
            ahead, inside, yaw = _on_chord(law, part.centre[0], beneath[part.name])
            place, across = place + ahead, across + inside + 0.5 * float(np.mean(aside))
            spin = 0.0
        q[coordinates], q_t[coordinates] = state_on_track(
            track.centre, place, speed=law.speed, height=height, spin_rate=spin, lateral=across, yaw=yaw
        )
        if i >= wheelsets:  # on a grade it lies along the track
            q[6 * i + SPIN] = -asin(path_kernels.frame_at(track.centre.curve, place).t.z)
    q_t[law.wagons] = law.masses * law.speed
    turn_gears(law, q_t)
    return q, q_t


def turn_gears(law: VehicleOnTrack, q_t: Array) -> None:
    """Set the spin of the hollow axles of geared motors to that of their wheelsets, with cases that do not pitch."""
    for wheelset, place in law.gears.items():
        q_t[place + 1] = q_t[6 * wheelset + SPIN]


def _on_chord(law: VehicleOnTrack, x: float, wheelsets: tuple[int, ...]) -> tuple[float, float, float]:
    """Pose in plan of a body x [m] ahead of the vehicle's origin, fitted to its wheelsets: ahead and to the left of its
    own place along the track [m], yaw there [rad]."""
    if not wheelsets:
        return 0.0, 0.0, 0.0
    curve = law.track.centre.curve
    frame = path_kernels.frame_at(curve, law.start + x)
    places = np.array([law.vehicle.wheelsets[i].x for i in wheelsets])
    frames = [path_kernels.frame_at(curve, law.start + place).origin for place in places]
    ways = [(f.x - frame.origin.x, f.y - frame.origin.y) for f in frames]
    offsets = np.array([complex(dx * frame.t.x + dy * frame.t.y, dx * frame.n.x + dy * frame.n.y) for dx, dy in ways])
    middle = places.mean()
    angle = phase(np.sum((places - middle) * offsets)) if len(places) > 1 else 0.0
    position = complex(offsets.mean() + (x - middle) * exp(1j * angle))
    return position.real, position.imag, angle
