"""[run], [output], [ride] and [wear]: where a run along the track goes, what is stored and what is evaluated of it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import Field

from wrsim.contact.wear.laws import LawName, WearSettings
from wrsim.errors import InputError
from wrsim.inputs.lines import KeyPath
from wrsim.inputs.section import Fault
from wrsim.inputs.values import List, number, positive
from wrsim.results.channels import CHANNELS, FAST, NAMES
from wrsim.scenario.sections.table import AnalysisTable, PlanContext, PlanTable
from wrsim.simulation import DEFAULT_INTEGRATOR, Integrator
from wrsim.track.bridge import Bridge
from wrsim.vehicle.speed import SpeedProfile

Place = Annotated[float, number(-1e6, 1e6, "m along the centre line")]


class StretchTable(AnalysisTable):
    """Base of tables that count over a stretch of the run."""

    from_m: Place | None = None
    """Where the stretch that counts begins, for each wheelset; where the run starts unless given."""
    to_m: Place | None = None
    """Where the stretch that counts ends; where the run ends unless given."""

    def consistency(self) -> Iterator[Fault]:
        if self.from_m is not None and self.to_m is not None and self.to_m <= self.from_m:
            yield Fault("to_m", f"must lie beyond from_m ({self.from_m:g} m)")


Coefficient = Annotated[float, positive(1.0)]
Coefficients = Annotated[
    tuple[Coefficient, Coefficient, Coefficient, Coefficient],
    Field(strict=False, description="four numbers above 0: slow, faster and fast sliding, seizure"),
]


class WearSection(StretchTable, header="[wear]"):
    """By which laws wear and rolling contact fatigue of a run are computed, and over which stretch."""

    laws: List[LawName] = ()
    """Laws of wear, one or several; without any there is neither wear nor fatigue in the result."""
    hardness_GPa: Annotated[float, number(0.5, 20, "of the softer body")] = 2.8
    """Hardness of the softer body, in Archard's law."""
    archard_coefficients: Coefficients = (5e-4, 35e-4, 5e-4, 350e-4)
    """Coefficients k of Archard's law: sliding below 0.2 m/s, up to 0.7 m/s, above, and seizure."""
    shear_yield_MPa: Annotated[float, number(50, 2000, "of the rail's steel")] = 300.0
    """Yield stress of the rail in shear, of the surface fatigue index and the shakedown map."""
    place_step_mm: Annotated[float, number(0.05, 5)] = 0.25
    """Distance of the places on the profiles at which depths are given."""

    def consistency(self) -> Iterator[Fault]:
        yield from super().consistency()
        if len(set(self.laws)) < len(self.laws):
            yield Fault("laws", "must hold each law once")

    def settings(self, start: float, end: float, fault: Callable[[KeyPath, str], InputError]) -> WearSettings | None:
        """The same in SI units; None without a law. start, end: of the run [m]."""
        if not self.laws:
            return None
        for key, place in (("from_m", self.from_m), ("to_m", self.to_m)):
            if place is not None and not start <= place <= end:
                raise fault(("wear", key), f"must lie on the run, from {start:.6g} to {end:.6g} m")
        return self.to_si(
            WearSettings,
            stretch=(self.from_m, self.to_m),
            coefficients=self.archard_coefficients,
            step=1e-3 * self.place_step_mm,
        )


class RideSection(StretchTable, header="[ride]"):
    """Which stretch of a run is evaluated, and how finely; it leaves out where a run starts and ends."""

    resolution_Hz: Annotated[float, number(0.001, 10, "Hz")] = 0.1
    """Distance between two lines of the spectra."""


@dataclass(frozen=True)
class RunPlan:
    """A run along the track: from ``start`` to ``end`` [m] of the centre line, at the start with ``speed`` [m/s].

    At rest the speed is 0. profile: how it goes on from the start, constant unless given. step: of the integration [s],
    None: chosen for the integrator; output_interval: between two samples [s]; fast_interval: the same of
    the fast channels, which are stored so often besides, if any; patches_at: distances [m], rising, at which the strips
    of the patches are stored; left_out: those on the track that the run does not pass; wear: laws of wear, if any.
    """

    start: float
    end: float
    speed: float
    integrator: Integrator = DEFAULT_INTEGRATOR
    step: float | None = None
    output_interval: float = 5e-3
    fast_interval: float | None = None
    fast_channels: tuple[str, ...] = ()
    patches_at: tuple[float, ...] = ()
    left_out: tuple[float, ...] = ()
    profile: SpeedProfile | None = None
    wear: WearSettings | None = None

    @property
    def recorded_interval(self) -> float:
        """Time between two states that are recorded [s]."""
        return self.fast_interval or self.output_interval

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
    def limited(self) -> bool:
        """Whether the step of the file may be too long for its integrator: its start decides."""
        return self.integrator == "rk44" and self.step is not None and self.speed > 0.0

    def facts(self) -> dict[str, Any]:
        if self.speed == 0.0:
            return {"at_m": self.start}
        slow, fast = (3.6 * speed for speed in self.speeds)
        speed = slow if slow == fast else f"from {3.6 * self.speed:.6g} on, within {slow:.6g} and {fast:.6g}"
        way = {"from_m": self.start, "to_m": self.end, "speed_kmh": speed, "duration_s": self.duration}
        return way | {"integrator": self.integrator, "patches_at_m": list(self.patches_at)}


