"""What an optimisation writes: history, report, the files of the best candidate."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import xarray as xr

from wrsim.results import write_atomically
from wrsim.results.files import STUDY, as_csv, as_json
from wrsim.results.netcdf import write_netcdf
from wrsim.study.changed_files import file_names, write_changed
from wrsim.study.optimisation.search import Search
from wrsim.study.plan import value_text

REPORT, HISTORY, PAGE = "optimisation.json", "history.csv", "optimisation.html"
BEST = "best"


def written_names(names: Sequence[str]) -> tuple[str, ...]:
    """Files in the folder of an optimisation with scenarios of these names."""
    return (STUDY, REPORT, HISTORY, PAGE, *file_names(BEST, names))


def write_optimisation(search: Search, dataset: xr.Dataset, report: dict[str, Any], folder: Path) -> list[Path]:
    """Write ``study.nc``, ``history.csv``, ``optimisation.json`` and the files of the best candidate."""
    candidates, best = search.optimisation.candidates, search.best()
    table = dataset.reset_coords().to_dataframe().reset_index()
    cells = [["" if v != v else f"{v:.10g}" if isinstance(v, float) else str(v) for v in row] for row in table.values]
    files = [
        write_netcdf(folder / STUDY, dataset),
        write_atomically(folder / HISTORY, as_csv([list(map(str, table.columns)), *cells])),
        write_atomically(folder / REPORT, as_json(report)),
    ]
    if not best.feasible:
        return files
    changes = candidates.changes(best.candidate.values)
    start = candidates.changes(candidates.values(candidates.start))
    remarks = [f"wrsim optimise {candidates.source.file.name}: candidate {best.number} of {report['evaluations']}"]
    remarks += [f"{key}: {value_text(start[key])} -> {value_text(value)}" for key, value in changes.items()]
    return files + write_changed(folder, BEST, candidates, best.candidate.values, "optimised", remarks)
