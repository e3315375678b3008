"""Civil files of tracks by their kind, and the record of a track of ours."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path

from wrsim.errors import InputError, suggest
from wrsim.track.alignment import Cant, Plan, Profile
from wrsim.track.cant import Pivot
from wrsim.track.civil.ifc import ifc_text, read_ifc
from wrsim.track.civil.landxml import landxml_text, read_landxml
from wrsim.track.civil.line import MOST, RAILS, CivilLine, ramp_of
from wrsim.track.civil.railml import read_railml
from wrsim.track.civil.xml_tree import read_xml
from wrsim.track.forms import CantForm, Form
from wrsim.track.segments import Segment, end_states


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


def alignment_of(name: str, segments: Sequence[Segment], profile: Sequence[Profile], pivot: Pivot) -> CivilLine:
    """The record of segments with their lengths in plan, a profile and what cant turns about. Gauge widening is left
    out."""
    elements, ramps, start = list[Plan](), list[Cant](), 0.0
    for segment, states in zip(segments, end_states(segments).transpose(2, 0, 1).tolist(), strict=True):
        (first, cant, _), (last, end_cant, _) = states
        form: Form = getattr(segment, "form", "clothoid")
        ramp: CantForm = getattr(segment, "cant_form", None) or ramp_of(form)
        length, height = segment.length, getattr(segment, "centre_of_gravity_height", None)
        elements.append(Plan(length, first, last, form, height))
        ends = [(start, cant), (start + length, end_cant)]
        if ramp == "linear" and pivot in ("low rail", "high rail") and cant * end_cant < 0.0:
            ends.insert(1, (start + length * cant / (cant - end_cant), 0.0))  # from there on the other rail moves
        ramps += [Cant(a, b - a, RAILS[pivot](c), RAILS[pivot](d), ramp) for (a, c), (b, d) in pairwise(ends)]
        start += length
    level = not any(any(ramp.rails_start + ramp.rails_end) for ramp in ramps)
    return CivilLine(name, name, tuple(elements), tuple(profile), () if level else tuple(ramps))