class RunSection(PlanTable, header="[run]"):
    """Where a run along the track starts and ends, and its steps in time."""

    at_most_one = ("distance_m time_s",)

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
    fast_channels: List[NAMES.among(FAST).key()] = ()  # type: ignore[valid-type]
    """Channels that are stored more often besides, as `fast_Q` over `fast_time`."""
    channels_at_hz: Annotated[float, number(1, 100_000, "samples a second")] = 2000.0
    """How often these are stored; a step that is chosen divides the time between two of their samples."""

    def consistency(self) -> Iterator[Fault]:
        if self.step_us is not None and self.step_us > self.output_interval_ms * 1000.0 * (1.0 + 1e-9):
            yield Fault("step_us", f"must be at most the output interval ({self.output_interval_ms:g} ms)")
        if not self.fast_channels:
            return
        if len(set(self.fast_channels)) < len(self.fast_channels):
            yield Fault("fast_channels", "must hold each channel once")
        each = 1e3 / self.channels_at_hz
        if not _is_whole(self.output_interval_ms / each):
            yield Fault("channels_at_hz", f"must be a multiple of {1e3 / self.output_interval_ms:g}, one sample each "
                        f"output_interval_ms ({self.output_interval_ms:g})")  # fmt: skip
        elif self.step_us is not None and not _is_whole(1e3 * each / self.step_us):
            most = f"must be {1e6 / self.step_us:g}, a sample each step_us ({self.step_us}), or a whole part of it"
            yield Fault("channels_at_hz", most)

    def plan(self, context: PlanContext) -> RunPlan:
        ahead = context.vehicle.foremost
        last = context.track.length - ahead
        start, end = self.start_distance_m, last
        room = f"must lie on the track, which is {context.track.length:.6g} m long"
        if ahead:
            room += f", and the first wheelset is {ahead:.6g} m ahead of the vehicle's origin"
        if start >= last:
            raise context.fault(("run", "start_distance_m"), f"{room}; nothing is left to run")
        if not context.analysis.moves:
            return RunPlan(start, start, 0.0, patches_at=(start,))
        motion = context.speed_from(start, last)
        if self.distance_m is not None:
            end = start + self.distance_m
        elif self.time_s is not None:
            end = start + float(motion.way(self.time_s))
        if end > last * (1.0 + 1e-12):
            key = "distance_m" if self.distance_m is not None else "time_s"
            raise context.fault(("run", key), f"ends at {end:.6g} m: {room}")
        end = min(end, last, start + motion.stands_after)
        wanted = context.table(OutputSection).patches_at_m
        for place in wanted or ():
            if place > context.track.length:
                message = f"{place:g} m is not on the track: must lie from {start:.6g} to {end:.6g} m"
                raise context.fault(("output", "patches_at_m"), message)
        if wanted is None:
            wanted = (0.5 * (f.start + f.end) for f in context.track.features() if f.kind == "arc")
            places = tuple(place for place in wanted if start <= place <= end)
        else:
            places = tuple(sorted(set(wanted)))
        return RunPlan(
            start=start,
            end=end,
            speed=motion.pieces[0][2],
            profile=motion if motion.varies else None,
            integrator=self.integrator,
            step=None if self.step_us is None else self.step_us * 1e-6,
            output_interval=self.output_interval_ms * 1e-3,
            fast_interval=1.0 / self.channels_at_hz if self.fast_channels else None,
            fast_channels=self._fast_channels(context),
            patches_at=tuple(place for place in places if start <= place <= end),
            left_out=tuple(place for place in places if not start <= place <= end),
            wear=context.table(WearSection).settings(start, end, context.fault),
        )

    def _fast_channels(self, context: PlanContext) -> tuple[str, ...]:
        vehicle, structure = context.vehicle, context.track.structure
        sources = {
            "point": vehicle.points, "body": vehicle.bodies, "suspension": vehicle.elements,
            "coupling": vehicle.couplings, "span": context.track.bridge is not None,
        }  # fmt: skip
        on_rails = structure is not None and not isinstance(structure, Bridge)
        for i, name in enumerate(self.fast_channels):
            channel = CHANNELS[name]
            if not all(sources.get(dim, True) for dim in channel.dims) or (name.startswith("rail_") and not on_rails):
                noun = "elastic rails" if name.startswith("rail_") else f"{channel.dims[-1]}s"
                raise context.fault(("run", "fast_channels"), f"entry [{i}] {name} cannot be: this run has no {noun}")
        return self.fast_channels


def _is_whole(number: float) -> bool:
    return number > 0.5 and abs(number - round(number)) <= 1e-6 * number


class OutputSection(AnalysisTable, header="[output]"):
    """What is stored besides the channels."""

    patches_at_m: List[Annotated[float, number(0, 1e6, "m, distance of the vehicle")]] | None = None
    """Places at which whole patches are stored; the middle of every arc unless given."""
