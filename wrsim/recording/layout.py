"""The table in a recording's file: letters, separator, decimal sign, header, row of units, rows."""

import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from wrsim.errors import InputError
from wrsim.inputs.csv_tables import csv_cells, numbered
from wrsim.inputs.toml_files import read_bytes
from wrsim.inputs.values import repeated
from wrsim.recording.names import unit_in

EMPTY = re.compile(r"(-+|[*?]+|n\.?/?a\.?n?\.?|null|none|nil|#[a-z]+[/!?]?[a-z0]*[!?]?)?", re.IGNORECASE)
"""Cells without a number: empty, dashes, n/a, NaN, and the errors of spreadsheets, ``#N/A``, ``#DIV/0!``."""
STATION = re.compile(r"[a-z ]*([\d.,]+)\+([\d.,]+)", re.IGNORECASE)
"""Kilometres and metres, ``12+300.00``, or stations of 100 ft."""
COMMENT = re.compile(r"\s*[#%](?![a-z]+[/!?])", re.IGNORECASE)
Lines = list[tuple[int, str]]


class RecordedTable(NamedTuple):
    """header: names of columns; where: file and line of it; units: of columns, from a row of their own; rows: cells;
    lines: their numbers; decimal: sign of decimals; notes: for the user."""

    header: list[str]
    where: str
    units: dict[str, str]
    rows: list[list[str]]
    lines: list[int]
    decimal: str
    notes: list[str]


def read_table(path: Path, known: Callable[[str], bool]) -> RecordedTable:
    """The table of a recording; known: whether a name is that of a column.

    The header is the line above the rows that has most of the known names; letters are read so that it has most.
    Raises InputError for a file without rows, and for rows with more or fewer cells than the header.
    """
    best: tuple[int, str, Lines, str | None, int, list[str], int] | None = None
    for encoding, text in _texts(path):
        lines = numbered(text)
        separator = next((sign for sign in ";\t,|" if 2 * sum(sign in line for _, line in lines) > len(lines)), None)
        top = [_cells(path, line, separator) for line in lines[:200]]
        first = next((i for i, cells in enumerate(top) if _is_row(cells)), len(top))
        for i in range(first - 1, -1, -1) if first else ():
            names = sum(map(known, top[i]))
            if len(top[i]) > 1 and not _is_of_units(top[i]) and (best is None or names > best[0]):
                best = names, encoding, lines, separator, i, top[i], first
    if best is None or len(best[2]) <= best[4] + 1:
        raise InputError(f"{path}: has no rows; its first line must name the columns, rows of numbers follow")
    _, encoding, lines, separator, head, header, first = best
    where = f"{path}:{lines[head][0]}"
    while header and not header[-1]:
        header.pop()
    for name in repeated(header):
        raise InputError(f"{where}: column '{name}': duplicate")
    units: dict[str, str] = {}
    for line in lines[head + 1 : first]:
        if _is_of_units(cells := _cells(path, line, separator)):
            units = {name: unit for name, cell in zip(header, cells, strict=False) if (unit := unit_in(cell))}
    begin = first if units else head + 1
    table = [(line[0], _cells(path, line, separator)) for line in lines[begin:] if not COMMENT.match(line[1])]
    for number, cells in table:
        if len(cells) < len(header) or any(cells[len(header) :]):
            raise InputError(f"{path}:{number}: has {len(cells)} cells; must have {len(header)} like the header")
    notes = [] if encoding in ("utf-8-sig", "utf-16") else [f"letters are read as {encoding}"]
    decimal = "," if separator != "," and any("," in cell for _, cells in table[:50] for cell in cells) else "."
    return RecordedTable(header, where, units, [cells for _, cells in table], [i for i, _ in table], decimal, notes)


def _texts(path: Path) -> Iterator[tuple[str, str]]:
    """The text of a file in every encoding that it may have, the usual first."""
    data = read_bytes(path, "recording")
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        names = ["utf-16"]
    elif b"\0" in data:  # of two bytes a letter, of which Latin ones have one that is 0
        names = ["utf-16-le" if data[1:400:2].count(0) > data[:400:2].count(0) else "utf-16-be"]
        if 4 * data[:400].count(0) < len(data[:400]):
            raise InputError(f"{path}: is no text file; a recording is needed here")
    else:
        names = ["utf-8-sig", "latin-1", "gb18030", "cp932"]
    for name in names:
        try:
            yield name, data.decode(name)
        except UnicodeDecodeError:
            continue
        if name.startswith("utf"):
            return


def _cells(path: Path, line: tuple[int, str], separator: str | None) -> list[str]:
    number, text = line[0], re.sub(r"^\s*[#%]\s*(?=[^\s/])", "", line[1]) if COMMENT.match(line[1]) else line[1]
    if separator is None:
        return re.split(r"\s+(?![\[(/])", text.strip())
    return csv_cells(path, number, text, separator)[1]


def is_number(cell: str) -> bool:
    """Whether a cell holds a number, with a decimal point or comma, or a station."""
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return STATION.fullmatch(cell) is not None
    return True


def _is_row(cells: Sequence[str]) -> bool:
    """Whether most of what these cells hold are numbers."""
    filled = [cell for cell in cells if not EMPTY.fullmatch(cell)]
    return 2 * sum(map(is_number, filled)) > len(filled)


def _is_of_units(cells: Sequence[str]) -> bool:
    """Whether most of these cells are units."""
    filled = [cell for cell in cells if cell and cell != "-"]
    return 2 * sum(unit_in(cell) is not None for cell in filled) > len(filled)
