"""The reports of a study, one page about all its cases, and of a profile evolution."""

from collections import Counter
from collections.abc import Sequence

import numpy as np
import xarray as xr

from wrsim import __version__
from wrsim.plots.drawing import Makers
from wrsim.plots.study import COMPLETED, DERAILED, MOST_OUTPUTS, label_of, numbers_in, of_cases, study_figures
from wrsim.plots.wear import LAW_LABELS, evolution_figures
from wrsim.report.document import ASKED, NO_COVER, Cover, contact_sentence, vehicle_name
from wrsim.report.page import as_picture, last_part, page_template
from wrsim.report.tables import BAD, OPEN, ReportVerdict
from wrsim.results.sensitivity import sensitivity_in, sensitivity_tables
from wrsim.results.table import Column, Table, formatted, join_names, quantity
from wrsim.system import quoted

MOST_TOLD = 3  # outputs and keys that the summary names
MOST_ROWS, FEW_ROWS = 500, 40  # cases in a table of the page; up to so many, the table is open


def study_page(dataset: xr.Dataset, source: str, cover: Cover = NO_COVER) -> str:
    """The report of a study as HTML. dataset: ``study.nc``; source: where it was read from."""
    outputs = numbers_in(dataset)
    status = of_cases(dataset, "status").astype(str)
    counts = dict(sorted(Counter(status).most_common(), key=lambda pair: pair[0] != COMPLETED))
    verdict = f"{status.size} cases: {', '.join(f'{n} {name}' for name, n in counts.items())}."
    folder = last_part(source.removesuffix("/study.nc"))
    rows = [("title", dataset.attrs["title"]), ("study", folder), ("analysis", dataset.attrs.get("analysis", ""))]
    rows += [(f"varied: {dataset[name].attrs['key']}", _span(dataset, name, 8)) for name in varied(dataset)]
    labels, messages = _labels(dataset), of_cases(dataset, "message").astype(str)
    without = np.flatnonzero((status != COMPLETED) | (messages != ""))
    lost = [(labels[i], str(status[i]), str(messages[i])) for i in without[:MOST_ROWS]]
    cases_more = [f"Case abcd… lies in {folder}/cases/ab/abcd…; study.csv has full names"]
    cases_more += [f"{MOST_OUTPUTS} of {len(outputs)} outputs; study.csv has all"] * (len(outputs) > MOST_OUTPUTS)
    page = {
        "cover": cover.of(dataset.attrs["title"]),
        "version": __version__,
        "verdict": ReportVerdict(OPEN if set(counts) <= {COMPLETED, DERAILED} else BAD, verdict),
        "paragraph": _study_paragraph(dataset, outputs, labels),
        "identity": [*rows, ("cases", str(status.size))],
        "versions": _versions(dataset),
        "outputs": _outputs(dataset, outputs, labels),
        "pictures": [as_picture(name, make()) for name, make in study_figures(dataset).items()],
        "sensitivity": sensitivity_tables(sensitivity_in(dataset)),
        "without": _table(("case", "status", "message"), lost),
        "without_more": _more(len(without)),
        "cases": _cases(dataset, outputs[:MOST_OUTPUTS]),
        "cases_more": "; ".join(filter(None, (*cases_more, _more(status.size)))),
        "few": status.size <= FEW_ROWS,
        "command": f"wrsim study study.toml -o {quoted(folder or 'study')}",
        "study_text": dataset.attrs.get("study_text", ""),
        "scenario_text": dataset.attrs.get("scenario_text", ""),
    }
    return page_template("study.html").render(page)


def _span(dataset: xr.Dataset, name: str, most: int) -> str:
    """The values of what is varied; of more than so many their number and the ends."""
    values = [_text(value) for value in np.unique(dataset[name].values)]
    return f"{len(values)} values, {values[0]} to {values[-1]}" if len(values) > most else ", ".join(values)


def _study_paragraph(dataset: xr.Dataset, outputs: Sequence[str], labels: Sequence[str]) -> str:
    """Vehicle, what is asked and varied, contact, and between what the first outputs lie, in sentences."""
    keys = {name: str(dataset[name].attrs["key"]) for name in varied(dataset)}
    single_vehicle = "vehicle.model" not in keys.values()
    subject = f"of vehicle {vehicle_name(dataset)}" if single_vehicle else "of several vehicles"
    analysis = str(dataset.attrs.get("analysis", ""))
    sentences = [f"{dataset['status'].size} cases {subject}: {ASKED.get(analysis, analysis)}."]
    told = [f"{key} ({_span(dataset, name, MOST_TOLD)})" for name, key in keys.items()]
    sentences.append(f"Varied: {join_names(told, MOST_TOLD)}." if told else "")
    changed = any(key.startswith("contact.") for key in keys.values())
    sentences.append(contact_sentence(dataset, " of the base scenario" if changed else ""))
    table = _outputs(dataset, outputs[:MOST_TOLD], labels)
    for name, low, at_low, median, high, at_high in table.rows if table else ():
        ends = f"{low} ({at_low}) and {high} ({at_high})"
        sentences.append(
            f"{name} is {low} in all cases." if low == high else f"{name} lies between {ends}; median {median}."
        )
    return " ".join(filter(None, sentences))


