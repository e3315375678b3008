"""From a Scenario to what the analyses take: wheelset, rails, track and settings. Units of files end here."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np

from wrsim.contact.settings import ConicalWheels, ContactSettings
from wrsim.errors import InputError
from wrsim.geometry.profile.models import load_profile
from wrsim.geometry.profile.profile import Profile
from wrsim.geometry.track.rail_surface import RailSection, RailSurface, read_sections
from wrsim.geometry.track.track import MAX_OFFSET, Track
from wrsim.inputs.checking import dotted
from wrsim.inputs.lines import KeyPath
from wrsim.inputs.section import SIDES, on_side
from wrsim.inputs.toml_files import noting_reads, read_bytes
from wrsim.register import ANALYSES, Analysis, resolved
from wrsim.scenario.friction_build import contact_of
from wrsim.scenario.loading import Scenario
from wrsim.scenario.placement import Stand, stand
from wrsim.scenario.sections.table import Given
from wrsim.scenario.sections.vehicle import SpeedTable
from wrsim.scenario.track_build import gauge_extremes, track_of
from wrsim.scenario.vehicle_build import vehicle_of
from wrsim.vehicle.loads import Drive
from wrsim.vehicle.vehicle import Vehicle
from wrsim.vehicle.wheelset import Wheelset

P = TypeVar("P")


@dataclass(frozen=True, eq=False)
class Setup(Generic[P]):
    """Everything an analysis needs, in SI units, and the text it came from.

    drive: what holds the vehicle's speed; rails: inclined profiles of the left and right rail; surfaces: of rails that
    change along the track, else None; conical: wheels in place of profiles and contact models; plan: what the analysis
    has to do, from its own table; files: model files that were read; inputs: SHA-256 of every file that was read, by
    its name; threads: that compute contacts, which changes no number."""

    title: str
    analysis: str
    vehicle: Vehicle
    drive: Drive
    rails: tuple[Profile, Profile]
    surfaces: tuple[RailSurface | None, RailSurface | None]
    track: Track
    contact: ContactSettings
    conical: ConicalWheels | None
    plan: P
    text: str
    files: tuple[Path, ...]
    inputs: Mapping[str, str] = field(default_factory=dict)
    threads: int = 1

    @property
    def wheelset(self) -> Wheelset:
        """The first wheelset, of which single poses are solved."""
        return self.vehicle.wheelsets[0].wheelset

    def attributes(self, stop_reason: str = "") -> dict[str, str | float | int]:
        """Attributes of a result; stop_reason: why the analysis did not reach its end, if so."""
        own: dict[str, str | float | int] = {
            "title": self.title,
            "analysis": self.analysis,
            "status": "stopped" if stop_reason else "completed",
            "scenario_text": self.text,
            "inputs": json.dumps(dict(self.inputs)),
        }
        return own | ({"stop_reason": stop_reason} if stop_reason else {})


def build(scenario: Scenario) -> Setup[Any]:
    """Read the models of a scenario and build vehicle, rails, track and contact.

    Raises InputError when a model file is missing or faulty, when the track has no unique shape, when a run
    leaves the track, and when the wheels are not on the rails.
    """
    with noting_reads() as read, scenario.finder.guard():
        setup = _build(scenario)
        for file in scenario.files:
            read_bytes(file, "scenario file")
    return replace(setup, inputs={_short_name(scenario, file): digest for file, digest in read.items()})


def _build(scenario: Scenario) -> Setup[Any]:
    spec, analysis = scenario.spec, ANALYSES[scenario.analysis]
    files: list[Path] = []
    vehicle = vehicle_of(scenario, files)
    for key, message in _unfit(scenario, analysis, vehicle):
        raise scenario.fault(key, message)
    rails = _rails(scenario, files)
    track = track_of(scenario, rails, files)
    if spec.track.gauge_between == "gauge points":
        for each in dict.fromkeys(mounted.wheelset for mounted in vehicle.wheelsets):
            _check_placement(scenario, each, rails, track)
    surfaces = _surfaces(scenario, track, files)
    if any(surfaces) and not analysis.moves:
        message = f'are for runs: analysis = "{spec.analysis}" knows one profile of each rail'
        raise scenario.fault(("track", "rail_sections"), message)
    own = scenario.table(resolved(next(iter(analysis.tables.values()))))
    drive = spec.vehicle.drive or vehicle.drive
    speed = spec.vehicle.speed_kmh
    given = Given(analysis, vehicle, track, drive, speed, scenario.table, scenario.find, scenario.fault)
    plan = own.plan(given)
    if any(surfaces) and getattr(plan, "wear", None) is not None:
        message = "knows rails of one profile only, not [[track.rail_sections]]"
        raise scenario.fault(("wear", "laws"), message)
    return Setup(
        title=spec.title,
        analysis=spec.analysis,
        vehicle=vehicle,
        drive=drive,
        rails=rails,
        surfaces=surfaces,
        track=track,
        contact=contact_of(scenario, track, files),
        conical=None if spec.contact.conical is None else spec.contact.conical.wheels(),
        plan=plan,
        text=scenario.text,
        files=tuple(dict.fromkeys((*files, *getattr(plan, "files", ())))),
    )


def _unfit(scenario: Scenario, analysis: Analysis, vehicle: Vehicle) -> Iterator[tuple[KeyPath, str]]:
    """Keys of a vehicle or a contact model that is not for the analysis, and why."""
    spec, kind, model = scenario.spec, f'analysis = "{analysis.name}"', ("vehicle", "model")
    taken_along = (spec.vehicle.drive or vehicle.drive) != "free" or vehicle.runs_with_frame
    any_vehicle = analysis.own_track or analysis.moves or analysis.name == "equilibrium"
    if analysis.points and not vehicle.points:
        yield model, f"{kind} needs a vehicle with [[points]], at which accelerations are kept"
    if analysis.own_track and spec.vehicle.drive == "free" and not vehicle.runs_with_frame:
        yield ("vehicle", "drive"), 'must be "train" or "wheels": something has to hold the speed'
    if vehicle.members and not any_vehicle:
        yield model, f"is a train; {kind} knows one vehicle: take the file of one of them"
    if any(mounted.wheelset.torsion is not None for mounted in vehicle.wheelsets):
        if not any_vehicle:
            yield model, f"has wheels that turn against each other, and {kind} knows rigid wheelsets only"
        if spec.contact.conical is not None:
            message = "knows rigid wheelsets only; the wheels of this vehicle turn against each other"
            yield ("contact", "conical"), message
    if isinstance(spec.vehicle.speed_kmh, SpeedTable) and analysis.moves and not taken_along:
        message = 'must be "train" or "wheels": something has to take the vehicle along at the speed of the table'
        yield ("vehicle", "drive"), message
    if analysis.own_track and spec.contact.normal == "half-space":
        yield ("contact", "normal"), f"is for poses, rest and runs: {kind} needs the contacts a thousand times"
    varying = [load.name for load in vehicle.loads if load.varies]
    if analysis.own_track and varying:
        own: list[KeyPath] = [("vehicle", "loads", i) for i, v in enumerate(spec.vehicle.loads) if v.name == varying[0]]
        yield (*own, model)[0], f"{kind} looks for motion that lasts: load '{varying[0]}' must be constant"


def _short_name(scenario: Scenario, file: Path) -> str:
    """A file's name from the folder in which models are looked up."""
    whole = file.resolve()
    folders = [folder.resolve() for folder in scenario.directories]
    within = [whole.relative_to(folder).as_posix() for folder in folders if whole.is_relative_to(folder)]
    return min(within, key=len, default=file.name)


