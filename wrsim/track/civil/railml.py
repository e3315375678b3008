"""Geometry of railML 3: horizontalCurve and gradientCurve of the schemas 3.1 and 3.2 (infrastructure3.xsd) and of
https://wiki3.railml.org. These have no cant.

Lengths and radii are in m, angles in degrees clockwise from the north; radii are positive to the right; gradients are
per thousand. A curve has one radius: a transition leads from the curvature of the curve before it to that of the one
behind.
"""

import math
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any, Literal

from wrsim.track.alignment import Plan, Profile
from wrsim.track.civil.line import CivilLine
from wrsim.track.civil.xml_tree import Element
from wrsim.track.forms import Form

CURVES: dict[str, Form] = {
    "straight": "clothoid", "arc": "clothoid", "clothoide": "clothoid", "cosinusoide": "cosine", "sinusoide": "sine",
    "cubicParabola": "cubic parabola", "curveBloss": "bloss", "curveWiener": "viennese",
}  # fmt: skip
PROFILES: dict[str, Literal["parabola", "circle"]] = {"straight": "parabola", "arc": "circle"}
DELTA = 1e-3
"""Largest difference of deltaAzimuth from length times curvature [rad]: it is rounded to 0.1 deg at the coarsest."""


def read_railml(root: Element) -> dict[str, Any]:
    """The lines of a file by the net elements that their curves lie on, each as a function that reads it."""
    tracks: dict[str, dict[str, list[Element]]] = {}
    for kind in ("horizontalCurve", "gradientCurve"):
        for element in root.below(kind):
            net = next((e.attributes.get("netElementRef", "") for e in element.below("associatedNetElement")), "")
            tracks.setdefault(net or "line", {}).setdefault(kind, []).append(element)
    return {name: partial(_alignment, root, name, rows) for name, rows in tracks.items() if "horizontalCurve" in rows}


def _alignment(root: Element, name: str, rows: dict[str, list[Element]]) -> CivilLine:
    plan = tuple(_plan(rows["horizontalCurve"]))
    conventions = "lengths in plan, in m; curves in the order of the file; radii positive to the right"
    notes = (f"railML: {conventions}; level, for railML 3 has no cant",)
    azimuth = rows["horizontalCurve"][0].number("azimuth", 90.0)  # without one to the east, as tracks of ours
    origin = (0.0, 0.0, math.radians(90.0 - azimuth))
    profile = tuple(_profile(rows.get("gradientCurve", [])))
    return CivilLine(name, str(root.path), plan, profile, origin=origin, notes=notes)


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
        stop = behind if known is None else known
        if stop is None:
            if not (told and length > 0.0):
                message = "is followed by another transition; allowed: with deltaAzimuth, which has the curvature"
                raise row.fault(f"{message} between")
            stop = 2.0 * turn / length - start  # all forms turn by the mean of both curvatures
        made = 0.5 * (start + stop) * length
        if told and form != "cubic parabola" and not abs(turn - made) <= DELTA:
            angles = f"deltaAzimuth = {-math.degrees(turn):g}, length and radii make {-math.degrees(made):g}"
            raise row.fault(f"{angles}; allowed: at most {math.degrees(DELTA):.2g} apart")
        yield Plan(length, start, stop, form, line=row.line)
        end = stop


def _profile(rows: Sequence[Element]) -> Iterator[Profile]:
    place, height = 0.0, 0.0
    for row in rows:
        kind = row.choice("curveType", PROFILES)
        slope = 1e-3 * row.number("gradient")
        end, length = slope + 1e-3 * row.number("deltaGradient", 0.0), row.number("length")
        if kind == "circle":
            turn = abs(math.atan(end) - math.atan(slope))
            radius = abs(row.number("radius", length / (turn or 1.0)))
            row.check_arc(length, radius * turn)
            length = radius * abs(Profile(0.0, 0.0, slope, end).bend)
        element = Profile(place, length, slope, end, kind, height, row.line)
        yield element
        place, height = element.end, element.end_height
