"""A track made of a recording, in numbers: its columns, how they were undone, its design."""

from typing import Any

from wrsim.recording.restoring import Restored
from wrsim.results.table import Cell, Column, Table, formatted
from wrsim.track.segments import Arc, Transition

LONGEST_BAND = 500.0  # wavelength from which on a band counts as open [m]

LEFT_OUT = "columns left out: {}; if one of them is of use, name it in a column map (--columns)"


def recording_numbers(restored: Restored) -> dict[str, Any]:
    """Plain numbers, units in the keys."""
    read = restored.recording
    return {
        "from_m": read.start,
        "length_m": read.length,
        "step_m": read.step,
        "guessed": read.guessed,
        "columns": [{"column": c.column, "is": c.description} for c in read.columns.channels],
        "unused": list(read.unused),
        "warnings": [LEFT_OUT.format(", ".join(read.unused))] if read.unused and read.guessed else [],
        "undone": [
            {
                "column": c.column,
                "wavelengths_m": [[low, None if high > LONGEST_BAND else high] for low, high in i.kept().tolist()],
                "largest_factor": i.largest(),
                "noise_factor": i.noise(read.step),
            }
            for c, i in restored.inverses
        ],
        "segments": [
            {k: v for k, v in vars(s).items() if v} | {"kind": type(s).__name__.lower()} for s in restored.segments
        ],
        "notes": list(restored.notes),
    }


def recording_tables(restored: Restored) -> list[Table]:
    """Columns with the waves that come back and the factors with which; the design, segment by segment."""
    read = restored.recording
    by_column = {c.column: i for c, i in restored.inverses}
    rows: list[list[Cell]] = []
    for c in read.columns.channels:
        undone: list[Cell] = ["", "", ""]
        if (inverse := by_column.get(c.column)) is not None:
            ends = [[formatted(end, ".3g") for end in band if end <= LONGEST_BAND] for band in inverse.kept().tolist()]
            bands = [" to ".join(band) if len(band) > 1 else f"from {band[0]}" for band in ends]
            undone = [", ".join(bands) or "none", inverse.largest(), inverse.noise(read.step)]
        rows.append([c.column, c.description, *undone])
    heads = (Column("column"), Column("is"), Column("waves that come back", "m"), Column("largest factor", "", ".2g"))
    title = "columns, recognised by their names" if read.guessed else "columns"
    unused = (f"not used: {', '.join(read.unused)}",) if read.unused and not read.guessed else ()
    columns = Table(title, (*heads, Column("of noise", "", ".2g")), rows, unused)
    start, design = 0.0, []
    for s in restored.segments:
        cells: list[Cell] = ["", "", ""]
        if isinstance(s, Transition):
            cells[0] = s.form
        elif isinstance(s, Arc):
            cells = [f"R {formatted(s.radius, '.1f')}", 1e3 * s.cant, 1e3 * s.gauge_widening or ""]
        design.append([read.start + start, type(s).__name__.lower(), s.length, *cells])
        start += s.length
    heads = (Column("from", "m", ".1f"), Column("design"), Column("length", "m", ".1f"), Column())
    more = (Column("cant", "mm", ".1f"), Column("wider", "mm", ".1f"))
    return [columns, Table("", (*heads, *more), design, tuple(f"note: {note}" for note in restored.notes))]
