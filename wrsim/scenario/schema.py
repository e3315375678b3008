"""A scenario file as a whole: which sections there are and how they go together."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from wrsim.inputs.section import Fault, Section
from wrsim.inputs.values import Choice, Text
from wrsim.scenario.analysis_sections import OutputSection, RunSection, StaticSection
from wrsim.scenario.assessment_section import AssessmentSection
from wrsim.scenario.conicity_section import ConicitySection
from wrsim.scenario.contact_section import ContactSection, HalfSpaceSection, MaterialSection
from wrsim.scenario.irregularity_sections import IRREGULARITIES, GradeSection
from wrsim.scenario.ride_section import RideSection
from wrsim.scenario.track_section import Arc, ElasticitySection, Straight, TrackSection, Transition
from wrsim.scenario.vehicle_section import VehicleSection

Analysis = Literal["static", "equilibrium", "curving", "ride", "conicity"]
IN_TIME = ("curving", "ride")
"""Analyses that run along the track."""

UNUSED = {
    "static": ("run", "output", "conicity", "assessment", "ride"),
    "equilibrium": ("static", "conicity", "assessment", "ride"),
    "curving": ("static", "conicity"),
    "ride": ("static", "conicity"),
    "conicity": ("static", "run", "output", "assessment", "ride"),
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

    title: Annotated[str, Text("a title")] = "untitled"
    analysis: Annotated[Analysis, Choice(("static", "equilibrium", "curving", "ride", "conicity"))]
    vehicle: VehicleSection
    track: TrackSection
    contact: ContactSection = ContactSection()
    static: StaticSection | None = None
    run: RunSection = RunSection()
    output: OutputSection = OutputSection()
    conicity: ConicitySection = ConicitySection()
    assessment: AssessmentSection = AssessmentSection()
    ride: RideSection = RideSection()

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


def _tell_sections_of_each_other() -> None:
    """Let every section say where a key belongs that it does not know."""
    sections: tuple[type[Section], ...] = (
        ScenarioSpec, VehicleSection, TrackSection, Straight, Transition, Arc,
        GradeSection, *IRREGULARITIES.values(), ElasticitySection,
        ContactSection, MaterialSection, HalfSpaceSection, StaticSection, RunSection, OutputSection, ConicitySection,
        AssessmentSection, RideSection,
    )  # fmt: skip
    for section in sections:
        section.elsewhere = {
            key: "the top of the file, before the first table" if other is ScenarioSpec else other.header
            for other in reversed(sections)
            for key in other.model_fields
            if other is not section and key not in section.model_fields
        }


_tell_sections_of_each_other()
