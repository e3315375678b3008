"""Alignments of LandXML 1.2 (http://www.landxml.org/schema/LandXML-1.2).

Points are "north east"; rot and curvature are "cw" to the right, "ccw" to the left; cant is in mm or inches, positive
to the inside of a curve; stations are in plan and begin with staStart. The points say the directions. dir and dirStart
are not read, for programs differ: the schema and 3D-Win count them counter-clockwise from the north, Civil 3D
counter-clockwise from the east, MDT clockwise from the north.
"""

import cmath
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import accumulate, pairwise
from typing import Any, Literal
from xml.sax.saxutils import quoteattr

from wrsim.track.alignment import JOINT, Cant, Plan, Profile
from wrsim.track.cant import CANT_BASE, Pivot
from wrsim.track.civil.line import RAILS, CivilLine, ramp_of
from wrsim.track.civil.xml_tree import Element
from wrsim.track.forms import CantForm, Form

FOOT, SURVEY_FOOT = 0.3048, 1200.0 / 3937.0
METRES = {
    "meter": 1.0, "millimeter": 1e-3, "centimeter": 1e-2, "kilometer": 1e3, "foot": FOOT, "USSurveyFoot": SURVEY_FOOT,
    "inch": FOOT / 12.0, "mile": 5280.0 * FOOT,
}  # fmt: skip
SPIRALS: dict[str, Form] = {
    "clothoid": "clothoid", "bloss": "bloss", "cosine": "cosine", "sinusoid": "sine", "biquadratic": "helmert",
    "cubicParabola": "cubic parabola", "cubic": "cubic parabola", "weinerBogen": "viennese", "wienerBogen": "viennese",
}  # fmt: skip
RAMPS: dict[str, CantForm] = {name: ramp_of(form) for name, form in SPIRALS.items()}
"""spiType and transitionType, and the forms of `wrsim.track.forms`; the schema writes weinerBogen."""
HANDS = {"ccw": 1.0, "cw": -1.0}
PIVOTS: dict[str, Pivot] = {
    "center": "centre line", "insideRail": "low rail", "outsideRail": "high rail", "leftRail": "left rail",
    "rightRail": "right rail", "left": "left rail", "right": "right rail",
}  # fmt: skip
"""rotationPoint, and what the cant turns about; Inframodel has left and right."""
LEAST_MILLIMETRES = 10.0
"""A larger gauge is in mm: COYPU writes 1435. The schema has metres or feet."""
HEIGHT, BASE = "gravityCenterLineHeight", "railHeadDistance"
"""Properties of a Feature for what LandXML lacks: of a spiral and of the cant, in units of length."""


def read_landxml(root: Element) -> dict[str, Any]:
    """The alignments of a file by their names, each as a function that reads it. Raises InputError."""
    lines: dict[str, Any] = {}
    for element in root.below("Alignment"):
        name = element.attributes.get("name") or f"line {element.line}"
        name = name if name not in lines else f"{name} (line {element.line})"
        lines[name] = partial(_alignment, root, element, name)
    return lines


def _alignment(root: Element, element: Element, name: str) -> CivilLine:
    units = next((u for holder in root.all("Units") for u in holder.all("Metric", "Imperial")), None)
    if units is None:
        raise root.fault("has no Units with Metric or Imperial; allowed: one of them, with linearUnit")
    metre, unit = units.choice("linearUnit", METRES), units.attributes["linearUnit"]
    station = element.number("staStart", 0.0)
    plan, end = _plan(element, metre)
    notes = [f"LandXML: lengths in plan, in units of {unit}; points north east, which say the directions"]
    if any(spiral.attributes.get("spiType") == "cubic" for spiral in element.below("Spiral")):
        notes.append('spiType = "cubic" is taken as y = x^3/(6 R L)')
    cant, base, gauge = list[Cant](), None, None
    for row in element.all("Cant"):
        fine, unit = (1e-3, "mm") if units.tag == "Metric" else (FOOT / 12.0, "inches")
        cant = list(_cant(row, station, metre, fine, plan))
        base, gauge = _property(row, BASE, metre), row.number("gauge")
        gauge *= metre if gauge < LEAST_MILLIMETRES else 1e-3
        if base is None and "superelevationBase" in row.attributes:
            base = row.number("superelevationBase") * metre
        pivot = row.attributes.get("rotationPoint", "center (assumed)")
        notes.append(f"cant in {unit}, positive to the inside, about {pivot}; transitionType is of the ramp behind")
        if any("curvature" not in each.attributes for each in row.all("CantStation")):
            notes.append("without curvature the inside is that of the plan")
        if abs(gauge - CANT_BASE) < 1e-6:
            notes.append(f'gauge = "{row.attributes["gauge"]}" is taken as the distance between the rail tops')
            base, gauge = base or gauge, None
    rows = tuple(plan), tuple(_profile(element, station, metre)), tuple(cant)
    assert plan[0].pose is not None
    line = CivilLine(name, str(root.path), *rows, plan[0].pose, base, gauge, station * metre, end, tuple(notes))
    first = replace(line, plan=rows[0][:1], origin=(0.0, 0.0, 0.0), end=(plan[1].pose or end)[:2] if plan[1:] else end)
    return replace(line, origin=(*line.origin[:2], float(first.rotations(base or CANT_BASE)[0])))


