"""What a file may hold, by its sections: tables of keys for people, and a JSON schema for editors."""

import ast
import inspect
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any, Literal, get_args, get_origin

from pydantic import TypeAdapter, ValidationError
from pydantic_core import PydanticCustomError, PydanticUndefined

from wrsim.inputs.file_kinds import packaged
from wrsim.inputs.section import STRICT, UNITS, Section, unit_of
from wrsim.inputs.toml_files import shown_value
from wrsim.inputs.us_units import us_keys
from wrsim.inputs.values import (
    RANGE,
    entry_of,
    fields,
    is_union,
    number_limits,
    plain_number,
    requirement,
    table_header,
    unpacked,
)


@cache
def meanings(section: type[Section]) -> dict[str, str]:
    """A sentence for every key of a table: the text beneath its field, or the first paragraph on the inner table."""
    texts = {}
    for key, annotation in fields(section).items():
        kind = unpacked(annotation).base
        if isinstance(kind, type) and issubclass(kind, Section):
            texts[key] = purpose(kind)[0].strip()
    for kind in reversed(section.__mro__):
        if issubclass(kind, Section) and kind is not Section:
            texts |= _beneath_fields(kind)
    return {key: texts[key] for key in section.model_fields if key in texts}


def _beneath_fields(kind: type[Section]) -> dict[str, str]:
    """Texts beneath the fields of a class itself; none for a class without source."""
    texts = {}
    for field, beneath in pairwise(_classes(kind.__module__).get(kind.__name__, ())):
        match field, beneath:
            case ast.AnnAssign(target=ast.Name(id=key)), ast.Expr(value=ast.Constant(value=str(text))):
                texts[key] = " ".join(text.split())
    return texts


@cache
def _classes(module: str) -> dict[str, list[ast.stmt]]:
    """Statements of the classes of a module, by name; none for a module without source."""
    try:
        tree = ast.parse(inspect.getsource(sys.modules[module]))
    except (OSError, KeyError):
        return {}
    return {node.name: node.body for node in tree.body if isinstance(node, ast.ClassDef)}


SCHEMA = "http://json-schema.org/draft-07/schema#"
_QUOTED = re.compile(r'"([^"]+)"')
_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?![\w.]*\w)")


@dataclass(frozen=True)
class Entry:
    """One key: its meaning, unit in words, what is allowed, default as in TOML (or "needed"), other names, example, the
    keys in US units that may take its place."""

    table: str
    key: str
    meaning: str
    unit: str
    allowed: str
    default: str
    aliases: tuple[str, ...]
    example: str
    us: tuple[str, ...]


def entries(section: type[Section]) -> list[Entry]:
    """All keys of one table."""
    keys = []
    for key, annotation in fields(section).items():
        if key not in section.model_fields:
            continue  # constants of the class
        default = _default(section, key)
        if default == "[]" and not accepts(annotation, []):
            default = "none"
        aliases = tuple(section.aliases.get(key, ()))
        sample = _examples().get(section.header, {}).get(key) or _examples().get(key)
        example = default if default not in ("needed", "none", "") else example_of(annotation)
        if example and default in ("needed", "none", "") and accepts(annotation, sample):
            example = shown_value(sample)
        unit, meaning = UNITS.get(unit_of(key), ""), meanings(section).get(key, "")
        allowed = requirement(annotation)
        keys.append(Entry(section.header, key, meaning, unit, allowed, default, aliases, example, _us(section, key)))
    return keys


def _us(section: type[Section], key: str) -> tuple[str, ...]:
    """Keys in US units in place of one, but for those of tables of rows and those that a table has itself."""
    annotation = section.model_fields[key].annotation
    rows = entry_of(annotation) is not None and entry_of(entry_of(annotation)) is not None
    return () if rows or table_header(annotation) else tuple(k for k in us_keys(key) if k not in section.model_fields)


@cache
def _examples() -> dict[str, Any]:
    """Figures of the trade for keys without a default, by key, or by table and key (``inputs/examples.toml``)."""
    return packaged("wrsim.inputs", "examples.toml")


def accepts(annotation: Any, value: Any) -> bool:
    """Whether a key takes a value."""
    try:
        TypeAdapter(annotation, config=STRICT).validate_python(value)
    except (ValidationError, PydanticCustomError):
        return False
    return value is not None


def _default(section: type[Section], key: str) -> str:
    """A default as in a file; "needed" or "none" where there is none, empty for tables."""
    field = section.model_fields[key]
    if field.is_required():
        return "needed"
    value = field.get_default(call_default_factory=True)
    if value is None or value is PydanticUndefined:
        return "none"
    return "" if isinstance(value, Section) or (isinstance(value, dict) and not value) else shown_value(value)


def example_of(annotation: Any) -> str:
    """An allowed value, as in TOML; empty for tables."""
    base, limits, description, _ = unpacked(annotation)
    if get_origin(base) is Literal:
        return shown_value(get_args(base)[0])
    if base is bool:
        return "true"
    quoted = _QUOTED.findall(description)
    if base in (int, float) and (limits or not quoted):
        return _number_example(base, limits, description)
    if quoted:
        return shown_value(quoted[0])
    if table_header(annotation):
        return ""
    if is_union(base):
        return next(filter(None, map(example_of, get_args(base))), "")
    each = entry_of(annotation)
    if each is Any:
        return "[40, 60]"
    if each is not None:
        inner = "" if table_header(each) else example_of(each)
        count = len([a for a in get_args(base) if a is not ...])
        return f"[{', '.join([inner] * count)}]" if inner else ""
    if "date" in description:
        return "2026-01-31"
    return '"..."' if base is str else ""


