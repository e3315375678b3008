"""Summary and table of an analysis of overturning: the speeds at which limits are reached."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from wrsim.results.summary import extent
from wrsim.results.table import Column, Table, formatted, quantity
from wrsim.results.tables import Row, long

UNLOADING = 0.9
"""Unloading of the wheels on one side of a bogie that EN 14067-6 allows in the wind, [mem]."""


def summarise_overturning(dataset: xr.Dataset) -> dict[str, Any]:
    """For every wind the speeds [km/h] at which a wheel reaches the limit of unloading, at which it lifts, above which
    the vehicle overturns, and the wheelset that loses most; None where the highest speed does not reach them. And of
    runs: the highest speed at which the vehicle comes through, the lowest at which it does not, and how it ends."""
    speed, wind = 3.6 * dataset["pose_speed"].values, dataset["wind_speed"].values
    unloading = dataset["wheel_unloading"].max("wheel").values
    limits = []
    for value in np.unique(wind):
        speeds = np.flatnonzero(wind == value)
        largest = unloading[speeds].max(axis=1)
        first = int(np.argmax(unloading[speeds[-1]]))
        limits.append(
            {
                "wind_m_s": float(value),
                "unloaded_kmh": _reaches(speed[speeds], largest, UNLOADING),
                "lifts_kmh": _reaches(speed[speeds], largest, 1.0),
                "overturns_kmh": float(speed[speeds[-1]]) if dataset["overturns"].values[speeds[-1]] else None,
                "first_wheelset": str(dataset["wheelset"].values[first]),
            }
        )
    summary: dict[str, Any] = {"extent": extent(dataset), "limits": limits}
    if "run_stands_m_s" in dataset.attrs:
        falls = 3.6 * float(dataset.attrs["run_falls_m_s"])
        summary["runs"] = {
            "comes_through_kmh": 3.6 * float(dataset.attrs["run_stands_m_s"]),
            "falls_kmh": falls if np.isfinite(falls) else None,
            "how": str(dataset.attrs["run_end"]),
        }
    return summary


def _reaches(speed: np.ndarray, value: np.ndarray, limit: float) -> float | None:
    """Speed at which rising values reach a limit; None where they do not."""
    beyond = np.flatnonzero(value >= limit - ROUND_OFF)
    if not beyond.size:
        return None
    i = int(beyond[0])
    return float(speed[0]) if i == 0 else float(np.interp(limit, value[i - 1 : i + 1], speed[i - 1 : i + 1]))


ROUND_OFF = 1e-9  # of the unloading of a wheel in the air, which is 1


def csv_of_overturning(dataset: xr.Dataset) -> Iterator[tuple[str, list[Row]]]:
    """One row per speed, wind, wheelset and wheel."""
    columns = ("pose", "wheelset", "wheel", "wind_speed", "pose_speed", "wheel_unloading", "overturns")
    whole = np.ones(dataset["wheel_unloading"].shape, dtype=bool)
    yield "overturning", long(dataset, columns, whole, ("pose", "wheelset", "wheel"))


def overturning_tables(dataset: xr.Dataset, summary: dict[str, Any]) -> list[Table]:
    """One line a wind."""
    names = f"ΔQ/Q₀ {UNLOADING:g}", "lifts", "overturns"
    heads = (Column("wind", "m/s", "g"), *(Column(name, "km/h", ".1f") for name in names), Column("first"))
    rows = [tuple("-" if value is None else value for value in limits.values()) for limits in summary["limits"]]
    radius, cant = dataset["pose_radius"].values[0], 1e3 * dataset["pose_cant"].values[0]
    notes = [f"quasi-static, R {quantity(radius, 'm', 'g')}, cant {quantity(cant, 'mm', 'g')}"]
    notes += [str(message) for message in dataset["pose_message"].values if message]
    if runs := summary.get("runs"):
        through = f"runs: comes through at {quantity(runs['comes_through_kmh'], 'km/h', '.1f')}"
        falls = runs["falls_kmh"]
        notes.append(through if falls is None else f"{through}, falls at {formatted(falls, '.1f')} km/h: {runs['how']}")
    return [Table(str(dataset.attrs["title"]), heads, rows, tuple(notes))]
