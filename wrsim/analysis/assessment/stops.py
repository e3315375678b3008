"""Clearances: how much of its travel a bump stop uses.

The end of a bump stop's table in the vehicle file is where it is solid; nothing is known of forces beyond.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr

from wrsim.analysis.assessment.quantities import QUANTITIES
from wrsim.results.assessment import Limit, Section, Value


def stop_values(dataset: xr.Dataset, sections: Sequence[Section]) -> Iterator[Value]:
    """Largest travel of every bump stop in every section, by the distance of the vehicle's reference body."""
    if "suspension_stop_max" not in dataset:
        return
    distance = dataset["distance"].values
    names = dataset["suspension"].values
    ends = np.column_stack([dataset[f"suspension_stop_{end}"].values for end in ("min", "max")])
    for i in np.flatnonzero(~np.isnan(ends).any(axis=1)):
        # a stop works along one axis; its travel along the others is zero
        travel = np.sum([dataset[f"suspension_d{axis}"].isel(suspension=i).values for axis in "xyz"], axis=0)
        for section in sections:
            inside = (distance >= section.start) & (distance <= section.end)
            if not inside.any():
                continue
            used = [(extreme / end, abs(extreme), abs(end)) for extreme, end in _extremes(travel[inside], ends[i])]
            if used:
                _, value, end = max(used)
                limit = Limit(end, "vehicle file: end of the bump stop's table", "file")
                yield Value(QUANTITIES["bump_stop"], section, "", "", float(value), limit, str(names[i]))


def _extremes(travel: np.ndarray, ends: np.ndarray) -> list[tuple[float, float]]:
    """Extreme travel towards either end that lies on its side of the design position; an end at infinity is none."""
    pairs = ((float(travel.min()), float(ends[0])), (float(travel.max()), float(ends[1])))
    return [
        (min(extreme, 0.0) if end < 0.0 else max(extreme, 0.0), end)
        for extreme, end in pairs
        if end != 0.0 and np.isfinite(end)
    ]
