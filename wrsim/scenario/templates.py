"""Scenarios to start from: what an analysis needs with values that run, every other key in a comment."""

from __future__ import annotations

from textwrap import shorten
from typing import Any

from wrsim.inputs.reference import Entry, entries
from wrsim.inputs.section import Section
from wrsim.inputs.toml_files import shown_value
from wrsim.inputs.values import entry_of, fields, table_header, unpacked
from wrsim.register import ANALYSES
from wrsim.scenario.schema import ScenarioFile

WHEELSET, COACH = "vehicles/wheelset_s1002_steering.toml", "vehicles/manchester_1.toml"
CURVE: tuple[dict[str, Any], ...] = (
    {"kind": "straight", "length_m": 30},
    {"kind": "transition", "length_m": 40},
    {"kind": "arc", "radius_m": 300, "length_m": 100, "cant_mm": 60},
)
RAILS = {"gauge_mm": 1435, "rail": "rails/60E1.toml", "inclination": "1:40"}
STARTS: dict[str, dict[str, Any]] = {
    "static": {
        "vehicle": {"model": WHEELSET},
        "track": RAILS,
        "static": {"target": "wheelset", "lateral_mm": {"from": -6, "to": 6, "step": 1}, "load_kN": 110},
    },
    "equilibrium": {"vehicle": {"model": WHEELSET}, "track": RAILS},
    "curving": {"vehicle": {"model": WHEELSET, "speed_kmh": 54}, "track": RAILS | {"segments": CURVE}},
    "ride": {
        "vehicle": {"model": COACH, "speed_kmh": 120},
        "track": RAILS
        | {
            "segments": ({"kind": "straight", "length_m": 200},),
            "irregularities": ({"kind": "spectrum", "spectrum": "ERRI-low", "seed": 1},),
        },
    },
    "conicity": {"vehicle": {"model": WHEELSET}, "track": RAILS},
    "stability": {
        "vehicle": {"model": COACH},
        "track": RAILS,
        "stability": {"speed_kmh": {"from": 60, "to": 240, "step": 60}},
    },
    "steady": {
        "vehicle": {"model": COACH, "speed_kmh": 60},
        "track": RAILS,
        "steady": {"radius_m": [300, 600], "cant_mm": 60},
    },
}
"""Keys that are given, by analysis and table."""
LINE = 120


def scenario_template(analysis: str) -> str:
    """The text of a scenario of this kind."""
    start = STARTS[analysis]
    lines = [
        "# A scenario of wrsim. Lines that begin with # are keys with their defaults: take the # away to change one.",
        f'title = "My {analysis} scenario"',
        f'analysis = "{analysis}"',
    ]
    own = ANALYSES[analysis]
    for name, annotation in fields(ScenarioFile).items():
        table = unpacked(annotation).base
        if isinstance(table, type) and issubclass(table, Section) and name not in own.unused:
            lines += ["", f"[{name}]", *_keys_of(table, start.get(name, {}), name)]
    return "\n".join(lines) + "\n"


def _keys_of(table: type[Section], given: dict[str, Any], name: str) -> list[str]:
    """Lines of one table: keys that are given, others as comments, then lists of tables."""
    lines, after = [], []
    for entry in entries(table):
        annotation = fields(table)[entry.key]
        if entry.key in given and isinstance(given[entry.key], tuple):
            for each in given[entry.key]:
                after += ["", f"[[{name}.{entry.key}]]", *(f"{k} = {shown_value(v)}" for k, v in each.items())]
        elif entry.key in given:
            lines.append(_line(f"{entry.key} = {shown_value(given[entry.key])}", entry))
        elif table_header(annotation) or (entry_of(annotation) is not None and table_header(entry_of(annotation))):
            about, see = f"# {entry.key}: {entry.meaning}", f" wrsim keys {name}.{entry.key}"
            lines.append(shorten(about, LINE - len(see), placeholder=" ...") + see)
        else:
            lines.append(_line(f"# {entry.key} = {entry.example}", entry))
    return lines + after


def _line(start: str, entry: Entry) -> str:
    """A key with what it is and may be behind it, as far as there is room; what may be chosen goes first."""
    room = LINE - max(len(start), 36) - 4
    meaning = entry.meaning.rstrip(".")
    words = f"{meaning}; {entry.allowed}"
    if len(words) > room:
        words = entry.allowed if entry.allowed.startswith('"') and len(entry.allowed) <= room else meaning
    return f"{start:<36}  # {shorten(words, room, placeholder=' ...')}" if room > 20 else start
