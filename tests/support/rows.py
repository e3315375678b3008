"""Rows of parametrised tests: a TOML file beside the module, tables of ``tests/data``."""

import csv
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

DATA = Path(__file__).parents[1] / "data"


def rows_of(module: str) -> Callable[[str], list[Any]]:
    """Reads lists of the file beside a module by name; a row of several values is a tuple."""
    tables = tomllib.loads(Path(module).with_suffix(".toml").read_text(encoding="utf-8"))
    return lambda name: [tuple(row) if isinstance(row, list) else row for row in tables[name]]


def data_rows(name: str) -> list[dict[str, str]]:
    """Rows of a table of ``tests/data``, whose lines with # say its source and licence."""
    with (DATA / name).open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))
