"""What the files of users may hold: their kinds, tables of keys for people, schemas for editors."""

import json
from re import findall
from textwrap import fill
from typing import Any

from wrsim.errors import InputError, suggest
from wrsim.inputs.file_kinds import FILES, OTHER_NAMES, resolved
from wrsim.inputs.reference import Entry, entries, heading, json_schema, purpose, tables_in
from wrsim.inputs.section import Section
from wrsim.scenario.merging import BASE

WIDTH = 110
ABSENT = {"needed": "has to be given", "none": "may be left out"}
"""Words for what keys without a default have in its place."""


def kind_of_file(file: str) -> str:
    """The kind of file of a name, or of another name of it. Raises InputError for an unknown one."""
    file = OTHER_NAMES.get(file, file)
    if file not in FILES:
        raise InputError(f"--file {file}: must be {', '.join(FILES)}{suggest(file, list(FILES))}")
    return file


def keys_text(file: str, section: str | None) -> str:
    """Names of the keys of all tables of a kind of file; of one table everything about them. Raises InputError."""
    if section is None:
        return "\n".join(f"{kind.header}: {', '.join(e.key for e in entries(kind))}" for kind in tables_of_file(file))
    parts = []
    for kind, chosen in _chosen(section, tables_of_file(file)).items():
        meant = purpose(kind) if len(chosen) == len(entries(kind)) else []
        parts += [heading(kind).strip("`"), *(_indented(line, 2) for line in meant), "", *map(_entry_text, chosen), ""]
    return "\n".join(parts)


def keys_numbers(file: str, section: str | None) -> dict[str, Any]:
    """The same as plain records by the headers of tables."""
    tables = tables_of_file(file)
    chosen = {kind: entries(kind) for kind in tables} if section is None else _chosen(section, tables)
    return {kind.header: [vars(entry) for entry in rows] for kind, rows in chosen.items()}


def _chosen(section: str, tables: list[type[Section]]) -> dict[type[Section], list[Entry]]:
    """The tables of a name with their keys; of the name of a key, ``contact.friction``, that key. Raises InputError."""
    table, _, key = section.strip("[] ").rpartition(".")
    if not any({key, section} & {*_names(kind)} for kind in tables):
        candidates = {
            k: [e for e in entries(k) if key in (e.key, *e.aliases, *e.us)] for k in tables if table in ("", *_names(k))
        }
        if matching := {kind: keys for kind, keys in candidates.items() if keys}:
            return matching
        if table and candidates:
            known = [e.key for kind in candidates for e in entries(kind)]
            raise InputError(f"{table} has no key '{key}'{suggest(key, known)}; there is {', '.join(known)}")
    return {kind: entries(kind) for kind in chosen_tables(section, tables)}


def _entry_text(entry: Entry) -> str:
    """A key and, beneath it, what it is and may be."""
    more = {
        "must be": entry.allowed,
        "default": "" if entry.default in ABSENT else entry.default,
        "example": "" if entry.example == entry.default else entry.example,
        "in US units": ", ".join(entry.us),
        "also understood as": ", ".join(entry.aliases),
    }
    lines = [entry.meaning, ABSENT.get(entry.default, ""), *(f"{head}: {text}" for head, text in more.items() if text)]
    return "\n".join([f"  {entry.key}", *(_indented(line, 6) for line in lines if line)])


def _indented(text: str, by: int) -> str:
    return fill(text, WIDTH, initial_indent=" " * by, subsequent_indent=" " * (by + 2))


def tables_of_file(file: str) -> list[type[Section]]:
    """All tables of a kind of file, the file itself first."""
    return list(dict.fromkeys(tables_in(resolved(FILES[file].place))))


def chosen_tables(section: str, tables: list[type[Section]]) -> list[type[Section]]:
    """The tables of a name. Raises InputError."""
    wanted = section.strip("[] ")
    matching = [kind for kind in tables if {wanted, wanted.rpartition(".")[2]} & set(_names(kind))]
    if not matching:
        names = list(dict.fromkeys(name for kind in tables for name in _names(kind)))
        raise InputError(f"no table is called '{section}'{suggest(wanted, names)}; there is {', '.join(names)}")
    return matching


def _names(kind: type[Section]) -> list[str]:
    """Names of a table in its header: ``contact.material.wheel`` and ``contact.material.rail``; ``points`` of a file
    of that kind."""
    in_brackets = [part.split("]")[0].strip("[") for part in kind.header.split(" ") if part.startswith("[")]
    return in_brackets or [kind.header, *findall(r'= "?([\w-]+)', kind.header)]


def schema_text(file: str) -> str:
    """The JSON schema of a kind of file, as in ``docs/schema``."""
    kind = FILES[file]
    schema = json_schema(resolved(kind.place), f"wrsim: {kind.label}")
    if file == "scenario":  # keys may come from the base or from a track file
        start = "Scenario file to start from; keys of this file override it."
        schema["properties"] = {BASE: {"type": "string", "description": start}} | schema["properties"]
        schema |= {"if": {"not": {"required": [BASE]}}, "then": {"required": schema.pop("required")}}
        for entry in schema["properties"].values():
            schema["definitions"].get(entry.get("$ref", "").rpartition("/")[2], {}).pop("required", None)
    if file == "track":  # the table [track] is that of a scenario
        whole = json_schema(resolved(FILES["scenario"].place), "")
        schema["properties"]["track"] = {"$ref": "#/definitions/TrackSection"}
        schema["definitions"] = whole["definitions"]
        schema["definitions"]["TrackSection"].pop("required", None)
    return json.dumps(schema, indent=1, ensure_ascii=False)
