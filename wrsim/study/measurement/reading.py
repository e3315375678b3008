"""Measured series in SI units, from CSV, NetCDF and MDF files."""

import re
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from wrsim.errors import InputError, suggest
from wrsim.recording.columns import UNITS as TRACK_UNITS
from wrsim.recording.layout import read_table
from wrsim.recording.reading import column_numbers
from wrsim.results.channels import CHANNELS, SHOWN, Shown
from wrsim.results.filters import LEAST_SAMPLES
from wrsim.results.moments import Array
from wrsim.study.measurement.sections import RecordSection, SeriesSection

NETCDF, MDF = (".nc",), (".mf4", ".mdf", ".dat")
CLOCKS = {"distance": TRACK_UNITS["distance"], "time": {"s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0}}
"""Units of distance and time, and their size; the first where a file says nothing."""
BRACKET = re.compile(r"[\[(]\s*([^\])]+?)\s*[\])]\s*$")
PERIODS = 3.0
"""Periods of its lowest frequency that a filter needs."""


def _names(shown: Shown) -> list[str]:
    return [name for name in (*(key for key, s in SHOWN.items() if s == shown), shown.symbol, shown.suffix) if name]


def _units() -> dict[str, dict[str, float]]:
    units: dict[str, dict[str, float]] = defaultdict(dict)
    for channel in CHANNELS.values():
        units[channel.unit] |= {channel.unit: 1.0} | dict.fromkeys(_names(channel.shown), 1.0 / channel.shown.factor)
    units["m/s2"] |= dict.fromkeys(_names(SHOWN["g"]), 1.0 / SHOWN["g"].factor)
    return units


UNITS = _units()
"""Units of a series by the SI unit of its channel, and their size."""


class RawSeries(NamedTuple):
    """Numbers of a series (n,), its unit as the file states it, empty where it does not."""

    values: Array
    unit: str


@dataclass(frozen=True)
class Measured:
    """A series in the SI unit and the sign of its channel. values (n,), not-a-number where there is none; noise: its
    standard deviation, None where it is not given."""

    section: SeriesSection
    values: Array
    noise: float | None


@dataclass(frozen=True)
class Record:
    """What was measured beside a scenario.

    name: of the scenario; file; axis: "distance", "time" or "pose"; clock (n,) [m] or [s], numbers of rows over poses;
    shift, search [m] or [s]: see `RecordSection`; search is 0 where the shift is given.
    """

    name: str
    file: Path
    axis: str
    clock: Array
    series: tuple[Measured, ...]
    shift: float = 0.0
    search: float = 0.0

    @property
    def unit(self) -> str:
        """Of the clock."""
        return {"distance": "m", "time": "s"}.get(self.axis, "")


def read_record(
    path: Path, name: str, about: RecordSection, sections: Sequence[SeriesSection], speed: float | None = None
) -> Record:
    """The series of a scenario. speed: of the vehicle [m/s], where it is known, for filters of a series over distance.

    Raises InputError that names file, line and series: for series that are not there, units that are none of the
    channel's, a clock that does not rise, and series too short or too coarse for their filter.
    """
    axis = "distance" if about.distance else "time" if about.time else "pose"
    along = about.distance or about.time
    names = [section.series for section in sections]
    raw, lines = _read(path, [*names, *([along] if along else [])], about)
    rows = np.arange(raw[names[0]].values.size, dtype=float)
    clock = rows if along is None else _clock(path, along, raw[along], axis, about.unit, lines)
    series = tuple(_measured(path, section, raw[section.series]) for section in sections)
    per_unit = {"pose": 0.0, "time": 1.0, "distance": speed or 0.0}[axis]
    per_second = per_unit / float(np.median(np.diff(clock))) if per_unit else 0.0
    for each in series if per_second else ():
        _check_filter(path, each.section, per_second, (clock[-1] - clock[0]) / per_unit)
    shift, search = (about.shift_m, about.search_m) if axis == "distance" else (about.shift_s, about.search_s)
    return Record(name, path, axis, clock, series, shift, search or 0.0)


def _read(path: Path, names: Sequence[str], about: RecordSection) -> tuple[dict[str, RawSeries], Sequence[int]]:
    """Series by name, and the line of every row of a text file."""
    if path.suffix.lower() in NETCDF:
        return _of_netcdf(path, names), ()
    if path.suffix.lower() in MDF:
        return _of_mdf(path, names), ()
    table = read_table(path, names.__contains__)
    _check_names(path, names, table.header)
    columns = {
        name: RawSeries(
            column_numbers(path, table, name, name == about.distance, about.unit),
            table.units.get(name, "") or _stated(name),
        )
        for name in names
    }
    return columns, table.lines


def _check_names(path: Path, names: Sequence[str], known: Sequence[str]) -> None:
    for name in names:
        if name not in known:
            raise InputError(f'{path}: has no series "{name}"{suggest(name, known)}; it has {", ".join(known)}')


def _of_netcdf(path: Path, names: Sequence[str]) -> dict[str, RawSeries]:
    import xarray as xr

    try:
        with xr.open_dataset(path, engine="netcdf4", decode_times=False) as dataset:
            variables = {
                str(n): v.load() for n, v in dataset.variables.items() if v.ndim == 1 and v.dtype.kind in "fiu"
            }
    except (OSError, ValueError, RuntimeError) as error:
        raise InputError(f"{path}: cannot be read as NetCDF: {error}") from None
    _check_names(path, names, list(variables))
    series = {n: RawSeries(variables[n].values.astype(float), str(variables[n].attrs.get("units", ""))) for n in names}
    return _equally_long(path, series)


def _of_mdf(path: Path, names: Sequence[str]) -> dict[str, RawSeries]:
    """Signals at the times of the first one."""
    try:
        from asammdf import MDF as File
        from asammdf.blocks.utils import MdfException
    except ImportError:
        raise InputError(f"{path}: MDF needs asammdf: pip install 'wrsim[decide]'") from None
    try:
        with File(path) as file:
            _check_names(path, names, list(file.channels_db))
            signals = [file.get(name) for name in names]
    except (MdfException, OSError, ValueError, KeyError) as error:
        raise InputError(f"{path}: cannot be read as MDF: {error}") from None
    first = signals[0].timestamps
    return {
        name: RawSeries(np.interp(first, s.timestamps, s.samples.astype(float)), str(s.unit))
        for name, s in zip(names, signals, strict=True)
    }


def _equally_long(path: Path, series: dict[str, RawSeries]) -> dict[str, RawSeries]:
    sizes = {name: each.values.size for name, each in series.items()}
    if len(set(sizes.values())) > 1:
        raise InputError(
            f"{path}: series of different lengths: {', '.join(f'{n} {size}' for n, size in sizes.items())}"
        )
    return series


def _stated(name: str) -> str:
    """Unit at the end of a name: ``ay [m/s2]``, ``Q_kN``; empty where there is none."""
    if bracket := BRACKET.search(name):
        return bracket[1]
    suffixes = [shown.suffix for shown in SHOWN.values() if shown.suffix and name.endswith(f"_{shown.suffix}")]
    return max(
        (*suffixes, *(u for units in CLOCKS.values() for u in units if name.endswith(f"_{u}"))), key=len, default=""
    )


def _clock(path: Path, name: str, raw: RawSeries, axis: str, unit: str | None, lines: Sequence[int]) -> Array:
    units = CLOCKS[axis]
    stated = unit or raw.unit or next(iter(units))
    if stated not in units:
        raise InputError(f'{path}: series "{name}": unit "{stated}" is none of {axis}: must be {", ".join(units)}')
    clock = units[stated] * raw.values
    bad = np.flatnonzero(~np.isfinite(clock[1:]) | ~(np.diff(clock) > 0.0))
    if bad.size:
        i = int(bad[0])
        where = f"{path}:{lines[i + 1]}" if lines else f"{path}: sample {i + 1}"
        pair = f"{raw.values[i + 1]:.10g} after {raw.values[i]:.10g}"
        raise InputError(
            f'{where}: "{name}" = {pair}: {axis} must rise from row to row, it stands still or runs backward'
        )
    if clock.size < 2:
        raise InputError(f"{path}: has {clock.size} rows; needs 2 at least")
    return clock


def _measured(path: Path, section: SeriesSection, raw: RawSeries) -> Measured:
    channel = CHANNELS[section.channel]
    units, stated = UNITS[channel.unit], section.unit or raw.unit or ("1" if channel.unit == "1" else "")
    if stated not in units:
        fault = f'unit "{stated}" is none of' if stated else "the file states no unit of"
        must = f"must be {', '.join(units)}"
        raise InputError(f'{path}: series "{section.series}": {fault} channel {channel.name}: [[measured]] unit {must}')
    if not np.isfinite(raw.values).any():
        raise InputError(f'{path}: series "{section.series}": has no numbers')
    size = units[stated] * (-1.0 if section.reversed else 1.0)
    values = size * (raw.values + section.offset)
    return Measured(section, values, None if section.noise is None else units[stated] * section.noise)


def _check_filter(path: Path, section: SeriesSection, rate: float, duration: float) -> None:
    """Raise InputError for a series that its filter cannot work on; rate: samples a second, duration [s]."""
    band = section.band_Hz or (() if section.low_pass_Hz is None else (section.low_pass_Hz,))
    if not band:
        return
    needed = max(PERIODS / band[0], LEAST_SAMPLES / rate)
    place = f'{path}: series "{section.series}"'
    if duration < needed:
        raise InputError(f"{place}: is {duration:.3g} s long; a filter at {band[0]:g} Hz needs {needed:.3g} s")
    if band[-1] >= 0.5 * rate:
        raise InputError(
            f"{place}: has {rate:.4g} samples a second; {band[-1]:g} Hz needs more than {2.0 * band[-1]:g}"
        )
