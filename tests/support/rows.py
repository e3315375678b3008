"""Rows of parametrised tests that stand in a TOML file beside the module."""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any


def rows_of(module: str) -> Callable[[str], list[Any]]:
    """Reads lists of the file beside a module by name; a row of several values is a tuple."""
    tables = tomllib.loads(Path(module).with_suffix(".toml").read_text(encoding="utf-8"))
    return lambda name: [tuple(row) if isinstance(row, list) else row for row in tables[name]]