@lru_cache(maxsize=16)
def _laid(rail: Profile, inclination: float, gauge_depth: float) -> Profile:
    """A rail as laid; cached, for its tables are made once."""
    return replace(rail.inclined(inclination), gauge_depth=gauge_depth)


def _rails(scenario: Scenario, files: list[Path]) -> tuple[Profile, Profile]:
    section = scenario.spec.track
    found = []
    for side in SIDES:
        key, name = section.of_side("rail", side)
        profile = scenario.read(("track", key), name, partial(load_profile, kind="rail"), files)
        rail = _laid(profile, section.inclination, section.gauge_depth_mm / 1e3)
        if section.gauge_between == "gauge points":
            try:
                u, w = rail.gauge_point()[0], rail.top[1]
            except InputError as error:
                hint = '; bare pairs of curves are placed by gauge_between = "origins" (static poses)'
                raise scenario.fault(("track", key), str(error) + hint) from None
            if (far := max(abs(u), abs(w))) > MAX_OFFSET:
                message = f"its gauge point or its top lies {far:.4g} m from the origin of {files[-1]}; at most "
                raise scenario.fault(("track", key), f"{message}{MAX_OFFSET:g} m")
        found.append(rail)
    return found[0], found[1]


def _surfaces(scenario: Scenario, track: Track, files: list[Path]) -> tuple[RailSurface | None, RailSurface | None]:
    """Rails that change along the track; distances of their sections are along the rail itself."""
    found: list[RailSurface | None] = []
    read = [_rail_sections(scenario, i, files) for i in range(len(scenario.spec.track.rail_sections))]
    for side, curve in zip(SIDES, (track.left_curve, track.right_curve), strict=True):
        own = []
        for i, each in on_side(scenario.spec.track.rail_sections, side):
            for one in read[i]:
                place = each.at_m + one.distance
                if not 0.0 <= place <= track.length:
                    which = "" if each.table is None else f"its section at {one.distance:g} m lies at {place:g} m: it "
                    message = f"{which}must be on the track, which is {track.length:g} m long"
                    raise scenario.fault(("track", "rail_sections", i, "at_m"), message)
                own.append(replace(one, distance=float(curve.arclength(place))))
        with scenario.faults_at(("track", "rail_sections")):
            found.append(RailSurface(f"{side} rail", tuple(own)) if own else None)
    return found[0], found[1]


