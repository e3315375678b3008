"""Lists of profiles of CONTACT: sections of a rail along the track (.slcs), of a wheel over its angle (.slcw)."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wrsim.contact.profiles.formats import finite_number, read_lines
from wrsim.contact.profiles.profile import Array
from wrsim.errors import InputError


@dataclass(frozen=True)
class Slices:
    """places (n,): of the sections, in mm along the track or rad; files: of their profiles; lines: of these; features
    (n, m): arclengths that belong together [mm], equal ones about a part that does not exist."""

    places: Array
    files: tuple[Path, ...]
    lines: tuple[int, ...]
    features: Array


def read_slices(path: Path) -> Slices:
    """Read a list of profiles: offset and scale; numbers of slices, features, kinks and accelerations; the method; a
    place and a file a slice; lines of kinks and accelerations; a place and its features a slice. Raises InputError."""
    rows = [(i, fields) for i, text in enumerate(read_lines(path), 1) if (fields := re.split("[%!]", text)[0].split())]

    def numbers(row: int, count: int, what: str) -> list[float]:
        if row >= len(rows) or len(rows[row][1]) < count:
            raise InputError(f"{path}:{rows[min(row, len(rows) - 1)][0] if rows else 1}: {what} expected here")
        return [finite_number(word, str(path), rows[row][0]) for word in rows[row][1][:count]]

    offset, scale = numbers(0, 2, "offset and scale of the places")
    (slices,) = numbers(1, 1, "the number of slices")
    features, kinks, accelerations = (int(x) for x in numbers(2, 3, "numbers of features, kinks, accelerations"))
    count, first = int(slices), 4  # one row for the method
    places = [numbers(first + i, 1, f"the place and file of slice {i + 1} of {count}")[0] for i in range(count)]
    named = rows[first : first + count]
    if not all(len(fields) > 1 for _, fields in named):
        raise InputError(f"{path}:{named[0][0]}: the place of a slice and the file of its profile expected here")
    first += count + int(kinks > 0) + int(accelerations > 0)
    table = np.zeros((count, features))
    for i in range(count if features else 0):
        table[i] = numbers(first + i, features + 1, f"the place and {features} features of slice {i + 1}")[1:]
        known = np.flatnonzero(table[i] >= 0.0)
        table[i] = table[i][known[np.minimum(np.searchsorted(known, np.arange(features)), known.size - 1)]]
    files = tuple(path.parent / fields[1].strip("'\"").replace("\\", "/") for _, fields in named)
    return Slices(scale * (np.array(places) + offset), files, tuple(line for line, _ in named), table)
