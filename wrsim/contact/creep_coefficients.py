"""Kalker's creep coefficients for one Poisson ratio, from the table in `data/`."""

from __future__ import annotations

from functools import lru_cache
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@lru_cache(maxsize=1)
def _kalker_table() -> Array:
    """(20, 3, 3): aspect (a < b from .1 to 1, then a > b from b/a = .1 to 1), Poisson ratio 0, .25, .5, C11 C22 C23."""
    text = files("wrsim.contact").joinpath("data/kalker_1990_table_e3.csv").read_text(encoding="utf-8")
    rows = np.array([[float(x) for x in line.split(",")] for line in text.splitlines() if line and line[0].isdigit()])
    by_aspect = {round(a, 4): rows[np.isclose(rows[:, 0], a)][:, 2:] for a in np.unique(rows[:, 0])}
    wide = [by_aspect[round(g / 10, 4)] for g in range(1, 11)]
    long = [by_aspect[min(by_aspect, key=lambda a, g=g: abs(a - 10.0 / g))] for g in range(1, 11)]  # type: ignore[misc]
    return np.array(wide + long)


def creep_coefficients(poisson_ratio: float) -> Array:
    """C11, C22, C23 as (20, 3) for the kernels: rows a/b = .1 ... 1, then b/a = .1 ... 1.

    1/C is quadratic in the Poisson ratio through the three columns of the table (Kalker's own rule).
    """
    inverse = 1.0 / _kalker_table()
    x = poisson_ratio
    weights = (
        (x - 0.25) * (x - 0.5) / 0.125,
        -x * (x - 0.5) / 0.0625,
        x * (x - 0.25) / 0.125,
    )
    return np.ascontiguousarray(1.0 / sum(w * inverse[:, i] for i, w in enumerate(weights)))
