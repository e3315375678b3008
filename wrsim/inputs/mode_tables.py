"""Tables of modes of vibration: CSV files with a row for every mode at every place."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from wrsim.errors import InputError
from wrsim.inputs.csv_tables import read_columns
from wrsim.inputs.values import number, positive

Array = NDArray[np.float64]


SLOWEST_MODE = 0.1
"""Lowest frequency f of an elastic mode [Hz]: under its own weight a body sags by some g / (2 pi f)^2, 25 m."""
MOST_MODES = 200
"""Modes of one file. A step costs the square of the number of unknowns: with 200 some ten times that of a coach, 60."""


def of_modes(largest_frequency: float, largest_mass: float) -> dict[str, Any]:
    """Columns of numbers that a mode has once, with their limits [Hz, kg]."""
    return {
        "mode": Annotated[int, number(1, 1000)],
        "frequency_Hz": Annotated[float, number(SLOWEST_MODE, largest_frequency, "Hz")],
        "damping": Annotated[float, number(0, 1, "of critical")],
        "modal_mass_kg": Annotated[float, positive(largest_mass, "kg")],
    }


class ModeTable(NamedTuple):
    """Frequencies [Hz], damping ratios, modal masses [kg] (n,); places (p, .) and shapes there (n, p, .), in units of
    their columns; line of the first row of every mode (n,)."""

    frequencies: Array
    damping: Array
    masses: Array
    places: Array
    shapes: Array
    lines: NDArray[np.intp]


def read_mode_table(
    path: Path, once: dict[str, Any], places: dict[str, Any], shapes: dict[str, Any], needed: Sequence[str]
) -> ModeTable:
    """A table with the columns of ``of_modes`` and these of places and of shapes, of which only some are needed: those
    that are missing are 0.

    Raises InputError where modes have other places than the first one, or several values of what they have once.
    """
    table, lines = read_columns(path, once | places | shapes, [*once, *places, *needed])
    modes, first, count = np.unique(table["mode"], return_index=True, return_counts=True)
    check_number(path, len(modes))
    order = np.argsort(table["mode"], kind="stable")
    uneven = np.flatnonzero(count != count[0])

    def columns(names: Sequence[str]) -> Array:
        """(modes, places, names)."""
        selected = [table.get(name, np.zeros(len(lines)))[order] for name in names]
        return np.stack(selected, axis=-1).reshape(len(modes), int(count[0]), len(names))

    if uneven.size or np.any((points := columns(list(places))) != points[0]):
        line = lines[first[uneven[0]]] if uneven.size else lines[0]
        raise InputError(f"{path}:{line}: every mode needs the same points in the same order")
    numbers = columns(list(once))
    for name, values in zip(once, np.moveaxis(numbers, -1, 0), strict=True):
        several = np.any(values != values[:, :1], axis=1)
        if several.any():
            mode = int(modes[np.argmax(several)])
            raise InputError(f"{path}: column {name}: mode {mode} has several values; must be the same in all its rows")
    _, frequencies, damping, masses = numbers[:, 0].T
    return ModeTable(frequencies, damping, masses, points[0], columns(list(shapes)), lines[first])


def check_number(path: Path, modes: int) -> None:
    """Raise InputError for a file of too many modes."""
    if modes > MOST_MODES:
        raise InputError(f"{path}: has {modes} modes; must be at most {MOST_MODES}: leave out the fastest ones")
