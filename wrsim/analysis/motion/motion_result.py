"""From the sampled states of a run to its result.

The contacts of each sample are computed anew from its state, so a sample is a function of the state (the strip model
starts from those of the sample before, and ends as sharply as afresh). Strips are kept at chosen places and at the
largest Y/Q of each wheel.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from wrsim.analysis.motion.track_channels import track_channels, uneven
from wrsim.contact.channels import RawContacts, StripRecorder, patch_channels, wheel_channels
from wrsim.errors import SimulationError
from wrsim.results import Result, assemble
from wrsim.simulation.placement import TrackPoses, poses_on_track

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wrsim.geometry.track.path import Path
    from wrsim.scenario.build import Setup
    from wrsim.simulation.integrate import Motion
    from wrsim.simulation.wheelset_law import WheelsetOnTrack

    Array = NDArray[np.float64]


NEAR = 1.0
"""Distance within which the largest Y/Q of both wheels are one moment [m]."""


@dataclass(frozen=True)
class Snapshot:
    """A sample whose strips are kept, and why."""

    sample: int
    label: str


def result_of(setup: Setup, law: WheelsetOnTrack, motion: Motion) -> Result:
    """All channels of a motion, from its sampled states.

    At the end of a stopped run the last state may have no place on the track any more; it is left out then.
    Raises SimulationError when not even the first one has.
    """
    track, speed = setup.track, setup.run.speed
    motion, poses = _placed(motion, law, track.centre, setup.run.start)
    n = len(motion.times)
    raw = RawContacts.empty(n, 2, setup.contact.max_patches)
    out = np.zeros(6)
    places = law.places(poses.distance)

    def evaluate(i: int) -> None:
        law.look_near(places[i])
        law(motion.times[i], motion.q[i], motion.q_t[i], out)

    law.follow(True, sharp=True)
    for i in range(n):
        evaluate(i)
        for j, wheel in enumerate(law.wheels):
            raw.store(i, j, wheel.model)
    law.follow(False)
    forces = wheel_channels(raw)
    snapshots = choose_snapshots(setup, poses.distance, forces, motion.status == "stopped")
    strips = StripRecorder.start(law.wheels)
    for snapshot in snapshots:
        evaluate(snapshot.sample)
        strips.store(law.elements())
    kept = np.array([s.sample for s in snapshots], dtype=int)
    channels = {
        "distance": poses.distance,
        "speed": np.full(n, speed),
        **track_channels(track, poses.distance),
        "lateral_shift": poses.lateral,
        "vertical_shift": poses.height - setup.wheelset.mean_radius,
        "yaw": poses.yaw,
        "roll": poses.roll,
        "spin_rate": poses.spin_rate,
        **forces,
        **patch_channels(raw, law.wheels, track.widening(poses.distance), uneven(track, poses.distance)),
        "snapshot_time": motion.times[kept],
        "snapshot_distance": poses.distance[kept],
        "snapshot_label": np.array([s.label for s in snapshots]),
        **strips.channels(),
    }
    attributes = run_attributes(setup, motion, poses.distance)
    return Result(assemble({"time": motion.times}, channels, attributes))


def run_attributes(setup: Setup, motion: Motion, distance: Array) -> dict[str, str | float | int]:
    """Attributes of the result of a run whose samples lie at these distances [m]."""
    attributes: dict[str, str | float | int] = {
        "title": setup.title,
        "analysis": setup.analysis,
        "status": motion.status,
        "scenario_text": setup.text,
        "step_s": motion.step,
    }
    if motion.status == "stopped":
        attributes["stop_reason"] = motion.reason
        attributes["stop_cause"] = motion.cause
        attributes["stop_time_s"] = motion.end
        attributes["stop_distance_m"] = float(distance[-1])
    return attributes


def _placed(motion: Motion, law: WheelsetOnTrack, centre: Path, start: float) -> tuple[Motion, TrackPoses]:
    """The motion as far as all its samples have a place on the track, and their poses."""
    out = np.zeros(6)
    while True:
        try:
            poses = poses_on_track(centre, motion.q, motion.q_t, start)
            law.look_near(law.places(poses.distance[-1:])[0])
            law(motion.times[-1], motion.q[-1], motion.q_t[-1], out)
        except SimulationError:
            if motion.status == "completed" or len(motion.times) == 1:
                raise
            motion = replace(motion, times=motion.times[:-1], q=motion.q[:-1], q_t=motion.q_t[:-1])
        else:
            return motion, poses


def choose_snapshots(setup: Setup, distance: Array, wheel: dict[str, Array], stopped: bool) -> list[Snapshot]:
    """Samples whose strips are kept: the distances asked for, the largest Y/Q of either wheel, the stop if any."""
    chosen = {
        int(np.argmin(np.abs(distance - place))): f"at {place:g} m"
        for place in setup.run.patches_at
        if distance[0] - 0.5 <= place <= distance[-1] + 0.5
    }
    q = wheel["Q"]
    quotient = np.divide(wheel["Y"], q, out=np.full(q.shape, -np.inf), where=q > 1.0)
    peaks = [int(np.argmax(quotient[:, side])) for side in (0, 1)]
    if abs(distance[peaks[0]] - distance[peaks[1]]) < NEAR:
        side = int(quotient[peaks[1], 1] > quotient[peaks[0], 0])
        labels = {peaks[side]: "largest Y/Q"}
    else:
        labels = {peak: f"largest Y/Q, {name}" for peak, name in zip(peaks, ("left", "right"), strict=True)}
    for peak, label in labels.items():
        if np.isfinite(quotient[peak]).any():
            chosen.setdefault(peak, label)
    if stopped or not chosen:
        chosen.setdefault(len(distance) - 1, "at the stop" if stopped else "end")
    return [Snapshot(sample, label) for sample, label in sorted(chosen.items())]
