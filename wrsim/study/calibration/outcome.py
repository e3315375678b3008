"""Tables, pictures and files of a calibration."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from wrsim.plots.drawing import Makers
from wrsim.plots.measurement import Panel, intervals_figure, lines_figure
from wrsim.results import write_atomically
from wrsim.results.files import as_csv, as_json
from wrsim.results.moments import Array
from wrsim.results.table import Column, Table, as_records, as_rows, formatted, with_unit
from wrsim.study.calibration.fit import Fit
from wrsim.study.calibration.intervals import NARROWER, TOGETHER, Knowledge
from wrsim.study.changed_files import file_names, write_changed
from wrsim.study.measurement.alignment import shift_notes

REPORT, TABLE, PAGE, KIND = "calibration.json", "calibration.csv", "calibration.html", "calibrated"


def written_names(names: Sequence[str]) -> tuple[str, ...]:
    """Files in the folder of a calibration with scenarios of these names."""
    return (REPORT, TABLE, PAGE, *file_names(KIND, names))


@dataclass(frozen=True)
class Calibrated:
    """A fit, what it tells, and values of the model (one array a target) at the start and at the optimum."""

    fit: Fit
    known: Knowledge
    before: list[Array]
    after: list[Array]

    @classmethod
    def from_fit(cls, fit: Fit, known: Knowledge) -> "Calibrated":
        models = fit.models([fit.start, fit.optimum])
        assert models[0] is not None and models[1] is not None
        return cls(fit, known, models[0], models[1])

    def keys_table(self) -> Table:
        """Every key: start, prior, value, interval, from where the value comes."""
        spec, rows = self.fit.calibration.spec, []
        varied = self.fit.calibration.candidates.varied
        for var, key, interval in zip(varied, spec.vary, self.known.intervals, strict=True):
            rows.append(
                (var.name, var.start, key.prior, key.tolerance, interval.value, interval.low, interval.high,
                 "measurement" if interval.told else "NOT TOLD by the channels", var.keys[0])
            )  # fmt: skip
        percent = f"{spec.confidence_percent:g} %"
        heads = (
            Column("", key="name"), Column("start", key="start"), Column("data sheet", key="prior"),
            Column("±", key="tolerance"), Column("calibrated", "", ".5g", key="value"),
            Column(f"from ({percent})", key="low"), Column("to", key="high"),
            Column("source", key="source"), Column("key", key="key"),
        )  # fmt: skip
        how = {"linear": "by the derivatives at the optimum", "profile": "by the profile of the likelihood"}
        return Table("Keys", heads, rows, (f"intervals {how[spec.intervals]}",))

    def targets_table(self) -> Table:
        """Every series: samples, how many of them count, noise, rms of the residual before and after."""
        rows = []
        fit = self.fit
        for target, weight, *models in zip(fit.targets, fit.weights, self.before, self.after, strict=True):
            factor = target.shown.factor
            rms = [factor * float(np.sqrt(np.mean((m - target.measured) ** 2))) for m in models]
            label = with_unit(target.label, target.shown.symbol)
            n, source = target.measured.size, "residual" if target.noise is None else "given"
            rows.append((label, n, n / weight.neighbours, factor * weight.noise, source, *rms))
        heads = (
            Column("series", key="series"), Column("samples", "", "d", key="samples"),
            Column("independent", "", ".0f", key="independent"), Column("noise", key="noise"),
            Column("of", key="noise_of"), Column("rms before", key="before"), Column("rms after", key="after"),
        )  # fmt: skip
        return Table("Residuals", heads, rows, ("independent: samples over the autocorrelation of the residual",))

    def notes(self) -> list[str]:
        """What the result rests on, and what the channels do not tell."""
        fit, known = self.fit, self.known
        notes = []
        for name, shift in fit.shifts.items():
            record = fit.calibration.records[name]
            if record.axis != "pose":
                notes += shift_notes(record, shift, record.file.name)
        varied = fit.calibration.candidates.varied
        for var, interval in zip(varied, known.intervals, strict=True):
            if not interval.told:
                notes.append(f"not told by these channels: {var.name}: its interval is no narrower than before")
            notes += [f"{var.name}: its interval reaches the {end} bound" for end in interval.at_bound]
        notes += [f"told together only: {', '.join(group)}: {self._pairs(group)}" for group in known.groups]
        for direction in known.directions:
            shares = " ".join(f"{share:+.2f} {name}" for name, share in direction.items())
            notes.append(f"the channels tell less than was known before, in standard deviations of that, of: {shares}")
        for i, target in known.uneven:
            notes.append(
                f"{target.label} jumps or bends over {varied[i].name} near its value: interval and value rest on "
                "derivatives that do not hold; leave it out, or give it more noise"
            )
        if known.misfit > 1.2:
            factor = formatted(known.misfit**0.5, ".2g")
            notes.append(
                f"the residual is {factor} times the noise: the intervals are wider by that; the model lacks something"
            )
        if not fit.converged:
            notes.append("not converged: more iterations, or other bounds")
        return notes

    def _pairs(self, group: Sequence[str]) -> str:
        names = [var.name for var in self.fit.calibration.candidates.varied]
        positions = [names.index(name) for name in group]
        pairs = [(i, j) for i, j in combinations(positions, 2) if abs(self.known.correlation[i, j]) >= TOGETHER]
        return ", ".join(f"correlation {self.known.correlation[i, j]:.2f}" for i, j in pairs)

    @property
    def sentence(self) -> str:
        """The outcome in one sentence."""
        told = sum(interval.told for interval in self.known.intervals)
        ending = "" if self.fit.converged else "; NOT CONVERGED"
        share = f"{told} of {len(self.known.intervals)} keys are told by the measurement"
        return f"{share}; {self.fit.candidates} candidates{ending}"

    def numbers(self) -> dict[str, Any]:
        """Content of ``calibration.json``."""
        fit, known, rows = self.fit, self.known, as_records(self.keys_table())
        return {
            "title": fit.calibration.candidates.title, "converged": fit.converged, "outcome": self.sentence,
            "confidence_percent": fit.calibration.spec.confidence_percent, "narrower": NARROWER,
            "keys": [row | {"told": interval.told} for row, interval in zip(rows, known.intervals, strict=True)],
            "series": as_records(self.targets_table()), "notes": self.notes(), "misfit": known.misfit,
            "degrees_of_freedom": known.freedom, "correlation": known.correlation.tolist(),
            "directions": list(known.directions), "together": [list(group) for group in known.groups],
            "shifts": {name: shift.value for name, shift in fit.shifts.items()},
            "rounds": fit.rounds, "candidates": fit.candidates,
        }  # fmt: skip

    def figures(self) -> Makers:
        """Pictures by their names: measured and model, before and after; intervals."""
        panels = [
            Panel(
                with_unit(t.label, t.shown.symbol), t.across,
                {"measured": (t.place, t.shown.factor * t.measured), "model, before": (t.place, t.shown.factor * first),
                 "model, calibrated": (t.place, t.shown.factor * last)},
            )
            for t, first, last in zip(self.fit.targets, self.before, self.after, strict=True)
        ]  # fmt: skip
        spec = self.fit.calibration.spec
        bars = {}
        for var, key, interval in zip(
            self.fit.calibration.candidates.varied, spec.vary, self.known.intervals, strict=True
        ):
            before = (var.low, var.high)
            if key.prior is not None and key.tolerance is not None:
                before = (key.prior - key.tolerance, key.prior + key.tolerance)
            bars[var.name] = (before, (interval.low, interval.high), interval.value, interval.told)
        return {
            "calibration": partial(lines_figure, "Measured and model, before and after", panels),
            "intervals": partial(
                intervals_figure, f"What was known before, and intervals of {spec.confidence_percent:g} %", bars
            ),
        }

    def write(self, folder: Path, page: str) -> list[Path]:
        """Write report, table and page, and scenarios, vehicle and wheel with the calibrated values."""
        candidates, percent = self.fit.calibration.candidates, self.fit.calibration.spec.confidence_percent
        values = candidates.values(self.fit.values(self.fit.optimum))
        remarks = [f"wrsim calibrate {candidates.source.file.name}: {self.sentence}"]
        for var, interval in zip(candidates.varied, self.known.intervals, strict=True):
            ends = f"{interval.low:.5g} to {interval.high:.5g} at {percent:g} %"
            source = "from the measurement" if interval.told else "not told by the measurement"
            remarks.append(f"{', '.join(var.keys)}: {var.start:.5g} -> {interval.value:.5g} ({ends}), {source}")
        files = [
            write_atomically(folder / REPORT, as_json(self.numbers(), indent=1)),
            write_atomically(folder / TABLE, as_csv(as_rows(self.keys_table()))),
            write_atomically(folder / PAGE, page.encode()),
        ]
        return files + write_changed(folder, KIND, candidates, values, "calibrated", remarks)
