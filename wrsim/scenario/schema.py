"""A scenario file as a whole: which tables there are and how they go together."""

from collections.abc import Iterator
from contextlib import AbstractContextManager
from functools import cache
from typing import Annotated, Any, Literal

from pydantic import create_model

from wrsim.contact.profiles.file_kinds import PointsKeys
from wrsim.contact.profiles.files import reading_as
from wrsim.inputs.file_kinds import resolved
from wrsim.inputs.reference import tables_in
from wrsim.inputs.section import Fault, Section
from wrsim.inputs.values import text
from wrsim.register import ANALYSES, TABLES, Analysis
from wrsim.scenario.sections.contact import ContactSection
from wrsim.scenario.sections.track import TrackSection
from wrsim.scenario.sections.vehicle import VehicleSection

OWN_TRACK = ("segments", "table", "grades", "irregularities")
"""Keys of [track] that an analysis which lays its own track does not take."""


class PointsSection(PointsKeys, header="[profiles.wheel] or [profiles.rail]"):
    """How files of points of wheels or of rails are read, where they and profile files do not say it."""


class ProfilesSection(Section, header="[profiles]"):
    """How files of points are read that a scenario or its vehicle names directly."""

    wheel: PointsSection = PointsSection.model_construct()
    """Files of wheels."""
    rail: PointsSection = PointsSection.model_construct()
    """Files of rails."""

    def reading(self) -> AbstractContextManager[None]:
        """Within this block files are read so."""
        return reading_as({"wheel": self.wheel.options(), "rail": self.rail.options()})


