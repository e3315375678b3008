"""Summary and tables of a conicity analysis."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import xarray as xr

from wrsim.results.rows import Row, wide
from wrsim.results.steering import steering_summary
from wrsim.results.summary import of_contacts as summary_of_contacts
from wrsim.results.tables import of_contacts as tables_of_contacts
from wrsim.results.wheelsets import of_wheelset, wheelsets


def summary(dataset: xr.Dataset) -> dict[str, Any]:
    """That of the poses, and the equivalent conicity of the wheelset."""
    found = summary_of_contacts(dataset)
    for name, own in found["wheelsets"].items():
        own |= conicity_summary(of_wheelset(dataset, name))
    return found


def tables(dataset: xr.Dataset) -> Iterator[tuple[str, Iterable[Row]]]:
    """Those of the poses, and one row per amplitude."""
    yield from tables_of_contacts(dataset)
    for name in wheelsets(dataset):
        yield "conicity", wide(of_wheelset(dataset, name), "amplitude")


def conicity_summary(dataset: xr.Dataset) -> dict[str, Any]:
    """Equivalent conicity at 3 mm (at 5 and 1 mm as well) and where the wheelset swings about.

    nonlinearity_per_mm: (tan gamma_e at 4 mm - tan gamma_e at 2 mm) / 2 mm, Polach's parameter: negative where
    conicity falls with the amplitude, which bodes ill for running behaviour at small ones. ``None`` where one of its
    amplitudes is missing.
    """
    amplitude = 1e3 * dataset["amplitude"].values
    values = dataset["equivalent_conicity"].values

    def at(millimetres: float) -> float | None:
        near = np.flatnonzero(np.abs(amplitude - millimetres) < 1e-6)
        return float(values[near[0]]) if near.size and np.isfinite(values[near[0]]) else None

    two, four = at(2.0), at(4.0)
    return {
        "equivalent_conicity": {f"{mm}_mm": at(float(mm)) for mm in (1, 3, 5)},
        "nonlinearity_per_mm": None if two is None or four is None else 0.5 * (four - two),
        "equilibrium_shift_mm": 1e3 * float(dataset.attrs["equilibrium_shift_m"]),
        **steering_summary(dataset),
    }
