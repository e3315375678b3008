"""Exported files hold the numbers of the result, all of them, as the programs they are made for read them."""

import logging
import math
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy.io import loadmat
from support.commands import ok, refusal
from support.runs import FAST, SCENARIOS
from support.synthetic_result import static_poses

from wrsim import Result, load, run
from wrsim.results import CHANNELS, exports
from wrsim.results.exports import export_result
from wrsim.results.tables import frame

SHOWN = {
    "kN": ("N", 1e3), "mm": ("m", 1e-3), "mrad": ("rad", 1e-3), "°": ("rad", math.pi / 180.0), "MPa": ("Pa", 1e6),
    "mm²": ("m2", 1e-6), "km/h": ("m/s", 1.0 / 3.6), "kJ": ("J", 1e3), "kW": ("W", 1e3), "kNm": ("N m", 1e3),
    "1/km": ("1/m", 1e-3), "m/s²": ("m/s2", 1.0), "µm": ("m", 1e-6), "nm": ("m", 1e-9), "t": ("kg", 1e3),
    "‰": ("1", 1e-3),
}  # fmt: skip
"""Units for readers: the unit of SI, and how much of it one is."""

SUFFIXES = {channel.shown.suffix for channel in CHANNELS.values()}
"""How units end the names of columns."""


