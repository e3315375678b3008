"""A scenario file as a whole: which sections there are and how they go together."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal, get_args

from wrsim.inputs.section import Fault, Section
from wrsim.inputs.values import Series, text, words
from wrsim.scenario.sections.analysis import OutputSection, RunSection, StaticSection
from wrsim.scenario.sections.assessment import AssessmentSection
from wrsim.scenario.sections.conical import ConicalSection
from wrsim.scenario.sections.conicity import ConicitySection
from wrsim.scenario.sections.contact import ContactSection, HalfSpaceSection, MaterialSection
from wrsim.scenario.sections.irregularities import GradeSection, IrregularitySection
from wrsim.scenario.sections.ride import RideSection
from wrsim.scenario.sections.stability import StabilitySection
from wrsim.scenario.sections.steady import Speed, SteadySection
from wrsim.scenario.sections.track import Arc, ElasticitySection, Straight, TrackSection, Transition
from wrsim.scenario.sections.vehicle import VehicleSection

Analysis = Literal["static", "equilibrium", "curving", "ride", "conicity", "stability", "steady"]
IN_TIME = ("curving", "ride")
"""Analyses that run along the track."""

STUDIES = ("stability", "steady")
"""Analyses of whole vehicles that lay their own track."""

UNUSED = {
    "static": ("run", "output", "conicity", "assessment", "ride", *STUDIES),
    "equilibrium": ("static", "conicity", "assessment", "ride", *STUDIES),
    "curving": ("static", "conicity", *STUDIES),
    "ride": ("static", "conicity", *STUDIES),
    "conicity": ("static", "run", "output", "assessment", "ride", *STUDIES),
    "stability": ("static", "run", "output", "conicity", "assessment", "ride", "steady"),
    "steady": ("static", "run", "output", "conicity", "assessment", "ride", "stability"),
}
"""Sections that an analysis does not look at: refused in a file, dropped when they come from its base."""


class ScenarioSpec(Section):
    """The file in the user's own units, checked. Units end here: see ``build``."""

    header: ClassVar[str] = "a scenario"
    aliases: ClassVar[dict[str, str]] = {
        "name": "title",
        "type": "analysis",
        "wheelset": "vehicle",
        "simulation": "run",
        "results": "output",
    }

    title: Annotated[str, text("a title")] = "untitled"
    analysis: Analysis
    vehicle: VehicleSection
    track: TrackSection
    contact: ContactSection = ContactSection()
    static: StaticSection | None = None
    run: RunSection = RunSection()
    output: OutputSection = OutputSection()
    conicity: ConicitySection = ConicitySection()
    assessment: AssessmentSection = AssessmentSection()
    ride: RideSection = RideSection()
    stability: StabilitySection = StabilitySection()
    steady: SteadySection | None = None

    @classmethod
    def rules(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """What each analysis needs, and what it does not use."""
        analysis = raw.get("analysis")
        if analysis == "static" and "static" not in raw:
            yield Fault("static", 'analysis = "static" needs the table [static] with its poses', missing=True)
        for unused in UNUSED.get(analysis, ()) if isinstance(analysis, str) else ():
            if unused in raw:
                yield Fault(unused, f'is not used by analysis = "{analysis}": remove it')
        track = raw.get("track")
        if analysis != "static" and isinstance(track, dict) and track.get("gauge_between") == "origins":
            yield Fault(("track", "gauge_between"), 'may be "origins" with analysis = "static" only')
        if analysis in IN_TIME:
            vehicle, track = raw.get("vehicle"), raw.get("track")
            if isinstance(vehicle, dict) and "speed_kmh" not in VehicleSection.keys_meant(vehicle):
                yield Fault(("vehicle", "speed_kmh"), f'analysis = "{analysis}" needs a speed', missing=True)
            laid = TrackSection.keys_meant(track) & {"segments", "table", "file"}
            if isinstance(track, dict) and (not laid or (laid == {"segments"} and track.get("segments") == [])):
                needed = f'analysis = "{analysis}" needs a track of [[track.segments]], a table or a file'
                yield Fault(("track", "segments"), needed, missing=True)
        yield from _of_studies(raw)


def _of_studies(raw: dict[str, Any]) -> Iterator[Fault]:
    """What stability and steady need, and what belongs to one of them only."""
    analysis, vehicle, track, contact = (raw.get(key) for key in ("analysis", "vehicle", "track", "contact"))
    if analysis in STUDIES and isinstance(track, dict):
        for key in ("segments", "table", "grades", "irregularities"):
            if track.get(key):
                message = f'has no place in analysis = "{analysis}", which lays its own track: remove it'
                yield Fault(("track", key), message + ("" if key == "table" else f" (or {key} = [])"))
    if isinstance(contact, dict) and "conical" in contact and isinstance(track, dict) and "elasticity" in track:
        yield Fault(("track", "elasticity"), "has no place beside [contact.conical], whose rails are rigid")
    if analysis == "steady":
        own = raw.get("steady")
        if own is None:
            message = 'analysis = "steady" needs the table [steady] with radius_m, cant_mm, speed_kmh'
            yield Fault("steady", message, missing=True)
        with_speed = (SteadySection, own), (VehicleSection, vehicle)
        if isinstance(own, dict) and not any(
            isinstance(table, dict) and "speed_kmh" in section.keys_meant(table) for section, table in with_speed
        ):
            yield Fault(("steady", "speed_kmh"), f"must be {words(Series[Speed])}", missing=True)
    if analysis != "stability" and isinstance(contact, dict) and "conical" in contact:
        yield Fault(("contact", "conical"), 'is for analysis = "stability" only')


def _tell_sections_of_each_other() -> None:
    """Let every section say where a key belongs that it does not know."""
    sections: tuple[type[Section], ...] = (
        ScenarioSpec, VehicleSection, TrackSection, Straight, Transition, Arc,
        GradeSection, *get_args(IrregularitySection), ElasticitySection,
        ContactSection, MaterialSection, HalfSpaceSection, StaticSection, RunSection, OutputSection, ConicitySection,
        AssessmentSection, RideSection, StabilitySection, SteadySection, ConicalSection,
    )  # fmt: skip
    for section in sections:
        section.elsewhere = {
            key: "the top of the file, before the first table" if other is ScenarioSpec else other.header
            for other in reversed(sections)
            for key in other.model_fields
            if other is not section and key not in section.model_fields
        }


_tell_sections_of_each_other()
