"""Register, dataset, file, tables and summary of a result."""

import csv
import io
import json
import os
import re
import sys
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr
from support.rows import rows_of
from support.runs import FAST, LEADING, setup_of, straight
from support.synthetic_result import curve_run, static_poses
from support.synthetic_run import run as synthetic_run

from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.monitor import Monitor
from wrsim.analysis.motion.run import recorded_run
from wrsim.assessment.limits import QUANTITY_NAMES
from wrsim.errors import InputError, WrsimError
from wrsim.report.output_folder import read
from wrsim.results import CHANNELS, Result, assemble, netcdf, summarise, write_atomically, write_run
from wrsim.results.channels import NAMES
from wrsim.results.files import Manifest, as_csv
from wrsim.results.netcdf import read_netcdf, write_netcdf
from wrsim.results.run_file import RunFile
from wrsim.results.summary import OF_WHEELSET, PEAKS
from wrsim.results.table import Column, Table, ValueAt, as_html, as_records, as_rows, as_text, formatted, quantity
from wrsim.results.tables import tables
from wrsim.scenario.build import Setup
from wrsim.simulation import recorder
from wrsim.simulation.integrate import Integration
from wrsim.simulation.placement import design_state
from wrsim.simulation.recorder import Recorder
from wrsim.simulation.system import BodySystem
from wrsim.study.spec import ChannelOutput

table = rows_of(__file__)

ATTRIBUTES = {"title": "t", "analysis": "curving", "status": "completed", "scenario_text": "x = 1\n"}
EVERY = ["curve", "stopped", "static", "one wheel"]


def the_wheelset(dataset: xr.Dataset) -> xr.Dataset:
    return Result(dataset).wheelset()


def dataset_of(kind: str) -> xr.Dataset:
    return {
        "curve": lambda: curve_run(),
        "stopped": lambda: curve_run(stopped=True),
        "static": lambda: static_poses(),
        "one wheel": lambda: static_poses((0.0, 5.5, 6.0, 7.0), (0.0,), ("left",), 24e3),
    }[kind]()


@pytest.fixture(scope="module")
def written(tmp_path_factory) -> dict[str, Path]:
    """Directories of written results by kind."""
    directories = {}
    for kind in EVERY:
        directories[kind] = tmp_path_factory.mktemp(kind.replace(" ", "_"))
        write_run(Result(dataset_of(kind)), directories[kind])
    return directories


def test_units_for_readers_agree_with_si_units():
    si = {"s": "s", "m": "m", "mm": "m", "um": "m", "mm2": "m2", "kmh": "m/s", "per_km": "1/m", "per_m": "1/m"}
    si |= {"rad_s": "rad/s", "mrad": "rad", "deg": "rad", "N": "N", "kN": "N", "Nm": "N m", "kNm": "N m", "MPa": "Pa"}
    si |= {"permille": "1", "": "1", "m_s": "m/s", "m_s2": "m/s2", "t": "kg"}
    si |= {"Hz": "Hz", "per_s": "1/s", "kW": "W", "kJ": "J", "C": "degC"}
    si |= {"um_per_km": "1", "g_per_km": "kg/m", "N_per_mm": "N/m", "nm": "m"}
    for c in CHANNELS.values():
        assert si[c.shown.suffix] == c.unit, c.name
    assert CHANNELS["p0"].shown.factor == 1e-6
    assert CHANNELS["contact_angle"].shown.factor == pytest.approx(180.0 / np.pi)


@pytest.mark.parametrize("kind", EVERY)
def test_every_variable_carries_its_unit_and_its_long_name(kind):
    for name, variable in dataset_of(kind).variables.items():
        assert variable.attrs["units"] == CHANNELS[str(name)].unit
        assert variable.attrs["long_name"] == CHANNELS[str(name)].long_name


