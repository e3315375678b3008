"""TOML files in and out, with errors for the person who wrote them."""

import json
import os
import re
import stat
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import chain
from pathlib import Path
from typing import Any

from wrsim import system
from wrsim.errors import InputError
from wrsim.inputs.file_kinds import ENDINGS, TERMS

_PLACE = re.compile(r" \(at line (\d+), column (\d+)\)")
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")

DEEPEST = 30
LONGEST_TEXT = 4096  # of a name or a text, as of paths
"""Levels of tables and lists in each other; no file of ours has more than six."""
_LONG_KEY = re.compile(rf"""(?<![\w.-])(?:(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){{{DEEPEST + 1}}}""")
"""Tables in each other by one key; tomllib takes time with the square of their number."""
_LONG_NUMBER = re.compile(r"(?<![\w.])\d(?:_?\d){4300,}")
"""More digits than Python reads."""


LARGEST = 64_000_000
"""Size of the largest file that is read [bytes]; a track of 1000 km has a table of 30 MB."""
_NO_FILES = {
    stat.S_ISFIFO: "a pipe",
    stat.S_ISSOCK: "a socket",
    stat.S_ISCHR: "a device",
    stat.S_ISBLK: "a device",
    stat.S_ISDIR: "a directory",
}


def read_text(path: Path, label: str = "file") -> str:
    """Return the text of a UTF-8 file (a byte order mark is allowed).

    Raises InputError as `read_bytes` does, for zero bytes, and for bytes that are not UTF-8 (naming the line).
    """
    data = read_bytes(path, label)
    if b"\0" in data and data[:2] not in (b"\xff\xfe", b"\xfe\xff"):  # UTF-16 is text
        raise InputError(f"{path}: is no text file; a {label} is needed here")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        byte = f"0x{data[error.start]:02x}"
        raise InputError(f"{path}:{line}: byte {byte} is not UTF-8 text; save the file as UTF-8") from None


def toml_text(path: Path, label: str) -> str:
    """The text of a TOML file; raises InputError as `read_text` does, and for empty files and other kinds."""
    kind = ENDINGS.get(path.suffix.lower()) if os.path.isfile(path) else None
    text = "" if kind else read_text(path, label)
    if not text.strip():
        raise InputError(f"{path}: is {kind or 'empty'}; a {label} is needed here")
    return text


def read_bytes(path: Path, label: str) -> bytes:
    """Return the content of a file; it never waits, and never takes more memory than the largest file allowed.

    Raises InputError, with what the file is, for a missing one (naming neighbours with a similar name), a directory, a
    pipe, a device, one that is too large or cannot be opened, and one out of reach (`reading_within`).
    """
    content = kept.contents.get(str(path)) if (kept := KEPT.get()) else None
    if content is None and (why := out_of_reach(path)):
        raise InputError(f"{path}: {why}")
    try:
        content = _content(path, label) if content is None else content
    except FileNotFoundError:
        raise InputError(f"{path}: no such {label}{similar_files(path)}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{path}: cannot read this {label}: {reason}") from None
    if (read := _READ.get()) is not None:
        read[path] = content
    return content


def _content(path: Path, label: str) -> bytes:
    """The content of a plain file, checked after it is open: it cannot be exchanged in between."""
    if os.path.isdir(path):
        inside = _listing(sorted(p.name for p in path.glob("*.toml")))
        raise InputError(f"{path}: is a directory, a {label} is needed{inside}")
    with open(open_plain(path, label), "rb") as stream:
        status = os.fstat(stream.fileno())
        content = b"" if status.st_size > LARGEST else stream.read(LARGEST + 1)
    if (size := max(status.st_size, len(content))) > LARGEST:
        raise InputError(f"{path}: has {size / 1e6:.1f} MB; a {label} of at most {LARGEST / 1e6:.0f} MB is read")
    return content


