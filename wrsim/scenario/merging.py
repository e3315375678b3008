"""A scenario that starts from another (``base``): the tables merged, and where each key came from."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from wrsim.errors import InputError
from wrsim.inputs.checking import fault_line
from wrsim.inputs.lines import KeyPath, key_lines, line_of
from wrsim.inputs.toml_files import parse_toml, read_text, write_toml

BASE = "base"


@dataclass
class Merged:
    """Tables of a scenario file and of those it starts from, laid over each other.

    files: the file itself first, then its base, the base of that, ...; text: TOML of the whole, the file as
    written when it has no base.
    """

    data: dict[str, Any]
    text: str
    files: tuple[Path, ...]
    owners: dict[KeyPath, str] = field(default_factory=dict)
    lines: dict[str, dict[KeyPath, int]] = field(default_factory=dict)

    def locate(self, path: KeyPath) -> str:
        """Return file and line of a key: the file that set it last, or that has its table."""
        for end in range(len(path), -1, -1):
            if end == 0 or path[:end] in self.owners:
                name = self.owners.get(path[:end], str(self.files[0]) if self.files else "scenario")
                line = line_of(self.lines.get(name, {}), path)
                return name if line is None else f"{name}:{line}"
        raise AssertionError("unreachable")


def read_merged(path: Path) -> Merged:
    """Read a scenario file and, if it has a ``base``, that one beneath it.

    Tables merge key by key; everything else, lists included, is replaced. Raises InputError for files that
    cannot be read and for a base that leads back to itself.
    """
    return _read(path, ())


def from_text(text: str, name: str) -> Merged:
    """Take the text of a scenario that is no file (of a stored result); ``base`` is not allowed there."""
    data = parse_toml(text, name)
    lines = {name: key_lines(text)}
    if BASE in data:
        raise InputError(f"{name}: base: needs a file; this text has to be whole")
    return Merged(data, text, (), owned(data, name), lines)


def overlay(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    """Return ``below`` with the keys of ``above``: tables merge, everything else is replaced."""
    merged = dict(below)
    for key, value in above.items():
        if isinstance(value, dict) and isinstance(merged.get(key), dict):
            merged[key] = overlay(merged[key], value)
        else:
            merged[key] = value
    return merged


def _read(path: Path, children: tuple[Path, ...]) -> Merged:
    text = read_text(path, "scenario file")
    name = str(path)
    data = parse_toml(text, name)
    lines = {name: key_lines(text)}
    if BASE not in data:
        return Merged(data, text, (path,), owned(data, name), lines)
    base = data.pop(BASE)
    top = Merged(data, text, (path,), owned(data, name), lines)
    if not isinstance(base, str) or not base.strip() or "\0" in base:
        message = 'must be the name of a scenario file in quotes, such as "curve.toml"'
        raise InputError(fault_line((BASE,), message, top.locate, base))
    below_path = path.parent / base
    family = (*children, path)
    for relative in family:
        if _same(relative, below_path):
            chain = " -> ".join(str(p) for p in (*family, below_path))
            message = f"scenarios start from each other: {chain}"
            raise InputError(fault_line((BASE,), message, top.locate, base))
    try:
        below = _read(below_path, family)
    except InputError as error:
        if os.path.isfile(below_path):
            raise
        raise InputError(fault_line((BASE,), str(error), top.locate, base)) from None
    return laid_over(below, top)


def laid_over(below: Merged, top: Merged) -> Merged:
    """Two trees of tables, ``top`` over ``below``, with the owner of every key; the files of ``top`` come first."""
    replaced = {own for own in top.owners if own and not isinstance(_at(top.data, own), dict)}
    kept = {
        path: owner
        for path, owner in below.owners.items()
        if not any(path[:end] in replaced for end in range(1, len(path)))
    }
    merged = overlay(below.data, top.data)
    return Merged(
        merged, write_toml(merged), (*top.files, *below.files), {**kept, **top.owners}, {**below.lines, **top.lines}
    )


def _same(a: Path, b: Path) -> bool:
    try:
        return a.resolve() == b.resolve()
    except (OSError, RuntimeError, ValueError):
        return False


def owned(data: Any, name: str, path: KeyPath = ()) -> dict[KeyPath, str]:
    """Every key of a tree, all with the same owner; plain lists count as one."""
    owners: dict[KeyPath, str] = {}
    if isinstance(data, dict):
        items: list[tuple[str | int, Any]] = list(data.items())
    elif isinstance(data, list) and any(isinstance(entry, dict) for entry in data):
        items = list(enumerate(data))
    else:
        items = []
    for key, value in items:
        owners[(*path, key)] = name
        owners.update(owned(value, name, (*path, key)))
    return owners


def _at(data: Any, path: KeyPath) -> Any:
    for part in path:
        data = data[part]
    return data