def test_arrays_are_copied_scalars_fill_their_channel_and_counts_become_integers():
    shift = np.zeros(3)
    dataset = assemble({"time": np.arange(3.0)}, {"lateral_shift": shift}, ATTRIBUTES)
    shift[:] = 1.0
    assert (dataset["lateral_shift"] == 0.0).all()
    channels = {"speed": 15.0, "n_patches": np.array([[1.0, np.nan], [2.0, 0.0]])}
    dataset = assemble({"time": [0.0, 1.0]}, channels, ATTRIBUTES)
    assert dataset["speed"].values.tolist() == [15.0, 15.0]
    assert dataset["n_patches"].dtype == np.int64
    assert dataset["n_patches"].values.tolist() == [[[1, 0]], [[2, 0]]]


def test_the_quotient_and_the_variation_of_the_contact_angle_are_derived():
    low, high = np.full((2, 2, 3), 0.1), np.full((2, 2, 3), 0.3)
    channels = {
        "Y": [[1.0, 2.0], [3.0, 4.0]],
        "Q": [[2.0, 0.0], [np.nan, -1.0]],
        "contact_angle_min": low,
        "contact_angle_max": high,
    }
    dataset = the_wheelset(assemble({"time": [0.0, 1.0]}, channels, ATTRIBUTES))
    np.testing.assert_array_equal(dataset["Y_over_Q"], [[0.5, np.nan], [np.nan, np.nan]])
    np.testing.assert_array_equal(dataset["contact_angle_variation"], high - low)


@pytest.mark.parametrize(
    ("coords", "channels", "attributes", "message"), table("a_mistake_of_the_calling_code_is_named")
)
def test_a_mistake_of_the_calling_code_is_named(coords, channels, attributes, message):
    with pytest.raises(ValueError, match=message):
        assemble(coords, channels, ATTRIBUTES | attributes)


@pytest.mark.parametrize("kind", EVERY)
def test_a_result_written_and_read_back_is_identical(kind, written):
    dataset = dataset_of(kind)
    again = Result.load(written[kind] / "result.nc")
    xr.testing.assert_identical(again.dataset, dataset)
    assert {n: v.dtype for n, v in again.dataset.variables.items()} == {
        n: v.dtype for n, v in dataset.variables.items()
    }


def test_a_run_without_a_sample_makes_tables_and_is_refused_where_it_is_read(tmp_path):
    """No analysis ends so: they raise."""
    stop = {"status": "stopped", "stop_reason": "no equilibrium", "stop_time_s": 0.0, "stop_distance_m": 0.0}
    channels = {"distance": [], "lateral_shift": [], "N": np.zeros((0, 2, 3))}
    dataset = assemble({"time": []}, channels, ATTRIBUTES | stop)
    result = Result(dataset)
    assert {p.name for p in write_run(result, tmp_path)} >= {"result.nc", "summary.json", "history.csv"}
    with pytest.raises(InputError, match=r"result\.nc: .* its time is empty"):
        Result.load(tmp_path)
    assert result.summary()["wheelsets"]["wheelset"]["lateral_shift_max_mm"] is None


def test_datasets_without_strips_make_tables_and_long_texts_survive(tmp_path):
    dataset = assemble({"time": [0.0, 1.0]}, {"distance": [0.0, 1.0], "yaw": [0.0, np.nan]}, ATTRIBUTES)
    assert tables(dataset) == {"history": [["time_s", "distance_m", "yaw_mrad"], ["0", "0", "0"], ["1", "1", ""]]}
    text = "# über 64 kB\n" * 10000
    dataset = assemble({"time": [0.0]}, {"distance": [0.0]}, ATTRIBUTES | {"scenario_text": text})
    assert Result.load(Result(dataset).save(tmp_path / "r.nc")).dataset.attrs["scenario_text"] == text


@pytest.mark.parametrize("share", [0.0, 0.001, 0.3, 0.9, 0.9999])
def test_a_truncated_file_gives_one_sentence(share, written, tmp_path):
    whole = (written["curve"] / "result.nc").read_bytes()
    cut = tmp_path / "cut.nc"
    cut.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(InputError, match=r"cut\.nc: not a wrsim result") as problem:
        Result.load(cut)
    assert "\n" not in str(problem.value)


