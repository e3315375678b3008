"""From a Scenario to what the analyses take: vehicle, rails, track and contact. Units of files end here."""

import json
from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Any, Generic, TypeVar

from wrsim.contact.profiles.files import noted
from wrsim.contact.profiles.profile import Profile
from wrsim.contact.settings import ConicalWheels, ContactSettings, Friction, FrictionAlong
from wrsim.contact.surfaces.rail_surface import RailSurface
from wrsim.inputs.csv_tables import check_rising, read_columns
from wrsim.inputs.file_kinds import resolved
from wrsim.inputs.lines import KeyPath
from wrsim.inputs.section import SIDES, on_side
from wrsim.inputs.toml_files import noting_reads, read_bytes
from wrsim.inputs.values import number
from wrsim.register import ANALYSES, Analysis
from wrsim.scenario import track_build
from wrsim.scenario.kept import ATTRIBUTE, KeptFiles
from wrsim.scenario.loading import Scenario
from wrsim.scenario.sections.contact import Coefficient, law_of
from wrsim.scenario.sections.table import PlanContext
from wrsim.scenario.sections.vehicle import SpeedTable
from wrsim.scenario.vehicle_build import vehicle_of
from wrsim.track.track import Track
from wrsim.vehicle.loads import Drive
from wrsim.vehicle.vehicle import Vehicle
from wrsim.vehicle.wheelset import Wheelset

P = TypeVar("P")
Digests = Mapping[str, str] | None


@dataclass(frozen=True, eq=False)
class Setup(Generic[P]):
    """Everything an analysis needs, in SI units, and the text it came from.

    drive: what holds the vehicle's speed; rails: inclined profiles of the left and right rail; surfaces: of rails that
    change along the track, else None; roller: radius of rollers in place of rails [m]; conical: wheels in place of
    profiles and contact models; plan: what the analysis has to do, from its own table; files: model files that were
    read; inputs: SHA-256 of every file that was read, by its name; kept: names and contents of the model files
    (`wrsim.scenario.kept`); threads: that compute contacts, which changes no number; support: what the rails of a run
    rest on; irregularities: spectra that are drawn, and where they fade in at the start of a run."""

    title: str
    analysis: str
    vehicle: Vehicle
    drive: Drive
    rails: tuple[Profile, Profile]
    surfaces: tuple[RailSurface | None, RailSurface | None]
    roller: float | None
    track: Track
    contact: ContactSettings
    conical: ConicalWheels | None
    plan: P
    text: str
    files: tuple[Path, ...] = ()
    inputs: Mapping[str, str] = field(default_factory=dict)
    kept: KeptFiles = field(default_factory=KeptFiles)
    threads: int = 1
    support: str = ""
    irregularities: str = ""

    @property
    def wheelset(self) -> Wheelset:
        """The first wheelset, of which single poses are solved."""
        return self.vehicle.wheelsets[0].wheelset

    @property
    def profiles(self) -> tuple[Profile, ...]:
        """All profiles of wheels and rails."""
        wheelsets = [mounted.wheelset for mounted in self.vehicle.wheelsets]
        wheels = [wheel.profile for wheelset in wheelsets for wheel in (wheelset.left, wheelset.right)]
        sections = [section.profile for surface in self.surfaces if surface for section in surface.sections]
        return *wheels, *self.rails, *sections

    @property
    def assumptions(self) -> dict[str, str]:
        """What is assumed of track and train, by the attributes of a result that say it."""
        alignment = "" if self.track.alignment is None else self.track.alignment.described
        texts = {
            "structure": self.support, "cant": self.track.assumptions, "irregularities": self.irregularities,
            "alignment": alignment, "train": self.vehicle.assumptions,
        }  # fmt: skip
        return {name: text for name, text in texts.items() if text}

    def attributes(self, stop_reason: str = "") -> dict[str, str | float | int]:
        """Attributes of a result; stop_reason: why the analysis did not reach its end, if so."""
        attributes: dict[str, str | float | int] = {
            "title": self.title,
            "analysis": self.analysis,
            "status": "stopped" if stop_reason else "completed",
            "scenario_text": self.text,
            "inputs": json.dumps(dict(self.inputs)),
            "vehicle": self.vehicle.name,
            ATTRIBUTE: self.kept.packed(),
            **noted(self.profiles),
            **self.assumptions,
        }
        return attributes | ({"stop_reason": stop_reason} if stop_reason else {})


MOST_SHARED = 12
"""Parts of set-ups that are stored for those that follow."""
_SHARED: dict[Hashable, tuple[dict[Path, bytes], Any]] = {}


