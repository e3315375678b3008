"""Measured series on the samples of a run: the shift of their clock, averages, filters."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.signal import correlate, correlation_lags, welch

from wrsim.errors import InputError
from wrsim.register import ANALYSES
from wrsim.results import filters
from wrsim.results.moments import Array
from wrsim.results.table import quantity
from wrsim.scenario.loading import Scenario
from wrsim.study.measurement.reading import Measured, Record, read_record
from wrsim.study.measurement.sections import RecordSection, SeriesSection
from wrsim.study.outputs import chosen_channel
from wrsim.study.plan import FileInput
from wrsim.study.task import begun

DENSER = 1.5
"""Measured samples so many times as dense as those of the run are averaged over the steps of these."""
LINES = 32
"""Lines of a spectrum at least."""
LEAST_PART = 0.5
"""Part of the shorter of run and measurement that has to overlap at a shift."""


class Shift(NamedTuple):
    """What is added to the measured clock [m] or [s]; correlation: of series and channels there, the mean; at_end:
    whether the best one lies at the end of the search."""

    value: float
    correlation: float
    at_end: bool = False


class Pair(NamedTuple):
    """A series beside its channel: places (n,) [m] along the run and on the clock of the series, values (n,) in SI
    units, samples a second."""

    series: Measured
    place: Array
    clock: Array
    model: Array
    measured: Array
    rate: float


def channel_of(dataset: xr.Dataset, section: SeriesSection) -> xr.DataArray:
    """The channel of a series, one number a sample. Raises InputError where the result has none, or several."""
    try:
        data = chosen_channel(dataset, section).squeeze()
    except InputError as error:
        raise InputError(f'[[measured]] "{section.series}": channel = "{section.channel}": {error}') from None
    data = data.expand_dims(dataset[section.channel].dims[0]) if data.ndim == 0 else data
    if data.ndim > 1 or data.dims[0] not in ("time", "pose"):
        several = ", ".join(map(str, data.dims[1:])) or str(data.dims[0])
        raise InputError(f'[[measured]] "{section.series}": channel = "{section.channel}": name one {several}')
    return data


def check_channels(scenario: Scenario, record: Record) -> None:
    """Raise InputError for channels that a run of the scenario has not; the first steps of a run tell."""
    if ANALYSES[scenario.analysis].moves:
        dataset = begun(scenario).dataset
        for each in record.series:
            channel_of(dataset, each.section)
    elif record.axis != "pose":
        raise InputError(f'[[scenario]] "{record.name}": analysis = "{scenario.analysis}" has no {record.axis}')


def record_beside(
    file: FileInput, place: int, name: str, about: RecordSection, sections: Sequence[SeriesSection], scenario: Scenario
) -> Record:
    """The series of a [[scenario]], counted from 0, whose channels a run of it has. Raises InputError."""
    path = file.file_of("scenario", place, "file", name=str(about.file))
    kmh = scenario.spec.vehicle.speed_kmh
    record = read_record(path, name, about, sections, kmh / 3.6 if isinstance(kmh, float) else None)
    check_channels(scenario, record)
    return record


def shift_notes(record: Record, shift: Shift, about: str) -> list[str]:
    """How the clock of a record was shifted, in sentences; about: the record."""
    how = "found by cross-correlation" if record.search else "as given"
    place = quantity(shift.value, record.unit, ".2f" if record.axis == "distance" else ".4f")
    notes = [f"{record.name}: {about}, shift {place} ({how}), correlation {shift.correlation:.3f}"]
    if shift.at_end:
        notes.append(f"{record.name}: the best shift lies at the end of the search: search farther")
    return notes


def clock_of(dataset: xr.Dataset, record: Record) -> Array:
    """Distance [m], time [s] or number of the pose of every sample of a result. Raises InputError for another axis."""
    if (record.axis == "pose") != ("pose" in dataset.dims):
        needed = "poses in order: leave distance and time away" if "pose" in dataset.dims else "distance or time"
        raise InputError(f'[[scenario]] "{record.name}": its result is over {needed}')
    if record.axis != "pose":
        return np.asarray(dataset[record.axis].values)
    if dataset.sizes["pose"] != record.clock.size:
        counts = f"{record.clock.size} rows, the scenario has {dataset.sizes['pose']} poses"
        raise InputError(f"{record.file}: has {counts}: one row for each is needed")
    return np.arange(dataset.sizes["pose"], dtype=float)


def _on_samples(each: Measured, clock: Array, wanted: Array) -> Array:
    """A series at other places of its clock, averaged where it is denser than these; not-a-number beyond its ends."""
    known = np.isfinite(each.values)
    step = float(np.median(np.diff(wanted)))
    x, values = clock[known], each.values[known]
    if step > DENSER * float(np.median(np.diff(x))):
        means = filters.sliding_mean(x, values, np.clip(wanted, x[0], x[-1]), step)
        return np.where((wanted < x[0] + 0.5 * step) | (wanted > x[-1] - 0.5 * step), np.nan, means)
    return np.interp(wanted, x, values, left=np.nan, right=np.nan)


def found_shift(dataset: xr.Dataset, record: Record) -> Shift:
    """The shift of a record: as given, or where series and channels correlate best. Raises InputError."""
    x = clock_of(dataset, record)
    if record.axis == "pose" or x.size < 2:
        return Shift(0.0, np.nan)
    step = float(np.median(np.diff(x)))
    shifts, correlations = _correlations(dataset, record, x, step)
    near = np.abs(shifts - record.shift) <= max(record.search, 0.5 * step) + 1e-9
    shifts, correlations = shifts[near], correlations[near]
    if not np.isfinite(correlations).any():
        raise InputError(f"{record.file}: has no common part with the run: {_ends(record, x, record.shift)}")
    best = int(np.nanargmax(correlations))
    if not record.search:
        return Shift(record.shift, float(correlations[best]))
    at_end = best in (0, shifts.size - 1)
    bend = np.nan if at_end else correlations[best - 1] - 2.0 * correlations[best] + correlations[best + 1]
    move = 0.5 * (correlations[best - 1] - correlations[best + 1]) / bend if bend < 0.0 else 0.0
    return Shift(float(shifts[best] + step * move), float(correlations[best]), at_end)


def _correlations(dataset: xr.Dataset, record: Record, x: Array, step: float) -> tuple[Array, Array]:
    """Shifts on a raster, and there the mean over the series of the coefficient of correlation; not-a-number where run
    and measurement hardly overlap."""
    clock = record.clock + record.shift
    rasters = np.arange(x[0], x[-1], step), np.arange(clock[0], clock[-1], step)
    lags = correlation_lags(rasters[0].size, rasters[1].size)
    total = np.zeros(lags.size)
    for each in record.series:
        channel = channel_of(dataset, each.section).values
        known = np.isfinite(channel)
        a, b = np.interp(rasters[0], x[known], channel[known]), _on_samples(each, clock, rasters[1])
        masks = [np.isfinite(v).astype(float) for v in (a, b)]
        a, b = (np.nan_to_num(v - np.nanmean(v)) for v in (a, b))
        count, sum_a, sum_b = (correlate(*pair) for pair in (masks, (a, masks[1]), (masks[0], b)))
        square_a, square_b, product = (correlate(*pair) for pair in ((a * a, masks[1]), (masks[0], b * b), (a, b)))
        n = np.maximum(np.round(count), 1.0)
        spread = np.maximum(square_a - sum_a**2 / n, 0.0) * np.maximum(square_b - sum_b**2 / n, 0.0)
        total += (product - sum_a * sum_b / n) / np.sqrt(np.maximum(spread, 1e-24 * (a @ a) * (b @ b) + 1e-300))
        total[count * step < LEAST_PART * min(np.ptp(x), np.ptp(clock))] = np.nan
    return record.shift + rasters[0][0] - rasters[1][0] + step * lags, total / len(record.series)


def _ends(record: Record, x: Array, shift: float) -> str:
    ends = f"{record.clock[0] + shift:.6g} to {record.clock[-1] + shift:.6g} {record.unit}"
    return f"measured {ends}, the run {x[0]:.6g} to {x[-1]:.6g} {record.unit}"


def overlap(dataset: xr.Dataset, record: Record, shift: float) -> tuple[xr.Dataset, list[Array]]:
    """The part of a result that was measured, and the unfiltered series (n,) on its samples. Raises InputError."""
    dataset = filters.on_raster(dataset) if "time" in dataset.dims else dataset
    x = clock_of(dataset, record)
    values = [
        _on_samples(each, record.clock + shift, x) if record.axis != "pose" else each.values for each in record.series
    ]
    inside = np.flatnonzero(np.isfinite(values).all(axis=0)) if record.axis != "pose" else np.arange(x.size)
    if inside.size < (filters.LEAST_SAMPLES if record.axis != "pose" else 1):
        raise InputError(f"{record.file}: has no common part with the run: {_ends(record, x, shift)}")
    part = slice(int(inside[0]), int(inside[-1]) + 1)
    return dataset.isel({"pose" if record.axis == "pose" else "time": part}), [v[part] for v in values]


def pairs(dataset: xr.Dataset, record: Record, shift: float) -> list[Pair]:
    """Every series of a record beside its channel, both filtered alike, within from_m and to_m. Raises InputError."""
    part, values = overlap(dataset, record, shift)
    rate = 1.0 if record.axis == "pose" else filters.sampling_rate(part["time"].values)
    clock = clock_of(part, record) if record.axis != "pose" else clock_of(dataset, record)
    place = clock if record.axis == "pose" else part["distance"].values
    compared = []
    for each, measured in zip(record.series, values, strict=True):
        section = each.section
        model = channel_of(part, section).values
        if record.axis != "pose":
            model, measured = (_filtered(v, rate, section) for v in (model, measured))
        low, high = (np.inf * sign if end is None else end for sign, end in ((-1, section.from_m), (1, section.to_m)))
        kept = (place >= low) & (place <= high) & np.isfinite(model) & np.isfinite(measured)
        if not kept.any():
            window = f"from_m = {low:g}, to_m = {high:g}"
            raise InputError(
                f'[[measured]] "{section.series}", {window}: nothing was measured there, or nothing is defined'
            )
        compared.append(Pair(each, place[kept], clock[kept], model[kept], measured[kept], rate))
    return compared


def _filtered(signal: Array, rate: float, section: SeriesSection) -> Array:
    if section.band_Hz is not None:
        return filters.band_pass(signal, rate, *section.band_Hz)
    return signal if section.low_pass_Hz is None else filters.low_pass(signal, rate, section.low_pass_Hz)


def spectral_length(n: int) -> int:
    """Samples of a segment of a spectrum."""
    return max(min(n, 2 * LINES), 2 * n // 4)


def densities(pair: Pair, values: Array) -> tuple[Array, Array]:
    """Frequencies (m,) [Hz] and power spectral density of values at the samples of a pair, without the mean."""
    frequency, density = welch(values, pair.rate, "hann", spectral_length(values.size), detrend="constant")
    return frequency[1:], density[1:]