def _property(element: Element, label: str, metre: float) -> float | None:
    """A length among the properties of a Feature [m]."""
    for feature in element.all("Feature"):
        for row in feature.all("Property"):
            if row.attributes.get("label") == label:
                return row.number("value") * metre
    return None


def _plan(alignment: Element, metre: float) -> tuple[list[Plan], tuple[float, float]]:
    """Elements in plan, and their end."""
    plan, end = list[Plan](), 0j
    for row in (e for geometry in alignment.all("CoordGeom") for e in geometry.children if e.tag != "Feature"):
        if row.tag not in ("Line", "Curve", "Spiral"):
            raise row.fault("is no element of a track; allowed: Line, Curve, Spiral")
        start, end = (_place(row, key, metre) for key in ("Start", "End"))
        side = 0.0 if row.tag == "Line" else row.choice("rot", HANDS)
        form: Form = "clothoid"
        length, height, radii = abs(end - start), None, (1.0, 1.0)
        if row.tag == "Curve":
            arm = start - (middle := _place(row, "Center", metre))
            radii = (row.number("radius", abs(arm) / metre) * metre,) * 2
            length = abs(arm) * (side * cmath.phase((end - middle) * arm.conjugate()) % math.tau)
        elif row.tag == "Spiral":
            form, height = row.choice("spiType", SPIRALS), _property(row, HEIGHT, metre)
            radii = (_radius(row, "radiusStart") * metre, _radius(row, "radiusEnd") * metre)
        if 0.0 in radii or (row.tag == "Curve" and radii[0] < 0.0):
            raise row.fault(f"a radius of {min(radii):g} m; allowed: above 0, INF for a straight; rot has the side")
        if length := row.number("length", length / metre) * metre:
            pose = (start.real, start.imag, math.nan)
            plan.append(Plan(length, side / radii[0], side / radii[1], form, height, pose, row.line))
    if not plan:
        raise alignment.fault("has no CoordGeom with Line, Curve or Spiral")
    return plan, (end.real, end.imag)


def _place(row: Element, key: str, metre: float) -> complex:
    """A point, east + i north [m]."""
    if (point := row.first(key)) is None:
        raise row.fault(f"{key} is missing; allowed: a point as 'north east'")
    north, east = point.numbers(point.text, 2, point.text.strip() or str(point.attributes))[:2]
    return complex(east, north) * metre


def _radius(spiral: Element, key: str) -> float:
    return math.inf if spiral.attributes.get(key, "").strip() == "INF" else spiral.number(key)


def _profile(alignment: Element, station: float, metre: float) -> Iterator[Profile]:
    """Grades and vertical curves between the points of intersection."""
    rows = [p for holder in alignment.all("Profile") for p in holder.all("ProfAlign")]
    if len(rows) > 1:
        raise rows[1].fault(f"'{alignment.attributes.get('name')}' has {len(rows)} designed profiles; allowed: one")
    points = rows[0].all("PVI", "ParaCurve", "UnsymParaCurve", "CircCurve") if rows else []
    texts = [p.numbers(p.text, 2, p.text.strip()) for p in points]
    places = [((x - station) * metre, z * metre) for x, z, *_ in texts]
    for point, (a, b) in zip(points[1:], pairwise(places), strict=False):
        if not a[0] < b[0]:
            raise point.fault(
                f"station {b[0] + station * metre:g} m after {a[0] + station * metre:g} m; allowed: rising ones"
            )
    slopes = [(b[1] - a[1]) / (b[0] - a[0]) for a, b in pairwise(places)]
    if points and (not slopes or {points[0].tag, points[-1].tag} != {"PVI"}):
        raise rows[0].fault("allowed: two points at least, PVI as the first and the last")
    done, height = places[0] if places else (0.0, 0.0)
    for i, point in enumerate(points[1:], 1):
        before, behind = slopes[i - 1], slopes[min(i, len(slopes) - 1)]
        curve = _tangents(point, before, behind, metre)
        straight = places[i][0] - curve[0] - done
        if straight < -JOINT:
            raise point.fault(
                f"its vertical curve begins {-straight:g} m before the end of the one before; allowed: behind it"
            )
        if straight > 1e-9:
            yield Profile(done, straight, before, before, height=height, line=point.line)
        done, height = places[i][0] - curve[0], places[i][1] - before * curve[0]
        middle = (before * curve[0] + behind * curve[1]) / (sum(curve) or 1.0)
        if point.tag == "UnsymParaCurve":  # two parabolas, which touch the line through the middles of both tangents
            yield Profile(done, curve[0], before, middle, height=height, line=point.line)
            done, height = done + curve[0], height + 0.5 * (before + middle) * curve[0]
            yield Profile(done, curve[1], middle, behind, height=height, line=point.line)
        elif point.tag != "PVI" and sum(curve) > 0.0:
            form: Literal["circle", "parabola"] = "circle" if point.tag == "CircCurve" else "parabola"
            yield Profile(done, sum(curve), before, behind, form, height, point.line)
        done, height = places[i][0] + curve[1], places[i][1] + behind * curve[1]


