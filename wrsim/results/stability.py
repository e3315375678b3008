"""Summary and tables of a stability analysis."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from wrsim.results.rows import Row, long, wide

MODES = ("pose_speed", "mode_branch", "mode_frequency", "mode_damping", "mode_growth", "mode_name")


def summary(dataset: xr.Dataset) -> dict[str, Any]:
    """Critical speeds with their frequency and mode; ``None`` where there are none, and a note that says why."""
    attributes = dataset.attrs

    def number(name: str, factor: float = 1.0) -> float | None:
        value = float(attributes.get(name, np.nan))
        return factor * value if np.isfinite(value) else None

    found: dict[str, Any] = {
        "speeds": dataset.sizes["pose"],
        "linear_critical_speed_kmh": number("critical_speed_m_s", 3.6),
        "critical_frequency_Hz": number("critical_frequency_Hz"),
        "held_speeds": dataset.sizes.get("cycle", 0),
        "nonlinear_critical_speed_kmh": number("nonlinear_critical_speed_m_s", 3.6),
    }
    words = ("critical_mode", "critical_note", "nonlinear_note")
    return found | {name: str(attributes[name]) for name in words if name in attributes}


def tables(dataset: xr.Dataset) -> Iterator[tuple[str, list[Row]]]:
    """One row per speed and mode; one row per held speed."""
    said = [name for name in ("contact_remark",) if name in dataset]
    yield "modes", long(dataset, [*MODES, *said], np.isfinite(dataset["mode_growth"].values), ("pose", "mode"))
    if "cycle" in dataset.dims:
        yield "cycles", wide(dataset, "cycle", ("wheelset",))