def open_plain(path: Path, label: str, flags: int = os.O_RDONLY) -> int:
    """A descriptor of a plain file; it never waits. Raises InputError for a pipe, a device, a directory; OSError."""
    try:
        handle = os.open(path, flags | system.PLAIN, 0o666)
    except PermissionError:
        if not path.is_dir():  # Windows opens none
            raise
        raise InputError(f"{path}: is a directory, a {label} is needed") from None
    if kind := other_kind(os.fstat(handle).st_mode):
        os.close(handle)
        raise InputError(f"{path}: is {kind}, a {label} is needed")
    return handle


def other_kind(mode: int) -> str:
    """The kind of a file that is not plain; empty for a plain one. mode: of ``os.stat``."""
    kinds = (name for is_one, name in _NO_FILES.items() if is_one(mode))
    return "" if stat.S_ISREG(mode) else next(kinds, "no plain file")


_WITHIN: ContextVar[tuple[Path, ...] | None] = ContextVar("_WITHIN", default=None)


@dataclass(frozen=True)
class Kept:
    """Contents of files by their paths, which count in place of files, and the user's folders that these were in."""

    contents: Mapping[str, bytes]
    user_folders: tuple[Path, ...]


KEPT: ContextVar[Kept | None] = ContextVar("KEPT", default=None)


@contextmanager
def reading_within(folders: Sequence[Path], kept: Kept | None = None) -> Iterator[None]:
    """Within this block no file outside of these folders is opened, and those that are kept count."""
    before, without = _WITHIN.set(tuple(folders)), KEPT.set(kept)
    try:
        yield
    finally:
        _WITHIN.reset(before)
        KEPT.reset(without)


def out_of_reach(path: Path) -> str:
    """Why a file must not be opened (`reading_within`): its name, or the file that its links lead to, lies outside."""
    folders = _WITHIN.get()
    if folders is None:
        return ""
    for full in (os.path.abspath, os.path.realpath):  # nothing outside is looked at, not even for links
        if not any(Path(full(path)).is_relative_to(full(folder)) for folder in folders):
            places = ", ".join(os.path.abspath(folder) for folder in folders)
            return f"lies outside of {places}; the scenario of a result reads no other files"
    return ""


_READ: ContextVar[dict[Path, bytes] | None] = ContextVar("_READ", default=None)


@contextmanager
def noting_reads() -> Iterator[dict[Path, bytes]]:
    """Within this block every file that is read is noted with its content."""
    noted: dict[Path, bytes] = {}
    around = _READ.get()
    before = _READ.set(noted)
    try:
        yield noted
    finally:
        _READ.reset(before)
        if around is not None:
            around.update(noted)


def parse_value(text: str) -> Any:
    """The value of a key as written in TOML; a text that is no value, such as a bare word, is taken as text."""
    try:
        table = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return table["value"] if len(table) == 1 else text  # more keys: a line break in the text


def parse_toml(text: str, name: str) -> dict[str, Any]:
    """Return the tables of a TOML text; ``name`` is the file's name for messages.

    Raises InputError with file, line, column, the line itself and, for frequent slips, a hint.
    """
    too_deep = f"{name}: tables or arrays are nested too deeply; at most {DEEPEST} levels are read"
    if _LONG_KEY.search(text):
        raise InputError(too_deep)
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(_syntax_message(str(error), text, name)) from None
    except RecursionError:
        raise InputError(too_deep) from None
    except ValueError as error:
        if digits := _LONG_NUMBER.search(text):
            row, count = text.count("\n", 0, digits.start()) + 1, len(digits[0].replace("_", ""))
            raise InputError(f"{name}:{row}: a whole number of {count} digits; at most 4300 are read") from None
        raise InputError(f"{name}: not valid TOML: {error}") from None
    if is_too_deep(data):
        raise InputError(too_deep)
    text = max(texts_in(data), key=len, default="")
    if len(text) > LONGEST_TEXT:
        raise InputError(f"{name}: {shown_value(text)} has {len(text)} characters; at most {LONGEST_TEXT} are read")
    return data


def texts_in(data: Any, without: str = "") -> Iterator[str]:
    """All texts in a tree of tables and lists, names of keys included; without: a key that is left out."""
    level = [data]
    while level:
        value = level.pop()
        if isinstance(value, str):
            yield value
        elif isinstance(value, dict):
            level += chain.from_iterable(item for item in value.items() if item[0] != without)
        elif isinstance(value, (list, tuple)):
            level += value


