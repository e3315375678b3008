"""Civil files of tracks by their kind, and the record of a track of ours."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from wrsim.contact.profiles.curves import gauss_integrals
from wrsim.errors import InputError, suggest
from wrsim.track.alignment import Cant, Plan, profile_of
from wrsim.track.cant import Pivot
from wrsim.track.civil.ifc import ifc_text, read_ifc
from wrsim.track.civil.landxml import landxml_text, read_landxml
from wrsim.track.civil.line import MOST, RAILS, CivilLine, ramp_of
from wrsim.track.civil.railml import read_railml
from wrsim.track.civil.xml_tree import read_xml
from wrsim.track.forms import CantForm, Form
from wrsim.track.piecewise import Piecewise, merged
from wrsim.track.segments import Grade, Segment, end_states


def read_alignment(path: Path, name: str | None = None) -> CivilLine:
    """An alignment of an IFC, LandXML or railML file; name: which one of several. Raises InputError."""
    lines: dict[str, Callable[[], CivilLine]]
    if path.suffix.lower() == ".ifc":
        lines = read_ifc(path)
    else:
        root = read_xml(path, "LandXML or railML file")
        if root.tag not in ("LandXML", "railML"):
            raise InputError(f"{path}: begins with <{root.tag}>; allowed: <LandXML> or <railML>")
        lines = read_landxml(root) if root.tag == "LandXML" else read_railml(root)
    listed = ", ".join(f'"{each}"' for each in [*lines][:20]) + (", ..." if len(lines) > 20 else "")
    if not lines:
        raise InputError(f"{path}: has no alignment in plan")
    if name is None and len(lines) > 1:
        raise InputError(f"{path}: has {len(lines)} alignments; choose one by alignment_name: {listed}")
    if name is not None and name not in lines:
        raise InputError(f"{path}: has no alignment '{name}'; allowed: {listed}{suggest(name, [*lines])}")
    line = lines[name if name is not None else next(iter(lines))]()
    if (count := max(map(len, (line.plan, line.profile, line.cant)))) > MOST:
        raise InputError(f"{path}: '{line.name}' has {count} elements; allowed: {MOST}")
    return line


def civil_text(line: CivilLine, path: Path, base: float, gauge: float, date: str) -> str:
    """The text of an IFC or LandXML file, by the ending of its name. base: distance over which cant is counted [m];
    gauge [m]; date: of today. Raises InputError."""
    if path.suffix.lower() == ".railml":
        raise InputError(f"{path}: railML is read only; allowed: .ifc, .xml (LandXML)")
    return ifc_text(line, base, date) if path.suffix.lower() == ".ifc" else landxml_text(line, base, gauge, date)


def alignment_of(
    name: str, segments: Sequence[Segment], pitch: Piecewise, grades: Sequence[Grade], pivot: Pivot
) -> CivilLine:
    """The record of segments of a track, whose lengths are along it, its angle of slope and its grades. Gauge widening
    is left out."""
    edges = np.concatenate([[0.0], np.cumsum([segment.length for segment in segments])])
    places = merged(edges, pitch.breaks)
    plan = np.cumsum([0.0, *gauss_integrals(lambda s: np.cos(pitch(s)), places[:-1], places[1:], 16)])
    starts = np.interp(edges, places, plan).tolist()
    elements, ramps = list[Plan](), list[Cant]()
    for i, (segment, states) in enumerate(zip(segments, end_states(segments).transpose(2, 0, 1).tolist(), strict=True)):
        (first, cant, _), (last, end_cant, _) = states
        form: Form = getattr(segment, "form", "clothoid")
        ramp: CantForm = getattr(segment, "cant_form", None) or ramp_of(form)
        length, height = starts[i + 1] - starts[i], getattr(segment, "centre_of_gravity_height", None)
        elements.append(Plan(length, first, last, form, height))
        ramps.append(Cant(starts[i], length, RAILS[pivot](cant), RAILS[pivot](end_cant), ramp))
    level = not any(any(ramp.rails_start + ramp.rails_end) for ramp in ramps)
    profile = profile_of(grades, starts[-1]) if grades else ()
    return CivilLine(name, name, tuple(elements), tuple(profile), () if level else tuple(ramps))
