"""From the sampled states of a run to its result: every channel of every wheelset, and of the vehicle.

The contacts of each sample are computed anew from its state, so a sample is a function of the state (the strip model
starts from those of the sample before, and ends with the same). Strips are stored at chosen places and at the
largest Y/Q of each wheel.
"""

from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from wrsim.analysis.contacts import friction_channels
from wrsim.analysis.motion import body_channels as states
from wrsim.analysis.motion.body_channels import uneven
from wrsim.analysis.motion.messages import Event, event_words
from wrsim.contact.channels import StripRecorder, contact_channels
from wrsim.contact.patches import RawContacts, patch_wear_numbers
from wrsim.contact.wear.laws import fatigue_channels
from wrsim.contact.wear.losses import ZONES, Losses, ways
from wrsim.errors import SimulationError
from wrsim.results import Result, assemble
from wrsim.results.channels import BOGIE_FRAME
from wrsim.results.dataset import typed, with_derived
from wrsim.results.netcdf import Channels
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.run import RunPlan
from wrsim.simulation.integrate import Motion
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import TrackPoses, poses_as_far
from wrsim.simulation.system import Array
from wrsim.vehicle.bogies import bogie_mass, holders_of, level_of
from wrsim.vehicle.vehicle import MeasuringPoint

RAIL_CHANNELS = ("rail_displacement_y", "rail_displacement_z")

BLOCK = 500  # samples whose contacts are in memory at once beside the channels
NEAR = 1.0  # distance within which the largest Y/Q of both wheels are one moment [m]


