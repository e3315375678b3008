"""A calibration, read and checked, and what is fitted: measured values beside those of the model."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment

from wrsim.errors import InputError, suggest
from wrsim.inputs.section import given
from wrsim.inputs.toml_files import noting_reads
from wrsim.register import ANALYSES
from wrsim.results import CHANNELS, Result
from wrsim.results.channels import PLAIN, SHOWN, Shown
from wrsim.results.moments import Array
from wrsim.study.calibration.sections import CalibrationFile, ValueSection
from wrsim.study.candidates import ONLY, Candidates, read_candidates
from wrsim.study.measurement.alignment import Pair, Shift, densities, found_shift, pairs, record_beside
from wrsim.study.measurement.reading import Record
from wrsim.study.outputs import case_outputs, check_place, reduced
from wrsim.study.plan import FileInput
from wrsim.study.spec import OutputsSection
from wrsim.study.task import begun

MARGIN = 0.05
"""Part of a series at each end that is left out where its shift is looked for, at most."""
FARTHEST = 1e3
"""Distance of a mode of another name, in logarithms of frequencies."""
LAST, FEW = 2.5, 20
"""Steps at each end that are left out of a series, of more samples than a few."""
ACROSS = {"distance": "Distance along the track [m]", "time": "Time [s]", "pose": "Pose"}


@dataclass(frozen=True, eq=False)
class Target:
    """What is fitted of one series or number.

    label: for people; row: number of [[measured]] or [[value]]; place (n,): where the values are, on the measured
    clock [m] or [s], of poses by number, of a spectrum [Hz]; measured (n,): in SI units, of a spectrum the logarithm of
    the density; noise: standard deviation, None where it comes from the residual; neighbours: whether values that are
    near each other go together; weight: factor of the squares; shown: unit for readers; across: name of the places.
    """

    label: str
    scenario: str
    row: int
    place: Array
    measured: Array
    noise: float | None
    neighbours: bool
    weight: float = 1.0
    shown: Shown = PLAIN
    across: str = ""


@dataclass(frozen=True)
class Calibration:
    """source: the file; candidates: the space of its keys; records: measured files by scenario; reads: all files."""

    source: FileInput
    candidates: Candidates
    records: Mapping[str, Record]
    reads: tuple[Path, ...]

    @property
    def spec(self) -> CalibrationFile:
        """The content of the file."""
        return self.source.spec  # type: ignore[no-any-return]

    def shifts(self, results: Mapping[str, Result]) -> dict[str, Shift]:
        """The shift of every record beside the results of a candidate."""
        return {name: found_shift(results[name].dataset, record) for name, record in self.records.items()}

    def targets(self, results: Mapping[str, Result], shifts: Mapping[str, Shift]) -> list[Target]:
        """What is fitted, at the samples of these results."""
        weights = {s.name: s.weight for s in self.candidates.scenarios}
        targets = []
        for name, record in self.records.items():
            for pair in pairs(results[name].dataset, record, shifts[name].value):
                place, values = _part(pair, pair.measured, shifts[name].value)
                margin = min(record.search, MARGIN * float(np.ptp(place)))
                if record.axis != "pose" and place.size > FEW:  # runs end a sample earlier or later
                    margin = max(margin, LAST * float(np.median(np.diff(place))))
                kept = (place >= place[0] + margin) & (place <= place[-1] - margin)
                if pair.series.section.fit == "series":
                    place, values = place[kept], values[kept]
                section, channel = pair.series.section, CHANNELS[pair.series.section.channel]
                spectral, single = section.fit == "spectrum", section.reduce is not None
                targets.append(
                    Target(
                        f"{name}, {section.label}" if len(self.candidates.scenarios) > 1 else section.label,
                        name, self.spec.measured.index(section), place, values, None if spectral else pair.series.noise,
                        record.axis != "pose" and not single, weights[name],
                        Shown("ln density", "", 1.0) if spectral else channel.shown,
                        "Frequency [Hz]" if spectral else ACROSS[record.axis],
                    )
                )  # fmt: skip
        for row, value in enumerate(self.spec.value):
            name = value.scenario or self.candidates.scenarios[0].name
            numbers = np.array(value.frequencies_Hz or (given(value.value),))
            label = value.summary or "natural frequencies"
            shown = SHOWN["Hz"] if value.summary is None else PLAIN
            places = np.arange(numbers.size, dtype=float)
            targets.append(
                Target(label, name, row, places, numbers, value.noise, False, weights[name], shown, "Number")
            )
        return targets

    def model(self, results: Mapping[str, Result], targets: Sequence[Target]) -> list[Array]:
        """Values of the model at the places of the targets, every candidate with its own shift: no key takes the blame
        for that. Raises InputError where a run does not reach them."""
        known: dict[tuple[str, int], tuple[Array, Array]] = {}
        for name, shift in self.shifts(results).items():
            for pair in pairs(results[name].dataset, self.records[name], shift.value):
                known[name, self.spec.measured.index(pair.series.section)] = _part(pair, pair.model, shift.value)
        values = []
        for target in targets:
            if target.across == "Number":
                values.append(_numbers(self.spec.value[target.row], results[target.scenario]))
                continue
            place, model = known[target.scenario, target.row]
            values.append(model if place.size == 1 else np.interp(target.place, place, model))
        return values


def _part(pair: Pair, values: Array, shift: float) -> tuple[Array, Array]:
    """Places, on the measured clock, and values of what is fitted of a series: samples, a number of them, or the
    logarithm of their density."""
    section = pair.series.section
    if section.reduce is not None:
        return np.zeros(1), np.array([reduced(values[:, None], section.reduce, section.percentile)])
    if section.fit != "spectrum":
        return pair.clock - shift, values
    frequency, density = densities(pair, values)
    low, high = section.band_Hz or (0.0, section.low_pass_Hz or np.inf)
    inside = (frequency >= low) & (frequency <= high) & (density > 0.0)
    return frequency[inside], np.log(density[inside])


def _numbers(value: ValueSection, result: Result) -> Array:
    if value.summary is not None:
        outputs = case_outputs(result, OutputsSection(summary=(value.summary,)), None)
        if outputs.faults:
            raise InputError(outputs.faults[0].replace("outputs", "[[value]]", 1))
        return np.array([*outputs.numbers.values()])
    return mode_numbers(value, result)


def mode_numbers(value: ValueSection, result: Result) -> Array:
    """Frequencies of the modes that are nearest to measured ones, or of their names [Hz]. Raises InputError."""
    frequencies, names = (result.dataset[f"mode_{name}"].values[0] for name in ("frequency", "name"))
    swings = np.isfinite(frequencies) & (np.nan_to_num(frequencies) > 0.0)
    frequencies, names, wanted = frequencies[swings], names[swings], np.array(value.frequencies_Hz)
    for name in value.modes:
        if name not in names:
            known = list(map(str, dict.fromkeys(names)))
            raise InputError(f'[[value]] modes: "{name}" is none{suggest(name, known)}; there is {", ".join(known)}')
    apart = np.abs(np.log(wanted[:, None] / frequencies[None, :]))
    if value.modes:
        apart = np.where(np.array(value.modes)[:, None] == names[None, :], apart, FARTHEST)
    if frequencies.size < wanted.size:
        raise InputError(f"[[value]] frequencies_Hz: {wanted.size}, the model has {frequencies.size} modes that swing")
    rows, columns = linear_sum_assignment(apart)
    if apart[rows, columns].max() >= FARTHEST:
        raise InputError("[[value]] modes: a name stands there more often than the model has modes of it")
    return np.asarray(frequencies[columns[np.argsort(rows)]])


def read_calibration(file: Path, folder: Path, models: Sequence[str | Path]) -> Calibration:
    """A calibration; candidates run in ``folder``. Raises InputError before anything runs."""
    with noting_reads() as seen:
        opened = FileInput(file, "calibration file", CalibrationFile, models)
        spec: CalibrationFile = opened.spec
        names = [name for name, *_ in spec.named_bases()]
        candidates = read_candidates(opened, folder, dict.fromkeys(names, OutputsSection()))
        bases = {s.name: s.base for s in candidates.scenarios}
        records: dict[str, Record] = {}
        for i, each in enumerate(spec.scenario):
            sections = [s for s in spec.measured if s.scenario in (None, each.name)]
            if each.file is None or not sections:
                continue
            records[each.name] = record_beside(opened, i, each.name, each, sections, bases[each.name])
        begins: dict[str, Result] = {}
        for row, value in enumerate(spec.value):
            name = value.scenario or (names[0] if names else ONLY)
            base = bases[name]
            if value.frequencies_Hz and base.analysis != "stability":
                with opened.naming("value", row, "frequencies_Hz"):
                    raise InputError(f'its scenario has analysis = "{base.analysis}"; must be "stability"')
            if value.summary and ANALYSES[base.analysis].moves:
                with opened.naming("value", row, "summary"):
                    check_place(begins.get(name) or begins.setdefault(name, begun(base)), value.summary)
    return Calibration(opened, candidates, records, tuple(seen))
