"""Tables and summary of a stability analysis."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from wrsim.results.channels import CHANNELS

OUTCOME = ("critical_mode", "critical_note", "nonlinear_note")
MODES = ("mode_branch", "mode_frequency", "mode_damping", "mode_growth", "mode_name")
CYCLES = ("cycle_speed", "cycle_branch", "cycle_ending", "cycle_frequency", "cycle_time")


def is_stability(dataset: xr.Dataset) -> bool:
    """True for the dataset of a stability analysis."""
    return "mode_growth" in dataset


def stability_summary(dataset: xr.Dataset) -> dict[str, Any]:
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
    return found | {name: str(attributes[name]) for name in OUTCOME if name in attributes}


def mode_table(dataset: xr.Dataset) -> list[list[str]]:
    """One row per speed and mode."""
    columns = [CHANNELS[name] for name in MODES]
    rows = [[CHANNELS["pose_speed"].column, *(c.column for c in columns)]]
    for i, speed in enumerate(dataset["pose_speed"].values):
        for j in np.flatnonzero(np.isfinite(dataset["mode_growth"].values[i])):
            cells = [_cell(dataset[c.name].values[i, j], c.shown.factor) for c in columns]
            rows.append([_cell(speed, CHANNELS["pose_speed"].shown.factor), *cells])
    return rows


def cycle_table(dataset: xr.Dataset) -> list[list[str]]:
    """One row per held speed, the amplitudes of all wheelsets in it."""
    columns = [CHANNELS[name] for name in CYCLES]
    amplitude = CHANNELS["cycle_amplitude"]
    names = [str(w) for w in dataset["wheelset"].values]
    rows = [[*(c.column for c in columns), *(f"amplitude_{n}_{amplitude.shown.suffix}" for n in names)]]
    for i in range(dataset.sizes["cycle"]):
        cells = [_cell(dataset[c.name].values[i], c.shown.factor) for c in columns]
        rows.append([*cells, *(_cell(v, amplitude.shown.factor) for v in dataset["cycle_amplitude"].values[i])])
    return rows


def _cell(value: Any, factor: float) -> str:
    if isinstance(value, str):
        return value
    number = factor * float(value)
    return "" if number != number else f"{number:.10g}"
