"""The reports of a study, one page about all its cases, and of wheels that wear in service."""

from __future__ import annotations

import shlex
from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim import __version__
from wrsim.plots.study import COMPLETED, DERAILED, MOST_OUTPUTS, label_of, numbers_in, of_cases, study_figures
from wrsim.plots.wear import service_figures
from wrsim.report.page import as_picture, template
from wrsim.report.tables import BAD, OPEN, Verdict
from wrsim.results.table import Column, Table, formatted, quantity

MOST_ROWS, FEW_ROWS = 500, 40
"""Cases in a table of the page; up to so many, the table is open."""


def study_page(dataset: xr.Dataset, source: str) -> str:
    """The report of a study as HTML. dataset: ``study.nc``; source: where it was read from."""
    outputs = numbers_in(dataset)
    status = of_cases(dataset, "status").astype(str)
    rows = np.flatnonzero(status != COMPLETED)
    page = {
        "title": dataset.attrs["title"],
        "version": __version__,
        "verdict": _verdict(status),
        "identity": _identity(dataset, source),
        "outputs": _outputs(dataset, outputs),
        "pictures": [as_picture(name, make()) for name, make in study_figures(dataset).items()],
        "without": _without(dataset, rows[:MOST_ROWS]),
        "without_more": _more(len(rows)),
        "cases": _cases(dataset, outputs[:MOST_OUTPUTS]),
        "cases_more": "; ".join(filter(None, (_folders(source), _left_out(outputs), _more(status.size)))),
        "few": status.size <= FEW_ROWS,
        "command": f"wrsim study study.toml -o {shlex.quote(source.rstrip('/').rsplit('/', 1)[-1] or 'study')}",
        "study_text": dataset.attrs.get("study_text", ""),
        "scenario_text": dataset.attrs.get("scenario_text", ""),
    }
    return template("study.html").render(page)


def _verdict(status: NDArray[np.str_]) -> Verdict:
    """How the cases ended."""
    counts = _counts(status)
    words = f"{status.size} cases: {', '.join(f'{n} {name}' for name, n in counts.items())}."
    return Verdict(OPEN if set(counts) <= {COMPLETED, DERAILED} else BAD, words)


def _counts(status: NDArray[np.str_]) -> dict[str, int]:
    names, counts = np.unique(status, return_counts=True)
    found = {str(n): int(c) for n, c in zip(names, counts, strict=True)}
    return dict(sorted(found.items(), key=lambda pair: (pair[0] != COMPLETED, -pair[1])))


def _identity(dataset: xr.Dataset, source: str) -> list[tuple[str, str]]:
    rows = [("title", dataset.attrs["title"]), ("file", source), ("analysis", dataset.attrs.get("analysis", ""))]
    for name in varied(dataset):
        values = np.unique(dataset[name].values)
        ends = (_text(values[0]), _text(values[-1]))
        span = ", ".join(map(_text, values)) if values.size <= 8 else f"{values.size} values, {' to '.join(ends)}"
        rows.append((f"varied: {dataset[name].attrs['key']}", span))
    rows.append(("cases", str(dataset["status"].size)))
    versions = sorted(k for k in dataset.attrs if k.endswith("_version"))
    return rows + [(k.removesuffix("_version"), str(dataset.attrs[k])) for k in versions]


def varied(dataset: xr.Dataset) -> list[str]:
    """Names of the coordinates that hold what is varied."""
    return [str(name) for name, c in dataset.coords.items() if "key" in c.attrs]