def is_too_deep(data: Any) -> bool:
    """True if tables and lists are nested more than `DEEPEST` deep."""
    level = [data]
    for _ in range(DEEPEST):
        inner = (v.values() if isinstance(v, dict) else v for v in level if isinstance(v, (dict, list)))
        level = [*chain.from_iterable(inner)]
    return bool(level)


def similar_files(path: Path) -> str:
    """A hint with files like ``path`` in its folder, or on a missing folder."""
    if not os.path.isdir(path.parent):
        return f" (there is no folder '{path.parent}')"
    for whole in (path.with_suffix(".toml"), path.parent / "scenarios" / f"{path.stem}.toml"):
        if os.path.isfile(whole):
            return f"; did you mean '{whole}'?"
    names = [p.name for p in path.parent.iterdir() if os.path.isfile(p) and not p.name.startswith(".")]
    if near := get_close_matches(path.name, names, n=3):
        return "; did you mean " + " or ".join(f"'{path.parent / n}'" for n in near) + "?"
    return _listing(sorted(n for n in names if n.endswith(path.suffix or ".toml")))


def _listing(names: list[str]) -> str:
    if not names:
        return ""
    return "; there are " + ", ".join(names[:8]) + (", ..." if len(names) > 8 else "")


def _syntax_message(reason: str, text: str, name: str) -> str:
    source = text.splitlines() or [""]
    row, column = len(source), len(source[-1]) + 1
    if place := _PLACE.search(reason):
        row, column = int(place[1]), int(place[2])
    reason = _PLACE.sub("", reason).replace(" (at end of document)", " at the end of the file")
    reason += next((hint for cause, hint in TERMS["syntax"].items() if cause in reason), "")
    message = f"{name}:{row}:{column}: not valid TOML: {reason[:1].lower()}{reason[1:]}"
    if 0 < row <= len(source) and len(source[row - 1]) <= 120:
        line = source[row - 1].expandtabs(1)
        message += f"\n    {line}\n    {' ' * (column - 1)}^"
        value = line.split("=", 1)[1].split("#")[0].strip() if "=" in line else line.strip() if ":" in line else ""
        message += value_hint(value)
    return message


def value_hint(value: str) -> str:
    """A hint on a text that is no value of TOML, on a line of its own; or nothing."""
    hints = (f"\n    {hint}" for pattern, hint in TERMS["hints"].items() if re.fullmatch(pattern, value))
    return next(hints, "").format(value, value.replace(",", "."))


def shown_value(value: Any, longest: int = 60) -> str:
    """A value as in a TOML file, cut to ``longest`` characters."""
    return shortened(_value(value), longest)


def shortened(text: str, longest: int = 100) -> str:
    """A text, cut to ``longest`` characters."""
    return text if len(text) <= longest else text[: longest - 4] + " ..."


def write_toml(data: dict[str, Any]) -> str:
    """Return TOML text that reads back as ``data``."""
    return "\n".join(_table((), data)).strip() + "\n"


def _table(path: tuple[str, ...], data: dict[str, Any]) -> list[str]:
    lines = [f"{_key(k)} = {_value(v)}" for k, v in data.items() if not isinstance(v, dict) and not _is_tables(v)]
    for key, value in data.items():
        inner = (*path, key)
        name = ".".join(_key(k) for k in inner)
        if isinstance(value, dict):
            lines += ["", f"[{name}]", *_table(inner, value)]
        elif _is_tables(value):
            for entry in value:
                lines += ["", f"[[{name}]]", *_table(inner, entry)]
    return lines


def _is_tables(value: Any) -> bool:
    return isinstance(value, (list, tuple)) and len(value) > 0 and all(isinstance(v, dict) for v in value)


def _key(key: str) -> str:
    return key if _BARE_KEY.fullmatch(key) else _string(key)


def _string(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")  # JSON's escapes are TOML's, but for one


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(str(k))} = {_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    if isinstance(value, int) and value.bit_length() > 4096:
        return hex(value)  # Python refuses to print such numbers in decimals
    return str(value)
