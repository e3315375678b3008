"""What an optimisation writes: history, report, the files of the best candidate."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import xarray as xr

from wrsim.results import write_atomically
from wrsim.results.files import STUDY, as_csv, as_json
from wrsim.results.netcdf import write_netcdf
from wrsim.study.candidates import ONLY
from wrsim.study.changed_files import changed_in, write_scenario, write_vehicle, write_wheel
from wrsim.study.optimisation.search import Search
from wrsim.study.plan import in_words

REPORT, HISTORY, PAGE = "optimisation.json", "history.csv", "optimisation.html"
BEST, VEHICLE, WHEEL = "best", "best_vehicle.toml", "best_wheel.toml"


def written_names(names: Sequence[str]) -> tuple[str, ...]:
    """Files in the folder of an optimisation with scenarios of these names."""
    return (STUDY, REPORT, HISTORY, PAGE, VEHICLE, WHEEL, *map(_best_file, names))


def _best_file(name: str) -> str:
    return f"{BEST}.toml" if name == ONLY else f"{BEST}_{name}.toml"


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
    remarks = [f"wrsim optimise {candidates.given.file.name}: candidate {best.number} of {report['evaluations']}"]
    remarks += [f"{key}: {in_words(start[key])} -> {in_words(value)}" for key, value in changes.items()]
    for scenario in candidates.scenarios:
        title = f"{scenario.base.title}, optimised"
        files.append(write_scenario(folder / _best_file(scenario.name), scenario.base, changes, title, remarks))
    first = candidates.scenarios[0].base.with_values(changes)
    if changed_in(changes, "changes"):
        files.append(write_vehicle(folder / VEHICLE, first, remarks))
    if changed_in(changes, "wheel_changes"):
        files.append(write_wheel(folder / WHEEL, first, remarks))
    return files