@pytest.mark.parametrize("share", [0.01, 0.2, 0.5, 0.999])
def test_a_single_wrong_bit_is_found(share, written, tmp_path):
    content = bytearray((written["static"] / "result.nc").read_bytes())
    content[int(share * len(content))] ^= 4
    (tmp_path / "result.nc").write_bytes(bytes(content))
    with pytest.raises(InputError, match="damaged"):
        Result.load(tmp_path)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda d: d.drop_vars("wheelset"), "has no wheelset"),
        (lambda d: d.drop_vars("Q").assign(Q=("time", d["time"].values)), "its Q is laid out along (time)"),
        (lambda d: d.assign_attrs(status="fine"), "its status is 'fine', none of completed, stopped"),
        (lambda d: d.assign_attrs(title=3), "has no title"),
        (lambda d: d.isel(time=slice(0, 0)), "its time is empty"),
        (lambda d: d.isel(time=slice(None, None, -1)), "its time does not increase"),
        (lambda d: d.assign_coords(distance=d["distance"] * np.nan), "its distance is not finite everywhere"),
        (lambda d: d.assign(Q=d["Q"].astype(str)), ", must be float64"),
        (lambda d: d.assign(odd=d["Q"]), "has 'odd', which is no channel"),
        (lambda d: d.drop_vars("snapshot_time"), "has snapshot_distance and no snapshot_time"),
        (lambda d: d.drop_vars("Q"), "has Y and no Q"),
        (lambda d: d.assign_attrs(step_s="x"), "its step_s is 'x', must be a number"),
        (lambda d: d.assign_attrs(law=np.arange(3.0)), "its law is array([0., 1., 2.]), must be a number or a text"),
        (lambda d: d.assign_attrs(format_version="two"), "has no format"),
    ],
)
def test_a_file_that_says_it_is_ours_and_lacks_what_readers_need_is_refused(spoil, message, tmp_path):
    path = Result(spoil(curve_run(samples=40))).save(tmp_path / "result.nc")
    with pytest.raises(InputError, match=re.escape(message)):
        Result.load(path)


@pytest.mark.parametrize("name", ["stop_reason", "step_s", "steps"])
def test_a_result_that_does_not_say_all_of_its_run_has_a_summary(name):
    dataset = dataset_of("stopped").assign_attrs(integrator="x", step_s=0.001)
    dataset.attrs.pop(name, None)
    assert summarise(dataset)["status"] == "stopped"


def test_files_that_are_not_ours_and_places_that_are_no_directory_are_refused(tmp_path):
    with pytest.raises(InputError, match="no such result file"):
        Result.load(tmp_path / "missing.nc")
    (tmp_path / "text.nc").write_text("time,N\n0,1\n")
    with pytest.raises(InputError, match="not a wrsim result"):
        Result.load(tmp_path / "text.nc")
    xr.Dataset({"a": ("x", [1.0])}).to_netcdf(tmp_path / "other.nc", engine="netcdf4")
    with pytest.raises(InputError, match="not a wrsim result, or its checksum is missing"):
        Result.load(tmp_path / "other.nc")
    newer = dataset_of("one wheel").assign_attrs(format_version=99)
    with pytest.raises(InputError, match="newer wrsim"):
        Result.load(Result(newer).save(tmp_path / "newer.nc"))
    (tmp_path / "taken").write_text("")
    with pytest.raises(WrsimError, match="a part of this path is a file"):
        write_atomically(tmp_path / "taken" / "result.nc", b"")
    (tmp_path / "result.nc").mkdir()
    with pytest.raises(WrsimError, match="is a directory; a file of that name is written"):
        write_atomically(tmp_path / "result.nc", b"")