def result_of(
    setup: Setup[RunPlan], law: VehicleOnTrack, motion: Motion, events: Sequence[Event], folder: Path | None = None
) -> Result:
    """All channels of a motion, from its sampled states; those of a long one are stored on disk in ``folder``, if any.

    At the end of a stopped run the last states may have no place on the track any more; they are left out then.
    Raises SimulationError when not even the first one has.
    """
    vehicle, plan, recorded = law.vehicle, setup.plan, motion
    if plan.fast_channels:
        motion = _each(motion, plan.output_interval, True)
    motion, poses = _placed(motion, law)
    body = 6 * vehicle.reference
    places, wear = _places(law, poses), plan.wear
    losses = None if wear is None else Losses(wear, law.wheels, [ways(p.distance, wear.stretch) for p in poses])
    channels = _channels(setup, law, motion, poses, places, folder, losses)
    channels["distance"] = reference = np.asarray(channels["distance"])
    shapes, bent = states.bent_channels(law, motion, channels)
    channels |= shapes
    if law.driven:
        from scipy.integrate import cumulative_trapezoid  # some 40 ms to import, for drives alone

        channels["drive_work"] = cumulative_trapezoid(channels["drive_power"], motion.times, axis=0, initial=0.0)
    y, q = np.asarray(channels["Y"]), np.asarray(channels["Q"])
    quotient = np.divide(y, q, out=np.full(q.shape, -np.inf), where=q > 1.0).max(axis=1)
    snapshots = choose_snapshots(setup, reference, quotient, motion.status == "stopped")
    strips = [StripRecorder(pair) for pair in law.wheels]
    out = np.zeros(law.size)
    for sample in snapshots:
        law.set_search_start(places[sample])
        law(motion.times[sample], motion.q[sample], motion.q_t[sample], out)
        for recorder, elements in zip(strips, law.elements_of_contacts(), strict=True):
            recorder.store(elements)
    shown = np.array(list(snapshots), dtype=int)
    channels |= {
        "speed": np.linalg.norm(motion.q_t[:, body : body + 3], axis=1),
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
        fast, of_wheelsets = _placed(_each(recorded, plan.recorded_interval), law)
        coords["fast_time"] = fast.times
        along = _places(law, of_wheelsets)
        channels |= _channels(setup, law, fast, of_wheelsets, along, folder, None, channels)
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
    there = np.rint(motion.times / motion.step) % round(interval / motion.step) == 0.0
    there[-1] |= last
    rows: Any = np.flatnonzero(there)
    if len(rows) == rows[-1] + 1:
        rows = slice(len(rows))  # no copy: many are on disk
    return replace(motion, times=motion.times[rows], q=motion.q[rows], q_t=motion.q_t[rows])


def _places(law: VehicleOnTrack, poses: list[TrackPoses]) -> Array:
    return law.places(np.column_stack([p.distance for p in poses]))


def _channels(
    setup: Setup[RunPlan], law: VehicleOnTrack, motion: Motion, poses: list[TrackPoses], places: Array,
    folder: Path | None, losses: Losses | None, sampled: dict[str, Any] | None = None,
) -> dict[str, Any]:  # fmt: skip
    """Channels of a motion; sampled: of its samples, for the fast channels of all of its states in place of these. In a
    sample a fast channel has its value to the bit, in which the warm start of the contacts may differ."""
    fast = () if sampled is None else ("distance", *setup.plan.fast_channels)
    every = round(setup.plan.output_interval / setup.plan.recorded_interval)
    n, stored = len(motion.times), Channels(len(motion.times), folder)
    bodies = np.array([law.start + part.centre[0] for part in law.vehicle.bodies])
    seats = states.wheel_seats(law.vehicle) if "axle_box_acceleration" in fast else []
    points = law.vehicle.points if not fast or any(name.startswith("point_") for name in fast) else ()
    law.follow(True)
    for begin in range(0, n, BLOCK):
        block = slice(begin, min(begin + BLOCK, n))
        channels: dict[str, Any] = with_derived(
            _block(setup, law, motion, poses, places, bodies, block, losses, points, seats)
        )
        if sampled is not None:
            first = -begin % every
            for name in sampled.keys() & fast:
                same, j = channels[name][first::every], (begin + first) // every
                same[:] = sampled[name][j : j + len(same)]
            channels = {f"fast_{name}": channels[name] for name in fast}
        stored.put(block, {name: typed(name, values) for name, values in channels.items()})
    law.follow(False)
    return dict(stored.filled())


def _block(
    setup: Setup[RunPlan], law: VehicleOnTrack, motion: Motion, poses: list[TrackPoses], places: Array, bodies: Array,
    block: slice, losses: Losses | None, own_points: Sequence[MeasuringPoint], seats: Sequence[MeasuringPoint],
) -> dict[str, Array]:  # fmt: skip
    """Channels of some samples of a motion, the sample first. A long run fills memory: raw contacts do not stay.

    bodies: see `body_channels`; losses: gathers the wear, if it is computed; own_points, seats: of the vehicle and of
    its wheels whose accelerations are computed.
    """
    vehicle, track = law.vehicle, setup.track
    times, q, q_t = motion.times[block], motion.q[block], motion.q_t[block]
    n, count, out = len(times), len(vehicle.wheelsets), np.zeros(law.size)
    raw = [RawContacts.empty(n, 2, setup.contact.patch_count) for _ in range(count)]
    points = (*own_points, *seats)
    accelerations = np.zeros((n, len(points), 3))
    records = np.zeros((n, *law.records.shape))
    reference, drive = np.zeros(n), np.zeros(n)
    external = np.zeros((n, len(vehicle.loads), 3))
    axles, deck = np.zeros((5, n, count)), np.zeros((n, len(law.of_deck)))
    powers = np.zeros((3, n))
    for i in range(n):
        law.set_search_start(places[block][i])
        law(times[i], q[i], q_t[i], out)
        for w, pair in enumerate(law.wheels):
            for j, wheel in enumerate(pair):
                raw[w].store(i, j, wheel.model.arrays)
            if losses is not None:
                losses.store(w, block.start + i)
        records[i] = law.records
        external[i] = law.load_forces
        reference[i], drive[i] = law.distance, law.drive_force
        axles[:, i] = [law.axles[name] for name in ("moment", "power", "slip", "speed", "shaft")]
        deck[i] = out[law.of_deck]
        if vehicle.bodies:
            powers[:, i] = states.lost_at(law, q_t[i])
        if points:
            accelerations[i] = states.point_accelerations(law, q[i], q_t[i], out, points)
    moved = np.zeros((n, count, 2, 2))  # rails under the wheels: left and right, lateral and up
    if law.rails:
        moved = q[:, law.size - law.rails :].reshape(moved.shape)
    of_wheelsets = []
    for w, (mounted, whole, r, pair) in enumerate(zip(vehicle.wheelsets, poses, raw, law.wheels, strict=True)):
        p = TrackPoses(*(values[block] for values in whole))
        channels = {
            "wheelset_distance": p.distance,
            **states.track_channels(track, p.distance),
            **friction_channels(setup, p.distance),
            **(dict(zip(RAIL_CHANNELS, np.moveaxis(moved[:, w], -1, 0), strict=True)) if law.rails else {}),
            "lateral_shift": p.lateral,
            "vertical_shift": p.height - mounted.wheelset.mean_radius,
            "yaw": p.yaw,
            "roll": p.roll,
            "spin_rate": p.spin_rate,
            **contact_channels(r, pair, track.widening(p.distance), uneven(track, p.distance) + moved[:, w]),
        }
        if losses is not None:
            channels |= fatigue_channels(channels, patch_wear_numbers(r), losses.settings.shear_yield)
        of_wheelsets.append(channels)
    stacked = stack_wheelsets(of_wheelsets)
    stacked |= {"distance": reference, "drive_force": drive, **states.guide_channels(law, times, records)}
    if law.on_sleepers is not None and len(motion.times) > 1:  # its forces on a bridge are those of a step
        deck = np.gradient(motion.q_t[:, law.of_deck], motion.times, axis=0)[block]
    stacked |= states.deck_channels(law, q, deck)
    if law.twists:
        stacked |= states.twist_channels(law, q, q_t)
    if law.driven:
        moment, power, slip, speed, shaft = axles
        stacked |= {"drive_moment": moment, "drive_power": power, "axle_creepage": -slip / speed}
        if law.gears:
            stacked["shaft_moment"] = shaft
    if vehicle.bodies:
        stacked |= states.body_channels(law, q, q_t, bodies)
        if setup.roller is None:  # drives of rollers
            stacked |= states.energy_channels(law, q, q_t)
        stacked |= dict(zip(("creep_power", "damper_power", "pull_power"), powers, strict=True))
    if seats:
        stacked["axle_box_acceleration"] = accelerations[:, len(own_points) :, 2].reshape(n, count, 2)
    if own_points:
        stacked |= {f"point_a{axis}": accelerations[:, : len(own_points), k] for k, axis in enumerate("xyz")}
    if vehicle.elements:
        stacked |= {f"suspension_f{axis}": records[:, :, k] for k, axis in enumerate("xyz")}
        stacked |= {f"suspension_d{axis}": records[:, :, 3 + k] for k, axis in enumerate("xyz")}
    if vehicle.couplings:
        stacked |= states.coupling_channels(law, q, records)
    if vehicle.loads:
        stacked |= {f"external_f{axis}": external[:, :, k] for k, axis in enumerate("xyz")}
    return stacked


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


def _placed(motion: Motion, law: VehicleOnTrack) -> tuple[Motion, list[TrackPoses]]:
    """The motion as far as all its samples have a place on the track, and the poses of every wheelset."""
    poses = []
    for w, mounted in enumerate(law.vehicle.wheelsets):
        q, q_t = (state[:, 6 * w : 6 * w + 6] for state in (motion.q, motion.q_t))
        poses.append(poses_as_far(law.track.centre, q, q_t, law.start + mounted.x))
    n, out = min(len(p.distance) for p in poses), np.zeros(law.size)
    while True:
        if n == 0 or (n < len(motion.times) and motion.status == "completed"):
            raise SimulationError(f"sample {n} has no place on the track")
        try:
            law.set_search_start(law.places(np.array([[p.distance[n - 1] for p in poses]]))[0])
            law(motion.times[n - 1], motion.q[n - 1], motion.q_t[n - 1], out)
        except SimulationError:
            if motion.status == "completed" or n == 1:
                raise
            n -= 1
        else:
            cut = replace(motion, times=motion.times[:n], q=motion.q[:n], q_t=motion.q_t[:n])
            return cut, [TrackPoses(*(values[:n] for values in p)) for p in poses]


def choose_snapshots(setup: Setup[RunPlan], distance: Array, quotient: Array, stopped: bool) -> dict[int, str]:
    """Samples whose strips are stored, and why: chosen distances, the largest Y/Q of either side, the stop if any.

    quotient: largest Y/Q of all wheelsets (samples, 2), minus infinity where no wheel has a load.
    """
    chosen = {
        int(np.argmin(np.abs(distance - place))): f"at {place:g} m"
        for place in setup.plan.patches_at
        if distance[0] - 0.5 <= place <= distance[-1] + 0.5
    }
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
    return dict(sorted(chosen.items()))


def stack_wheelsets(each: list[dict[str, Array]]) -> dict[str, Array]:
    """Channels of all wheelsets in one, the wheelsets behind the first dimension."""
    stacked: dict[str, Array] = {}
    for name in each[0]:
        arrays = [channels[name] for channels in each]
        if name.startswith(("strip_", "element_")):  # not-a-number behind the shorter ones
            shape = np.max([a.shape for a in arrays], axis=0)
            arrays = [np.pad(a, [(0, n) for n in shape - a.shape], constant_values=np.nan) for a in arrays]
        stacked[name] = np.stack(arrays, axis=1)
    return stacked
