"""Tables of numbers for people, as analyses give them: nothing in here is formatted before a renderer does it.

``wrsim.results.render`` puts them on a terminal, into a page, into CSV and JSON files.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

from wrsim.results.channels import Channel

MISSING = "-"  # in place of a number where there is none


@dataclass(frozen=True)
class Placed:
    """A number and where it is, in words: ``78.2 m``, the name of a pose."""

    value: float | None
    place: str


Cell = object
"""A text, a number, a ``Placed`` or None."""


@dataclass(frozen=True)
class Column:
    """words: heading; unit: symbol; form: format of its numbers; key: its name in CSV and JSON files, with the unit."""

    words: str = ""
    unit: str = ""
    form: str = ".4g"
    key: str = ""

    @classmethod
    def of(cls, channel: Channel, words: str = "", form: str = ".4g") -> Column:
        """The column of a channel, whose cells are in its unit for readers."""
        return cls(words or channel.long_name, channel.shown.symbol, form, channel.column)

    @property
    def heading(self) -> str:
        """Words with the unit: ``Y, largest [kN]``."""
        return with_unit(self.words, self.unit)


@dataclass(frozen=True)
class Table:
    """Rows of cells under columns; notes are beneath, each on a line. A row of one cell heads the rows below it.
    Without columns it is a title with notes."""

    title: str
    columns: tuple[Column, ...] = ()
    rows: Sequence[Sequence[Cell]] = ()
    notes: tuple[str, ...] = ()

    def texts(self) -> list[list[str]]:
        """All cells as they are read."""
        forms = [column.form for column in self.columns]
        return [[formatted(cell, form) for cell, form in zip(row, forms, strict=False)] for row in self.rows]

    def is_text(self, column: int) -> bool:
        """Whether a column holds words and no number."""
        return all(isinstance(row[column], str) for row in self.rows if len(row) > 1)


def finite(value: float | None, factor: float = 1.0) -> float | None:
    """A number in another unit, as JSON knows it: None where it is infinite or not-a-number."""
    return float(value) * factor if value is not None and isfinite(value) else None


def with_unit(words: str, unit: str) -> str:
    """Words with the unit in brackets; of a plain number the words alone."""
    return f"{words} [{unit}]" if unit not in ("", "1") else words


def formatted(value: Cell, form: str = ".4g") -> str:
    """One cell as it is read."""
    if isinstance(value, Placed):
        return f"{formatted(value.value, form)} at {value.place}" if value.value is not None else MISSING
    if value is None or value != value:
        return MISSING
    return f"{value:z{form}}" if isinstance(value, float) else str(value)


def quantity(value: float | None, unit: str = "", form: str = ".4g") -> str:
    """A number with its unit in a sentence: ``43.5 kN``."""
    return f"{formatted(value, form)} {unit}".strip()


def listed(names: Sequence[str], most: int) -> str:
    """The first names with commas between, and how many more there are."""
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def duration(seconds: float) -> str:
    """A time in words: ``42 s``, ``3.5 min``, ``2.1 h``."""
    if seconds < 90.0:
        return quantity(seconds, "s", ".3g")
    return quantity(seconds / 60.0, "min", ".3g") if seconds < 5400.0 else quantity(seconds / 3600.0, "h", ".3g")
