"""Which line of a TOML file holds which key, so that a message can point at it."""

import re
import tomllib
from functools import lru_cache
from typing import Any

KeyPath = tuple[str | int, ...]

_HEADER = re.compile(r"\s*\[")
_KEY = re.compile(r"""(?:[A-Za-z0-9_.\-\s]|"[^"\n]*"|'[^'\n]*')+=""")
_TOKEN = re.compile(
    r"""\"{3}(?:\\.|[^\\])*?\"{3,5} | '{3}.*?'{3,5} | "(?:\\.|[^"\\])*" | '[^']*' | \#[^\n]* | [\[\]{}\n]""",
    re.DOTALL | re.VERBOSE,
)
"""What decides where a value ends: texts and comments, in which brackets mean nothing, brackets, ends of lines."""


@lru_cache(maxsize=32)
def key_lines(text: str) -> dict[KeyPath, int]:
    """Return the line (from 1) of every table header and key of a valid TOML text.

    Keys inside inline tables and arrays are not listed: their line is that of the value which holds them. A
    text that the scan cannot follow gives an empty result, so that no message ever names a wrong line.
    """
    try:
        return _scan(text)
    except (tomllib.TOMLDecodeError, ValueError, RecursionError):
        return {}


def line_of(lines: dict[KeyPath, int], path: KeyPath) -> int | None:
    """Return the line of ``path``, or of the nearest table that holds it; None for the top of the file."""
    for end in range(len(path), 0, -1):
        if path[:end] in lines:
            return lines[path[:end]]
    return None


def _scan(text: str) -> dict[KeyPath, int]:
    numbers: dict[KeyPath, int] = {}
    entries: dict[KeyPath, int] = {}  # number of entries so far of every array of tables
    table: KeyPath = ()
    start, row = 0, 1
    while start < len(text):
        end = text.find("\n", start) + 1 or len(text)
        line = text[start:end].strip()
        if _HEADER.match(line):
            keys, is_array = _keys_of(line)
            table = ()
            for position, key in enumerate(keys):
                table += (key,)
                if is_array and position == len(keys) - 1:
                    entries[table] = entries.get(table, 0) + 1
                    numbers.setdefault(table, row)
                if table in entries:
                    table += (entries[table] - 1,)
            numbers.setdefault(table, row)
        elif line and not line.startswith("#"):
            match = _KEY.match(text, start, end)
            if match is None:
                raise ValueError("not a key")
            path = table
            for key in _keys_of(match[0] + "0")[0]:
                path += (key,)
                numbers.setdefault(path, row)
            end = _end_of_value(text, match.end())
        row += text.count("\n", start, end)
        start = end
    return numbers


def _end_of_value(text: str, start: int) -> int:
    """Where the line ends on which a value ends that begins at a place of a valid text."""
    depth = 0
    for token in _TOKEN.finditer(text, start):
        depth += (token[0] in "[{") - (token[0] in "]}")
        if token[0] == "\n" and depth == 0:
            return token.end()
    return len(text)


@lru_cache(maxsize=1024)
def _keys_of(line: str) -> tuple[tuple[str, ...], bool]:
    """The keys that a line names, from the root; True for the header of an entry in an array of tables."""
    keys: list[str] = []
    tree: Any = tomllib.loads(line)
    while isinstance(tree, dict) and tree:
        ((key, tree),) = tree.items()
        keys.append(key)
    return tuple(keys), isinstance(tree, list)
