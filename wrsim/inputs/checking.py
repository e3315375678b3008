"""All faults of one file in one InputError, a line each: where, what was found, what is allowed."""

import contextlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import TypeAdapter, ValidationError

from wrsim.errors import InputError, nearest
from wrsim.inputs.file_kinds import ENDINGS, FILES, FileKind, resolved
from wrsim.inputs.lines import KeyPath, key_lines, line_of
from wrsim.inputs.section import ABSENT, FAULT, MOST_FAULTS, STRICT, UNKNOWN, Section
from wrsim.inputs.toml_files import parse_toml, shortened, shown_value, toml_text
from wrsim.inputs.values import refusal

S = TypeVar("S", bound=Section)

Locate = Callable[[KeyPath], str]
"""Gives the file and line (``curve.toml:12``) for the path of a key."""


def opened(path: Path, label: str) -> tuple[dict[str, Any], Locate]:
    """Tables of a TOML file, and a function that locates its keys. label: name of such a file. Raises InputError."""
    text = toml_text(path, label)

    def locate(key: KeyPath) -> str:
        line = line_of(key_lines(text), key)
        return f"{path}:{line}" if line else str(path)

    return parse_toml(text, str(path)), locate


def check_section(section: type[S], data: dict[str, Any], locate: Locate) -> S:
    """Return ``data`` as a section, or raise one InputError that lists every fault on a line of its own."""
    try:
        return section.model_validate(data)
    except ValidationError as error:
        refuse_other_kind(section, data, locate)
        unknown = tuple(dotted(e["loc"]) for e in error.errors(include_url=False) if e["type"] == UNKNOWN)
        told = first_faults(_lines(error, locate), locate(()))
        raise InputError(told, unknown if len(unknown) == error.error_count() else ()) from None


def refuse_other_kind(kind: Any, data: dict[str, Any], locate: Locate) -> None:
    """Raise InputError where a file is of another kind than it should be: most keys at its top are those of one, or all
    are, and those that are not of its own kind are no misspelt ones."""
    known, name, foreign = _known(_classes(kind), data), *_likeliest(data)
    strange = data.keys() - known
    meant = [key for each in _classes(kind) for key in each.model_fields]
    wholly = len(foreign) == len(data) and strange and not any(nearest(key, meant) for key in strange)
    wanted = [file.label for file in FILES.values() if {*_classes(kind)} <= {*_classes_of(file)}]
    if wanted and (wholly or (2 * len(known) <= len(data) and len(foreign) > len(known) + 1)):
        raise InputError(f"{locate(())}: is {FILES[name].described}; {wanted[0]} is needed here")


def kind_of(path: Path) -> str:
    """What a file is, with the command that takes it: "a scenario (wrsim run)"; empty where that is not seen."""
    with contextlib.suppress(InputError):
        data, _ = opened(path, "file")
        name, known = _likeliest(data)
        return FILES[name].described if 2 * len(known) > len(data) else ""
    return ENDINGS.get(path.suffix.lower(), "")


def _likeliest(data: dict[str, Any]) -> tuple[str, set[str]]:
    """The kind of file that knows most of the keys at the top of one, and these."""
    known = {name: _known(_classes_of(file), data) for name, file in FILES.items() if file.command}
    return max(known.items(), key=lambda pair: len(pair[1]))


def _known(classes: Sequence[type[Section]], data: dict[str, Any]) -> set[str]:
    return max((data.keys() & {*each.model_fields, *each.foreign} for each in classes), key=len, default=set())


def _classes_of(kind: FileKind) -> list[type[Section]]:
    """The classes of a kind of file; none where what its room needs is not installed."""
    try:
        return _classes(resolved(kind.place))
    except ModuleNotFoundError:
        return []


def _classes(kind: Any) -> list[type[Section]]:
    """The class of a kind of file, or those that it may be one of."""
    return [kind] if isinstance(kind, type) else [each for part in get_args(kind) for each in _classes(part)]


def first_faults(faults: Sequence[str], where: str) -> str:
    """The first of many faults, a line each, and how many more there are; where: the file."""
    more = [f"{where}: and {len(faults) - MOST_FAULTS} more faults"] if len(faults) > MOST_FAULTS else []
    return "\n".join([*faults[:MOST_FAULTS], *more])


def check_value(kind: Any, value: Any, name: str) -> Any:
    """Return a value that is no key of a file, such as that of an option; raise InputError that names it."""
    try:
        return TypeAdapter(kind, config=STRICT).validate_python(value)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        why = fault["msg"] if fault["type"] == FAULT else refusal(kind, [], value)
        raise InputError(f"{name} {shortened(str(value))}: {why}") from None


def fault_line(path: KeyPath, message: str, locate: Locate, value: Any = None) -> str:
    """Return one line on one fault; the value is shown unless it is None, a table or a list of tables."""
    where = dotted(path)
    tables = isinstance(value, dict) or (isinstance(value, list) and any(isinstance(v, dict) for v in value))
    if value is not None and not tables:
        where += f" = {shown_value(value)}"
    return f"{locate(path)}: {where}: {message}" if where else f"{locate(path)}: {message}"


def dotted(path: KeyPath) -> str:
    """Return the path of a key as users write it: ``track.segments[2].radius_m``."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else (f".{part}" if text else str(part))
    return text


def _lines(error: ValidationError, locate: Locate) -> list[str]:
    lines = []
    for fault in error.errors(include_url=False):
        path = fault["loc"]
        if fault["type"] == ABSENT:
            lines.append(f"{locate(path)}: {dotted(path)} is missing: {fault['msg']}")
        else:
            lines.append(fault_line(path, fault["msg"], locate, fault["input"]))
    return sorted(lines, key=_order)


def _order(line: str) -> tuple[str, int]:
    """Sort by file and line, as compilers do; faults without a line come first."""
    name, _, rest = line.partition(".toml:")
    number = rest.split(":", 1)[0]
    return name, int(number) if number.isdigit() else 0
