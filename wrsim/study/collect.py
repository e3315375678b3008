"""One dataset of all cases that have come to an end."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.analysis.motion.record import code_digest
from wrsim.errors import InputError
from wrsim.plots.drawing import save_all
from wrsim.plots.study import study_figures
from wrsim.results import write_atomically
from wrsim.results.channels import Kind
from wrsim.results.dataset import faults_of_attributes, faults_of_variable, versions
from wrsim.results.files import STUDY, as_csv, as_json
from wrsim.results.netcdf import read_netcdf, write_netcdf
from wrsim.results.sensitivity import sensitivity_tables
from wrsim.results.table import Column, Table, with_unit
from wrsim.results.tables import Row
from wrsim.study.axes import AxisPoints
from wrsim.study.plan import Plan, value_text
from wrsim.study.sensitivity import sensitivities
from wrsim.study.task import COMPLETED, DERAILED, Marker, read_marker

FORMAT = "wrsim study"
OUTPUTS = (STUDY, "study.csv", "sensitivity.csv", "times.csv", "study.json", "plan.json")
"""Files of a study in its folder."""
MOST_LISTED = 40
"""Cases that are listed where there are many."""
MISSING = "missing"
"""Status of a case without a marker."""


def markers_of(plan: Plan) -> list[Marker]:
    """The marker of every case, of the status ``MISSING`` where there is none."""
    known = {case.name: case for case in plan.cases}
    read = {n: read_marker(plan.folder_of(case)) or Marker(n, case.label, MISSING, "") for n, case in known.items()}
    return [read[case.name] for case in plan.cases]


def collected(plan: Plan, markers: Sequence[Marker]) -> xr.Dataset:
    """All outputs along the axes of the study.

    One dimension an axis, labelled by its values; rows and samples have a coordinate for every key that they vary.
    Outputs are in units for readers; ``status``, ``message`` and ``name`` of every case are texts.
    """
    units: dict[str, str] = {}
    for marker in markers:
        units |= marker.units
    dims = tuple(axis.name for axis in plan.axes)
    variables: dict[str, Any] = {}
    for name, unit in units.items():
        array = np.array([m.numbers.get(name) for m in markers], dtype=float).reshape(plan.shape)  # None: not-a-number
        variable = f"output_{name}" if name in (*dims, "status", "message", "name") else name
        variables[variable] = (dims, array, {"units": unit or "1"})
    texts = {
        "status": [m.status for m in markers],
        "message": [m.message for m in markers],
        "name": [case.name for case in plan.cases],
    }
    for name, column in texts.items():
        variables[name] = (dims, np.array(column, dtype=object).reshape(plan.shape))
    coords: dict[str, Any] = {}
    for axis in plan.axes:
        coords |= _coordinates(axis)
    attributes = {"format": FORMAT, "title": plan.title, "analysis": plan.analysis}
    attributes |= {"study_text": plan.source, "scenario_text": plan.text, "vehicle": plan.vehicle}
    return xr.Dataset(variables, coords, attributes | versions())


def _coordinates(axis: AxisPoints) -> dict[str, Any]:
    """The labels of an axis, and of rows and samples the values of their keys."""
    if not axis.listed:
        return {axis.name: (axis.name, labels_of([row[0] for row in axis.values]), {"key": ", ".join(axis.keys[0])})}
    coordinates: dict[str, Any] = {axis.name: (axis.name, np.array(axis.labels or range(len(axis.values))), {})}
    for column, keys, values in zip(axis.columns, axis.keys, zip(*axis.values, strict=True), strict=True):
        name = column.replace(" ", "_")  # as coordinates of netCDF are called
        coordinates[name] = (axis.name, labels_of(values), {"key": ", ".join(keys)})
    return coordinates


def labels_of(values: Sequence[Any]) -> NDArray[Any]:
    """Numbers as they are, everything else in words."""
    if all(isinstance(v, int | float) and not isinstance(v, bool) for v in values):
        return np.array(values, dtype=float)
    return np.array([value_text(v) for v in values])


def rows_of_cases(plan: Plan, markers: Sequence[Marker]) -> list[Row]:
    """One row a case: name, what is varied, status, message, outputs; the first is the header."""
    units = list(dict.fromkeys(name for m in markers for name in m.units))
    varied = [group[0] for axis in plan.axes for group in axis.keys]
    rows: list[Row] = [["case", *varied, "status", "message", *units]]
    for case, marker in zip(plan.cases, markers, strict=True):
        values = [axis.values[i] for axis, i in zip(plan.axes, case.place, strict=True)]
        cells = [str(v) if isinstance(v, float) else value_text(v) for row in values for v in row]
        cells += [marker.status, marker.message.replace("\n", "; ")]
        cells += ["" if n is None else f"{n:.10g}" for n in map(marker.numbers.get, units)]
        rows.append([case.name, *cells])
    return rows


def times_of_cases(plan: Plan, markers: Sequence[Marker]) -> list[Row]:
    """One row a case: what it took and where; the first is the header."""
    rows: list[Row] = [["case", "host", "process", "began_s", "wall_time_s", "simulation_s", "resumed"]]
    for case, m in zip(plan.cases, markers, strict=True):
        if m.status != MISSING:
            times = (f"{m.began:.3f}", f"{m.wall_time:.4g}", f"{m.simulation:.4g}")
            rows.append([case.name, m.host, str(m.process), *times, "yes" if m.resumed else ""])
    return rows


def write_study(plan: Plan, markers: Sequence[Marker], pictures: bool) -> tuple[dict[str, Any], list[Path]]:
    """Write ``study.nc``, ``study.csv``, ``times.csv``, ``study.json`` and pictures; gives the content of the JSON."""
    folder, dataset = Path(plan.folder), collected(plan, markers)
    report = study_report(plan, markers, dataset)
    if plan.sensitivity is not None:
        done = np.array([marker.status == COMPLETED for marker in markers])
        numbers = {str(n): np.where(done, v.values, np.nan) for n, v in dataset.items() if v.dtype.kind == "f"}
        report["sensitivity"] = sensitivities(plan.sensitivity, numbers)
        dataset.attrs["sensitivity"] = as_json(report["sensitivity"]).decode()
    files = [
        write_netcdf(folder / STUDY, dataset),
        write_atomically(folder / "study.csv", as_csv(rows_of_cases(plan, markers))),
        write_atomically(folder / "times.csv", as_csv(times_of_cases(plan, markers))),
        write_atomically(folder / "study.json", as_json(report)),
    ]
    if rows := report.get("sensitivity", {}).get("indices"):
        cells = [["" if cell is None else str(cell) for cell in row.values()] for row in rows]
        files.append(write_atomically(folder / "sensitivity.csv", as_csv([[*rows[0]], *cells])))
    if pictures:
        files += save_all(study_figures(dataset), folder)
    return report, files


def read_study(path: Path) -> xr.Dataset:
    """The dataset of a study, from its folder or its ``study.nc``. Raises InputError for anything else."""
    return read_numbers(path, STUDY, FORMAT, "study", _faults)


def read_numbers(
    path: Path, name: str, form: str, label: str, faults: Callable[[xr.Dataset], Iterator[str]]
) -> xr.Dataset:
    """The dataset in a file of that name, or in its folder. Raises InputError for another format and for faults."""
    file = path / name if path.is_dir() else path
    dataset = read_netcdf(file, label)
    if dataset.attrs.get("format") != form:
        raise InputError(f"{file}: a wrsim file, but no {label}")
    for fault in faults(dataset):
        raise InputError(f"{file}: is marked as a {label}, but {fault}; run it again")
    return dataset


def _faults(dataset: xr.Dataset) -> Iterator[str]:
    """What is wrong with the dataset of a study; see `collected`."""
    yield from faults_of_attributes(dataset.attrs, ("title",))
    cases = dataset["status"].dims if "status" in dataset else ()
    for text in ("status", "message", "name"):
        yield from faults_of_variable(dataset, text, cases, "text")
    for axis, size in dataset.sizes.items():
        if not size or axis not in cases or axis not in dataset.coords:
            yield f"its axis {axis!s:.40} has no cases or no labels"
    for name, variable in dataset.variables.items():
        dims = variable.dims[:1] if name in dataset.coords else cases
        kind: Kind = "number" if variable.dtype.kind == "f" else "count" if variable.dtype.kind in "iu" else "text"
        yield from faults_of_variable(dataset, str(name), dims, kind)
        if not isinstance(variable.attrs.get("key", ""), str):
            yield f"its {name!s:.40} has a key that is no text"


def study_report(plan: Plan, markers: Sequence[Marker], dataset: xr.Dataset) -> dict[str, Any]:
    """A study in a few numbers: cases, how they ended, range of every output over the completed ones."""
    ranges, completed = {}, dataset["status"].values == COMPLETED
    for name, variable in dataset.data_vars.items():
        values = variable.values[completed]
        if values.dtype.kind == "f" and np.isfinite(values).any():
            low, middle, high = (float(v) for v in np.nanpercentile(values, (0, 50, 100)))
            ranges[str(name)] = {"min": low, "median": middle, "max": high, "unit": variable.attrs["units"]}
    unfinished = [
        {"case": case.name, "label": case.label, "status": m.status, "message": m.message}
        for case, m in zip(plan.cases, markers, strict=True)
        if m.status not in (COMPLETED, DERAILED, MISSING)
    ]
    return {
        "title": plan.title,
        "cases": len(plan.cases),
        "axes": {axis.name: {"keys": [list(g) for g in axis.keys], "points": len(axis.values)} for axis in plan.axes},
        "status": Counter(m.status for m in markers),
        "unfinished": unfinished,
        "outputs": ranges,
    }


def study_tables(report: dict[str, Any]) -> list[Table]:
    """How the cases ended, and the range of every output."""
    counts = ", ".join(f"{count} {status}" for status, count in report["status"].items())
    rows = [
        (with_unit(name, numbers["unit"]), numbers["min"], numbers["median"], numbers["max"])
        for name, numbers in report["outputs"].items()
    ]
    heads = (Column("output"), *(Column(heading, "", ".5g") for heading in ("smallest", "median", "largest")))
    open_cases = tuple(f"{e['label']}: {e['status']}: {e['message']}" for e in report["unfinished"][:MOST_LISTED])
    tables = [Table(report["title"], notes=(counts,))]
    if rows or open_cases:
        tables.append(Table("", heads if rows else (), rows, open_cases))
    return [*tables, *sensitivity_tables(report.get("sensitivity", {}))]


def faults_of(report: dict[str, Any], markers: Sequence[Marker], briefly: bool) -> list[str]:
    """What went wrong: outputs that are lacking, cases without a result; results of other code unless briefly."""
    foreign = sum(m.code not in ("", code_digest()) for m in markers)
    lacking = [lacks for m in markers if (lacks := m.faults + m.absent)]
    faults = []
    if foreign and not briefly:
        faults.append(f"{foreign} cases were computed by other code of wrsim; delete their folders to run them again")
    if lacking:
        faults.append(f"{len(lacking)} cases lack outputs, listed in study.csv: {lacking[0][0]}")
    if failed := len(report["unfinished"]):
        faults.append(f"{failed} of {len(markers)} cases have no result; --retry runs them again")
    return faults