def _shared(digests: Digests, scenario: Scenario, part_name: str, names: list[str], make: Callable[[], Any]) -> Any:
    """What is made of these tables of a scenario; the vehicle does not depend on its speed, unless in the wind."""
    if digests is None:
        return make()
    data = scenario.merged.data
    tables = {name: data.get(name) for name in ("analysis", "profiles", *names)}
    if "vehicle" in names and scenario.spec.vehicle.wind is None:
        tables["vehicle"] = {key: value for key, value in data["vehicle"].items() if key != "speed_kmh"}
    key = part_name, frozenset(digests.items()), scenario.finder, repr(tables)
    with noting_reads() as read:
        reads, part = _SHARED.pop(key) if key in _SHARED else (read, make())
        read.update(reads)
    _SHARED[key] = reads, part  # the last ones are those that are used
    if len(_SHARED) > MOST_SHARED:
        del _SHARED[next(iter(_SHARED))]
    return part


def build(scenario: Scenario, digests: Digests = None) -> Setup[Any]:
    """Read the models of a scenario and build vehicle, rails, track and contact.

    digests: those of now, of all files that the scenario names, by their paths: vehicle, rails and track are shared
    with earlier ones of this process of equal tables and files. Without them nothing is shared.

    Raises InputError when a model file is missing or faulty, when the track has no unique shape, when a run
    leaves the track, and when the wheels are not on the rails.
    """
    with noting_reads() as read, scenario.finder.guard():
        setup = _build(scenario, partial(_shared, digests, scenario))
        files = tuple(read)
        kept = KeptFiles.of(scenario.finder.folders, read)
        for file in scenario.merged.files:
            read_bytes(file, "scenario file")
    inputs = {name_among_models(scenario, file): sha256(content).hexdigest() for file, content in read.items()}
    return replace(setup, files=files, inputs=inputs, kept=kept)


def _build(scenario: Scenario, shared: Callable[..., Any]) -> Setup[Any]:
    spec, analysis = scenario.spec, ANALYSES[scenario.analysis]
    vehicle = shared("vehicle", ["vehicle"], lambda: vehicle_of(scenario))
    for key, message in _unfit(scenario, analysis, vehicle):
        raise scenario.fault(key, message)
    rails = shared("rails", ["track"], lambda: track_build.rails_of(scenario))
    track = shared("track", ["track"], lambda: track_build.track_of(scenario, rails))

    def placed() -> Any:
        wheelsets = dict.fromkeys(mounted.wheelset for mounted in vehicle.wheelsets)
        by_gauge_points = spec.track.gauge_between == "gauge points"
        for each in wheelsets if by_gauge_points else ():
            track_build.check_placement(scenario, each, rails, track)
        surfaces = shared("surfaces", ["track"], lambda: track_build.surfaces_of(scenario, track))
        for each in wheelsets if by_gauge_points and not conical else ():
            track_build.check_flange_backs(scenario, each, rails, surfaces)
        return surfaces

    conical = spec.contact.conical is not None
    surfaces = shared("cones" if conical else "wheels", ["vehicle", "track"], placed)
    if any(surfaces) and not analysis.moves:
        message = f'are for runs: analysis = "{spec.analysis}" knows one profile of each rail'
        raise scenario.fault(("track", "rail_sections"), message)
    table = scenario.table(resolved(next(iter(analysis.tables.values()))))
    drive = spec.vehicle.drive or vehicle.drive
    speed = spec.vehicle.speed_kmh
    context = PlanContext(analysis, vehicle, track, drive, speed, scenario.table, scenario.find, scenario.fault)
    plan = table.plan(context)
    if any(surfaces) and getattr(plan, "wear", None) is not None:
        message = "knows rails of one profile only, not [[track.rail_sections]]"
        raise scenario.fault(("wear", "laws"), message)
    rollers = spec.track.rollers
    track, begun = track_build.track_of_run(track, vehicle, plan) if analysis.moves else (track, "")
    return Setup(
        title=spec.title,
        analysis=spec.analysis,
        vehicle=vehicle,
        drive=drive,
        rails=rails,
        surfaces=surfaces,
        roller=None if rollers is None else rollers.radius_mm / 1e3,
        track=track,
        contact=contact_of(scenario, track),
        conical=None if spec.contact.conical is None else spec.contact.conical.to_si(ConicalWheels),
        plan=plan,
        text=scenario.text,
        support=track_build.support_text(track, spec.track.structure is None, rollers)
        if analysis.moves or rollers
        else "",
        irregularities="; ".join(filter(None, (*(each.label() for each in spec.track.irregularities), begun))),
    )