def _tangents(point: Element, before: float, behind: float, metre: float) -> tuple[float, float]:
    """Length in plan of a vertical curve before and behind its point of intersection [m]."""
    if point.tag == "ParaCurve":
        return (0.5 * point.number("length") * metre,) * 2
    if point.tag == "UnsymParaCurve":
        return point.number("lengthIn") * metre, point.number("lengthOut") * metre
    if point.tag == "PVI":
        return 0.0, 0.0
    radius, turn = abs(point.number("radius")) * metre, abs(math.atan(behind) - math.atan(before))
    point.check_arc(point.number("length", radius * turn / metre) * metre, radius * turn)
    tangent = radius * math.tan(0.5 * turn)
    return tangent / math.hypot(1.0, before), tangent / math.hypot(1.0, behind)


def _cant(element: Element, station: float, metre: float, fine: float, plan: Sequence[Plan]) -> Iterator[Cant]:
    """Ramps between the stations."""
    sides = RAILS[element.choice("rotationPoint", PIVOTS, "center")]
    stations = element.all("CantStation")
    rows = []
    for row in stations:
        place = (row.number("station") - station) * metre
        hand = _hand(plan, place) if "curvature" not in row.attributes else row.choice("curvature", HANDS)
        adverse = row.choice("adverse", {"false": 1.0, "0": 1.0, "true": -1.0, "1": -1.0}, "false")
        form = RAMPS["clothoid"] if "transitionType" not in row.attributes else row.choice("transitionType", RAMPS)
        rows.append((place, sides(hand * adverse * row.number("appliedCant") * fine), form))
    if rows:  # beyond the stations the cant is held
        (first, a, _), (last, b, _) = rows[0], rows[-1]
        length = sum(e.length for e in plan)
        rows = [(min(first, 0.0), a, RAMPS["clothoid"]), *rows, (max(last, length), b, RAMPS["clothoid"])]
    for row, ((start, a, form), (end, b, _)) in zip(stations[:1] + stations, pairwise(rows), strict=False):
        if end < start:
            raise row.fault("the next station lies before it; allowed: rising ones")
        if end > start:
            yield Cant(start, end - start, a, b, form, row.line)


def _hand(plan: Sequence[Plan], place: float) -> float:
    """+1 where the element of largest curvature at a distance turns to the left, -1 to the right."""
    ends = accumulate(element.length for element in plan)
    near = [e.start + e.end for e, end in zip(plan, ends, strict=True) if -JOINT <= end - place <= e.length + JOINT]
    return math.copysign(1.0, max(near, key=abs, default=0.0))


