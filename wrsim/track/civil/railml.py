"""Geometry of railML 3 (infrastructure, https://wiki3.railml.org): horizontalCurve, gradientCurve, superelevationCurve.

Lengths and radii are in m, angles in degrees clockwise from the north; radii are positive to the right; gradients are
per thousand; cant is in mm. A curve has one radius: a transition leads from the curvature of the curve before it to
that of the one behind. The attributes of superelevationCurve are from memory.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any, Literal

from wrsim.track.civil.line import JOINT, Cant, CivilLine, Plan, Profile
from wrsim.track.civil.xml_tree import Element
from wrsim.track.forms import CantForm, Form

CURVES: dict[str, Form] = {
    "straight": "clothoid", "arc": "clothoid", "clothoide": "clothoid", "cosinusoide": "cosine", "sinusoide": "sine",
    "cubicParabola": "cubic parabola", "curveBloss": "bloss", "curveWiener": "viennese",
}  # fmt: skip
PROFILES: dict[str, Literal["parabola", "circle"]] = {"straight": "parabola", "arc": "circle"}
DELTA = 1e-3
"""Largest difference of deltaAzimuth from length times curvature [rad]: it is rounded to 0.1 deg at the coarsest."""
RAMPS: dict[str, CantForm] = {
    "straight": "linear",
    "ramp": "linear",
    "linear": "linear",
    "cosinusoide": "cosine",
    "sinusoide": "sine",
    "curveBloss": "bloss",
}


def read_railml(root: Element) -> dict[str, Any]:
    """The lines of a file by the net elements that their curves lie on, each as a function that reads it."""
    tracks: dict[str, dict[str, list[Element]]] = {}
    for kind in ("horizontalCurve", "gradientCurve", "superelevationCurve"):
        for element in root.below(kind):
            net = next((e.attributes.get("netElementRef", "") for e in element.below("associatedNetElement")), "")
            tracks.setdefault(net or "line", {}).setdefault(kind, []).append(element)
    return {name: partial(_alignment, root, name, rows) for name, rows in tracks.items() if "horizontalCurve" in rows}


def _alignment(root: Element, name: str, rows: dict[str, list[Element]]) -> CivilLine:
    plan = tuple(_plan(rows["horizontalCurve"]))
    notes = (
        "railML: lengths in plan, in m; curves in the order of the file; radii positive to the right; cant in mm, "
        "positive to the inside, about the centre line (assumed)",
    )
    azimuth = rows["horizontalCurve"][0].number("azimuth", 90.0)  # without one to the east, as tracks of ours
    origin = (0.0, 0.0, math.radians(90.0 - azimuth))
    profile, cant = _profile(rows.get("gradientCurve", [])), _cant(rows.get("superelevationCurve", []), plan)
    return CivilLine(name, str(root.path), plan, tuple(profile), tuple(cant), origin, notes=notes)


def _plan(rows: Sequence[Element]) -> Iterator[Plan]:
    kinds = [(row.choice("curveType", CURVES), row.attributes["curveType"]) for row in rows]
    fixed: list[float | None] = []
    for row, (_, kind) in zip(rows, kinds, strict=True):
        radius = row.number("radius", 0.0)
        if (kind == "arc" and radius == 0.0) or (kind == "straight" and radius != 0.0):
            raise row.fault(f"{kind} of radius {radius:g}; allowed: 0 for a straight, another number for an arc")
        fixed.append(-1.0 / radius if kind == "arc" else 0.0 if kind == "straight" else None)
    end = 0.0
    for row, (form, _), known, behind in zip(rows, kinds, fixed, [*fixed[1:], 0.0], strict=True):
        length, turn = row.number("length"), -math.radians(row.number("deltaAzimuth", 0.0))
        start, told = end if known is None else known, "deltaAzimuth" in row.attributes
        if known is None and behind is None and not (told and length > 0.0):
            message = "is followed by another transition; allowed: with deltaAzimuth, which has the curvature between"
            raise row.fault(message)
        if known is not None or behind is not None:
            end = known if known is not None else behind or 0.0
        else:
            end = 2.0 * turn / length - start  # all forms turn by the mean of both curvatures
        made = 0.5 * (start + end) * length
        if told and form != "cubic parabola" and not abs(turn - made) <= DELTA:
            angles = f"deltaAzimuth = {-math.degrees(turn):g}, length and radii make {-math.degrees(made):g}"
            raise row.fault(f"{angles}; allowed: at most {math.degrees(DELTA):.2g} apart")
        yield Plan(length, start, end, form, line=row.line)


def _profile(rows: Sequence[Element]) -> Iterator[Profile]:
    place, height = 0.0, 0.0
    for row in rows:
        kind = row.choice("curveType", PROFILES)
        slope = 1e-3 * row.number("gradient")
        end, length = slope + 1e-3 * row.number("deltaGradient", 0.0), row.number("length")
        if kind == "circle":
            turn = abs(math.atan(end) - math.atan(slope))
            radius = abs(row.number("radius", length / (turn or 1.0)))
            if abs(length - radius * turn) > JOINT + 1e-3 * length:
                raise row.fault(
                    f"length {length:g} m, but radius and gradients make {radius * turn:g} m; allowed: as these do"
                )
            length = radius * abs(Profile(0.0, 0.0, slope, end).bend)
        element = Profile(place, length, slope, end, kind, height, row.line)
        yield element
        place, height = element.end, element.end_height


def _cant(rows: Sequence[Element], plan: Sequence[Plan]) -> Iterator[Cant]:
    """Cant to the inside of the curve that each element lies in."""
    place = 0.0
    for row in rows:
        form, length = row.choice("curveType", RAMPS, "linear"), row.number("length")
        first = 1e-3 * row.number("superelevation")
        ends = first, first + 1e-3 * row.number("deltaSuperelevation", 0.0)
        side = _side(plan, place, place + length)
        rails = [(-0.5 * side * cant, 0.5 * side * cant) for cant in ends]
        yield Cant(place, length, rails[0], rails[1], form, row.line)
        place += length


def _side(plan: Sequence[Plan], start: float, end: float) -> float:
    """+1 where the plan turns to the left between two distances, -1 to the right."""
    place, turned = 0.0, 0.0
    for element in plan:
        shared = min(end, place + element.length) - max(start, place)
        turned += max(shared, 0.0) * 0.5 * (element.start + element.end)
        place += element.length
    return math.copysign(1.0, turned)