def _number_example(base: type, limits: tuple[Any, ...], description: str) -> str:
    """A number from the description, or one in the middle of what is allowed."""
    low, high, excluded = number_limits(limits)
    for text in _NUMBER.findall(description):
        value = float(text)
        if low <= value <= high and not (excluded and value == low):
            return plain_number(base(value))
    if low > 0.0 and high < float("inf"):
        value = float(f"{(low * high) ** 0.5:.1g}")
    elif low <= 0.0 <= high:
        value = 0.0 if not excluded else min(1.0, high)
    else:
        value = low
    return plain_number(base(max(low, min(high, value))))


def tables_in(annotation: Any, seen: tuple[type, ...] = ()) -> Iterator[type[Section]]:
    """All kinds of tables inside an annotation, from the top down; those that hold themselves once."""
    if isinstance(annotation, type) and issubclass(annotation, Section):
        if annotation in seen:
            return
        yield annotation
        for inner in fields(annotation).values():
            yield from tables_in(inner, (*seen, annotation))
    for part in get_args(annotation):
        yield from tables_in(part, seen)


def heading(section: type[Section]) -> str:
    """How a table is called."""
    return f"`{section.header}`" if "[" in section.header else section.header[0].upper() + section.header[1:]


def purpose(section: type[Section]) -> list[str]:
    """The text of the class, a paragraph a line."""
    text = (section.__doc__ or "").strip()
    return [" ".join(part.split()) + "\n" for part in text.split("\n\n") if part.strip()]


def json_schema(file: Any, title: str) -> dict[str, Any]:
    """JSON schema (draft 7) of a file, for editors: keys, kinds, ranges, defaults, words.

    file: its class, or a union of the classes of which it may be one.

    It has no $id: Taplo refuses a relative one.
    """
    schema = TypeAdapter(file).json_schema(ref_template="#/definitions/{model}")
    definitions = schema.pop("$defs", {})
    classes = {kind.__name__: kind for kind in tables_in(file)}
    schema = _cleaned(schema, classes.get(getattr(file, "__name__", "")))
    tables = {name: _cleaned(value, classes.get(name)) for name, value in sorted(definitions.items())}
    return {"$schema": SCHEMA, **schema, "title": title, "definitions": tables}


def _cleaned(schema: dict[str, Any], section: type[Section] | None) -> dict[str, Any]:
    """One table in terms of TOML: without null; a series is a number, a list or a range."""
    schema = {k: v for k, v in schema.items() if k != "title"}
    if section is not None:
        schema["description"] = "\n\n".join(line.strip() for line in purpose(section))
        for key, property_schema in schema.get("properties", {}).items():
            annotation = fields(section)[key]
            cleaned = _value_schema(property_schema, annotation)
            meaning = meanings(section).get(key, "")
            is_table = bool(table_header(annotation))
            cleaned["description"] = meaning if is_table else f"{meaning} Must be {requirement(annotation)}.".strip()
            if is_table:
                cleaned.pop("default", None)  # it holds null, which TOML does not have
            schema["properties"][key] = cleaned
        for key in [*schema.get("properties", {})]:
            for us in _us(section, key):
                unit = f"`{key}` in {UNITS[unit_of(us)]}."
                kinds = {"type": "number"} if "number" in str(schema["properties"][key].get("type")) else {}
                schema["properties"][us] = kinds | {"description": unit}
                schema["required"] = [k for k in schema.get("required", []) if k != key]
    return _without_titles(schema)


def _value_schema(schema: dict[str, Any], annotation: Any) -> dict[str, Any]:
    """The schema of one value, without null, titles and pydantic's words."""
    schema = {k: v for k, v in schema.items() if k not in ("title", "description")}
    default = {"default": schema.pop("default")} if schema.get("default") is not None else {}
    schema.pop("default", None)
    if "anyOf" in schema:
        retained = [part for part in schema.pop("anyOf") if part.get("type") != "null"]
        schema = retained[0] | schema if len(retained) == 1 else {"anyOf": retained, **schema}
    base, limits, description, _ = unpacked(annotation)
    variants: list[dict[str, Any]] = []
    if schema.get("type") == "array":
        if schema.get("items") and ("list of such" in description or "or a list" in description):  # one alone will do
            variants.append(schema["items"])
        if "from = " in description:
            span = {"type": "object", "properties": {k: {"type": "number"} for k in RANGE}, "required": list(RANGE)}
            variants.append(span | {"additionalProperties": False})
    elif base is float and not limits and _QUOTED.search(description):  # words in place of numbers
        variants.append({"type": "string"})
    return ({"anyOf": [schema, *variants]} if variants else schema) | default


def _without_titles(tree: Any) -> Any:
    """Without titles, patterns and discriminators, which do not help in editors."""
    if isinstance(tree, dict):
        left_out = {"pattern", "discriminator"} | ({"title"} if isinstance(tree.get("title"), str) else set())
        return {key: _without_titles(value) for key, value in tree.items() if key not in left_out}
    return [_without_titles(value) for value in tree] if isinstance(tree, list) else tree
