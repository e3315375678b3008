"""``wrsim keys``: what a file may hold; ``wrsim new``: a scenario to start from."""

from __future__ import annotations

import json
from pathlib import Path
from re import findall
from textwrap import fill
from typing import TYPE_CHECKING, Annotated, Any

import typer

from wrsim.cli.ending import reporting_errors
from wrsim.cli.options import Force, Json
from wrsim.cli.showing import print_json, say
from wrsim.cli.storing import writing
from wrsim.errors import InputError, suggest
from wrsim.register import ANALYSES, resolved

if TYPE_CHECKING:
    from wrsim.inputs.reference import Entry
    from wrsim.inputs.section import Section

FILES = {
    "scenario": ("a scenario", "wrsim.scenario.schema:ScenarioFile"),
    "study": ("a study", "wrsim.study.spec:StudyFile"),
    "service": ("a service", "wrsim.study.service.spec:ServiceFile"),
    "vehicle": ("a vehicle file", "wrsim.vehicle.vehicle_files:VehicleFile"),
    "wheelset": ("a vehicle file of one wheelset", "wrsim.vehicle.vehicle_files:WheelsetFile"),
    "train": ("a train file", "wrsim.vehicle.train_files:TrainFile"),
    "track": ("a track file", "wrsim.scenario.merging:TrackFile"),
    "profile": ("a profile file", "wrsim.geometry.profile.models:AnyProfileFile"),
    "columns": ("the column map of a recording", "wrsim.geometry.recording.columns:ColumnsFile"),
}
"""Kinds of files that users write, and the class of each, or the classes that it may be one of."""
MODELS = {"vehicle": "vehicles", "wheelset": "vehicles", "train": "trains", "track": "tracks", "profile": "wheels"}
"""Folders of the shipped files of a kind."""
WIDTH = 110
ABSENT = {"needed": "has to be given", "none": "may be left out"}
"""Words for what keys without a default have in its place."""


def keys(
    section: Annotated[
        str | None, typer.Argument(metavar="SECTION", help="A table such as contact or track.segments; default: all.")
    ] = None,
    file: Annotated[
        str,
        typer.Option("--file", metavar="KIND", help=f"{', '.join(FILES)}."),
    ] = "scenario",
    schema: Annotated[
        bool, typer.Option("--schema", help="Print the JSON schema of that kind of file, for editors.")
    ] = False,
    as_json: Json = False,
) -> None:
    """List the keys of a table: unit, what is allowed, default, other names, an example."""
    with reporting_errors(as_json):
        from wrsim.inputs.reference import entries, heading, purpose

        if file not in FILES:
            raise InputError(f"--file {file}: must be {', '.join(FILES)}{suggest(file, list(FILES))}")
        if schema:
            say(schema_text(file))
            return
        tables = tables_of(file)
        chosen = tables if section is None else _chosen(section, tables)
        if as_json:
            print_json({kind.header: [vars(entry) for entry in entries(kind)] for kind in chosen})
            return
        for kind in chosen:
            own = entries(kind)
            if section is None:
                say(f"{kind.header}: {', '.join(entry.key for entry in own)}")
                continue
            say("\n".join([heading(kind).strip("`"), *(_indented(line, 2) for line in purpose(kind)), ""]))
            say("\n".join(map(_told, own)) + "\n")


def _told(entry: Entry) -> str:
    """A key and, beneath it, what it is and may be."""
    more = {
        "must be": entry.allowed,
        "default": "" if entry.default in ABSENT else entry.default,
        "example": "" if entry.example == entry.default else entry.example,
        "also understood as": ", ".join(entry.aliases),
    }
    lines = [entry.meaning, ABSENT.get(entry.default, ""), *(f"{head}: {text}" for head, text in more.items() if text)]
    return "\n".join([f"  {entry.key}", *(_indented(line, 6) for line in lines if line)])


def _indented(text: str, by: int) -> str:
    return fill(text, WIDTH, initial_indent=" " * by, subsequent_indent=" " * (by + 2))


def tables_of(file: str) -> list[type[Section]]:
    """All tables of a kind of file, the file itself first."""
    from wrsim.inputs.reference import tables_in

    return list(dict.fromkeys(tables_in(resolved(FILES[file][1]))))


def _chosen(section: str, tables: list[type[Section]]) -> list[type[Section]]:
    """The tables that are meant. Raises InputError."""
    asked = section.strip("[] ")
    found = [kind for kind in tables if {asked, asked.rpartition(".")[2]} & set(_names(kind))]
    if not found:
        names = list(dict.fromkeys(name for kind in tables for name in _names(kind)))
        raise InputError(f"no table is called '{section}'{suggest(asked, names)}; there is {', '.join(names)}")
    return found


def _names(kind: type[Section]) -> list[str]:
    """Names of a table in its header: ``contact.material.wheel`` and ``contact.material.rail``; ``points`` of a file
    of that kind."""
    in_brackets = [part.split("]")[0].strip("[") for part in kind.header.split(" ") if part.startswith("[")]
    return in_brackets or [kind.header, *findall('"([^"]+)"', kind.header)]


def schema_text(file: str) -> str:
    """The JSON schema of a kind of file as it stands in ``docs/schema``."""
    from wrsim.inputs.reference import json_schema

    words, place = FILES[file]
    schema = json_schema(resolved(place), f"wrsim: {words}")
    if file == "scenario":
        _may_inherit(schema)
    if file == "track":  # the table [track] is that of a scenario
        whole = json_schema(resolved(FILES["scenario"][1]), "")
        schema["properties"]["track"] = {"$ref": "#/definitions/TrackSection"}
        schema["definitions"] = whole["definitions"]
        schema["definitions"]["TrackSection"].pop("required", None)
    return json.dumps(schema, indent=1, ensure_ascii=False)


def _may_inherit(schema: dict[str, Any]) -> None:
    """A scenario may start from another one and take its track from a file: then keys stand there."""
    from wrsim.scenario.merging import BASE

    start = "Scenario file to start from; keys of this file override it."
    schema["properties"] = {BASE: {"type": "string", "description": start}} | schema["properties"]
    schema |= {"if": {"not": {"required": [BASE]}}, "then": {"required": schema.pop("required")}}
    for name in schema["properties"]:
        kind = schema["properties"][name].get("$ref", "").rpartition("/")[2]
        schema["definitions"].get(kind, {}).pop("required", None)


def new(
    kind: Annotated[str, typer.Argument(metavar="ANALYSIS", help=f"One of {', '.join(ANALYSES)}.")] = "curving",
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help="Default: <ANALYSIS>.toml here.")
    ] = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Write a scenario to start from: it runs as it is, and names every other key in a comment."""
    with reporting_errors(as_json), writing(force):
        from wrsim.inputs.lookup import shipped_models
        from wrsim.results import write_atomically
        from wrsim.scenario.templates import template

        if kind in FILES and kind != "scenario":
            shipped = f"; copy one of {shipped_models() / MODELS[kind]}" if kind in MODELS else ""
            raise InputError(
                f"{kind}: must be the analysis of a scenario ({', '.join(ANALYSES)}){shipped}; "
                f"the keys of {FILES[kind][0]}: wrsim keys --file {kind}"
            )
        if kind not in ANALYSES:
            raise InputError(f"{kind}: must be {', '.join(ANALYSES)}{suggest(kind, list(ANALYSES))}")
        path = write_atomically(output or Path(f"{kind}.toml"), template(kind).encode())
        if as_json:
            print_json({"files": [str(path)]})
        else:
            say(f"{path}: run it with: wrsim run {path}; wrsim keys SECTION explains its keys")
