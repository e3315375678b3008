"""Model beside measurement: quantities of EN 14363 by section, their differences, and the series themselves.

The measured series take the place of their channels in a copy of the run; both are assessed by the same rules. What
was not measured is left out.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import csd, welch

from wrsim.assessment.assess import assess_runs
from wrsim.assessment.limits import QUANTITIES
from wrsim.assessment.outcome import TRANSITION, Assessment, Value
from wrsim.assessment.rules import ClauseSection, rule_set
from wrsim.assessment.sections import STRAIGHT
from wrsim.errors import InputError
from wrsim.inputs.file_kinds import packaged
from wrsim.inputs.toml_files import noting_reads
from wrsim.plots.drawing import Makers
from wrsim.plots.measurement import Panel, lines_figure, scatter_figure
from wrsim.results import CHANNELS, Result, write_atomically
from wrsim.results.files import as_csv, as_json
from wrsim.results.table import Column, Table, as_rows, with_unit
from wrsim.scenario.loading import load
from wrsim.study.measurement.alignment import (
    LINES,
    Pair,
    Shift,
    channel_of,
    densities,
    found_shift,
    overlap,
    pairs,
    record_beside,
    shift_notes,
    spectral_length,
)
from wrsim.study.measurement.reading import Record, read_record
from wrsim.study.measurement.sections import ValidationFile
from wrsim.study.plan import FileInput, Plan, with_cases
from wrsim.study.spec import OutputsSection
from wrsim.study.task import COMPLETED, RESULT, Marker

ANNEX_T = packaged("wrsim.study", "data/annex_t.toml")
MARK = "*" * (ANNEX_T["mark"] == "mem")
OUTPUTS = ("validation.json", "validation.csv", "validation.html")
NEEDED: dict[str, tuple[str, ...]] = {
    "Y_qst": ("Y",), "Q_qst": ("Q",), "Y_over_Q_qst": ("Y", "Q"), "sum_Y_qst": ("Y",),
    "Y": ("Y",), "Q": ("Q",), "Y_over_Q": ("Y", "Q"), "sum_Y": ("Y",),
    "body_ay_rms": ("point_ay",), "body_az_rms": ("point_az",), "body_ay": ("point_ay",), "body_az": ("point_az",),
}  # fmt: skip
"""Channels that a quantity of Annex T comes from."""


@dataclass(frozen=True)
class Compared:
    """A scenario: its record, the shift of that, the measured part of the run, series beside channels (filtered)."""

    record: Record
    shift: Shift
    model: Result
    measured: Result
    pairs: list[Pair]

    @classmethod
    def from_result(cls, result: Result, record: Record, shift: Shift) -> "Compared":
        """Raises InputError for a result without history, and where nothing was measured."""
        part, values = overlap(result.dataset, record, shift.value)
        measured = part.copy()
        for each, series in zip(record.series, values, strict=True):
            channel = measured[each.section.channel].copy(deep=True)
            place = channel.loc[each.section.chosen()]
            channel.loc[each.section.chosen()] = series.reshape(-1, *(1,) * (place.ndim - 1))
            measured[each.section.channel] = channel
        return cls(record, shift, Result(part), Result(measured), pairs(result.dataset, record, shift.value))

    def is_measured(self, value: Value) -> bool:
        """Whether all that a quantity comes from was measured."""
        wheels = [value.wheel] if value.wheel else ["left", "right"]
        where = {"wheelset": value.wheelset, "point": value.point}

        def has(channel: str, wheel: str) -> bool:
            chosen = (each.section.chosen() for each in self.record.series if each.section.channel == channel)
            wanted = where | {"wheel": wheel}
            return any(all(wanted.get(dim, label) in ("", label) for dim, label in labels.items()) for labels in chosen)

        return all(has(channel, wheel) for channel in NEEDED[value.quantity.key] for wheel in wheels)


@dataclass(frozen=True)
class Validation:
    """A validation, read and checked. records, and for each the result or the plan of the one run; reads: all files."""

    source: FileInput
    records: tuple[Record, ...]
    runs: tuple[Result | Plan, ...]
    reads: tuple[Path, ...]

    def compared(self, markers: Sequence[Marker | None]) -> list[Compared]:
        """Runs beside their records. Raises InputError for a run without a result."""
        results = []
        for record, run, marker in zip(self.records, self.runs, markers, strict=True):
            if isinstance(run, Plan) and (marker is None or marker.status != COMPLETED):
                why = "no result" if marker is None else f"{marker.status}: {marker.message}"
                raise InputError(f"{record.name}: {why}; --retry runs it again")
            results.append(run if isinstance(run, Result) else Result.load(run.folder_of(run.cases[0]) / RESULT))
        return [
            Compared.from_result(result, record, found_shift(result.dataset, record))
            for result, record in zip(results, self.records, strict=True)
        ]


def read_validation(file: Path, folder: Path, models: Sequence[str | Path]) -> Validation:
    """A validation with its measured files; its scenarios run in ``folder``. Raises InputError before anything runs."""
    with noting_reads() as seen:
        source = FileInput(file, "validation file", ValidationFile, models)
        spec: ValidationFile = source.spec
        records, runs = list[Record](), list[Result | Plan]()
        for i, each in enumerate(spec.scenario):
            sections = [s for s in spec.measured if s.scenario in (None, each.name)]
            if each.result is not None:
                path = source.file_of("scenario", i, "file", name=str(each.file))
                with source.naming("scenario", i, "result", value=each.result):
                    result = Result.load(
                        beside if (beside := file.parent / each.result).exists() else Path(each.result)
                    )
                speed = float(result.dataset["speed"].mean()) if "speed" in result.dataset else None
                records.append(read_record(path, each.name, each, sections, speed))
                for section in sections:
                    channel_of(result.dataset, section)
                runs.append(result)
                continue
            scenario = load(source.file_of("scenario", i, "base", name=str(each.base)), models)
            records.append(record_beside(source, i, each.name, each, sections, scenario))
            plan = source.plan_of(
                scenario, scenario.title, folder / "scenarios" / each.name, (), OutputsSection(), spec.cases
            )
            runs.append(with_cases(plan, scenario)[0])
    return Validation(source, tuple(records), tuple(runs), tuple(seen))


@dataclass(frozen=True)
class Difference:
    """A quantity in one section of track, in its unit for readers. value: of the model; measured: the same."""

    run: str
    value: Value
    model: float
    measured: float

    @property
    def difference(self) -> float:
        """Magnitude of the model less that measured: positive where the model has more."""
        return abs(self.model) - abs(self.measured)


@dataclass(frozen=True)
class Judged:
    """Differences of a quantity over all sections. limit: of their standard deviation; that of the mean is a part."""

    key: str
    differences: tuple[Difference, ...]
    limit: float

    @property
    def mean(self) -> float:
        return float(np.mean([d.difference for d in self.differences]))

    @property
    def deviation(self) -> float | None:
        """Standard deviation; None of a single difference."""
        values = [d.difference for d in self.differences]
        return float(np.std(values, ddof=1)) if len(values) > 1 else None

    @property
    def mean_limit(self) -> float:
        return float(ANNEX_T["mean_part"] * self.limit)

    @property
    def sections(self) -> int:
        return len({(d.run, d.value.section.number) for d in self.differences})

    @property
    def passed(self) -> bool:
        return abs(self.mean) <= self.mean_limit and (self.deviation or 0.0) <= self.limit


def judged(compared: Sequence[Compared]) -> tuple[list[Judged], Assessment]:
    """Every quantity of Annex T that was measured, and the assessment of the model. Raises InputError."""
    rules = rule_set("en14363")
    extra = [ClauseSection.model_validate(clause) for clause in ANNEX_T["clauses"]]
    rules = rules.model_copy(update={"clauses": (*rules.clauses, *extra)})
    names = [each.record.name for each in compared]
    by_name = dict(zip(names, compared, strict=True))
    model, measured = (
        assess_runs([getattr(each, side) for each in compared], None, names, rules) for side in ("model", "measured")
    )
    differences: dict[str, list[Difference]] = {key: [] for key in ANNEX_T["limits"]}
    beside = {_key(value): value.value for value in measured.values}
    for value in model.values:
        key, zone, run = value.quantity.key, value.section.zone, value.section.run or names[0]
        no_curve = zone == STRAIGHT and key.endswith("_qst")
        reference = beside.get(_key(value), np.nan)
        if key not in differences or zone == TRANSITION or no_curve or not by_name[run].is_measured(value):
            continue
        if np.isfinite(value.value) and np.isfinite(reference):
            factor = value.quantity.shown.factor
            differences[key].append(Difference(run, value, factor * value.value, factor * reference))
    loads = [v for k, v in model.settings.items() if k.startswith("axle_load") and isinstance(v, float)]
    wheel_load = 0.5 * float(np.mean(loads))

    def limit(key: str) -> float:
        row = ANNEX_T["limits"][key]
        return float(row["value"] * (1.0 + row.get("per_kN", 0.0) * wheel_load))

    return [Judged(key, tuple(rows), limit(key)) for key, rows in differences.items() if rows], model


def _key(value: Value) -> tuple[Any, ...]:
    return value.quantity.key, value.section.number, value.wheelset, value.wheel, value.point


def judged_table(rows: Sequence[Judged]) -> Table:
    """Mean and standard deviation of the differences, and their limits."""
    body = []
    for row in rows:
        judged_quantity = QUANTITIES[row.key]
        word = "ok" if row.passed else "EXCEEDED"
        body.append(
            (judged_quantity.symbol, judged_quantity.shown.unit, row.sections, len(row.differences), row.mean,
             row.mean_limit, row.deviation, row.limit, word)
        )  # fmt: skip
    heads = (
        Column("quantity", key="quantity"), Column("unit", key="unit"), Column("sections", "", "d", key="sections"),
        Column("values", "", "d", key="values"), Column("mean", key="mean"), Column("limit", key="mean_limit"),
        Column("deviation", key="deviation"), Column("limit", key="deviation_limit"), Column("verdict", key="verdict"),
    )  # fmt: skip
    note = f"model less measurement, of magnitudes; limits: {ANNEX_T['source']}{MARK}"
    confirm = ("*: from memory of the standard, to be confirmed against its text",) if MARK else ()
    return Table("Differences over all sections", heads, body, (note, *confirm))


def sections_table(rows: Sequence[Judged]) -> Table:
    """Every value: quantity, section, wheelset, wheel or point, model and measurement."""
    body = [
        (row.key, d.value.quantity.shown.unit, d.run, d.value.section.number, d.value.section.label,
         d.value.section.start, d.value.section.end, d.value.wheelset, d.value.wheel, d.value.point, d.model,
         d.measured, d.difference)
        for row in rows
        for d in row.differences
    ]  # fmt: skip
    heads = ("quantity", "unit", "run", "section", "class", "from_m", "to_m", "wheelset", "wheel", "point", "model",
             "measured", "difference")  # fmt: skip
    forms = {"from_m": ".1f", "to_m": ".1f", "section": "d"}
    return Table("", tuple(Column(head, "", forms.get(head, ".4g"), key=head) for head in heads), body)


def series_table(compared: Sequence[Compared]) -> Table:
    """Every series: rms, difference, correlation; at the strongest measured frequency the ratio and the phase."""
    body = []
    for each in compared:
        for pair in each.pairs:
            shown = CHANNELS[pair.series.section.channel].shown
            model, measured = (shown.factor * v for v in (pair.model, pair.measured))
            rms = [float(np.sqrt(np.mean(v**2))) for v in (measured, model)]
            spread = model.std() * measured.std()
            correlation = float(np.cov(model, measured, ddof=0)[0, 1] / spread) if spread > 0.0 else None
            off = model - measured
            label = f"{pair.series.section.label} [{shown.symbol}]"
            body.append((each.record.name, label, *rms, off.mean(), off.std(), correlation, *_phase(pair)))
    heads = (
        Column("run", key="run"), Column("series", key="series"), Column("rms, measured", key="rms_measured"),
        Column("rms, model", key="rms_model"), Column("mean difference", key="mean"),
        Column("its deviation", key="deviation"), Column("correlation", "", ".3f", key="correlation"),
        Column("strongest line", "Hz", ".3g", key="line_Hz"), Column("ratio", "", ".3g", key="ratio"),
        Column("phase", "°", ".1f", key="phase_deg"),
    )  # fmt: skip
    note = "ratio, phase: of the model over the measurement at the strongest measured line, positive where it leads"
    return Table("Series, filtered as the file says", heads, body, (note,))


def _phase(pair: Pair) -> tuple[float | None, float | None, float | None]:
    """Strongest measured line [Hz], and there ratio and phase [deg] of model over measurement."""
    if pair.measured.size < 2 * LINES:
        return None, None, None
    length = spectral_length(pair.measured.size)
    frequency, cross = csd(pair.measured, pair.model, pair.rate, "hann", length, detrend="constant")
    power = welch(pair.measured, pair.rate, "hann", length, detrend="constant")[1]
    i = 1 + int(np.argmax(power[1:]))
    if not power[i] > 0.0:
        return None, None, None
    ratio = cross[i] / power[i]
    return float(frequency[i]), float(np.abs(ratio)), float(np.degrees(np.angle(ratio)))


def basis(compared: Sequence[Compared], rows: Sequence[Judged], model: Assessment) -> list[str]:
    """What the verdict rests on: files, shifts, filters, sections, quantities that are lacking."""
    notes = []
    for each in compared:
        record = each.record
        notes += shift_notes(record, each.shift, f"{record.file.name} over {record.axis}")
    filters = {p.series.section.label: _filter_text(p) for each in compared for p in each.pairs}
    notes += [f"{series}: {form}" for series, form in filters.items() if form]
    counted = [s for s in model.sections if s.zone != TRANSITION]
    zones = ", ".join(f"{sum(s.zone == z for s in counted)} {z}" for z in dict.fromkeys(s.zone for s in counted))
    short = sum(s.short for s in counted)
    notes.append(
        f"{len(counted)} of {ANNEX_T['sections']}{MARK} sections of track ({zones or 'none'})"
        + (f", {short} of them shorter than the standard has them" if short else "")
    )
    lacking = [QUANTITIES[key].symbol for key in ANNEX_T["limits"] if key not in {row.key for row in rows}]
    notes.append(f"not compared, for it was not measured or no section has it: {', '.join(lacking) or 'nothing'}")
    return [*notes, *(note for note in model.notes if "event" in note)]


def _filter_text(pair: Pair) -> str:
    section = pair.series.section
    if section.band_Hz is not None:
        return f"band-pass {section.band_Hz[0]:g} to {section.band_Hz[1]:g} Hz"
    return "" if section.low_pass_Hz is None else f"low-pass {section.low_pass_Hz:g} Hz"


def verdict(rows: Sequence[Judged]) -> tuple[bool, str]:
    """Whether all differences are within their limits, and one sentence."""
    red = [QUANTITIES[row.key].symbol for row in rows if not row.passed]
    if not rows:
        return False, "No quantity of Annex T was measured"
    if red:
        return False, f"LIMITS EXCEEDED: {len(red)} of {len(rows)} quantities: {', '.join(red)}"
    few = max(row.sections for row in rows) < ANNEX_T["sections"]
    sentence = f"{len(rows)} of {len(ANNEX_T['limits'])} quantities compared, each within its limits"
    return True, sentence + f"; too few sections for a validation by {ANNEX_T['source']}" * few


def write_validation(folder: Path, numbers: dict[str, Any], sections: Table, page: str) -> list[Path]:
    """Write ``validation.json``, ``validation.csv`` and ``validation.html``."""
    contents: Iterable[bytes] = (as_json(numbers, indent=1), as_csv(as_rows(sections)), page.encode())
    return [write_atomically(folder / name, content) for name, content in zip(OUTPUTS, contents, strict=True)]


def figures(compared: Sequence[Compared], rows: Sequence[Judged]) -> Makers:
    """Pictures by their names: series, spectra, values against values."""
    series, spectra = list[Panel](), list[Panel]()
    for each in compared:
        for pair in each.pairs:
            channel, place = CHANNELS[pair.series.section.channel], f"{each.record.name}, {pair.series.section.label}"
            lines = {
                name: (pair.place, channel.shown.factor * y)
                for name, y in (("measured", pair.measured), ("model", pair.model))
            }
            series.append(Panel(f"{place} [{channel.shown.symbol}]", "Distance along the track [m]", lines))
            if pair.measured.size >= 2 * LINES:
                density = {name: densities(pair, values) for name, (_, values) in lines.items()}
                label = f"{place} [({channel.shown.symbol})²/Hz]"
                spectra.append(Panel(label, "Frequency [Hz]", density, log=True))
    labels = [with_unit(QUANTITIES[row.key].symbol, QUANTITIES[row.key].shown.unit) for row in rows]
    values = {
        label: (np.array([d.measured for d in row.differences]), np.array([d.model for d in row.differences]))
        for label, row in zip(labels, rows, strict=True)
    }
    zones = {label: [d.value.section.zone for d in row.differences] for label, row in zip(labels, rows, strict=True)}
    return {
        "series": partial(lines_figure, "Series over the distance", series),
        **({"spectra": partial(lines_figure, "Power spectral densities", spectra)} if spectra else {}),
        **({"sections": partial(scatter_figure, "Values of sections", values, zones)} if rows else {}),
    }
