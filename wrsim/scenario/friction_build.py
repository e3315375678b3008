"""Friction along the track: from the [contact] of a scenario to laws at places of each rail."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated

from wrsim.contact.settings import ContactSettings, Friction, FrictionAlong
from wrsim.geometry.track.track import Track
from wrsim.inputs.csv_tables import check_rising, read_columns
from wrsim.inputs.section import SIDES, on_side
from wrsim.inputs.values import number
from wrsim.register import ANALYSES
from wrsim.scenario.loading import Scenario
from wrsim.scenario.sections.friction import Coefficient, law_of

COLUMNS = {"at_m": Annotated[float, number(0, 1e6, "m along the track")]} | dict.fromkeys(
    ("left", "right", "left_gauge_corner", "right_gauge_corner"), Coefficient
)
"""Columns of a table of friction: of each rail on the top and on the gauge corner."""


def contact_of(scenario: Scenario, track: Track, files: list[Path]) -> ContactSettings:
    """The contact of a scenario; adds the table that was read to ``files``.

    In runs friction is given over the distance along each rail; other analyses have that of one place.
    Raises InputError at the key, or the line of the table, that does not fit.
    """
    section = scenario.spec.contact
    settings = section.settings()
    both = law_of(section.of_side("friction", "left")[1]), law_of(section.of_side("friction", "right")[1])
    if section.friction_table is not None:
        table = partial(_of_table, before=both)
        found = scenario.read(("contact", "friction_table"), section.friction_table, table, files)
    elif section.friction_sections:
        found = _of_sections(scenario, both)
    else:
        return settings
    if not ANALYSES[scenario.analysis].moves:
        at = section.friction_at_m
        return replace(settings, friction=(found[0].at(at), found[1].at(at)))
    for i, each in enumerate(section.friction_sections):
        if each.from_m > track.length:
            message = f"must be on the track, which is {track.length:.6g} m long"
            raise scenario.fault(("contact", "friction_sections", i, "from_m"), message)
    curves = track.left_curve, track.right_curve
    left, right = (a.moved(curve.arclength(a.places)) for a, curve in zip(found, curves, strict=True))
    return replace(settings, friction=(left, right))


def _of_sections(scenario: Scenario, before: tuple[Friction, Friction]) -> list[FrictionAlong]:
    found = []
    for side, law in zip(SIDES, before, strict=True):
        places, laws = [0.0], [law]
        for _, each in on_side(scenario.spec.contact.friction_sections, side):
            if each.from_m > places[-1]:
                places.append(each.from_m)
                laws.append(laws[-1])
            places.append(places[-1] + each.transition_m)
            laws.append(law_of(each.friction))
        found.append(FrictionAlong(tuple(places), tuple(laws)))
    return found


def _of_table(path: Path, before: tuple[Friction, Friction]) -> list[FrictionAlong]:
    """Coefficients of a table in the laws of [contact]. Raises InputError with line and column."""
    columns, lines = read_columns(path, COLUMNS, ("at_m", "left", "right"))
    places = columns["at_m"]
    check_rising(path, "at_m", places, lines)
    found = []
    for side, law in zip(SIDES, before, strict=True):
        corner = columns.get(f"{side}_gauge_corner")
        laws = [
            replace(law, static=float(mu), gauge_corner=law.gauge_corner if corner is None else float(corner[i]))
            for i, mu in enumerate(columns[side])
        ]
        found.append(FrictionAlong(tuple(places.tolist()), tuple(laws)))
    return found
