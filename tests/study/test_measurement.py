"""Measured series: the same from every kind of file, where they belong along a run, and what is refused."""

import re
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from support import synthetic_run

from wrsim.errors import InputError
from wrsim.results import Result
from wrsim.study.measurement.alignment import found_shift, pairs
from wrsim.study.measurement.reading import Record, read_record
from wrsim.study.measurement.sections import RecordSection, SeriesSection

ROWS = np.arange(200)
KM = 12.0 + 1e-3 * ROWS
FORCE = 10.0 + 3.0 * np.sin(0.1 * ROWS)  # kN
HEADER = "km;Y links [kN];ay_m_s2"


def csv(folder: Path, header: str = HEADER, km: np.ndarray = KM) -> Path:
    """A table as a spreadsheet in Germany writes it."""
    columns = np.column_stack([km, FORCE, 0.1 * FORCE])
    lines = [";".join(f"{v:.9g}" for v in row).replace(".", ",") for row in columns]
    file = folder / "measured.csv"
    file.write_text("\n".join([header, *lines]) + "\n")
    return file


def netcdf(folder: Path) -> Path:
    file = folder / "measured.nc"
    with netCDF4.Dataset(file, "w") as written:
        written.createDimension("row", ROWS.size)
        for name, unit, values in (("km", "km", KM), ("Y links [kN]", "kN", FORCE)):
            variable = written.createVariable(name.replace("/", "_"), "f8", ("row",))
            variable.units = unit
            variable[:] = values
    return file


def mdf(folder: Path) -> Path:
    from asammdf import MDF, Signal

    with MDF(version="4.10") as file:
        signals = [("km", "km", KM), ("Y links [kN]", "kN", FORCE)]
        file.append([Signal(v, 0.01 * ROWS, unit=unit, name=name) for name, unit, v in signals])
        return Path(file.save(folder / "measured.mf4", overwrite=True))


LEFT = SeriesSection(series="Y links [kN]", channel="Y", wheel="left")


def record(file: Path, *sections: SeriesSection, **keys) -> Record:
    keys = keys or {"distance": "km", "unit": "km"}
    return read_record(file, "run", RecordSection(file=str(file), **keys), sections or (LEFT,), 20.0)


@pytest.mark.parametrize("written", [csv, netcdf, mdf])
def test_a_series_is_the_same_from_every_kind_of_file(written, tmp_path):
    recorded = record(written(tmp_path))
    assert recorded.axis == "distance"
    assert recorded.clock == pytest.approx(1e3 * KM)
    assert recorded.series[0].values == pytest.approx(1e3 * FORCE)


def test_unit_offset_sign_and_noise_are_those_of_the_file(tmp_path):
    section = SeriesSection(
        series="ay_m_s2", channel="point_ay", point="floor", unit="g", offset=0.5, reversed=True, noise=0.01
    )
    (series,) = record(csv(tmp_path), section).series
    assert series.values == pytest.approx(-9.80665 * (0.1 * FORCE + 0.5))
    assert series.noise == pytest.approx(0.0980665)


@pytest.mark.parametrize(
    "keys, header, message",
    [
        (LEFT.model_copy(update={"series": "Y rechts"}), HEADER, 'has no series "Y rechts"; it has km, Y links'),
        (LEFT.model_copy(update={"unit": "mm"}), HEADER, 'unit "mm" is none of channel Y: [[measured]] unit must be'),
        (LEFT.model_copy(update={"series": "force"}), "km;force;a", "the file states no unit of channel Y"),
        (LEFT.model_copy(update={"low_pass_Hz": 0.2}), HEADER, "is 9.95 s long; a filter at 0.2 Hz needs 15 s"),
        (LEFT.model_copy(update={"low_pass_Hz": 12.0}), HEADER, "has 20 samples a second; 12 Hz needs more than 24"),
    ],
)
def test_what_cannot_be_used_is_refused_in_one_line(keys, header, message, tmp_path):
    with pytest.raises(InputError, match=re.escape(message)) as refused:
        record(csv(tmp_path, header), keys)
    assert "\n" not in str(refused.value)


def test_a_clock_that_runs_backward_is_refused_with_its_line(tmp_path):
    back = KM.copy()
    back[7] = back[5]
    with pytest.raises(InputError, match=r'measured.csv:9: "km" = 12.005 after 12.006: distance must rise'):
        record(csv(tmp_path, km=back))


def run(length: float = 300.0, speed: float = 20.0) -> Result:
    """Forces without a period, so that one shift alone is right."""
    return synthetic_run.run(
        length, speed, 5e-3, y=lambda s: (1e4 * np.sin(s**1.5 / 60.0), 5e3 * np.cos(s / 9.0))
    )  # fmt: skip


def beside(result: Result, shift: float, axis: str, every: float, noise: float = 0.0) -> Record:
    """The left force of a run as it is measured with another zero of the clock and other samples."""
    x, y = result.dataset[axis].values, result.dataset["Y"].values[:, 0, 0]
    clock = np.arange(x[0] + 20.0 * every, x[-1] - 30.0 * every, every)
    values = np.interp(clock, x, y) + noise * np.random.default_rng(1).normal(size=clock.size)
    (series,) = [type("M", (), {"section": LEFT, "values": values, "noise": None})()]
    return Record("run", Path("m.csv"), axis, clock - shift, (series,), shift=0.9 * shift, search=0.2 * abs(shift))


@pytest.mark.parametrize("axis, every, shift", [("distance", 0.25, -70.0), ("time", 0.004, 3.0)])
def test_the_shift_of_the_clock_is_found_again(axis, every, shift):
    clock_shift = found_shift(run().dataset, beside(run(), shift, axis, every, noise=500.0))
    assert clock_shift.value == pytest.approx(shift, abs=0.5 * every)
    assert clock_shift.correlation > 0.99 and not clock_shift.at_end


def test_a_shift_at_the_end_of_the_search_is_told():
    record = beside(run(), -70.0, "distance", 0.25)
    narrow = Record("run", record.file, "distance", record.clock, record.series, shift=-66.0, search=2.0)
    assert found_shift(run().dataset, narrow).at_end


def test_series_and_channel_are_filtered_alike():
    section = LEFT.model_copy(update={"low_pass_Hz": 4.0, "from_m": 50.0, "to_m": 200.0})
    record = beside(run(), -70.0, "distance", 0.1)
    record.series[0].section = section
    (pair,) = pairs(run().dataset, record, -70.0)
    assert pair.place[[0, -1]] == pytest.approx([50.0, 200.0], abs=0.11)
    assert pair.measured == pytest.approx(pair.model, abs=1e-3 * np.abs(pair.model).max())


def test_a_measurement_beside_the_run_is_refused():
    record = beside(run(), -70.0, "distance", 0.25)
    with pytest.raises(InputError, match=r"has no common part with the run: measured .* the run 0 to 300 m"):
        pairs(run().dataset, record, 5000.0)
