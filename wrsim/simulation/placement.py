"""Between states of a wheelset and its pose on a track."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wrsim.core.body import kinematics as kernels
from wrsim.core.track import path as path_kernels
from wrsim.errors import SimulationError
from wrsim.simulation.system import Array

if TYPE_CHECKING:
    from wrsim.geometry.track.path import Path


def place_on_track(
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


@dataclass(frozen=True)
class TrackPoses:
    """Poses against the track, each (n,): distance, lateral, height above the track plane [m], yaw, roll [rad].

    spin_rate: about the axle [rad/s].
    """

    distance: Array
    lateral: Array
    height: Array
    yaw: Array
    roll: Array
    spin_rate: Array

    def first(self, n: int) -> TrackPoses:
        """The first n of them."""
        return TrackPoses(*(getattr(self, name)[:n] for name in self.__dataclass_fields__))


def poses_as_far(path: Path, q: Array, q_t: Array, start: float = 0.0) -> TrackPoses:
    """Poses of sampled states (n, 6) along a centre line, up to the first one that has no place on the track.

    start: guess of the first distance [m]. Consecutive samples should lie within some metres of each other.
    """
    out = np.zeros(len(q), kernels.PLACED)
    bad = kernels.poses_along(np.ascontiguousarray(q), np.ascontiguousarray(q_t), path.curve, float(start), out)
    placed = out[: bad if bad >= 0 else len(q)]
    return TrackPoses(**{name: placed[name].copy() for name in kernels.PLACED.names})


def poses_on_track(path: Path, q: Array, q_t: Array, start: float = 0.0) -> TrackPoses:
    """The same of states that all have a place on the track. Raises SimulationError for one that has none."""
    poses = poses_as_far(path, q, q_t, start)
    if len(poses.distance) < len(q):
        raise SimulationError(f"sample {len(poses.distance)} has no place on the track")
    return poses