def coach() -> xr.Dataset:
    """A vehicle that has run a few steps: wheelsets, bodies, points, suspension, strips."""
    keys = {"run.start_distance_m": 150.0, "run.time_s": 0.03, "output.patches_at_m": [150.2]}
    return run(load(SCENARIOS / "manchester_r300.toml").with_values(FAST | keys)).dataset


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result with its exports."""
    for library in ("pyarrow", "asammdf"):
        pytest.importorskip(library)
    folder = tmp_path_factory.mktemp("run")
    Result(coach()).save(folder / "result.nc")
    ok("export", folder, "--to", "mat,csv,parquet,mdf")
    return folder


@pytest.fixture(scope="module")
def dataset(folder: Path) -> xr.Dataset:
    return Result.load(folder).dataset


@pytest.fixture(scope="module")
def samples(dataset: xr.Dataset) -> dict[tuple[str, ...], xr.Variable]:
    """Every row of numbers or words over the samples, by the words of its name: channel, wheelset, wheel, ..."""
    rows = {}
    names = {dim: [str(label).replace(" ", "_") for label in dataset[dim].values] for dim in dataset.dims}
    for name, data in dataset.variables.items():
        if data.dims[:1] == ("time",) and "strip" not in data.dims:
            inner_dims = data.dims[1:]
            for place in product(*(range(dataset.sizes[dim]) for dim in inner_dims)):
                indices = dict(zip(inner_dims, place, strict=True))
                rows[str(name), *(names[dim][i] for dim, i in indices.items())] = data.isel(indices)
    assert len(rows) > 30
    return rows


def in_si(values: Any, unit: str, variable: xr.Variable) -> np.ndarray[Any, np.dtype[Any]]:
    """Values of a column in the SI unit of its channel, whose unit must be that one."""
    si, size = SHOWN.get(unit, (unit, 1.0))
    assert si == variable.attrs["units"], (si, variable.attrs)
    return np.asarray(values, dtype=float) * size


def test_matlab_gets_every_channel_with_its_dimensions(folder: Path, dataset: xr.Dataset) -> None:
    exported = loadmat(folder / "result.mat", squeeze_me=False, struct_as_record=False)
    channels, units, dimensions = (exported[part][0, 0] for part in ("channels", "units", "dimensions"))
    for name, variable in dataset.variables.items():
        cells, values = getattr(channels, str(name)), variable.values
        is_text = values.dtype.kind in "UO"
        shape = values.shape if values.ndim > 1 else (values.size, 1)
        if is_text:
            assert [cell.item() if cell.size else "" for cell in cells.ravel()] == [str(w) for w in values.ravel()], (
                name
            )
        else:
            np.testing.assert_array_equal(cells, values.reshape(shape), err_msg=str(name))
        assert "".join(getattr(units, str(name)).ravel()) == variable.attrs.get("units", "")
        assert [cell.item() for cell in getattr(dimensions, str(name)).ravel()] == list(variable.dims)
    assert exported["about"][0, 0].title.item() == dataset.attrs["title"]


def test_the_table_has_a_column_for_every_row_of_samples(folder: Path, samples: dict[tuple[str, ...], Any]) -> None:
    """Each number of the text, ten digits, is that of the result; and there is no other column."""
    units = frame(Result.load(folder).dataset).attrs["units"]
    table = pd.read_csv(folder / "result.csv", keep_default_na=False, na_values=[""])
    left = set(table.columns)
    for label, variable in samples.items():
        name = "_".join(label)
        (column,) = left & {name, *(f"{name}_{suffix}" for suffix in SUFFIXES)}
        left.remove(column)
        if variable.dtype.kind in "UO":
            assert ["" if w != w else str(w) for w in table[column]] == [str(w) for w in variable.values], column
            continue
        values = in_si(table[column], units.get(column, "1"), variable)
        np.testing.assert_allclose(values, variable.values, rtol=1e-9, atol=0.0, err_msg=column)
    assert not left


def test_parquet_holds_the_same_table_to_the_bit(folder: Path, samples: dict[tuple[str, ...], Any]) -> None:
    table = pytest.importorskip("pyarrow.parquet").read_table(folder / "result.parquet")
    table_of = frame(Result.load(folder).dataset)
    assert table.column_names == list(table_of.columns) and len(table_of.columns) == len(samples)
    for name in table.column_names:
        np.testing.assert_array_equal(table[name].to_numpy(), table_of[name].to_numpy(), err_msg=name)
        unit = table.schema.field(name).metadata[b"unit"].decode()
        assert unit == table_of.attrs["units"].get(name, unit)


@pytest.mark.filterwarnings("ignore")
def test_mdf_holds_every_signal_over_time(folder: Path) -> None:
    table_of, held = frame(Result.load(folder).dataset), set()
    with pytest.importorskip("asammdf").MDF(folder / "result.mf4") as file:
        for group, index in (place for places in file.channels_db.values() for place in places):
            signal = file.get(group=group, index=index)
            held.add(signal.name)
            if signal.name not in ("time", "t"):
                np.testing.assert_array_equal(signal.samples, table_of[signal.name].to_numpy(), err_msg=signal.name)
                np.testing.assert_array_equal(signal.timestamps, table_of["time_s"].to_numpy())
                assert signal.unit == table_of.attrs["units"].get(signal.name, signal.unit)
    assert held - {"time", "t"} == set(table_of.columns) - {"time_s"}


def test_what_cannot_be_exported_is_one_sentence(tmp_path: Path) -> None:
    Result(static_poses()).save(tmp_path / "result.nc")
    answer = refusal("export", tmp_path, "--to", "matt")
    assert "'matt' is none of mat, csv, parquet, mdf, tables (did you mean 'mat'?)" in answer
    assert "MDF keeps signals over time" in refusal("export", tmp_path, "--to", "mdf")


def test_words_in_an_exported_table_are_no_formulas(tmp_path: Path) -> None:
    dataset = static_poses().copy()  # it is kept for others
    dataset["pose"] = [f"=1+{i}" for i in range(dataset.sizes["pose"])]
    export_result(Result(dataset), "csv", tmp_path)
    assert list(pd.read_csv(tmp_path / "result.csv")["pose"])[:2] == ["'=1+0", "'=1+1"]


def test_large_tables_are_written_on_request(folder, tmp_path, monkeypatch, caplog):
    """The same bytes as those beside a small result."""
    result = Result.load(folder)
    usual = exports.write_run(result, tmp_path / "usual")[2:]
    assert usual and not caplog.messages
    monkeypatch.setattr(exports, "LARGEST", result.dataset.nbytes - 1)
    with caplog.at_level(logging.WARNING, "wrsim"):
        written = exports.write_run(result, tmp_path / "large")
    assert [path.name for path in written] == ["result.nc", "summary.json"]
    assert f"wrsim export {tmp_path / 'large/result.nc'} --to tables" in caplog.text
    ok("export", tmp_path / "large", "--to", "tables")
    for path in usual:
        assert (tmp_path / "large" / path.relative_to(tmp_path / "usual")).read_bytes() == path.read_bytes()
