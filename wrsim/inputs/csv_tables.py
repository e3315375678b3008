"""Tables in CSV files: a header with the unit in every column's name, then rows of numbers and names."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wrsim.errors import InputError, nearest
from wrsim.inputs.checking import first_faults
from wrsim.inputs.section import MOST_FAULTS
from wrsim.inputs.toml_files import read_text, shown_value
from wrsim.inputs.values import number_limits, repeated, requirement, unpacked

MOST_ROWS = 2_000_000
Row = tuple[int, list[str]]
"""Number of a line, and its cells."""


def read_columns(
    path: Path, columns: Mapping[str, Any], needed: Sequence[str] = (), rows: str = "rows"
) -> tuple[dict[str, NDArray[Any]], NDArray[np.intp]]:
    """Columns of a table by name, each (n,), and the line number of every row.

    columns: those allowed and what they hold, as for the keys of a section: limited numbers, or ``str``; needed: those
    that must be there; rows: how the rows are called in messages. Cells are separated by commas, or by semicolons where
    the header has no comma. Empty lines and lines that begin with # are left out.
    Raises InputError with every fault: file, line, column, value, what is allowed.
    """
    lines = table_lines(path)
    if not lines:
        raise InputError(f"{path}: the table is empty; its first line must name columns: {', '.join(columns)}")
    separator = separator_of(lines[0][1])
    first, header = csv_cells(path, *lines.pop(0), separator)
    _refuse(path, _header_faults(header, f"{path}:{first}", columns, needed))
    if not lines:
        raise InputError(f"{path}: the table has no {rows} below its header")
    if len(lines) > MOST_ROWS:
        raise InputError(f"{path}: {len(lines)} {rows}; allowed: {MOST_ROWS}")
    numbers = np.array([number for number, _ in lines], dtype=np.intp)
    table: list[Sequence[Any]]
    try:  # all rows at once; if that fails row by row, for messages
        values = np.array([line.split(separator) for _, line in lines], dtype=np.float64)
        table = [*values.T]
        if len(table) != len(header) or not all(map(are_allowed, (columns[n] for n in header), values.T)):
            raise ValueError
    except ValueError:
        table = _row_by_row(path, [csv_cells(path, *line, separator) for line in lines], header, columns)
    return {name: np.array(column) for name, column in zip(header, table, strict=True)}, numbers


def check_rising(path: Path, name: str, values: NDArray[Any], lines: NDArray[np.intp]) -> None:
    """Raise InputError, with its line, where a column does not rise from row to row."""
    back = np.flatnonzero(np.diff(values) <= 0.0)
    if back.size:
        i = int(back[0])
        message = f"{name} = {values[i + 1]:g} after {values[i]:g}: must rise from row to row"
        raise InputError(f"{path}:{lines[i + 1]}: {message}")


def table_lines(path: Path) -> list[tuple[int, str]]:
    """The lines of a table with their numbers, but for empty ones and comments."""
    return [(i, line) for i, line in numbered(read_text(path, "table")) if not line.lstrip().startswith("#")]


def numbered(text: str) -> list[tuple[int, str]]:
    """The lines of a text that are not empty, with their numbers; they end in LF, CR or both."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    return [(i, line) for i, line in enumerate(lines, 1) if line.strip()]


def separator_of(header: str) -> str:
    """What separates cells: semicolons where the header has no comma."""
    return ";" if ";" in header and "," not in header else ","


def csv_cells(path: Path, number: int, line: str, separator: str) -> Row:
    """The cells of a line. Raises InputError."""
    try:
        return number, [c.strip() for c in next(csv.reader([line.strip()], delimiter=separator, strict=True))]
    except csv.Error:
        longest = f"at most {csv.field_size_limit()} characters"
        message = f'no line of a CSV table: a cell has {longest}, and quotes (") only around all of it'
        raise InputError(f"{path}:{number}: {message}") from None


def _refuse(path: Path, faults: list[str]) -> None:
    if faults:
        raise InputError(first_faults(faults, str(path)))


def _header_faults(header: list[str], where: str, columns: Mapping[str, Any], needed: Sequence[str]) -> list[str]:
    faults: list[str] = []
    guessed: set[str | None] = set()
    for name in header:
        if name not in columns:
            near = nearest(name, list(columns)) if len(faults) < MOST_FAULTS else None  # more are not listed
            guessed.add(near)
            hint = f"did you mean '{near}'?" if near else f"the columns are {', '.join(columns)}"
            faults.append(f"{where}: column {shown_value(name)}: unknown; {hint}")
    faults += [f"{where}: column {shown_value(name)}: duplicate" for name in sorted(repeated(header))]
    missing = [n for n in needed if n not in header and n not in guessed]
    return faults + [f"{where}: column '{n}' is missing; the columns are {', '.join(columns)}" for n in missing]


def are_allowed(kind: Any, values: NDArray[np.float64]) -> bool:
    """True if all numbers of a column are within its limits."""
    low, high, excluded = number_limits(unpacked(kind).limits)
    above = values > low if excluded else values >= low
    return kind is not str and bool((above & (values <= high) & np.isfinite(values)).all())


def _row_by_row(path: Path, rows: list[Row], header: list[str], columns: Mapping[str, Any]) -> list[Sequence[Any]]:
    faults: list[str] = []
    table: list[list[Any]] = [[] for _ in header]
    for number, cells in rows:
        if len(cells) != len(header):
            faults.append(f"{path}:{number}: has {len(cells)} cells; must have {len(header)} like the header")
            continue
        for name, cell, column in zip(header, cells, table, strict=True):
            value = cell if columns[name] is str else _number(cell)
            if value is None or (columns[name] is not str and not are_allowed(columns[name], np.array(value))):
                comma = "," in cell and _number(cell.replace(",", ".")) is not None
                hint = f"; decimals need a point: {cell.replace(',', '.')}" if comma else ""
                shown = shown_value(cell) if value is None else cell
                faults.append(f"{path}:{number}: {name} = {shown}: must be {requirement(columns[name])}{hint}")
            column.append(value)
    _refuse(path, faults)
    return list(table)


def _number(cell: str) -> float | None:
    try:
        return float(cell)
    except ValueError:
        return None
