"""Files to start from: scenarios with every key of an analysis, and copies of shipped files of the other kinds."""

from pathlib import Path
from textwrap import wrap
from typing import Any

from wrsim.errors import InputError, suggest
from wrsim.inputs.file_kinds import packaged
from wrsim.inputs.lookup import shipped_models
from wrsim.inputs.reference import Entry, entries
from wrsim.inputs.section import Section
from wrsim.inputs.toml_files import shown_value
from wrsim.inputs.values import entry_of, fields, table_header, unpacked
from wrsim.register import ANALYSES

_TABLES = packaged("wrsim.scenario", "data/templates.toml")
TEMPLATES: dict[str, dict[str, str]] = _TABLES["copies"]
"""Shipped files that are copied, by kind and name, the usual one first."""
LINE, COLUMN = 120, 40
"""Letters of a line, and where its words begin."""


def template_files(kind: str, name: str | None, path: Path) -> dict[Path, str]:
    """Files to start from and their texts, that of ``path`` first; those beside it begin with its name.

    kind: an analysis or one of `TEMPLATES`; name: which one of these. Raises InputError for unknown ones.
    """
    kinds = [*ANALYSES, *TEMPLATES]
    if kind not in kinds:
        raise InputError(f"{kind}: must be {', '.join(kinds)}{suggest(kind, kinds)}")
    names = list(TEMPLATES.get(kind, {}))
    if name is not None and name not in names:
        hint = f"must be {', '.join(names)}{suggest(name, names)}" if names else "there is one kind of such a scenario"
        raise InputError(f"{kind} {name}: {hint}")
    if kind in ANALYSES:
        return {path: scenario_template(kind)}
    texts = {path: _shipped(TEMPLATES[kind][name or names[0]])}
    for file, source in _TABLES["beside"].get(kind, {}).items():
        beside = path.with_name(f"{path.stem}_{file}")
        texts[path] = texts[path].replace(f'"{file}"', f'"{beside.name}"')
        texts[beside] = scenario_template(source) if source in ANALYSES else _shipped(f"templates/{source}")
    return texts


def _shipped(name: str) -> str:
    return (shipped_models() / name).read_text(encoding="utf-8")


def scenario_template(analysis: str) -> str:
    """The text of a scenario of this kind."""
    from wrsim.scenario.schema import ScenarioFile  # all models of tables, which a wrong name does not need

    start = {"track": {}} | _TABLES["starts"][analysis]
    start["track"] = _TABLES["rails"] | start["track"]
    lines = [
        "# A scenario of wrsim. Lines like # key = value are keys with their defaults: take the # away to change one.",
        "# Keys without a value have no default: give them one when you need them; wrsim keys SECTION has examples.",
        f'title = "My {analysis} scenario"',
        f'analysis = "{analysis}"',
    ]
    kind = ANALYSES[analysis]
    for name, annotation in fields(ScenarioFile).items():
        table = unpacked(annotation).base
        if isinstance(table, type) and issubclass(table, Section) and name not in kind.unused:
            lines += ["", f"[{name}]", *_keys_of(table, start.get(name, {}), name)]
    return "\n".join(lines) + "\n"


def _keys_of(table: type[Section], values: dict[str, Any], name: str) -> list[str]:
    """Lines of one table: keys that are given, others as comments, then lists of tables."""
    lines, after = [], []
    for entry in entries(table):
        annotation = fields(table)[entry.key]
        value = values.get(entry.key)
        if isinstance(value, list) and isinstance(value[0], dict):
            for each in value:
                after += ["", f"[[{name}.{entry.key}]]", *(f"{k} = {shown_value(v)}" for k, v in each.items())]
        elif value is not None:
            lines += _lines(f"{entry.key} = {shown_value(value)}", entry)
        elif entry.default.endswith(" ...") or not entry.default or table_header(entry_of(annotation) or annotation):
            inner = f"wrsim keys {name}" if entry.default.endswith(" ...") else f"wrsim keys {name}.{entry.key}"
            more = entry.allowed if entry.allowed.startswith("a table such") else inner
            lines += wrap(f"# {entry.key}: {entry.meaning} {more}", LINE, subsequent_indent="#     ")
        else:
            default = "" if entry.default in ("needed", "none", "") else f" {entry.default}"
            lines += _lines(f"# {entry.key} ={default}", entry)
    return lines + after


def _lines(start: str, entry: Entry) -> list[str]:
    """A key with what it is behind it, on further lines where there is no room; what may be chosen goes along."""
    meaning = entry.meaning.rstrip(".")
    sentence = f"{meaning}: {entry.allowed}" if entry.allowed.startswith('"') else meaning
    first, *more = wrap(sentence, LINE - COLUMN - 2)
    lines = [f"{start:<{COLUMN}}# {first}"] if len(start) < COLUMN else [start, f"{'#':<{COLUMN}}# {first}"]
    return lines + [f"{'#':<{COLUMN}}# {line}" for line in more]
