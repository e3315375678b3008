"""Tables of numbers in CSV files: a header with the unit in every column's name, then rows of numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wrsim.errors import InputError
from wrsim.inputs.toml_files import read_text
from wrsim.inputs.values import Quantity, nearest

MOST_ROWS = 2_000_000
MOST_FAULTS = 20


def read_numbers(
    path: Path, columns: Mapping[str, Quantity], needed: Sequence[str] = ()
) -> tuple[dict[str, NDArray[np.float64]], NDArray[np.intp]]:
    """Columns of a table by name, each (n,), and the number of the line every row stands on.

    columns: those allowed and their ranges; needed: those that must be there. Cells are separated by commas, or by
    semicolons where the header has no comma. Empty lines and lines that begin with # are passed over.
    Raises InputError with file, line and column of up to 20 faults at once.
    """
    lines = [
        (number, line.strip())
        for number, line in enumerate(read_text(path, "table").split("\n"), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not lines:
        raise InputError(f"{path}: the table is empty; its first line must name columns: {', '.join(columns)}")
    first, header_line = lines.pop(0)
    separator = ";" if ";" in header_line and "," not in header_line else ","
    header = [cell.strip().strip('"') for cell in header_line.split(separator)]
    faults = _header_faults(header, f"{path}:{first}", columns, needed)
    if faults:
        raise InputError("\n".join(faults))
    if not lines:
        raise InputError(f"{path}: the table has no rows below its header")
    if len(lines) > MOST_ROWS:
        raise InputError(f"{path}: {len(lines)} rows; allowed: {MOST_ROWS}")
    try:
        values = np.array([line.split(separator) for _, line in lines], dtype=np.float64)
        if values.shape[1] != len(header):
            raise ValueError
    except ValueError:
        values = _row_by_row(path, lines, header, separator, columns)
    numbers = np.array([number for number, _ in lines], dtype=np.intp)
    faults = []
    for j, name in enumerate(header):
        allowed, column = columns[name], values[:, j]
        low = allowed.low if allowed.above is None else allowed.above
        good = np.isfinite(column) & (column >= low) & (column <= allowed.high)
        if allowed.above is not None:
            good &= column > low
        for i in np.flatnonzero(~good)[:MOST_FAULTS]:
            faults.append(f"{path}:{numbers[i]}: {name} = {column[i]:g}: must be {allowed.words()}")
    if faults:
        raise InputError("\n".join(faults[:MOST_FAULTS]))
    return {name: np.ascontiguousarray(values[:, j]) for j, name in enumerate(header)}, numbers


def _header_faults(header: list[str], where: str, columns: Mapping[str, Quantity], needed: Sequence[str]) -> list[str]:
    faults = []
    for name in header:
        if name not in columns:
            near = nearest(name, list(columns))
            hint = f"did you mean '{near}'?" if near else f"the columns are {', '.join(columns)}"
            faults.append(f"{where}: column '{name}': unknown; {hint}")
    faults += [f"{where}: column '{n}': stands there twice" for n in sorted({h for h in header if header.count(h) > 1})]
    return faults + [f"{where}: column '{n}' is missing" for n in needed if n not in header and not faults]


def _row_by_row(
    path: Path, lines: list[tuple[int, str]], header: list[str], separator: str, columns: Mapping[str, Quantity]
) -> NDArray[np.float64]:
    """The same slowly, to say what is wrong where."""
    rows, faults = [], []
    for number, line in lines:
        cells = [cell.strip() for cell in line.split(separator)]
        if len(cells) != len(header):
            faults.append(f"{path}:{number}: has {len(cells)} cells; must have {len(header)} like the header")
            continue
        row = []
        for name, cell in zip(header, cells, strict=True):
            try:
                row.append(float(cell))
            except ValueError:
                faults.append(f"{path}:{number}: {name} = '{cell}': must be {columns[name].words()}")
        rows.append(row)
        if len(faults) >= MOST_FAULTS:
            break
    if faults:
        raise InputError("\n".join(faults[:MOST_FAULTS]))
    return np.array(rows, dtype=np.float64)
