"""[run] and [output]: where a run along the track goes, and what is kept of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar

from wrsim.contact.wear.laws import WearSettings
from wrsim.geometry.track.track import Track
from wrsim.inputs.section import Fault
from wrsim.inputs.values import List, number
from wrsim.scenario.sections.table import Given, PlanTable, Table
from wrsim.scenario.sections.wear import WearSection
from wrsim.simulation.integrators import DEFAULT_INTEGRATOR, Integrator
from wrsim.vehicle.speed import SpeedProfile


@dataclass(frozen=True)
class RunPlan:
    """A run along the track: from ``start`` to ``end`` [m] of the centre line, at the start with ``speed`` [m/s].

    At rest the speed is 0. profile: how it goes on from the start, constant unless given. step: of the integration [s],
    None: chosen for the integrator; output_interval: between two samples [s]; patches_at: distances [m], rising, at
    which the strips of the patches are kept; left_out: those asked for on the track that the run does not pass; wear:
    what is asked for of it, if anything.
    """

    start: float
    end: float
    speed: float
    integrator: Integrator = DEFAULT_INTEGRATOR
    step: float | None = None
    output_interval: float = 5e-3
    patches_at: tuple[float, ...] = ()
    left_out: tuple[float, ...] = ()
    profile: SpeedProfile | None = None
    wear: WearSettings | None = None

    @property
    def duration(self) -> float:
        """Time of the run [s]; 0 at rest."""
        if self.profile is not None:
            return self.profile.time(self.end - self.start)
        return (self.end - self.start) / self.speed if self.speed > 0.0 else 0.0

    @property
    def speeds(self) -> tuple[float, float]:
        """The lowest and the highest speed on the way [m/s]."""
        return (self.speed, self.speed) if self.profile is None else self.profile.until(self.duration)

    @property
    def at_constant_speed(self) -> RunPlan:
        """The same at the lowest speed on the way."""
        return replace(self, speed=self.speeds[0], profile=None)

    @property
    def limited(self) -> bool:
        """Whether the step that the file asks for may be too long for its integrator: its start has to tell."""
        return self.integrator == "rk44" and self.step is not None and self.speed > 0.0

    def facts(self) -> dict[str, Any]:
        """What a user checks."""
        if self.speed == 0.0:
            return {"at_m": self.start}
        slow, fast = (3.6 * speed for speed in self.speeds)
        speed = slow if slow == fast else f"from {3.6 * self.speed:.6g} on, within {slow:.6g} and {fast:.6g}"
        way = {"from_m": self.start, "to_m": self.end, "speed_kmh": speed, "duration_s": self.duration}
        return way | {"integrator": self.integrator, "patches_at_m": list(self.patches_at)}


class RunSection(PlanTable):
    """Where a run along the track starts and ends, and its steps in time."""

    header: ClassVar[str] = "[run]"
    at_most_one: ClassVar[tuple[str, ...]] = ("distance_m time_s",)
    aliases: ClassVar[dict[str, str]] = {
        "time_s": "duration_s t_end_s end_time_s", "distance_m": "length_m", "integrator": "method solver integration",
        "step_us": "dt_us h_us", "output_interval_ms": "output_step_ms sampling_ms",
    }  # fmt: skip

    start_distance_m: Annotated[float, number(0, 1e6, "m along the centre line")] = 0.0
    """Where the run starts; it starts from steady motion at that place."""
    distance_m: Annotated[float, number(0.01, 1e6, "m from the start")] | None = None
    """How far it goes; to the end of the track unless given."""
    time_s: Annotated[float, number(0.001, 1e5, "s from the start")] | None = None
    """How long it lasts, in place of a distance."""
    integrator: Integrator = DEFAULT_INTEGRATOR
    """How the motion is integrated in time: implicit or explicit."""
    step_us: Annotated[int, number(1, 20_000)] | None = None
    """Step of the integration; a good one is chosen unless given."""
    output_interval_ms: Annotated[float, number(0.01, 10_000, "ms between two samples")] = 5.0
    """Time between two samples of the result."""

    def consistency(self) -> Iterator[Fault]:
        """A sample needs at least one step."""
        if self.step_us is not None and self.step_us > self.output_interval_ms * 1000.0 * (1.0 + 1e-9):
            yield Fault("step_us", f"must be at most the output interval ({self.output_interval_ms:g} ms)")

    def plan(self, given: Given) -> RunPlan:
        """From the start to the end of the track or as far as the table says; at rest the start alone."""
        ahead = max(mounted.x for mounted in given.vehicle.wheelsets)
        last = given.track.length - ahead
        start, end = self.start_distance_m, last
        room = f"must lie on the track, which is {given.track.length:.6g} m long"
        if ahead:
            room += f", and the first wheelset is {ahead:.6g} m ahead of the vehicle's origin"
        if start >= last:
            raise given.fault(("run", "start_distance_m"), f"{room}; nothing is left to run")
        if not given.analysis.moves:
            return RunPlan(start, start, 0.0, patches_at=(start,))
        motion = given.speed_from(start, last)
        if self.distance_m is not None:
            end = start + self.distance_m
        elif self.time_s is not None:
            end = start + float(motion.way(self.time_s))
        if end > last * (1.0 + 1e-12):
            key = "distance_m" if self.distance_m is not None else "time_s"
            raise given.fault(("run", key), f"ends at {end:.6g} m: {room}")
        end = min(end, last, start + motion.stands_after)
        asked = given.table(OutputSection).patches_at_m
        for place in asked or ():
            if place > given.track.length:
                message = f"{place:g} m is not on the track: must lie from {start:.6g} to {end:.6g} m"
                raise given.fault(("output", "patches_at_m"), message)
        places = _middle_of_arcs(given.track, start, end) if asked is None else tuple(sorted(set(asked)))
        return RunPlan(
            start=start,
            end=end,
            speed=motion.pieces[0][2],
            profile=motion if motion.varies else None,
            integrator=self.integrator,
            step=None if self.step_us is None else self.step_us * 1e-6,
            output_interval=self.output_interval_ms * 1e-3,
            patches_at=tuple(place for place in places if start <= place <= end),
            left_out=tuple(place for place in places if not start <= place <= end),
            wear=given.table(WearSection).settings(start, end, given.fault),
        )


def _middle_of_arcs(track: Track, start: float, end: float) -> tuple[float, ...]:
    """Where patches are kept unless the file says it: in the middle of every arc on the way."""
    middles = (0.5 * (f.start + f.end) for f in track.features() if f.kind == "arc")
    return tuple(s for s in middles if start <= s <= end)


class OutputSection(Table):
    """What is kept besides the channels."""

    header: ClassVar[str] = "[output]"
    aliases: ClassVar[dict[str, str]] = {"patches_at_m": "snapshots_m patches"}

    patches_at_m: List[Annotated[float, number(0, 1e6, "m along the centre line")]] | None = None
    """Places at which whole patches are kept; the middle of every arc unless given."""
