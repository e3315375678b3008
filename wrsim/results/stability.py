"""Summary and tables of a stability analysis."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from wrsim.results.table import Column, Table, finite, quantity
from wrsim.results.tables import Row, long, wide

MODE = ("frequency", "damping", "growth", "name")
MODES = ("pose_speed", "mode_branch", "mode_frequency", "mode_damping", "mode_growth", "mode_name")


def summarise_stability(dataset: xr.Dataset) -> dict[str, Any]:
    """Critical speeds with their frequency and mode; ``None`` where there are none, and a note with the reason."""
    about = dataset.attrs
    texts = ("critical_mode", "critical_note", "nonlinear_note", "linearised")
    return {
        "speeds": dataset.sizes["pose"],
        "linear_critical_speed_kmh": finite(about.get("critical_speed_m_s"), 3.6),
        "critical_frequency_Hz": finite(about.get("critical_frequency_Hz")),
        "held_speeds": dataset.sizes.get("cycle", 0),
        "nonlinear_critical_speed_kmh": finite(about.get("nonlinear_critical_speed_m_s"), 3.6),
    } | {name: str(about[name]) for name in texts if name in about}


def csv_of_stability(dataset: xr.Dataset) -> Iterator[tuple[str, list[Row]]]:
    """One row per speed and mode; one row per held speed."""
    remarks = [name for name in ("contact_remark",) if name in dataset]
    yield "modes", long(dataset, [*MODES, *remarks], np.isfinite(dataset["mode_growth"].values), ("pose", "mode"))
    if "cycle" in dataset.dims:
        yield "cycles", wide(dataset, "cycle", ("wheelset",))


def stability_tables(dataset: xr.Dataset, summary: dict[str, Any]) -> list[Table]:
    """Critical speeds, the least damped mode at every speed, limit cycles."""
    lines = []
    for kind, note in (("linear", "critical_note"), ("nonlinear", "nonlinear_note")):
        if (speed := summary[f"{kind}_critical_speed_kmh"]) is not None:
            text = f"{kind} critical speed {quantity(speed, 'km/h', '.2f')} ({quantity(speed / 3.6, 'm/s', '.2f')})"
            mode = f", {quantity(summary['critical_frequency_Hz'], 'Hz', '.3f')}: {summary.get('critical_mode', '')}"
            lines.append(text + (mode if kind == "linear" else ""))
        lines += [summary[note]] if note in summary else []
    lines += [summary["linearised"]] if "linearised" in summary else []
    tables = [Table(str(dataset.attrs["title"]), notes=tuple(lines))]
    rows = []
    for pose in np.flatnonzero(np.isfinite(dataset["mode_growth"].values).any(axis=1)):
        least_damped = dataset.isel(pose=int(pose), mode=int(np.nanargmax(dataset["mode_growth"].values[pose])))
        rows.append((3.6 * least_damped["pose_speed"].item(), *(least_damped[f"mode_{name}"].item() for name in MODE)))
    heads = (Column("speed", "km/h"), Column("frequency", "Hz", ".3f"), Column("damping", "", ".3f"))
    tables.append(Table("least damped mode", (*heads, Column("growth", "1/s", ".3f"), Column("mode")), rows))
    if "cycle" not in dataset.dims:
        return tables
    amplitude = 1e3 * dataset["cycle_amplitude"].values.max(axis=1)
    speed, *texts = (dataset[f"cycle_{name}"].values for name in ("speed", "branch", "ending"))
    columns = (3.6 * speed, *texts, amplitude, dataset["cycle_frequency"].values, dataset["cycle_time"].values)
    rows = list(zip(*(column.tolist() for column in columns), strict=True))
    heads = (Column("speed", "km/h", ".5g"), Column("branch"), Column("came to"))
    last = (Column("amplitude", "mm", ".3f"), Column("frequency", "Hz", ".3f"), Column("held", "s", ".1f"))
    return [*tables, Table("held speeds", (*heads, *last), rows)]