def _labels(dataset: xr.Dataset) -> list[str]:
    """What is varied in every case, in words."""
    names = varied(dataset)
    columns = [of_cases(dataset, name) for name in names]
    return [", ".join(f"{n} {_text(v)}" for n, v in zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


def _outputs(dataset: xr.Dataset, outputs: Sequence[str]) -> Table | None:
    """Range and median of every output, with the cases of the ends."""
    done = of_cases(dataset, "status") == COMPLETED
    labels, rows = _labels(dataset), []
    for name in outputs:
        values = np.where(done, of_cases(dataset, name).astype(float), np.nan)
        low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
        ends = (_text(values[low]), labels[low], _text(values[high]), labels[high])
        rows.append((_words(dataset, name), *ends[:2], _text(np.nanmedian(values)), *ends[2:]))
    heads = ("output", "smallest", "in the case", "median", "largest", "in the case")
    return Table("", tuple(map(Column, heads)), rows) if rows else None


def _without(dataset: xr.Dataset, rows: NDArray[np.intp]) -> Table | None:
    """Cases that were not completed, with why."""
    labels, status, words = _labels(dataset), of_cases(dataset, "status"), of_cases(dataset, "message")
    heads = ("case", "status", "message")
    return (
        Table("", tuple(map(Column, heads)), [(labels[i], str(status[i]), str(words[i])) for i in rows])
        if len(rows)
        else None
    )


def _cases(dataset: xr.Dataset, outputs: Sequence[str]) -> Table:
    """One row a case: its name, what is varied, status, outputs."""
    columns = [of_cases(dataset, name)[:MOST_ROWS] for name in ("name", *varied(dataset), "status", *outputs)]
    heads = ("case", *(dataset[n].attrs["key"] for n in varied(dataset)), "status")
    rows = tuple((str(row[0])[:12], *map(_text, row[1:])) for row in zip(*columns, strict=True))
    return Table("", tuple(map(Column, (*heads, *(_words(dataset, name) for name in outputs)))), rows)


def _folders(source: str) -> str:
    return f"Case abcd… lies in {source.rstrip('/').removesuffix('/study.nc')}/cases/ab/abcd…; study.csv has full names"


def _left_out(outputs: Sequence[str]) -> str:
    return f"{MOST_OUTPUTS} of {len(outputs)} outputs; study.csv has all" if len(outputs) > MOST_OUTPUTS else ""


def _more(count: int) -> str:
    return f"{MOST_ROWS} of {count} cases; study.csv has all" if count > MOST_ROWS else ""


def _words(dataset: xr.Dataset, name: str) -> str:
    return label_of(dataset, name).replace("\n", " ")


def _text(value: object) -> str:
    if isinstance(value, float | np.floating):
        return formatted(float(value), ".6g")
    return str(value)


OF_SERVICE = {"service_text": "Service file", "cases_text": "Table of cases", "scenario_text": "Scenario"}
"""Files that a service holds, and words for them."""


def service_page(dataset: xr.Dataset, source: str, numbers: Table) -> str:
    """The report of a service as HTML.

    dataset: ``wear.nc``; source: where it was read from; numbers: of it against the mileage.
    """
    about = dataset.attrs
    steps = dataset.sizes["point"] - 1
    mileage = quantity(1e-3 * float(dataset["mileage"].values[-1]), "km", ".6g")
    deepest = quantity(1e3 * float(dataset["deepest"].values[-1]), "mm", ".3g")
    identity = [(key, str(about[key])) for key in ("title", "law", "wheel") if key in about]
    identity += [("file", source), ("steps of wear", str(steps)), ("mileage", mileage)]
    versions = sorted(key for key in about if key.endswith("_version"))
    page = {
        "title": about["title"],
        "version": __version__,
        "verdict": f"{mileage} in {steps} steps; {deepest} worn off at the deepest place.",
        "identity": identity + [(key.removesuffix("_version"), str(about[key])) for key in versions],
        "numbers": numbers,
        "pictures": [as_picture(name, make()) for name, make in service_figures(dataset).items()],
        "command": f"wrsim wear service.toml -o {shlex.quote(source.rstrip('/').rsplit('/', 1)[-1] or 'service')}",
        "texts": {words: str(about[key]) for key, words in OF_SERVICE.items() if about.get(key)},
    }
    return template("service.html").render(page)
