"""Channels of the samples of a motion, block by block: each is a function of its state (the strip model starts from the
contacts of the sample before, and ends with the same). A run may go on while those that it has are worked through.
"""

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from wrsim.analysis.contacts import friction_channels
from wrsim.analysis.motion import body_channels as states
from wrsim.contact.channels import contact_channels
from wrsim.contact.patches import patch_wear_numbers
from wrsim.contact.wear.laws import fatigue_channels
from wrsim.contact.wear.losses import Losses
from wrsim.results.dataset import typed, with_derived
from wrsim.results.netcdf import Channels
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.run import RunPlan
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import TrackPoses, poses_as_far
from wrsim.simulation.sampled_forces import SampledForces
from wrsim.simulation.system import Array

RAIL_CHANNELS = ("rail_displacement_y", "rail_displacement_z")

BLOCK = 500  # samples whose contacts are in memory at once beside the channels
STRIPS_BLOCK = 50  # the same with their strips
HANDED, WAITING = 50, 20
"""Samples that a run hands over at once, and how many such parts wait before the run waits."""


class Samples:
    """Channels of samples that come in the order of time.

    ``taken``: how many there are; ``lost``: why the one behind them has none, if it has none.
    """

    def __init__(
        self, setup: Setup[RunPlan], law: VehicleOnTrack, room: int, folder: Path | None = None,
        losses: Losses | None = None, sampled: Mapping[str, Any] | None = None,
    ) -> None:  # fmt: skip
        """room: most samples that may come; folder: where many channels are stored; losses: gathers the wear, if it is
        computed. sampled: channels of the samples; then these states are all that are recorded, and have the fast
        channels alone. In a sample a fast channel has its value to the bit, in which the warm start of the contacts may
        differ."""
        self.setup, self.law, self.losses, self.sampled = setup, law, losses, sampled
        self.taken, self.lost, self._waiting = 0, "", 0
        self._driven: tuple[float, Array, Array] | None = None
        """Time [s], power [W] of drives and their work so far [J] at the last sample."""
        self._fast = () if sampled is None else ("distance", *setup.plan.fast_channels)
        self._stored = Channels(room, folder)
        self._forces = SampledForces(law, STRIPS_BLOCK if losses else BLOCK, losses is not None)
        self._room = len(self._forces.forces)
        self._states, self._times = np.zeros((2, self._room, law.size)), np.zeros(self._room)
        self._poses = np.zeros((len(law.vehicle.wheelsets), len(TrackPoses._fields), self._room))
        self._wheelsets = [law.start + mounted.x for mounted in law.vehicle.wheelsets]
        self._bodies = np.array([law.start + part.centre[0] for part in law.vehicle.bodies])
        """Distances of wheelsets and bodies at the last sample [m]."""
        fast = self._fast
        self._seats = states.wheel_seats(law.vehicle) if "axle_box_acceleration" in fast else []
        has_points = not fast or any(name.startswith("point_") for name in fast)
        self._points = law.vehicle.points if has_points else ()

    def take(self, times: Array, q: Array, q_t: Array) -> None:
        """The next samples: times (n,) [s] and states (n, size). From the first one on that has no place on the track
        nothing is taken."""
        while len(times) and not self.lost:
            begin = self._waiting
            n = min(self._room - begin, len(times))
            n = self._evaluate(begin, times[:n], q[:n], q_t[:n])
            if self.losses is not None:
                self._store_strips(self.losses, begin, begin + n)
            self._waiting, self.taken = begin + n, self.taken + n
            if self._waiting == self._room:
                self._store()
            times, q, q_t = times[n:], q[n:], q_t[n:]

    def channels(self) -> dict[str, Any]:
        """Channels of all that were taken."""
        if self._waiting:
            self._store()
        return self._stored.filled(self.taken)

    def _evaluate(self, begin: int, times: Array, q: Array, q_t: Array) -> int:
        """Poses, forces and contacts of some samples, to the rows from ``begin`` on; returns how many have them."""
        law, n = self.law, len(times)
        for w, near in enumerate(self._wheelsets):
            coordinates = slice(6 * w, 6 * w + 6)
            poses = poses_as_far(law.track.centre, q[:n, coordinates], q_t[:n, coordinates], near)
            if len(poses.distance) < n:
                n = len(poses.distance)
                self.lost = f"sample {self.taken + n} has no place on the track"
            self._poses[w, :, begin : begin + n] = [values[:n] for values in poses]
        distances = self._poses[:, 0, begin : begin + n]
        rows = slice(begin, begin + n)
        self._times[rows], self._states[0, rows], self._states[1, rows] = times[:n], q[:n], q_t[:n]
        q, q_t = self._states[:, rows]
        n = self._forces.evaluate(begin, self._times[rows], q, q_t, law.places(distances.T))
        self.lost = self.lost or self._forces.lost
        if n:
            self._wheelsets = distances[:, n - 1].tolist()
        return n

    def _store_strips(self, losses: Losses, begin: int, end: int) -> None:
        of = [
            [self._forces.of(f"{part} {i}", end) for part in ("patches", "strips", "pose", "total")]
            for i in range(2 * len(self.law.wheels))
        ]
        for row in range(begin, end):
            contacts = [(p[row], s[row], pose[row], int(total["lobes"][row, 0])) for p, s, pose, total in of]
            for w in range(len(self.law.wheels)):
                losses.store(w, self.taken - begin + row, contacts[2 * w : 2 * w + 2])

    def _store(self) -> None:
        """Store the channels of the samples that wait."""
        begin, n = self.taken - self._waiting, self._waiting
        channels = with_derived(self._of_block(n))
        if self.sampled is not None:
            every = round(self.setup.plan.output_interval / self.setup.plan.recorded_interval)
            first = -begin % every
            for name in self.sampled.keys() & self._fast:
                same, j = np.asarray(channels[name])[first::every], (begin + first) // every
                same[:] = self.sampled[name][j : j + len(same)]
            channels = {f"fast_{name}": channels[name] for name in self._fast}
        self._stored.put(slice(begin, begin + n), {name: typed(name, values) for name, values in channels.items()})
        self._waiting = 0

    def _work_up_to(self, times: Array, power: Array) -> Array:
        """Work of drives (samples, axles) up to each sample of a block, by trapezes."""
        before, last, work = self._driven or (times[0], power[0], 0.0 * power[0])
        powers = np.concatenate([[last], power])
        steps = np.diff(times, prepend=before)[:, None] * (powers[1:] + powers[:-1]) / 2.0
        works = np.cumsum(np.concatenate([[work], steps]), axis=0)[1:]
        self._driven = times[-1], power[-1].copy(), works[-1]
        return np.asarray(works)

    def _of_block(self, n: int) -> dict[str, Array]:
        """Channels of the n samples that wait, the sample first."""
        setup, law, known = self.setup, self.law, self._forces
        vehicle, track = law.vehicle, setup.track
        times, (q, q_t), forces = self._times[:n], self._states[:, :n], known.forces[:n]
        readings, axles, units = (known.of(name, n) for name in ("reading", "axle", "unit"))
        records = readings[:, : len(vehicle.elements)]
        moved = np.zeros((n, len(vehicle.wheelsets), 2, 2))  # rails under the wheels: left and right, lateral and up
        if law.rails:
            moved = q[:, law.size - law.rails :].reshape(moved.shape)
        of_wheelsets = []
        for w, (raw, pair) in enumerate(zip(known.contacts(n), law.wheels, strict=True)):
            p = TrackPoses(*self._poses[w, :, :n])
            uneven = states.uneven(track, p.distance)
            channels = {
                "wheelset_distance": p.distance,
                **states.track_channels(track, p.distance, uneven),
                **friction_channels(setup, p.distance),
                **(dict(zip(RAIL_CHANNELS, np.moveaxis(moved[:, w], -1, 0), strict=True)) if law.rails else {}),
                "lateral_shift": p.lateral,
                "vertical_shift": p.height - vehicle.wheelsets[w].wheelset.mean_radius,
                "yaw": p.yaw,
                "roll": p.roll,
                "spin_rate": p.spin_rate,
                **contact_channels(raw, pair, track.widening(p.distance), uneven + moved[:, w]),
            }
            if self.losses is not None:
                shear_yield = self.losses.settings.shear_yield
                channels |= fatigue_channels(channels, patch_wear_numbers(raw), shear_yield)
            of_wheelsets.append(channels)
        stacked = stack_wheelsets(of_wheelsets)
        reference = q_t[:, 6 * vehicle.reference :][:, :3]
        stacked |= {"distance": units["s"][:, 0], "speed": np.linalg.norm(reference, axis=1)}
        stacked["drive_force"] = units["force"].sum(axis=1)
        stacked |= states.guide_channels(law, times, records)
        stacked |= states.deck_channels(law, q, forces[:, law.of_deck])
        if law.twists:
            stacked |= states.twist_channels(law, q, q_t)
        if law.driven:
            moment, power = axles["moment"], axles["power"]
            stacked |= {"drive_moment": moment, "drive_power": power, "axle_creepage": -axles["slip"] / axles["speed"]}
            stacked["drive_work"] = self._work_up_to(times, power)
            if law.gears:
                stacked["shaft_moment"] = axles["shaft"]
        if vehicle.bodies:
            stacked |= states.body_channels(law, q, q_t, self._bodies)
            if setup.roller is None:  # drives of rollers
                stacked |= states.energy_channels(law, q, q_t)
            stacked |= states.power_channels(law, q_t, known, n)
        points = (*self._points, *self._seats)
        if points:
            accelerations = states.point_accelerations(law, q, q_t, forces, points)
            split = len(self._points)
            if self._seats:
                box = accelerations[:, split:, 2].reshape(n, len(vehicle.wheelsets), 2)
                stacked["axle_box_acceleration"] = box
            if self._points:
                stacked |= {f"point_a{axis}": accelerations[:, :split, k] for k, axis in enumerate("xyz")}
        if vehicle.elements:
            stacked |= {f"suspension_f{axis}": records[:, :, k] for k, axis in enumerate("xyz")}
            stacked |= {f"suspension_d{axis}": records[:, :, 3 + k] for k, axis in enumerate("xyz")}
        if vehicle.couplings:
            stacked |= states.coupling_channels(law, q, readings)
        if vehicle.loads:
            loads = known.of("load", n)["force"][:, : len(vehicle.loads)]
            stacked |= {f"external_f{axis}": loads[axis] for axis in "xyz"}
        return stacked


