"""Which keys decide on the outputs of a study: rows of indices, as the study stores them, and their tables."""

from collections.abc import Mapping
from typing import Any

import xarray as xr

from wrsim.results.files import from_json
from wrsim.results.table import Column, Table

METHODS = {
    "sobol": {"total": "total index", "first": "first index"},
    "morris": {"mu_star": "μ*", "sigma": "σ"},
    "regression": {"coefficient": "standardised coefficient"},
}
"""What every method finds, the index by which keys are put in order first, and its words."""


def sensitivity_in(dataset: xr.Dataset) -> dict[str, Any]:
    """``method``, ``indices`` (rows of output, key, index, value, low, high) and ``notes`` (by output) of the dataset
    of a study; empty where it has none."""
    return from_json(str(dataset.attrs.get("sensitivity", ""))) or {}


def by_output(table: Mapping[str, Any]) -> dict[str, list[tuple[str, dict[str, Mapping[str, Any]]]]]:
    """Keys of every output, the one that decides most first, with their rows by index."""
    first = next(iter(METHODS[table["method"]]))
    outputs: dict[str, dict[str, dict[str, Mapping[str, Any]]]] = {}
    for row in table["indices"]:
        outputs.setdefault(row["output"], {}).setdefault(row["key"], {})[row["index"]] = row
    return {
        output: sorted(keys.items(), key=lambda pair: -abs(pair[1][first]["value"] or 0.0))
        for output, keys in outputs.items()
    }


def sensitivity_tables(table: Mapping[str, Any]) -> list[Table]:
    """A table an output; table: see `sensitivity_in`."""
    if not table:
        return []
    indices = METHODS[table["method"]]
    heads = [Column("key")]
    for kind in indices.values():
        heads += [Column(kind, "", ".3f"), Column("from", "", ".3f"), Column("to", "", ".3f")]
    made = []
    for output, keys in by_output(table).items():
        rows = [[key, *(row[kind][end] for kind in indices for end in ("value", "low", "high"))] for key, row in keys]
        note = table["notes"].get(output)
        made.append(Table(f"{table['method']}: {output}", tuple(heads), rows, (note,) if note else ()))
    without = [f"{output}: {note}" for output, note in table["notes"].items() if output not in by_output(table)]
    return [*made, *([Table("", notes=tuple(without))] if without else [])]