def landxml_text(line: CivilLine, base: float, gauge: float, date: str) -> str:
    """A file of one alignment, in metres and millimetres. base: distance over which cant is counted [m]. Raises
    InputError for cant that turns about no point which LandXML knows."""
    names = {form: name for name, form in reversed(SPIRALS.items())}
    rows = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<LandXML xmlns="http://www.landxml.org/schema/LandXML-1.2" version="1.2" date="{date}" time="00:00:00">',
        '<Units><Metric areaUnit="squareMeter" linearUnit="meter" volumeUnit="cubicMeter" temperatureUnit="celsius" '
        'pressureUnit="milliBars" angularUnit="radians" directionUnit="radians"/></Units>',
        '<Application name="wrsim"/>',
        f'<Alignments><Alignment name={quoteattr(line.name)} length="{line.length!r}" staStart="{line.station!r}">',
        "<CoordGeom>",
    ]
    shape = line.level(base)
    joints = zip(
        (shape.position(line.edges) @ [1.0, 1.0j, 0.0]).tolist(), shape.heading(line.edges).tolist(), strict=True
    )
    for element, ((start, heading), (end, leaving)) in zip(line.plan, pairwise(joints), strict=True):
        ahead = cmath.rect(1.0, heading)
        bends = max((element.start, element.end), key=abs)
        towards, kind, inner, extra = f'length="{element.length!r}"', "Line", "", ""
        if bends:
            towards += f' rot="{"ccw" if bends > 0.0 else "cw"}"'
            kind, inner = "Curve", _point("Center", start + 1j * ahead / bends)
        if bends and element.start == element.end and element.form != "viennese":
            towards += f' radius="{1.0 / abs(bends)!r}"'
        elif bends:
            kind, side = "Spiral", math.copysign(1.0, bends)  # a radius to the other side is negative
            radii = ["INF" if k == 0.0 else repr(side / k) for k in (element.start, element.end)]
            towards += f' radiusStart="{radii[0]}" radiusEnd="{radii[1]}" spiType="{names[element.form]}"'
            turn = math.sin(leaving - heading)  # tangents of both ends meet in the PI
            reach = ((end - start) * cmath.rect(1.0, -leaving)).imag / -turn if turn else 0.5 * abs(end - start)
            inner = _point("PI", start + reach * ahead)
            extra = "" if (high := element.centre_of_gravity_height) is None else _feature(HEIGHT, high)
        ends = _point("Start", start), _point("End", end)
        rows.append(f"<{kind} {towards}>{ends[0]}{inner}{ends[1]}{extra}</{kind}>")
    rows += [
        "</CoordGeom>",
        *_profile_rows(line),
        *_cant_rows(line, base, gauge),
        "</Alignment></Alignments></LandXML>",
    ]
    return "\n".join(rows) + "\n"


def _point(tag: str, place: complex) -> str:
    return f"<{tag}>{place.imag!r} {place.real!r}</{tag}>"


def _feature(label: str, value: float) -> str:
    return f'<Feature code="wrsim"><Property label="{label}" value="{value!r}"/></Feature>'


def _profile_rows(line: CivilLine) -> Iterator[str]:
    """The profile as points of intersection."""
    if not line.profile:
        return
    yield '<Profile name="profile"><ProfAlign name="profile">'
    rows = line.profile_rows()
    first, last = rows[0], rows[-1]
    yield f"<PVI>{first.start + line.station!r} {first.height!r}</PVI>"
    for element in rows:
        if element.slope_start == element.slope_end:
            continue
        turn = math.atan(element.slope_end) - math.atan(element.slope_start)
        tangent, tag = 0.5 * element.length, f'ParaCurve length="{element.length!r}"'
        if element.form == "circle":
            radius = element.length / abs(element.bend)
            tangent = radius * math.tan(0.5 * abs(turn)) / math.hypot(1.0, element.slope_start)
            tag = f'CircCurve length="{radius * abs(turn)!r}" radius="{radius!r}"'
        place, height = element.start + tangent, element.height + element.slope_start * tangent
        yield f"<{tag}>{place + line.station!r} {height!r}</{tag.split()[0]}>"
    yield f"<PVI>{last.end + line.station!r} {last.end_height!r}</PVI>"
    yield "</ProfAlign></Profile>"


def _cant_rows(line: CivilLine, base: float, gauge: float) -> Iterator[str]:
    """Cant by its stations."""
    if not line.cant:
        return
    rows = line.cant_rows()
    rows.append(Cant(rows[-1].end, 0.0, rows[-1].rails_end, rows[-1].rails_end))
    heights = [rails for e in rows for rails in (e.rails_start, e.rails_end)]
    turns = (p for p, name in PIVOTS.items() if all(math.dist(RAILS[name](b - a), (a, b)) < 1e-9 for a, b in heights))
    if (pivot := next(turns, None)) is None:
        raise line.fault(line.cant[0], f"rails that do not turn about one point; LandXML allows: {', '.join(PIVOTS)}")
    names = {form: name for name, form in reversed(RAMPS.items())} | {"linear": "clothoid"}
    yield f'<Cant name="cant" gauge="{gauge!r}" rotationPoint="{pivot}">'
    for row in rows:
        cant, ramp = 1e3 * (row.rails_start[1] - row.rails_start[0]), ""
        if row.rails_start != row.rails_end:
            ramp = f' transitionType="{names[row.form]}"'
        place, hand = f'station="{row.start + line.station!r}"', "cw" if cant < 0.0 else "ccw"
        yield f'<CantStation {place} appliedCant="{abs(cant)!r}" curvature="{hand}"{ramp}/>'
    yield _feature(BASE, base) + "</Cant>"
