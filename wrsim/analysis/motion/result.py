"""From the sampled states of a run to its result: every channel of every wheelset, and of the vehicle (`samples`).
Strips are stored at chosen places and at the largest Y/Q of each wheel.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np

from wrsim.analysis.motion import body_channels as states
from wrsim.analysis.motion.messages import Event, event_words
from wrsim.analysis.motion.samples import Samples, stack_wheelsets
from wrsim.contact.channels import StripRecorder
from wrsim.contact.wear.losses import ZONES, Losses, ways
from wrsim.errors import SimulationError
from wrsim.results import Result, assemble
from wrsim.results.channels import BOGIE_FRAME
from wrsim.results.netcdf import parts_of
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.run import RunPlan
from wrsim.simulation.integrate import Motion
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import TrackPoses, poses_as_far
from wrsim.simulation.system import Array
from wrsim.vehicle.bogies import bogie_mass, holders_of, level_of

NEAR = 1.0  # distance within which the largest Y/Q of both wheels are one moment [m]


def result_of(
    setup: Setup[RunPlan], law: VehicleOnTrack, motion: Motion, events: Sequence[Event], folder: Path | None = None,
    samples: Samples | None = None,
) -> Result:  # fmt: skip
    """All channels of a motion, from its sampled states; those of a long one are stored on disk in ``folder``, if any.

    samples: the first ones, where they are known already. At the end of a stopped run the last states may have no place
    on the track any more; they are left out then. Raises SimulationError when not even the first one has.
    """
    vehicle, plan, recorded = law.vehicle, setup.plan, motion
    if plan.fast_channels:
        motion = _each(motion, plan.output_interval, True)
    losses = None
    if plan.wear is not None:
        losses = Losses(plan.wear, law.wheels, [ways(p.distance, plan.wear.stretch) for p in _poses(motion, law)])
    samples = samples or Samples(setup, law, len(motion.times), folder, losses)
    motion = _taken(samples, motion)
    channels = samples.channels()
    reference = np.asarray(channels["distance"])
    if (
        law.on_sleepers is not None and len(law.of_deck) and len(motion.times) > 1
    ):  # forces on a bridge are those of a step
        channels |= states.deck_channels(law, motion.q, np.gradient(motion.q_t[:, law.of_deck], motion.times, axis=0))
    shapes, bent = states.bent_channels(law, motion, channels)
    channels |= shapes
    snapshots = choose_snapshots(setup, reference, _largest_quotients(channels), motion.status == "stopped")
    strips = [StripRecorder(pair) for pair in law.wheels]
    out = np.zeros(law.size)
    for sample in snapshots:
        law.set_search_start(law.places(np.asarray(channels["wheelset_distance"][sample])))
        law(motion.times[sample], motion.q[sample], motion.q_t[sample], out)
        for recorder, elements in zip(strips, law.elements_of_contacts(), strict=True):
            recorder.store(elements)
    shown = np.array(list(snapshots), dtype=int)
    channels |= {
        "snapshot_time": motion.times[shown],
        "snapshot_distance": reference[shown],
        "snapshot_label": np.array(list(snapshots.values())),
        **stack_wheelsets([recorder.channels() for recorder in strips]),
    }
    named: dict[str, Sequence[Any]] = {
        "wheelset": vehicle.wheelsets, "body": vehicle.bodies, "point": vehicle.points, "suspension": vehicle.elements,
        "coupling": vehicle.couplings, "external_load": vehicle.loads,
    }  # fmt: skip
    coords: dict[str, Any] = {"time": motion.times}
    if plan.fast_channels:
        fast = _each(recorded, plan.recorded_interval)
        all_states = Samples(setup, law, len(fast.times), folder, sampled=channels)
        coords["fast_time"] = _taken(all_states, fast).times
        channels |= all_states.channels()
    if law.deck is not None:
        coords["span"] = [f"span {k + 1}" for k in range(len(law.deck.values))]
    coords |= {dimension: [each.name for each in members] for dimension, members in named.items() if members}
    if losses is not None:
        channels |= losses.channels()
        coords |= {"wear_law": losses.settings.laws, "wear_zone": ZONES}
    holders = [body if body and level_of(vehicle, body) == BOGIE_FRAME else "" for body in holders_of(vehicle)]
    if any(holders):
        channels["wheelset_bogie"] = np.array(holders)
    if vehicle.points:
        channels["point_level"] = np.array([level_of(vehicle, point.body) for point in vehicle.points])
        channels["point_bogie_mass"] = [bogie_mass(vehicle, point.body) for point in vehicle.points]
    if vehicle.elements:
        ends = np.array([e.limits or (np.nan, np.nan) for e in vehicle.elements])
        channels |= {"suspension_stop_min": ends[:, 0], "suspension_stop_max": ends[:, 1]}
    if events:
        channels |= {
            "event_time": [event.start[0] for event in events],
            "event_distance": [event.start[1] for event in events],
            "event_label": np.array([event_words(event, vehicle) for event in events]),
        }
    return Result(assemble(coords, channels, _attributes(setup, motion, reference) | bent, copy=False))


def _each(motion: Motion, interval: float, last: bool = False) -> Motion:
    """The states of a motion at whole multiples of an interval [s]; with the last one, wherever it is."""
    mask = np.rint(motion.times / motion.step) % round(interval / motion.step) == 0.0
    mask[-1] |= last
    rows: Any = np.flatnonzero(mask)
    if len(rows) == rows[-1] + 1:
        rows = slice(len(rows))  # no copy: many are on disk
    return replace(motion, times=motion.times[rows], q=motion.q[rows], q_t=motion.q_t[rows])


def _poses(motion: Motion, law: VehicleOnTrack) -> list[TrackPoses]:
    """Poses of every wheelset, as far as all have a place on the track."""
    poses = []
    for w, mounted in enumerate(law.vehicle.wheelsets):
        q, q_t = (state[:, 6 * w : 6 * w + 6] for state in (motion.q, motion.q_t))
        poses.append(poses_as_far(law.track.centre, q, q_t, law.start + mounted.x))
    n = min(len(p.distance) for p in poses)
    return [TrackPoses(*(values[:n] for values in p)) for p in poses]


def _taken(samples: Samples, motion: Motion) -> Motion:
    """Take what is left of a motion; returns it as far as its samples could be taken."""
    samples.take(*(values[samples.taken :] for values in (motion.times, motion.q, motion.q_t)))
    n = samples.taken
    if n == 0 or (samples.lost and motion.status == "completed"):
        raise SimulationError(samples.lost)
    return replace(motion, times=motion.times[:n], q=motion.q[:n], q_t=motion.q_t[:n])


def _attributes(setup: Setup[RunPlan], motion: Motion, distance: Array) -> dict[str, str | float | int]:
    """Attributes of the result of a run whose samples lie at these distances [m]."""
    attributes = setup.attributes(motion.reason)
    if motion.step > 0.0:
        steps = round(motion.end / motion.step)
        attributes |= {"integrator": motion.integrator, "step_s": motion.step, "steps": steps, **asdict(motion.work)}
    if motion.status == "stopped":
        # also where what stopped it had no words
        attributes |= {"status": motion.status, "stop_reason": motion.reason, "stop_cause": motion.cause}
        attributes |= {"stop_time_s": motion.end, "stop_distance_m": float(distance[-1])}
    return attributes


def _largest_quotients(channels: Mapping[str, Any]) -> list[tuple[float, int]]:
    """Largest Y/Q of all wheels of either side, and its sample; minus infinity where no wheel had a load."""
    largest = [(-np.inf, 0)] * 2
    for (begin, y), (_, q) in zip(parts_of(channels["Y"]), parts_of(channels["Q"]), strict=True):
        quotient = np.divide(y, q, out=np.full(q.shape, -np.inf), where=q > 1.0).max(axis=1)
        of_part = [(float(column.max()), begin + int(np.argmax(column))) for column in quotient.T]
        largest = [max(pair, key=itemgetter(0)) for pair in zip(largest, of_part, strict=True)]
    return largest


def choose_snapshots(
    setup: Setup[RunPlan], distance: Array, largest: Sequence[tuple[float, int]], stopped: bool
) -> dict[int, str]:
    """Samples whose strips are stored, and why: chosen distances, the largest Y/Q of either side with its sample (minus
    infinity: there is none), the stop if any."""
    chosen = {
        int(np.argmin(np.abs(distance - place))): f"at {place:g} m"
        for place in setup.plan.patches_at
        if distance[0] - 0.5 <= place <= distance[-1] + 0.5
    }
    peaks = [(*each, f", {name}") for each, name in zip(largest, ("left", "right"), strict=True)]
    if abs(distance[peaks[0][1]] - distance[peaks[1][1]]) < NEAR:
        peaks = [(*max(largest, key=itemgetter(0)), "")]
    for quotient, peak, side in peaks:
        if np.isfinite(quotient):
            chosen.setdefault(peak, f"largest Y/Q{side}")
    if stopped or not chosen:
        chosen.setdefault(len(distance) - 1, "at the stop" if stopped else "end")
    return dict(sorted(chosen.items()))