@contextmanager
def worked_through(samples: Samples) -> Iterator[Callable[[float, Array, Array], None]]:
    """While this lasts, a function that takes the next sample (time, q, q_t); a thread works through them. At the end
    some may be left over, see ``samples.taken``."""
    parts: deque[Future[None]] = deque()
    rows: list[tuple[float, Array, Array]] = []
    with ThreadPoolExecutor(1) as thread:

        def take(t: float, q: Array, q_t: Array) -> None:
            rows.append((t, q.copy(), q_t.copy()))
            if len(rows) == HANDED:
                if len(parts) == WAITING:
                    parts.popleft().result()
                parts.append(thread.submit(samples.take, *(np.array(column) for column in zip(*rows, strict=True))))
                rows.clear()

        try:
            yield take
        finally:
            thread.shutdown(cancel_futures=True)
    for part in parts:
        if not part.cancelled():
            part.result()


def stack_wheelsets(each: Sequence[dict[str, Array]]) -> dict[str, Array]:
    """Channels of all wheelsets in one, the wheelsets behind the first dimension."""
    stacked: dict[str, Array] = {}
    for name in each[0]:
        arrays = [channels[name] for channels in each]
        if len(each) > 1 and name.startswith(("strip_", "element_")):  # not-a-number behind the shorter ones
            shape = np.max([a.shape for a in arrays], axis=0)
            arrays = [np.pad(a, [(0, n) for n in shape - a.shape], constant_values=np.nan) for a in arrays]
        stacked[name] = np.stack(arrays, axis=1)
    return stacked