def _unfit(scenario: Scenario, analysis: Analysis, vehicle: Vehicle) -> Iterator[tuple[KeyPath, str]]:
    """Keys of a vehicle or a contact model that is not for the analysis, and why."""
    spec, kind, model = scenario.spec, f'analysis = "{analysis.name}"', ("vehicle", "model")
    taken_along = (spec.vehicle.drive or vehicle.drive) != "free" or vehicle.runs_with_frame
    any_vehicle = analysis.own_track or analysis.moves or analysis.name == "equilibrium"
    if analysis.points and not vehicle.points:
        yield model, f"{kind} needs a vehicle with [[points]], at which accelerations are stored"
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
    wheels = [wheel for mounted in vehicle.wheelsets for wheel in (mounted.wheelset.left, mounted.wheelset.right)]
    if spec.track.rollers is not None and any(wheel.out_of_round for wheel in wheels):
        yield model, "has wheels out of round; [track.rollers] are for round ones"
    if spec.contact.normal == "half-space" and any(m.wheelset.axle is not None for m in vehicle.wheelsets):
        yield ("contact", "normal"), 'cannot be "half-space" with elastic axles, [wheelset.axle]: the fast models only'
    if isinstance(spec.vehicle.speed_kmh, SpeedTable) and analysis.moves and not taken_along:
        message = 'must be "train" or "wheels": something has to take the vehicle along at the speed of the table'
        yield ("vehicle", "drive"), message
    if analysis.own_track and spec.contact.normal == "half-space":
        yield ("contact", "normal"), f"is for poses, rest and runs: {kind} needs the contacts a thousand times"
    varying = [load.name for load in vehicle.loads if load.varies]
    if analysis.own_track and varying:
        keys: list[KeyPath] = [
            ("vehicle", "loads", i) for i, v in enumerate(spec.vehicle.loads) if v.name == varying[0]
        ]
        yield (*keys, model)[0], f"{kind} looks for motion that lasts: load '{varying[0]}' must be constant"


def name_among_models(scenario: Scenario, file: Path) -> str:
    """A file's name from the folder in which models are looked up."""
    whole = file.resolve()
    folders = [folder.resolve() for folder in scenario.finder.folders]
    within = [whole.relative_to(folder).as_posix() for folder in folders if whole.is_relative_to(folder)]
    return min(within, key=len, default=file.name)


COLUMNS = {"at_m": Annotated[float, number(0, 1e6, "m along the track")]} | dict.fromkeys(
    ("left", "right", "left_gauge_corner", "right_gauge_corner"), Coefficient
)
"""Columns of a table of friction: of each rail on the top and on the gauge corner."""


def contact_of(scenario: Scenario, track: Track) -> ContactSettings:
    """The contact of a scenario.

    In runs friction is given over the distance along each rail; other analyses have that of one place.
    Raises InputError at the key, or the line of the table, that does not fit.
    """
    section = scenario.spec.contact
    settings = section.settings()
    laws = law_of(section.of_side("friction", "left")[1]), law_of(section.of_side("friction", "right")[1])
    if section.friction_table is not None:
        table = partial(_of_table, before=laws)
        frictions = scenario.read(("contact", "friction_table"), section.friction_table, table)
    elif section.friction_sections:
        frictions = _of_sections(scenario, laws)
    else:
        return settings
    if not ANALYSES[scenario.analysis].moves:
        place = section.friction_at_m
        return replace(settings, friction=(frictions[0].at(place), frictions[1].at(place)))
    for i, each in enumerate(section.friction_sections):
        if each.from_m > track.length:
            message = f"must be on the track, which is {track.length:.6g} m long"
            raise scenario.fault(("contact", "friction_sections", i, "from_m"), message)
    curves = track.left_curve, track.right_curve
    along = (
        tuple(curve.arclength(friction.places).tolist()) for friction, curve in zip(frictions, curves, strict=True)
    )
    left, right = (replace(friction, places=places) for friction, places in zip(frictions, along, strict=True))
    return replace(settings, friction=(left, right))


def _of_sections(scenario: Scenario, before: tuple[Friction, Friction]) -> list[FrictionAlong]:
    frictions = []
    for side, law in zip(SIDES, before, strict=True):
        places, laws = [0.0], [law]
        for _, each in on_side(scenario.spec.contact.friction_sections, side):
            if each.from_m > places[-1]:
                places.append(each.from_m)
                laws.append(laws[-1])
            places.append(places[-1] + each.transition_m)
            laws.append(law_of(each.friction))
        frictions.append(FrictionAlong(tuple(places), tuple(laws)))
    return frictions


def _of_table(path: Path, before: tuple[Friction, Friction]) -> list[FrictionAlong]:
    """Coefficients of a table in the laws of [contact]. Raises InputError with line and column."""
    columns, lines = read_columns(path, COLUMNS, ("at_m", "left", "right"))
    places = columns["at_m"]
    check_rising(path, "at_m", places, lines)
    frictions = []
    for side, law in zip(SIDES, before, strict=True):
        corner = columns.get(f"{side}_gauge_corner")
        laws = [
            replace(law, static=float(mu), gauge_corner=law.gauge_corner if corner is None else float(corner[i]))
            for i, mu in enumerate(columns[side])
        ]
        frictions.append(FrictionAlong(tuple(places.tolist()), tuple(laws)))
    return frictions
