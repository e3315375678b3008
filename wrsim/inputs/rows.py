"""Values that follow the time or the distance: rows of a table in a TOML file."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, TypeVar

from pydantic import AfterValidator, Field

from wrsim.inputs.values import refuse

Row = TypeVar("Row")
Rows = TypeVar("Rows", bound=tuple[tuple[float, ...], ...])


def rising(rows: Rows) -> Rows:
    """Rows whose first numbers rise, from 0 on."""
    for position, (before, row) in enumerate(pairwise(rows), 1):
        if row[0] <= before[0]:
            raise refuse(f"row [{position}] must lie behind the row before it: the first numbers rise")
    if rows[0][0] < 0.0:
        raise refuse(f"row [0] begins with {rows[0][0]:g}: must not lie before 0")
    return rows


RisingRows = Annotated[
    tuple[Row, ...],
    Field(strict=False, min_length=1, description="a list of rows in rising order, each {each}"),
    AfterValidator(rising),
]
"""A table of rows whose first numbers rise from 0 on."""