class ScenarioSpec(Section, header="a scenario"):
    """The file in the user's own units, checked. Units end here: see ``build``.

    These tables belong to all analyses; the others come from the register.
    """

    title: Annotated[str, text("a title")] = "untitled"
    """Title of the scenario, of its pictures, tables and reports."""
    units: Literal["metric", "us"] = "metric"
    """Units of tables, pictures and reports: us has ft, in, mph, kip and degrees of curve of 100 ft."""
    analysis: Literal[*ANALYSES]  # type: ignore[valid-type]
    """What is computed; it decides which further tables the file takes."""
    vehicle: VehicleSection
    """Which vehicle runs, how fast, and what differs from its file."""
    track: TrackSection
    """Gauge, rails, the way they are laid and what they rest on."""
    contact: ContactSection = ContactSection.model_construct()
    """Contact model, friction and material."""
    profiles: ProfilesSection = ProfilesSection.model_construct()
    """How files of points of wheels and rails are read."""

    @classmethod
    def raw_faults(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        name = raw.get("analysis")
        analysis = ANALYSES.get(name) if isinstance(name, str) else None
        tables = (raw.get(key) for key in ("vehicle", "track", "contact"))
        vehicle, track, contact = (table if isinstance(table, dict) else {} for table in tables)
        if track.get("gauge_between") == "origins" and not (analysis and analysis.origins):
            yield Fault(("track", "gauge_between"), f'may be "origins" with {_where("origins")} only')
        if "conical" in contact and not (analysis and analysis.conical):
            yield Fault(("contact", "conical"), f"is for {_where('conical')} only")
        if "conical" in contact and "structure" in track:
            yield Fault(("track", "structure"), "cannot be combined with [contact.conical], whose rails are rigid")
        structure = track.get("structure")
        kind = structure.get("kind") if isinstance(structure, dict) else None
        if kind == "sleepers":
            yield from _of_sleepers(name, raw, contact)
        if "rollers" in track:
            if not (analysis and analysis.rollers):
                yield Fault(("track", "rollers"), f"is for {_where('rollers')} only")
            if "conical" in contact:
                yield Fault(("track", "rollers"), "cannot be combined with [contact.conical]")
            if kind in ("sleepers", "bridge"):
                yield Fault(("track", "structure", "kind"), f'cannot be "{kind}" with [track.rollers]')
        if kind == "bridge" and contact.get("normal") == "half-space":
            yield Fault(("contact", "normal"), 'cannot be "half-space" on a bridge: the fast models only')
        if analysis is not None:
            yield from _of_tables(analysis, raw)
            yield from _of_vehicle_and_track(analysis, raw, vehicle, track)


def _where(ability: str) -> str:
    return " or ".join(f'analysis = "{a.name}"' for a in ANALYSES.values() if getattr(a, ability))


def _of_sleepers(analysis: Any, raw: dict[str, Any], contact: dict[str, Any]) -> Iterator[Fault]:
    """What rails on sleepers do not go with: they have a state of their own, which implicit steps of a run move on."""
    run = raw.get("run")
    if isinstance(analysis, str) and analysis in ANALYSES and not ANALYSES[analysis].moves:
        runs = " or ".join(f'"{a.name}"' for a in ANALYSES.values() if a.moves)
        yield Fault(("track", "structure", "kind"), f'may be "sleepers" with analysis = {runs} only')
    if contact.get("normal") == "half-space":
        yield Fault(("contact", "normal"), 'cannot be "half-space" on sleepers: the fast models only')
    if isinstance(run, dict) and run.get("integrator") == "rk44":
        yield Fault(("run", "integrator"), 'cannot be "rk44" on sleepers, which need implicit steps')


def _of_tables(analysis: Analysis, raw: dict[str, Any]) -> Iterator[Fault]:
    """Tables that are missing, and those of other analyses."""
    for name, place in analysis.tables.items():
        table = resolved(place)
        if name not in raw and _is_needed(table):
            keys = ", ".join(table.model_fields)
            yield Fault(name, f'analysis = "{analysis.name}" needs the table {table.header} with {keys}', missing=True)
        yield from table.beside(raw)
    for name in analysis.unused:
        if name in raw:
            yield Fault(name, f'is not used by analysis = "{analysis.name}": remove it')


def _of_vehicle_and_track(
    analysis: Analysis, raw: dict[str, Any], vehicle: dict[str, Any], track: dict[str, Any]
) -> Iterator[Fault]:
    """Speed, track and loads that an analysis needs, and those that it does not use."""
    kind = f'analysis = "{analysis.name}"'
    if analysis.moves:
        if isinstance(raw.get("vehicle"), dict) and "speed_kmh" not in VehicleSection.keys_meant(vehicle):
            yield Fault(("vehicle", "speed_kmh"), f"{kind} needs a speed", missing=True)
        laid = TrackSection.keys_meant(track) & {"segments", "table", "alignment", "file"}
        if isinstance(raw.get("track"), dict) and (not laid or (laid == {"segments"} and track.get("segments") == [])):
            message = f"{kind} needs a track of at least one of [[track.segments]], a table, an alignment or a file"
            yield Fault(("track", "segments"), message, missing=not laid)
    unused = [] if analysis.loaded else [("vehicle", key, "") for key in ("loads", "payloads")]
    if not analysis.moves:
        unused += [("vehicle", key, f", is for {_where('moves')} only") for key in ("efforts", "slip_control")]
    if analysis.own_track:
        unused += [("track", key, ", which lays its own track") for key in OWN_TRACK]
    for table, key, why in unused:
        if value := (vehicle if table == "vehicle" else track).get(key):
            emptied = f" (or {key} = [])" if isinstance(value, list) else ""
            yield Fault((table, key), f"cannot be combined with {kind}{why}: remove it{emptied}")


def _is_needed(table: type[Section]) -> bool:
    return any(field.is_required() for field in table.model_fields.values())


def _with_all_tables() -> type[ScenarioSpec]:
    """All tables in one; what is not given is not checked: each check of its own would take time to build."""
    tables: dict[str, Any] = {}
    for name, place in TABLES.items():
        table = resolved(place)
        tables[name] = (table | None, None) if _is_needed(table) else (table, table.model_construct())
    return create_model("ScenarioFile", __base__=ScenarioSpec, **tables)


@cache
def _keys_elsewhere(table: type[Section]) -> dict[str, str]:
    """Keys of the other tables of a scenario, for messages of one of its tables -> the header of that table."""
    tables = dict.fromkeys(tables_in(ScenarioFile))
    top = "the top of the file, before the first table"
    homes = {key: top if t is ScenarioFile else t.header for t in reversed(tables) for key in t.model_fields}
    return {key: home for key, home in homes.items() if table in tables and key not in table.model_fields}


ScenarioFile = _with_all_tables()
Section.keys_elsewhere = staticmethod(_keys_elsewhere)
