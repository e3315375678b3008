"""From a Scenario to what the analyses take: wheelset, rails, track and settings. Units of files end here."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from wrsim.contact.conical import ConicalWheels
from wrsim.contact.settings import ContactSettings
from wrsim.errors import InputError
from wrsim.geometry.profile.models import load_profile
from wrsim.geometry.profile.profile import Profile
from wrsim.geometry.track.track import Track
from wrsim.register import ANALYSES
from wrsim.scenario.cases import StaticPose, static_poses
from wrsim.scenario.loading import Scenario
from wrsim.scenario.placement import Stand, stand
from wrsim.scenario.sections.conicity import ConicityPlan, ConicitySection
from wrsim.scenario.sections.run import OutputSection, RunSection
from wrsim.scenario.sections.stability import StabilityPlan, StabilitySection
from wrsim.scenario.sections.static import StaticSection
from wrsim.scenario.sections.steady import SteadyPoint, SteadySection
from wrsim.scenario.track_build import gauge_extremes, track_of
from wrsim.scenario.vehicle_build import SIDES, Side, vehicle_of
from wrsim.vehicle.vehicle import Drive, Vehicle
from wrsim.vehicle.wheelset import Wheelset


@dataclass(frozen=True)
class StaticPlan:
    """Poses to solve: of one wheel (then ``side`` says which) or of the wheelset; rolling or frictionless."""

    target: Literal["wheel", "wheelset"]
    side: Side
    rolling: bool
    poses: tuple[StaticPose, ...]


@dataclass(frozen=True)
class RunPlan:
    """A run along the track: from ``start`` to ``end`` [m] of the centre line at ``speed`` [m/s], 0 at rest.

    drive: what holds the speed (``simulation.law``); step: of the integration [s], None:
    chosen by speed; output_interval: between two samples [s]; patches_at: distances [m], rising, at which the strips
    of the patches are kept.
    """

    start: float
    end: float
    speed: float
    drive: Drive
    step: float | None
    output_interval: float
    patches_at: tuple[float, ...]

    @property
    def duration(self) -> float:
        """Time of the run [s]; 0 at rest."""
        return (self.end - self.start) / self.speed if self.speed > 0.0 else 0.0


@dataclass(frozen=True, eq=False)
class Setup:
    """Everything an analysis needs, in SI units, and the text it came from.

    rails: inclined profiles of the left and right rail; static: of a static analysis only; run: also of a
    static one, then without meaning; conicity, stability, steady: of these analyses only; conical: wheels that take the
    place of profiles and contact models; files: the model files that were read.
    """

    title: str
    analysis: str
    vehicle: Vehicle
    rails: tuple[Profile, Profile]
    track: Track
    contact: ContactSettings
    run: RunPlan
    static: StaticPlan | None
    text: str
    files: tuple[Path, ...]
    conicity: ConicityPlan | None = None
    stability: StabilityPlan | None = None
    steady: tuple[SteadyPoint, ...] = ()
    conical: ConicalWheels | None = None

    @property
    def wheelset(self) -> Wheelset:
        """The first wheelset: the one that single poses are looked at of."""
        return self.vehicle.wheelsets[0].wheelset


def build(scenario: Scenario) -> Setup:
    """Read the models of a scenario and put everything together.

    Raises InputError when a model file is missing or faulty, when the track has no unique shape, when a run
    leaves the track, and when the wheelset does not stand on the rails.
    """
    spec, kind = scenario.spec, ANALYSES[scenario.analysis]
    files: list[Path] = []
    vehicle = vehicle_of(scenario, files)
    if kind.points and not vehicle.points:
        needed = f'analysis = "{kind.name}" needs a vehicle with [[points]], at which accelerations are kept'
        raise scenario.fault(("vehicle", "model"), needed)
    if kind.own_track and spec.vehicle.drive == "free" and not vehicle.runs_with_frame:
        raise scenario.fault(("vehicle", "drive"), 'must be "train" or "wheels": something has to hold the speed')
    if kind.own_track and spec.contact.normal == "half-space":
        message = f'is for poses, rest and runs: analysis = "{spec.analysis}" asks for the contacts a thousand times'
        raise scenario.fault(("contact", "normal"), message)
    rails = _rails(scenario, files)
    track = track_of(scenario, rails, files)
    if spec.track.gauge_between == "gauge points":
        for each in dict.fromkeys(mounted.wheelset for mounted in vehicle.wheelsets):
            _check_placement(scenario, each, rails, track)
    plan = None
    if kind.name == "static":
        static = scenario.table(StaticSection)
        poses = static_poses(scenario)
        if static.cases is not None:
            files.append(scenario.find(("static", "cases"), static.cases))
        plan = StaticPlan(static.target, static.side, static.rolling, poses)
    return Setup(
        title=spec.title,
        analysis=spec.analysis,
        vehicle=vehicle,
        rails=rails,
        track=track,
        contact=spec.contact.settings(),
        run=_run(scenario, track, vehicle),
        static=plan,
        text=scenario.text,
        files=tuple(dict.fromkeys(files)),
        conicity=scenario.table(ConicitySection).plan() if kind.name == "conicity" else None,
        stability=scenario.table(StabilitySection).plan() if kind.name == "stability" else None,
        steady=scenario.table(SteadySection).points(spec.vehicle.speed_kmh) if kind.name == "steady" else (),
        conical=None if spec.contact.conical is None else spec.contact.conical.wheels(),
    )


def _rails(scenario: Scenario, files: list[Path]) -> tuple[Profile, Profile]:
    section = scenario.spec.track
    found = []
    for side in SIDES:
        key, name = section.rail_of(side)
        files.append(scenario.find(("track", key), name))
        rail = load_profile(files[-1], "rail").inclined(section.inclination)
        if section.gauge_between == "gauge points":
            try:
                rail.gauge_point()
            except InputError as error:
                hint = '; bare pairs of curves are placed by gauge_between = "origins" (static poses)'
                raise scenario.fault(("track", key), str(error) + hint) from None
        found.append(rail)
    return found[0], found[1]


def _run(scenario: Scenario, track: Track, vehicle: Vehicle) -> RunPlan:
    spec = scenario.spec
    section, kind = scenario.table(RunSection), ANALYSES[spec.analysis]
    speed = (spec.vehicle.speed_kmh or 0.0) / 3.6
    ahead = max((mounted.x for mounted in vehicle.wheelsets), default=0.0)
    last = track.length - ahead
    start, end = section.start_distance_m, last
    room = f"must lie on the track, which is {track.length:.6g} m long"
    if ahead:
        room += f", and the first wheelset is {ahead:.6g} m ahead of the vehicle's origin"
    if start >= last and "run" in kind.tables:
        raise scenario.fault(("run", "start_distance_m"), f"{room}; nothing is left to run")
    patches = scenario.table(OutputSection).patches_at_m
    if kind.moves:
        key = "distance_m" if section.distance_m is not None else "time_s"
        if section.distance_m is not None:
            end = start + section.distance_m
        elif section.time_s is not None:
            end = start + section.time_s * speed
        if end > last * (1.0 + 1e-12):
            raise scenario.fault(("run", key), f"ends at {end:.6g} m: {room}")
        end = min(end, last)
        for place in patches or ():
            if not start <= place <= end:
                message = f"{place:g} m is not passed by the run: must lie from {start:.6g} to {end:.6g} m"
                raise scenario.fault(("output", "patches_at_m"), message)
    return RunPlan(
        start=start,
        end=end,
        speed=speed,
        drive=spec.vehicle.drive or vehicle.drive,
        step=None if section.step_us is None else section.step_us * 1e-6,
        output_interval=section.output_interval_ms * 1e-3,
        patches_at=tuple(sorted(set(patches))) if patches is not None else _middle_of_arcs(track, start, end),
    )


def _middle_of_arcs(track: Track, start: float, end: float) -> tuple[float, ...]:
    """Where patches are kept unless the file says it: in the middle of every arc on the way."""
    middles = (0.5 * (f.start + f.end) for f in track.features() if f.kind == "arc")
    return tuple(s for s in middles if start <= s <= end)


def _check_placement(scenario: Scenario, wheelset: Wheelset, rails: tuple[Profile, Profile], track: Track) -> None:
    """Refuse a wheelset that does not stand with both treads on the rails when it is centred."""
    nominal = track.nominal_gauge
    for gauge in sorted({nominal, *gauge_extremes(track)}, key=lambda g: abs(g - nominal)):
        for side, wheel, rail in zip(SIDES, (wheelset.left, wheelset.right), rails, strict=True):
            reason = _misplaced(stand(wheel.profile, rail, wheelset.profile_spacing, gauge))
            if not reason:
                continue
            message = (
                f"the wheelset is placed off the rails: at a gauge of {1e3 * gauge:g} mm, its wheel profiles "
                f"{1e3 * wheelset.profile_spacing:g} mm apart (vehicle.model), the {side} {reason}"
            )
            if gauge == nominal:
                raise scenario.fault(("track", "gauge_mm"), message)
            raise scenario.fault(("track", _culprit(scenario, track, gauge)), message)


def _culprit(scenario: Scenario, track: Track, gauge: float) -> str:
    """Key of [track] that makes the gauge what it is."""
    widening = gauge - track.nominal_gauge
    designed = track.widening(np.array([f.start for f in track.features()] + [track.length]))
    beyond = not designed.min() - 1e-9 <= widening <= designed.max() + 1e-9
    if scenario.spec.track.irregularities and beyond:
        return "irregularities"
    return "segments" if track.segments else "table"


def _misplaced(s: Stand) -> str:
    """Say what is wrong with a wheel on its rail; empty if nothing is."""
    if math.isnan(s.u_wheel):
        return "wheel misses its rail"
    if s.on_flange:
        return "wheel stands with its flange on the rail"
    if s.clearance < 0.0:
        return f"flange overlaps the gauge face by {-1e3 * s.clearance:.3g} mm"
    if s.rail_top > s.reach or s.u_wheel > s.reach - 2e-3:
        return f"wheel ends {1e3 * (s.rail_top - s.reach):.3g} mm inside of the top of its rail"
    return ""