def _rail_sections(scenario: Scenario, i: int, files: list[Path]) -> list[RailSection]:
    """The sections of an entry of [[track.rail_sections]], as laid; distances are from its at_m."""
    entry, inclination = scenario.spec.track.rail_sections[i], scenario.spec.track.inclination
    kind, name = ("rail", entry.rail) if entry.table is None else ("table", entry.table)
    key = ("track", "rail_sections", i, kind)
    features, shift = tuple(f / 1e3 for f in entry.features_mm), (entry.outward_mm / 1e3, -entry.down_mm / 1e3)

    def read(file: Path) -> list[RailSection]:
        if entry.table is not None:
            return read_sections(file, bool(entry.measured))
        return [RailSection(0.0, load_profile(file, "rail"), features)]

    found = scenario.read(key, name or "", read, files)
    return [replace(one, profile=one.profile.inclined(inclination).shifted(*shift)) for one in found]


def _check_placement(scenario: Scenario, wheelset: Wheelset, rails: tuple[Profile, Profile], track: Track) -> None:
    """Refuse a wheelset that, centred, does not rest with both treads on the rails."""
    spec, nominal = scenario.spec.track, track.nominal_gauge
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
                key, name = scenario.spec.vehicle.of_side("wheel", side)
                others: list[KeyPath] = [("track", "gauge_mm"), ("vehicle", "model" if name is None else key)]
                named = " and ".join(f"{dotted(other)} in {scenario.locate(other)}" for other in others)
                raise scenario.fault(("track", spec.of_side("rail", side)[0]), f"{message}; see {named}")
            designed = track.widening(np.array([f.start for f in track.features()] + [track.length]))
            beyond = not designed.min() - 1e-9 <= gauge - nominal <= designed.max() + 1e-9
            widened_by = "segments" if track.segments else "table"
            raise scenario.fault(("track", "irregularities" if spec.irregularities and beyond else widened_by), message)


def _misplaced(s: Stand) -> str:
    """What is wrong with a wheel on its rail; empty if nothing is."""
    if math.isnan(s.u_wheel):
        return "wheel misses its rail"
    if s.on_flange:
        return "wheel rests with its flange on the rail"
    if s.clearance < 0.0:
        return f"flange overlaps the gauge face by {-1e3 * s.clearance:.3g} mm"
    if s.rail_top > s.reach or s.u_wheel > s.reach - 2e-3:
        return f"wheel ends {1e3 * (s.rail_top - s.reach):.3g} mm inside of the top of its rail"
    return ""