def read_table(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


@pytest.mark.parametrize("kind", EVERY)
def test_numbers_in_the_patch_table_are_those_of_the_dataset(kind, written):
    dataset = the_wheelset(dataset_of(kind))
    rows = read_table(written[kind] / "patches.csv")
    sample = "time" if "time" in dataset.dims else "pose"
    labels, wheels = dataset[sample].values, dataset["wheel"].values.tolist()
    names = ("N", "p0", "area", "contact_angle", "contact_angle_variation", "approach", "xi")
    values = {
        name: dataset[name].transpose(sample, "wheel", "patch").values * CHANNELS[name].shown.factor for name in names
    }
    for row in rows:
        if sample == "time":
            i = int(np.argmin(np.abs(labels - float(row["time_s"]))))
        else:
            i = int(np.flatnonzero(labels == row["pose"])[0])
        for name in names:
            value = float(values[name][i, wheels.index(row["wheel"]), int(row["patch"])])
            cell = row[CHANNELS[name].column]
            assert (cell == "") == np.isnan(value)
            if cell:
                assert float(cell) == pytest.approx(value, rel=1e-9)
    in_contact = int(np.isfinite(dataset["N"]).sum())
    without = int(np.isnan(dataset["N"].isel(patch=0)).sum()) if sample == "pose" else 0
    assert len(rows) == in_contact + without


@pytest.mark.parametrize("kind", ["stopped", "static"])
def test_tables_do_not_depend_on_how_many_instants_are_written_at_once(kind, written, monkeypatch):
    size = dataset_of(kind).sizes.get("time", 0)
    monkeypatch.setattr(sys.modules["wrsim.results.tables"], "BLOCK", 7)
    assert kind == "static" or (size > 7 and size % 7)  # several blocks, the last one not full
    for name, rows in tables(dataset_of(kind)).items():
        with (written[kind] / f"{name}.csv").open(newline="") as stream:
            assert list(csv.reader(stream)) == rows


@pytest.mark.parametrize("kind", EVERY)
def test_the_strip_table_sums_up_to_the_normal_force(kind, written):
    dataset = dataset_of(kind)
    rows = read_table(written[kind] / "strips.csv")
    total = sum(float(row["strip_N_N"]) for row in rows)
    assert total == pytest.approx(float(dataset["strip_N"].sum()), rel=1e-9)
    assert len(rows) == int(np.isfinite(dataset["strip_p"]).sum())


@pytest.mark.parametrize("kind", EVERY)
def test_the_summary_is_plain_json_and_matches_the_dataset(kind, written):
    dataset = dataset_of(kind)
    summary = json.loads((written[kind] / "summary.json").read_text())
    assert summary == json.loads(json.dumps(Result(dataset).summary()))
    assert summary["status"] == dataset.attrs["status"]
    assert summary["versions"]["wrsim"] == dataset.attrs["wrsim_version"]
    for wheel, peaks in summary["wheelsets"]["wheelset"]["wheels"].items():
        of_wheel = dataset.sel(wheel=wheel)
        assert peaks["Q_max_kN"]["value"] == pytest.approx(float(of_wheel["Q"].max()) / 1e3)
        assert peaks["Q_min_kN"]["value"] == pytest.approx(float(of_wheel["Q"].min()) / 1e3)
        assert peaks["p0_max_MPa"]["value"] == pytest.approx(float(of_wheel["p0"].max()) / 1e6)
        angle = float(np.degrees(of_wheel["contact_angle_max"].max()))
        assert peaks["contact_angle_max_deg"]["value"] == pytest.approx(angle)


def test_a_peak_and_each_of_its_rows_say_where_it_is():
    dataset = the_wheelset(curve_run())
    summary = Result(curve_run()).summary()["wheelsets"]["wheelset"]
    peak = summary["wheels"]["right"]["Y_over_Q_max"]
    index = int(np.argmax(dataset["Y_over_Q"].sel(wheel="right").values))
    assert peak["distance_m"] == float(dataset["distance"][index])
    assert peak["time_s"] == float(dataset["time"][index])
    shift = summary["lateral_shift_max_mm"]["value"]
    assert shift == pytest.approx(1e3 * float(dataset["lateral_shift"].min()))  # the left curve pushes to the right
    # one entry of PEAKS makes the number in summary.json and the row in every table
    result = Result(curve_run())
    peaks = result.numbers()[0]
    of_wheel = result.summary()["wheelsets"]["wheelset"]["wheels"]["right"]
    known = {key for key in of_wheel if of_wheel[key]["value"]}
    assert len(peaks.rows) == len(known)
    assert all(isinstance(cell, ValueAt) and cell.place.endswith(" m") for row in peaks.rows for cell in row[1:])


def test_peaks_below_20_hz_and_over_2_m_stand_beside_raw_ones_and_both_are_named() -> None:
    """1 Hz passes, 100 Hz does not; a mean over 2 m is one over 0.1 s here. Without load there is no Y/Q nearby."""
    mean = np.sin(0.1 * np.pi) / (0.1 * np.pi)

    def lateral(s):
        return 10e3 * np.sin(2.0 * np.pi * s / 20.0) + 5e3 * np.sin(2.0 * np.pi * 5.0 * s), 0.0 * s

    def vertical(s):
        return np.where(s < 300.0, 50e3, -1e3), 50e3 + 0.0 * s

    result = synthetic_run(y=lateral, q=vertical)
    wheelset = result.summary()["wheelsets"]["wheelset"]
    left = wheelset["wheels"]["left"]
    assert left["Y_max_kN"]["value"] > 14.0
    assert left["Y_max_20Hz_kN"]["value"] == pytest.approx(10.0, rel=1e-3)
    assert abs(wheelset["sum_Y_max_20Hz_2m_kN"]["value"]) == pytest.approx(10.0 * mean, rel=1e-3)
    assert left["Y_over_Q_max_20Hz_2m"]["value"] == pytest.approx(0.2 * mean, rel=5e-3)
    assert left["Y_over_Q_max_20Hz_2m"]["distance_m"] < 300.0
    labels = [row[0] for table in result.numbers() for row in table.rows]
    assert {"max Y, raw [kN]", "max Y, 20 Hz [kN]", "max Y/Q, 20 Hz, 2 m"} <= {*labels}
    assert "max Y [kN]" in [row[0] for table in Result(static_poses()).numbers() for row in table.rows]


def test_poses_are_listed_with_their_patches_and_patches_csv_has_the_same() -> None:
    poses = Result(static_poses((0.0, 5.5, 6.0, 7.0), (0.0,), ("left",), 24e3))
    listed = poses.numbers()[0]
    rows = csv.DictReader(io.StringIO(as_csv(tables(poses.dataset)["patches"]).decode()))
    written = [row for row in rows if row["N_kN"]]
    heads = [column.key or column.label for column in listed.columns]
    numbers = ["N_kN", "p0_MPa", "n_strips", "width_mm", "contact_angle_min_deg", "contact_angle_max_deg"]
    assert heads[0] == "pose" and heads[-6:] == numbers
    assert len(listed.rows) == len(written) >= 4
    for row, texts in zip(listed.rows, written, strict=True):
        assert row[0] == texts["pose"]
        assert row[-6:] == pytest.approx([float(texts[name]) for name in numbers], rel=1e-8)


def test_quasi_static_values_are_medians_in_the_full_curve():
    dataset = the_wheelset(curve_run())
    (curve,) = Result(curve_run()).summary()["wheelsets"]["wheelset"]["full_curves"]
    assert curve["radius_m"] == pytest.approx(300.0)
    assert curve["cant_mm"] == pytest.approx(60.0)
    assert curve["from_m"] == pytest.approx(70.0, abs=2.0)
    assert curve["to_m"] == pytest.approx(190.0, abs=2.0)
    half = (dataset["distance"] >= 0.5 * (curve["from_m"] + curve["to_m"]) - 1.0) & (
        dataset["distance"] <= curve["to_m"]
    )
    expected = float(dataset["Q"].sel(wheel="right").where(half).median()) / 1e3
    assert curve["right"]["Q_kN"] == pytest.approx(expected, rel=1e-3)


def test_every_hand_of_an_s_curve_is_found_and_straight_track_has_none():
    distance = np.linspace(0.0, 400.0, 801)
    curvature = np.interp(distance, [50, 80, 150, 210, 300, 330], [0.0, 1 / 200, 1 / 200, -1 / 250, -1 / 250, 0.0])
    channels = {"distance": distance, "curvature": curvature, "lateral_shift": 0.0}

    def full_curves(channels: dict) -> list[dict]:
        return summarise(assemble({"time": distance}, channels, ATTRIBUTES))["wheelsets"]["wheelset"]["full_curves"]

    curves = full_curves(channels)
    assert [round(c["radius_m"], 6) for c in curves] == [200.0, -250.0]
    assert full_curves(channels | {"curvature": 0.0}) == []


def test_a_large_file_keeps_labels_that_no_channel_has(tmp_path, monkeypatch):
    monkeypatch.setattr(netcdf, "LARGE", 500)
    coords = {"x": np.arange(50.0), "lonely": ("y", np.array(["p", "q"]))}
    channels = {name: ("x", i + np.arange(50.0)) for i, name in enumerate("abc")}
    dataset = xr.Dataset(channels, coords=coords, attrs={"title": "three groups"})
    read = read_netcdf(write_netcdf(tmp_path / "a.nc", dataset), "result")
    xr.testing.assert_identical(read.load(), dataset)


def anonymous_memory() -> float:
    """Of this process [bytes]."""
    lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
    return 1024.0 * next(float(line.split()[1]) for line in lines if line.startswith("RssAnon"))


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory is read as Linux tells it")
def test_an_open_result_holds_one_chunk_of_each_variable_and_no_other_file_is_touched(tmp_path, monkeypatch):
    monkeypatch.setattr(netcdf, "LARGE", 500)
    before, chunks = netCDF4.get_chunk_cache(), 8
    values = np.arange(float(chunks * netcdf.CHUNK // 8))
    dataset = xr.Dataset({f"a{i}": ("time", i + values) for i in range(40)})
    room = anonymous_memory()
    read = read_netcdf(write_netcdf(tmp_path / "a.nc", dataset), "result")
    for name, variable in read.items():
        assert variable.encoding["chunksizes"] == (netcdf.CHUNK // 8,)
        assert np.array_equal(variable.values, dataset[name].values)
    assert anonymous_memory() - room < 2.5 * 40 * netcdf.CHUNK < 40 * values.nbytes / 2
    assert netCDF4.get_chunk_cache() == before


def test_a_file_of_an_older_version_is_read_with_room_for_its_larger_chunks(tmp_path, monkeypatch):
    monkeypatch.setattr(netcdf, "LARGE", 500)
    monkeypatch.setattr(netcdf, "CHUNK", 10 * netcdf.CHUNK)
    path = write_netcdf(tmp_path / "a.nc", xr.Dataset({"a": ("time", np.arange(4e5))}))
    monkeypatch.undo()
    monkeypatch.setattr(netcdf, "LARGE", 500)
    opened, caches = xr.open_dataset, []
    monkeypatch.setattr(
        xr, "open_dataset", lambda *a, **k: caches.append(netCDF4.get_chunk_cache()[0]) or opened(*a, **k)
    )
    assert np.array_equal(read_netcdf(path, "result")["a"].values, np.arange(4e5))
    assert caches == [netcdf.CHUNK, netCDF4.get_chunk_cache()[0]]


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9, 0.9999])
def test_the_numbers_of_a_study_are_sealed_too(share, tmp_path):
    path = write_netcdf(tmp_path / "study.nc", xr.Dataset({"Q": ("case", [1.0, 2.0])}))
    assert read_netcdf(path, "study")["Q"].values.tolist() == [1.0, 2.0]
    content = bytearray(path.read_bytes())
    content[int(share * len(content))] ^= 1
    path.write_bytes(bytes(content))
    with pytest.raises(InputError, match=r"study\.nc: .*run the study again|study\.nc: not a wrsim study"):
        read_netcdf(path, "study")


def test_no_cell_of_a_table_is_a_formula_to_a_spreadsheet():
    harmless = ["-1.5", "+2e-3", "-inf", "nan", "", "curve", "a=b", "1-2"]
    formulas = ["=1+1", "+cmd", "-2+3", "@SUM(A1)", "\t=1", "  @A1", '=HYPERLINK("x","y")']
    (header, row, broken) = csv.reader(io.StringIO(as_csv([harmless, formulas, ["a\r=1+1"]]).decode(), newline=""))
    assert header == harmless
    assert row == [f"'{cell}" for cell in formulas]
    assert broken == ["a =1+1"]
    for cell in formulas:  # alone among numbers
        _, (_, alone) = csv.reader(io.StringIO(as_csv([["-2.5e-07", "1e+07"], ["-1", cell]]).decode(), newline=""))
        assert alone == f"'{cell}"


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pipes in folders")
@pytest.mark.parametrize("name", ["result.nc", "result.nc.part"])
def test_a_pipe_in_place_of_a_result_is_refused(name, tmp_path):
    os.mkfifo(tmp_path / name)
    with pytest.raises(InputError, match=rf"{name}: is a pipe"):
        read(tmp_path)
    with pytest.raises(InputError, match="is a pipe"):
        RunFile(tmp_path / name)


@pytest.mark.parametrize(
    "entry",
    [
        b'{"file": "../x"}', b'{"file": 3}', b'{"files": ["/x"]}', b'{"files": ["C:/x"]}', b'{"files": ["C:x"]}',
        rb'{"files": ["\\x"]}', rb'{"files": ["a\\..\\x"]}', rb'{"file": "a\\x"}', b"[" * 100000, b"{",
    ],
)  # fmt: skip
def test_a_manifest_names_files_of_its_own_folder_alone(entry, tmp_path):
    (tmp_path / ".wrsim").write_bytes(entry + b'\n{"file": "a.csv"}\n')
    assert Manifest(tmp_path).entries() == [{"file": "a.csv"}]


# Tables for people: one formatting of numbers on the terminal, in pages, in CSV and JSON files.
TABLE = Table(
    "forces <b>",
    (Column("wheel", key="wheel"), Column("Y", "kN", ".3g", "Y_kN"), Column("of", key="place")),
    [("left", 1234.5678, ValueAt(-0.25, "3.0 m")), ("<i>right</i>", None, ValueAt(None, ""))],
    ("a note & more",),
)


def test_texts_of_a_table_are_the_same_on_the_terminal_and_on_a_page_and_no_markup():
    text, page = as_text([TABLE]), as_html(TABLE)
    for cell in ("1.23e+03", "-0.25 at 3.0 m", "Y [kN]"):
        assert cell in text and cell in page
    assert text.splitlines()[-1] == "a note & more"
    page = as_html(TABLE)
    assert "<i>" not in page and "<b>" not in page and "&lt;i&gt;" in page


def test_files_hold_ten_digits_and_terminals_no_sign_of_a_zero():
    head, left, right = csv.reader(io.StringIO(as_csv(as_rows(TABLE)).decode()))
    assert head == ["wheel", "Y_kN", "place"]
    assert left == ["left", "1234.5678", "-0.25"] and right[1:] == ["", ""]
    assert as_records(TABLE)[0] == {"wheel": "left", "Y_kN": 1234.5678, "place": -0.25}
    assert as_records(TABLE)[1]["Y_kN"] is None
    assert formatted(-1e-9, ".3f") == "0.000"
    assert quantity(-0.0, "mm", ".1f") == "0.0 mm"


@pytest.mark.parametrize("nothing", [None, float("nan"), np.float64("nan"), ValueAt(None, "")])
def test_a_missing_number_is_a_dash(nothing):
    assert formatted(nothing) == "-"


def test_a_row_of_a_curve_never_mixes_two_patches():
    run = curve_run().copy(deep=True)
    for name, value in {"N": 26.5e3, "p0": 2233e6, "contact_angle": np.radians(17.3), "area": 2e-5}.items():
        run[name][{"patch": 1}] = value
    (table,) = (t for t in Result(run).numbers() if t.title.startswith("full curve"))
    second = [row[-4:] for row in table.rows if "second" in row]
    assert len(second) == 2  # one a wheel
    assert all(cells == pytest.approx([26.5, 2233.0, 17.3, 20.0]) for cells in second)


# The numbers of a long run stand on disk: the same numbers, the same files, and memory that does not go with them.
def at_most(monkeypatch: pytest.MonkeyPatch, size: int) -> None:
    """So many bytes may stand in memory."""
    monkeypatch.setattr(netcdf, "LARGE", size)
    monkeypatch.setattr(recorder, "LARGE", size)


@pytest.fixture(scope="module")
def setup() -> Setup:
    return setup_of([straight(6.0)], 20.0, LEADING, values=FAST)


@pytest.fixture
def record(setup: Setup, tmp_path: Path) -> Path:
    """The file of a short run."""
    law = force_law(setup)
    q, q_t = design_state(law, lateral=1e-3)
    path = tmp_path / "result.nc.part"
    file = Recorder.create(path, {"step_s": 1e-3, "start_s": 0.0, "integrator": "generalised-alpha"}, law.size)
    system = BodySystem(law.bodies, law)
    monitor = Monitor(law, 20.0, system.work)
    Integration(system, duration=0.1, step=1e-3, recorder=file, monitor=monitor).run(q, q_t)
    file.close()
    return path


def test_a_result_on_disk_is_the_one_in_memory(setup, record, tmp_path, monkeypatch):
    at_most(monkeypatch, 10**9)
    in_memory = recorded_run(setup, record)
    tables = {f.name: f.read_bytes() for f in write_run(in_memory, tmp_path / "memory") if f.suffix != ".nc"}
    at_most(monkeypatch, 1000)
    on_disk = recorded_run(setup, record)
    assert on_disk.dataset.identical(in_memory.dataset)
    assert tables == {f.name: f.read_bytes() for f in write_run(on_disk, tmp_path / "disk") if f.suffix != ".nc"}
    read = Result.load(tmp_path / "disk")
    assert read.dataset.identical(in_memory.dataset)
    for dataset in (on_disk.dataset, read.dataset):  # reading has left nothing in memory
        assert not any(
            isinstance(dataset[name].variable._data, np.ndarray) for name in ("Y", "p0", "sum_Y", "n_patches")
        )
    twice = Result.load(on_disk.save(tmp_path / "again.nc"))
    assert twice.dataset.identical(read.dataset)
    # Windows removes no file that is open: there it goes with the process
    assert sys.platform == "win32" or not [p for p in tmp_path.rglob("*") if p.name.startswith(".")]


def test_words_of_reports_are_understood_as_names_of_channels() -> None:
    """Of a run's channel and one of poses of the same words the first is meant; a word of several means none."""
    for peak in (*PEAKS.values(), *OF_WHEELSET.values()):
        word = peak.title.partition(",")[0]
        assert NAMES.understood(word) in (peak.channel, word.replace(" ", "_")), word
    channels_of_words = {
        "angle_of_attack": "yaw",
        "Angle of attack": "yaw",
        "L/V": "Y_over_Q",
        "p₀": "p0",
        "y": "Y",
        "y/q": "Y_over_Q",
    }
    assert {word: NAMES.understood(word) for word in channels_of_words} == channels_of_words
    assert NAMES.understood("spring force") is None and '"suspension_fx"' in NAMES.unknown("spring force")
    assert NAMES.among(["attack"]).understood("angle of attack") == "attack"
    assert NAMES.unknown("lateral shft").count('"') == 10 and '"lateral_shift"' in NAMES.unknown("lateral shft")
    output = ChannelOutput(channel="angle_of_attack", reduce="max")
    assert (output.channel, output.column) == ("yaw", "yaw_max_mrad")
    result = Result(curve_run())
    assert result.plot("angle of attack").axes[0].get_ylabel() == result.plot("yaw").axes[0].get_ylabel()
    assert QUANTITY_NAMES.understood("derailment quotient") == "Y_over_Q"
