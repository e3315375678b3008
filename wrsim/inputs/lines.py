"""Which line of a TOML file holds which key, so that a message can point at it."""

from __future__ import annotations

import re
import tomllib
from typing import Any

KeyPath = tuple[str | int, ...]

LONGEST_VALUE = 200
"""Lines of one value (an array over many lines) after which the search for line numbers is given up."""

_HEADER = re.compile(r"\s*\[")
_KEY = re.compile(r"""\s*(?P<key>(?:[A-Za-z0-9_.\-\s]|"[^"\n]*"|'[^'\n]*')+?)\s*=(?P<value>.*)""", re.DOTALL)


def key_lines(text: str) -> dict[KeyPath, int]:
    """Return the line (from 1) of every table header and key of a valid TOML text.

    Keys inside inline tables and arrays are not listed: their line is that of the value which holds them. A
    text that the scan cannot follow gives an empty result, so that no message ever names a wrong line.
    """
    try:
        return _scan(text.splitlines(keepends=True))
    except (tomllib.TOMLDecodeError, ValueError, RecursionError):
        return {}


def line_of(lines: dict[KeyPath, int], path: KeyPath) -> int | None:
    """Return the line of ``path``, or of the nearest table that holds it; None for the top of the file."""
    for end in range(len(path), 0, -1):
        if path[:end] in lines:
            return lines[path[:end]]
    return None


def _scan(source: list[str]) -> dict[KeyPath, int]:
    found: dict[KeyPath, int] = {}
    entries: dict[KeyPath, int] = {}  # number of entries so far of every array of tables
    table: KeyPath = ()
    i = 0
    while i < len(source):
        start, line = i, source[i]
        i += 1
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        if _HEADER.match(line):
            parsed = tomllib.loads(line)
            keys, is_array = _only_keys(parsed)
            table = ()
            for position, key in enumerate(keys):
                table += (key,)
                if is_array and position == len(keys) - 1:
                    entries[table] = entries.get(table, 0) + 1
                    found.setdefault(table, start + 1)
                if table in entries:
                    table += (entries[table] - 1,)
            found.setdefault(table, start + 1)
            continue
        match = _KEY.match(line)
        if match is None:
            raise ValueError("not a key")
        value = match["value"]
        while not _is_value(value):
            if i >= len(source) or i - start > LONGEST_VALUE:
                raise ValueError("value without end")
            value += source[i]
            i += 1
        path = table
        for key in _only_keys(tomllib.loads(match["key"] + " = 0"))[0]:
            path += (key,)
            found.setdefault(path, start + 1)
    return found


def _is_value(text: str) -> bool:
    try:
        tomllib.loads("x =" + text)
    except tomllib.TOMLDecodeError:
        return False
    return True


def _only_keys(tree: Any) -> tuple[list[str], bool]:
    """Keys of a tree with one branch, from the root; True if the branch ends in an array of tables."""
    keys: list[str] = []
    while isinstance(tree, dict) and tree:
        ((key, tree),) = tree.items()
        keys.append(key)
    return keys, isinstance(tree, list)
