"""Kinds of files that users write: the classes that read them, the commands that take them.

Classes are named as ``package.module:name`` and imported when they are used: all rooms read files.
"""

import tomllib
from importlib import import_module
from importlib.resources import files
from typing import Any, NamedTuple


def packaged(room: str, name: str) -> dict[str, Any]:
    """The tables of a TOML file in a package."""
    return tomllib.loads(files(room).joinpath(name).read_text(encoding="utf-8"))


class FileKind(NamedTuple):
    """What a file is, its class or the classes that it may be one of, the command that takes it, if any."""

    label: str
    place: str
    command: str = ""

    @property
    def described(self) -> str:
        """What it is, with the command: "a scenario (wrsim run)"."""
        return f"{self.label} ({self.command})"


_TABLES = packaged("wrsim.inputs", "file_kinds.toml")
FILES = {name: FileKind(**row) for name, row in _TABLES["kinds"].items()}
"""Kinds of files that users write."""
ENDINGS: dict[str, str] = _TABLES["endings"]
"""Files that are not TOML, by the ending of their name, and the commands that take them."""
OTHER_NAMES: dict[str, str] = _TABLES["other_names"]
"""Other names of kinds of files, that are understood."""
TERMS = packaged("wrsim.inputs", "words.toml")
"""Words of other programs and of the field, names of units, hints for messages."""


def resolved(name: str) -> Any:
    """The function or class of a name of the register."""
    module, _, attribute = name.partition(":")
    return getattr(import_module(module), attribute)
