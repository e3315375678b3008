"""Exported files hold the numbers of the result, as the programs they are made for read them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.io import loadmat
from support.synthetic_result import curve_run, static_poses
from typer.testing import CliRunner

from wrsim.cli import app
from wrsim.results import Result

runner = CliRunner()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run with all its exports."""
    folder = tmp_path_factory.mktemp("run")
    Result(curve_run()).save(folder / "result.nc")
    answer = runner.invoke(app, ["export", str(folder), "--to", "mat,csv"])
    assert answer.exit_code == 0, answer.output
    return folder


def test_matlab_gets_every_channel_with_its_dimensions(folder: Path) -> None:
    dataset = Result.load(folder).dataset
    found = loadmat(folder / "result.mat", simplify_cells=True)
    for name in ("Y", "Q", "p0", "strip_pressure"):
        if name in dataset:
            np.testing.assert_array_equal(found["channels"][name], np.squeeze(dataset[name].values))
            assert found["units"][name] == dataset[name].attrs["units"]
    assert list(found["channels"]["wheel"]) == ["left", "right"]
    assert found["about"]["title"] == dataset.attrs["title"]


def test_the_table_has_a_column_for_every_wheel_in_units_for_readers(folder: Path) -> None:
    dataset = Result.load(folder).dataset
    table = pd.read_csv(folder / "result.csv")
    np.testing.assert_allclose(
        table["Y_wheelset_left_kN"], dataset["Y"].sel(wheel="left").values[:, 0] / 1e3, rtol=1e-9
    )
    np.testing.assert_allclose(table["distance_m"], dataset["distance"].values, rtol=1e-9, atol=1e-9)
    assert len(table) == dataset.sizes["time"]


def test_parquet_holds_the_same_table_with_its_units(folder: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    assert runner.invoke(app, ["export", str(folder), "--to", "parquet"]).exit_code == 0
    table = parquet.read_table(folder / "result.parquet")
    frame = pd.read_csv(folder / "result.csv")
    assert table.column_names == list(frame.columns)
    np.testing.assert_allclose(table["Q_wheelset_right_kN"].to_numpy(), frame["Q_wheelset_right_kN"], rtol=1e-9)
    assert table.schema.field("Q_wheelset_right_kN").metadata[b"unit"] == b"kN"


@pytest.mark.filterwarnings("ignore")
def test_mdf_holds_signals_over_time(folder: Path) -> None:
    asammdf = pytest.importorskip("asammdf")
    answer = runner.invoke(app, ["export", str(folder), "--to", "mdf"])
    assert answer.exit_code == 0, answer.output
    dataset = Result.load(folder).dataset
    with asammdf.MDF(folder / "result.mf4") as file:
        signal = file.get("Y_wheelset_left_kN")
    np.testing.assert_allclose(signal.samples, dataset["Y"].sel(wheel="left").values[:, 0] / 1e3, rtol=1e-12)
    np.testing.assert_allclose(signal.timestamps, dataset["time"].values)
    assert signal.unit == "kN"


def test_what_cannot_be_exported_is_one_sentence(folder: Path, tmp_path: Path) -> None:
    answer = runner.invoke(app, ["export", str(folder), "--to", "matt"])
    assert answer.exit_code == 2 and "'matt' is none of mat, csv, parquet, mdf (did you mean 'mat'?)" in answer.output
    Result(static_poses()).save(tmp_path / "result.nc")
    answer = runner.invoke(app, ["export", str(tmp_path), "--to", "mdf"])
    assert answer.exit_code == 2 and "MDF keeps signals over time" in answer.output
