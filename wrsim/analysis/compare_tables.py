"""Contact models side by side in numbers: differences, values of single poses, times."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np

from wrsim.analysis.compare import DIFFERENCES, OF_LOAD, PLAIN, Comparison, spread_of_differences
from wrsim.results import CHANNELS
from wrsim.results.summary_tables import first_lines, happened, remarks
from wrsim.results.table import MISSING, Cell, Column, Table, formatted
from wrsim.results.tables import channel_cells, number_cells, rows_of

SHOWN = ("p0", "area", "approach", "N", "contact_angle", "X", "Y", "T_gamma")
"""Quantities in the table on the screen."""
UNITS = {"relative": (100.0, "percent"), "of the normal force": (100.0, "percent"), "plain": (180.0 / pi, "deg")}
"""Factor and unit of differences, by their kind."""
FEW = 4
"""Poses and wheels of a small comparison, whose values are printed one by one."""


def comparison_report(found: Comparison, scenario: str) -> dict[str, Any]:
    """Everything in numbers: differences in per cent or degrees, times in microseconds and seconds."""
    models = {}
    for model in found.models:
        differences = {}
        for quantity, numbers in spread_of_differences(found, model.name).items():
            factor, unit = UNITS[DIFFERENCES[quantity]]
            differences[f"{quantity}_{unit}"] = {name: factor * value for name, value in numbers.items()}
        dataset = model.result.dataset
        unsolved = int((dataset["pose_message"].values != "").sum()) if "pose_message" in dataset else 0
        models[model.name] = {
            "status": model.result.status,
            "unsolved_poses": unsolved,
            "remarks": happened(model.result.summary()) + remarks(model.result.summary()),
            "evaluation_us": None if model.evaluation_time != model.evaluation_time else 1e6 * model.evaluation_time,
            "run_s": model.run_time,
            "differences": differences,
        }
    kinds = {quantity: kind for quantity, kind in DIFFERENCES.items() if kind != PLAIN}
    return {"scenario": scenario, "reference": found.reference, "relative_to": kinds, "models": models}


def rows_of_samples(found: Comparison) -> list[list[str]]:
    """One row per sample, wheel and model; the first is the header. Differences in per cent or degrees."""

    values = found.values
    sample = "time" if "time" in values.dims else "pose"
    i, j, m = (index.ravel() for index in np.indices([values.sizes[d] for d in (sample, "wheel", "model")]))
    context = [n for n in (sample, "distance", "lateral_shift", "yaw", "load") if n in values.coords]
    columns = [(CHANNELS[n].column, channel_cells(n, values[n].values[i])) for n in context]
    columns += [("wheel", list(values["wheel"].values[j])), ("model", list(values["model"].values[m]))]
    columns += [(CHANNELS[q].column, channel_cells(q, values[q].values[m, i, j])) for q in DIFFERENCES]
    for q, kind in DIFFERENCES.items():
        difference = values[f"{q}_difference"].values[m, i, j]
        columns.append((f"{q}_difference_{UNITS[kind][1]}", number_cells(UNITS[kind][0] * difference)))
    return rows_of(columns)


def comparison_tables(found: Comparison, report: dict[str, Any]) -> list[Table]:
    """The values when they are few, differences and times; a column for every model."""
    values, models = found.values, report["models"]
    sample = "time" if "time" in values.dims else "pose"
    rows: list[list[Cell]] = []
    if values.sizes[sample] * values.sizes["wheel"] <= FEW:
        for i, place in enumerate(values[sample].values):
            for j, wheel in enumerate(values["wheel"].values):
                rows.append([f"{place} {wheel}" if sample == "pose" else str(wheel)])
                for q in SHOWN:
                    numbers = values[q].values[:, i, j] * CHANNELS[q].shown.factor
                    rows.append([CHANNELS[q].column, *map(float, numbers)])
    rows.append(["difference, median / 95 %"])
    for q in SHOWN:
        unit = {PLAIN: "°", OF_LOAD: "% of N"}.get(DIFFERENCES[q], "%")
        key = f"{q}_{UNITS[DIFFERENCES[q]][1]}"
        cells = [_spread(model["differences"].get(key)) for model in models.values()]
        rows.append(
            [f"{q} ({unit})", *("reference" if n == found.reference else c for n, c in zip(models, cells, strict=True))]
        )
    rows += [["time"], ["one contact (µs)", *(model["evaluation_us"] for model in models.values())]]
    rows.append(["all (s)", *(model["run_s"] for model in models.values())])
    notes = []
    for name, model in models.items():
        if model["unsolved_poses"]:
            notes.append(f"{name}: {model['unsolved_poses']} poses without a solution")
        notes += first_lines([f"{name}: {words}" for words in model["remarks"]], "remarks")
    return [Table("", (Column(), *(Column(name, "", ".5g") for name in models)), rows, tuple(notes))]


def _spread(numbers: dict[str, float] | None) -> str:
    """Median and 95 % of differences."""
    if numbers is None:
        return MISSING
    return f"{formatted(numbers['median'], '.2g')} / {formatted(numbers['p95'], '.2g')}"
