"""Values that follow the time or the distance: rows of a table in a TOML file, and the ways in which they are given."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any, TypeVar

from pydantic import Field

from wrsim.inputs.section import Fault
from wrsim.inputs.values import refuse

Rows = TypeVar("Rows", bound=tuple[tuple[float, ...], ...])

ROWS = Field(strict=False, min_length=1, description="a list of rows in rising order, each {each}")
"""Of a table's key; its rows say what each holds."""


def rising(rows: Rows) -> Rows:
    """Rows whose first numbers rise, from 0 on."""
    for position, (before, row) in enumerate(pairwise(rows), 1):
        if row[0] <= before[0]:
            raise refuse(f"row [{position}] must lie behind the row before it: the first numbers rise")
    if rows[0][0] < 0.0:
        raise refuse(f"row [0] begins with {rows[0][0]:g}: must not lie before 0")
    return rows


def one_way(raw: Mapping[str, Any], key: str, what: str, words: str) -> Iterator[Fault]:
    """A value in one of three ways: ``key`` constant, or as a table over the time or the distance.

    what: it is, as "a force"; words: of the constant value.
    """
    tables = f"time_s_{key}", f"distance_m_{key}"
    ways = [way for way in (key, *tables) if way in raw]
    if not ways:
        yield Fault(key, f"must be {words} (or give {' or '.join(tables)}, a table)", missing=True)
    elif len(ways) > 1:
        yield Fault(ways[1], f"cannot stand next to {ways[0]}: {what} follows the time, the distance or neither")