def _evolution_paragraph(dataset: xr.Dataset) -> str:
    """Wheel, law, mileage, and how the profile changes, in sentences."""
    about, steps = dataset.attrs, dataset.sizes["point"] - 1
    law = LAW_LABELS.get(str(about.get("law")), str(about.get("law", "")))
    mileage = quantity(1e-3 * float(dataset["mileage"].values[-1]), "km", ".6g")
    sentences = [
        f"Wheels {about.get('wheel', '')} of vehicle {vehicle_name(dataset)} wear by the law {law} over {mileage}."
    ]
    cases = str(about.get("cases_text", "")).strip().count("\n")
    sentences.append(f"Each of the {steps} steps runs {cases} cases by their shares, then the profile is made anew.")
    sentences.append(contact_sentence(dataset))
    units = {"flange_thickness": "mm", "flange_height": "mm", "flange_steepness": "mm", "conicity": ""}
    for name, unit in units.items():
        first, last = (float(v) * (1e3 if unit else 1.0) for v in dataset[name].values[[0, -1]])
        form = ".2f" if unit else ".3f"
        ends = f"from {formatted(first, form)} to {quantity(last, unit, form)}"
        heading = str(dataset[name].attrs["long_name"])
        sentences.append(f"{heading[0].upper()}{heading[1:]}: {ends}.")
    return " ".join(filter(None, sentences))


def _versions(dataset: xr.Dataset) -> list[tuple[str, str]]:
    versions = sorted(key for key in dataset.attrs if key.endswith("_version"))
    return [(key.removesuffix("_version"), str(dataset.attrs[key])) for key in versions]


def varied(dataset: xr.Dataset) -> list[str]:
    """Names of the coordinates that hold what is varied."""
    return [str(name) for name, c in dataset.coords.items() if "key" in c.attrs]


def _labels(dataset: xr.Dataset) -> list[str]:
    names = varied(dataset)
    columns = [of_cases(dataset, name) for name in names]
    return [", ".join(f"{n} {_text(v)}" for n, v in zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> Table | None:
    return Table("", tuple(map(Column, heads)), rows) if rows else None


def _outputs(dataset: xr.Dataset, outputs: Sequence[str], labels: Sequence[str]) -> Table | None:
    """Range and median of every output, with the cases of the ends."""
    done = of_cases(dataset, "status") == COMPLETED
    rows = []
    for name in outputs:
        values = np.where(done, of_cases(dataset, name).astype(float), np.nan)
        low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
        ends = (_text(values[low]), labels[low], _text(values[high]), labels[high])
        rows.append((_label_of(dataset, name), *ends[:2], _text(np.nanmedian(values)), *ends[2:]))
    return _table(("output", "smallest", "in the case", "median", "largest", "in the case"), rows)


def _cases(dataset: xr.Dataset, outputs: Sequence[str]) -> Table | None:
    columns = [of_cases(dataset, name)[:MOST_ROWS] for name in ("name", *varied(dataset), "status", *outputs)]
    heads = ("case", *(dataset[n].attrs["key"] for n in varied(dataset)), "status")
    rows = [(str(row[0])[:12], *map(_text, row[1:])) for row in zip(*columns, strict=True)]
    return _table((*heads, *(_label_of(dataset, name) for name in outputs)), rows)


def _more(count: int) -> str:
    return f"{MOST_ROWS} of {count} cases; study.csv has all" if count > MOST_ROWS else ""


def _label_of(dataset: xr.Dataset, name: str) -> str:
    return label_of(dataset, name).replace("\n", " ")


def _text(value: object) -> str:
    return formatted(float(value), ".6g") if isinstance(value, float | np.floating) else str(value)


def verdict_page(
    title: str, summary: str, tables: dict[str, Table], notes: Sequence[str], sentence: str, passed: bool,
    texts: dict[str, str], figures: Makers | None = None,
) -> str:  # fmt: skip
    """The report of a type test, a validation or a calibration as HTML. tables: by their headings; sentence: the
    verdict; texts: files by name."""
    page = {
        "cover": NO_COVER.of(title),
        "version": __version__,
        "verdict": ReportVerdict(OPEN if passed else BAD, sentence),
        "summary": summary,
        "tables": tables,
        "pictures": [as_picture(name, make()) for name, make in (figures or {}).items()],
        "notes": notes,
        "texts": texts,
    }
    return page_template("type_test.html").render(page)


OF_EVOLUTION = {
    "evolution_text": "File of the evolution",
    "service_text": "File of the evolution",  # of older results
    "cases_text": "Table of cases",
    "scenario_text": "Scenario",
}
"""Files that a profile evolution holds, and their headings."""


def evolution_page(dataset: xr.Dataset, source: str, numbers: Table, cover: Cover = NO_COVER) -> str:
    """The report of a profile evolution as HTML. dataset: ``wear.nc``, from source; numbers: against the mileage."""
    about = dataset.attrs
    steps = dataset.sizes["point"] - 1
    mileage = quantity(1e-3 * float(dataset["mileage"].values[-1]), "km", ".6g")
    deepest = quantity(1e3 * float(dataset["deepest"].values[-1]), "mm", ".3g")
    identity = [(key, str(about[key])) for key in ("title", "law", "wheel") if key in about]
    folder = last_part(source.removesuffix("/wear.nc"))
    identity += [("evolution", folder), ("steps of wear", str(steps)), ("mileage", mileage)]
    page = {
        "cover": cover.of(about["title"]),
        "version": __version__,
        "verdict": f"{mileage} in {steps} steps; {deepest} worn off at the deepest place.",
        "paragraph": _evolution_paragraph(dataset),
        "identity": identity,
        "versions": _versions(dataset),
        "numbers": numbers,
        "pictures": [as_picture(name, make()) for name, make in evolution_figures(dataset).items()],
        "command": f"wrsim wear evolution.toml -o {quoted(folder or 'evolution')}",
        "texts": {label: str(about[key]) for key, label in OF_EVOLUTION.items() if about.get(key)},
    }
    return page_template("evolution.html").render(page)
