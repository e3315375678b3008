"""Tables of numbers for people, as analyses give them, and the renderers of tables: terminal, HTML, CSV, JSON.

Nothing in a table is formatted before a renderer does it; no other code formats numbers.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import isfinite
from textwrap import fill
from typing import IO, Any

from markupsafe import Markup

from wrsim.errors import plain
from wrsim.results.channels import Channel
from wrsim.results.units import Conversion, conversion, finer, heading_in, in_text, numbers_in

MISSING = "-"  # in place of a number where there is none
ROUND_OFF = 1e-15  # in every unit of a table: what is smaller is shown as 0


@dataclass(frozen=True)
class ValueAt:
    """A number and where it is, in words: ``78.2 m``, the name of a pose."""

    value: float | None
    place: str


Cell = object
"""A text, a number, a ``ValueAt`` or None."""


@dataclass(frozen=True)
class Column:
    """words: heading; unit: symbol; form: format of its numbers; key: its name in CSV and JSON files, with the unit."""

    label: str = ""
    unit: str = ""
    form: str = ".4g"
    key: str = ""

    @classmethod
    def of(cls, channel: Channel, label: str = "", form: str = ".4g") -> Column:
        """The column of a channel, whose cells are in its unit for readers."""
        return cls(label or channel.long_name, channel.shown.symbol, form, channel.column)

    @property
    def heading(self) -> str:
        """Words with the unit in use: ``Y, largest [kN]``."""
        return heading_in(with_unit(self.label, self.unit))[0]


@dataclass(frozen=True)
class Table:
    """Rows of cells under columns, notes beneath. A row of one cell heads those below it. It may have no columns."""

    title: str
    columns: tuple[Column, ...] = ()
    rows: Sequence[Sequence[Cell]] = ()
    notes: tuple[str, ...] = ()

    def texts(self) -> list[list[str]]:
        """All cells as they are read, in the units in use; a row may have its own in its first cell."""
        rows = []
        for row in self.rows:
            head, unit = heading_in(row[0]) if row and isinstance(row[0], str) else ("", None)
            cells = [
                _shown(cell, column.form, conversion(column.unit) if column.unit else unit)
                for cell, column in zip(row, self.columns, strict=False)
            ]
            rows.append([head, *cells[1:]] if unit else cells)
        return rows

    @property
    def shown_notes(self) -> tuple[str, ...]:
        """Notes in the units in use."""
        return tuple(map(in_text, self.notes))


def _shown(cell: Cell, form: str, unit: Conversion | None) -> str:
    """One cell as it is read, in another unit where there is one."""
    if isinstance(cell, ValueAt):
        value = cell.value if cell.value is None or unit is None else unit.forward(cell.value)
        return in_text(formatted(ValueAt(value, cell.place), finer(form, unit) if unit else form))
    if isinstance(cell, str):
        return in_text(cell) if unit is None else numbers_in(cell, unit)
    if unit is None or isinstance(cell, bool) or not isinstance(cell, int | float):
        return formatted(cell, form)
    return formatted(unit.forward(cell), finer(form, unit))


def finite(value: float | None, factor: float = 1.0) -> float | None:
    """A number in another unit, as JSON knows it: None where it is infinite or not-a-number."""
    return float(value) * factor if value is not None and isfinite(value) else None


SIGNIFICANT_CHANGE = 0.01  # part of a quantity's largest value from which results differ, unless the user names another


def percent(first: float | None, second: float | None, zero: float = 0.0) -> float | None:
    """Change from the first number to the second one in percent of the first; None without one of them, and of a number
    that is no larger than what counts as no difference, zero: it cannot be told from 0."""
    if first is None or second is None or not abs(first) > zero:
        return None
    return finite(100.0 * (second - first) / abs(first))


def with_unit(label: str, unit: str) -> str:
    """Words with the unit in brackets; of a plain number the words alone."""
    return f"{label} [{unit}]" if unit not in ("", "1") else label


def formatted(value: Cell, form: str = ".4g") -> str:
    """One cell as it is read."""
    if isinstance(value, ValueAt):
        return f"{formatted(value.value, form)} at {value.place}" if value.value is not None else MISSING
    if value is None or value != value:
        return MISSING
    return f"{0.0 if abs(value) < ROUND_OFF else value:z{form}}" if isinstance(value, float) else str(value)


def quantity(value: float | None, unit: str = "", form: str = ".4g") -> str:
    """A number with its unit in a sentence: ``43.5 kN``."""
    return f"{formatted(value, form)} {unit}".strip()


def join_names(names: Sequence[str], most: int) -> str:
    """The first names with commas between, and how many more there are."""
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def duration(seconds: float) -> str:
    """A time in words: ``42 s``, ``3.5 min``, ``2.1 h``."""
    if seconds < 90.0:
        return quantity(seconds, "s", ".3g")
    return quantity(seconds / 60.0, "min", ".3g") if seconds < 5400.0 else quantity(seconds / 3600.0, "h", ".3g")


def as_text(tables: Iterable[Table]) -> str:
    """Tables as plain text."""
    stream = io.StringIO()
    on_terminal(tables, stream)
    return stream.getvalue().rstrip("\n")


def on_terminal(tables: Iterable[Table], stream: IO[str] | None = None) -> None:
    """Print tables, on stdout unless a stream is given. Words are flush left, numbers flush right. No cell is ever cut,
    headings are wrapped: where the terminal is narrower, lines are longer than it."""
    from rich.cells import cell_len
    from rich.console import Console
    from rich.table import Table as Grid

    for i, table in enumerate(tables):
        console = Console(file=stream, highlight=False, markup=False)
        if i:
            console.print()
        rows = [[*map(plain, row)] for row in table.texts()]
        heads = [plain(column.heading) for column in table.columns]
        columns = [[*head.split(), *(row[j] for row in rows if len(row) > 1)] for j, head in enumerate(heads)]
        least = [max(map(cell_len, column), default=0) for column in columns]
        whole = [max(letters, cell_len(head)) for letters, head in zip(least, heads, strict=True)]
        if sum(whole) + 2 * len(heads) > console.width:
            whole = least
            console.width = max(console.width, sum(least) + 2 * len(heads))
        if table.title:
            console.print(plain(in_text(table.title)), style="bold", soft_wrap=True)
        grid = Grid(show_header=any(heads), box=None, pad_edge=False)
        for j, (head, letters) in enumerate(zip(heads, whole, strict=True)):
            is_text = all(isinstance(row[j], str) for row in table.rows if len(row) > 1)
            grid.add_column(fill(head, max(letters, 1)), justify="left" if is_text else "right", no_wrap=True)
        for row in rows:
            grid.add_row(*row, style="bold" if len(row) == 1 else None)
        if heads:
            with console.capture() as printed:
                console.print(grid)
            print("\n".join(line.rstrip() for line in printed.get().splitlines()), file=stream)
        for note in table.shown_notes:
            print(plain(note), file=stream)


def as_html(table: Table, look: str = "") -> Markup:
    """A table of a page; every text is escaped. look: its class."""
    heads = Markup("").join(Markup('<th scope="col">{}</th>').format(column.heading) for column in table.columns)
    rows = Markup("\n").join(
        Markup('<tr><th scope="row">{}</th>{}</tr>').format(
            row[0], Markup("").join(Markup("<td>{}</td>").format(cell) for cell in row[1:])
        )
        for row in table.texts()
    )
    head = Markup("<thead><tr>{}</tr></thead>").format(heads) if any(c.heading for c in table.columns) else ""
    caption = Markup("<caption>{}</caption>").format(in_text(table.title)) if table.title else ""
    notes = Markup("").join(Markup('<p class="note">{}</p>').format(note) for note in table.shown_notes)
    return Markup('<table class="{}">{}{}<tbody>\n{}\n</tbody></table>{}').format(look, caption, head, rows, notes)


def as_rows(table: Table) -> list[list[str]]:
    """Rows of a CSV file, the names of the columns first: ten digits, yes or no, empty for not-a-number."""

    def text(value: Any) -> str:
        if value is None:
            return ""
        if isinstance(value, bool):
            return "yes" if value else "no"
        return csv_numbers([value])[0] if isinstance(value, float) else str(value)

    return [[c.key for c in table.columns], *([text(_bare(cell)) for cell in row] for row in table.rows)]


def csv_numbers(values: Iterable[float]) -> list[str]:
    """Cells of numbers in a CSV file: ten digits, empty for not-a-number."""
    return ["" if v != v else f"{v:z.10g}" for v in values]


def as_records(table: Table) -> list[dict[str, Any]]:
    """Rows of a JSON file by the names of the columns: plain numbers and texts, null for not-a-number."""
    keys = [column.key for column in table.columns]
    return [dict(zip(keys, map(_bare, row), strict=True)) for row in table.rows]


def _bare(cell: Any) -> Any:
    """The value of a cell without its place; None for not-a-number."""
    value = cell.value if isinstance(cell, ValueAt) else cell
    return None if value != value else value
