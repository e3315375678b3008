"""Long results, in parts: the numbers of the whole to the bit, in memory that goes with times and distances alone."""

import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from support.synthetic_result import curve_run

from wrsim.plots import histories, standard_figures
from wrsim.plots.histories import enveloped
from wrsim.results import Result, filters, netcdf, summarise
from wrsim.results.filters import low_pass, low_passed, means_about, sliding_mean

RATE, STEP = 500.0, 0.03  # samples a second, distance of two of them [m]


def long_run(samples: int) -> xr.Dataset:
    """A wheelset through one curve in so many samples."""
    run, place = curve_run(), np.linspace(0.0, 199.0, samples)
    run = run.isel(time=np.rint(place).astype(int))
    of_time, along = np.arange(samples) / RATE, ("time", STEP * np.arange(samples), run["distance"].attrs)
    curvature = ("time", np.interp(place, [20.0, 50.0, 150.0, 180.0], [0.0, 1.0 / 300.0, 1.0 / 300.0, 0.0]))
    run = run.assign_coords(time=("time", of_time, run["time"].attrs), distance=along)
    return run.assign(curvature=(("time", "wheelset"), curvature[1][:, None], run["curvature"].attrs))


def in_small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(netcdf, "LARGE", 500)
    monkeypatch.setattr(netcdf, "CHUNK", 1 << 16)
    monkeypatch.setattr(netcdf, "PART", 1 << 16)
    monkeypatch.setattr(histories, "PART", 1 << 16)
    monkeypatch.setattr(filters, "ROWS", 1000)


@pytest.mark.parametrize("count", [40, 199, 200, 201, 1003])
def test_a_filter_and_a_sliding_mean_in_parts_are_those_of_the_whole_to_the_bit(count, monkeypatch):
    monkeypatch.setattr(filters, "ROWS", 100)
    generator = np.random.default_rng(count)
    signal, place = generator.normal(size=(count, 3)), np.cumsum(generator.uniform(0.01, 0.1, count))
    parts = list(low_passed(lambda first, last: signal[first:last], count, RATE, 20.0))
    whole = low_pass(signal, RATE, 20.0)
    assert np.array_equal(np.concatenate(parts), whole)
    inside = (place >= place[0] + 0.25) & (place <= place[-1] - 0.25)
    means = list(means_about(place, parts, 0.5))
    assert [first for first, _ in means] == np.cumsum([0, *(len(mean) for _, mean in means[:-1])]).tolist()
    slid = np.concatenate([mean for _, mean in means])
    assert np.array_equal(slid[inside], sliding_mean(place, whole, place[inside], 0.5))
    assert np.isnan(slid[~inside]).all()


def test_parts_of_a_result_change_no_number_of_its_summary(monkeypatch, tmp_path):
    run = long_run(2000)
    usual, path = summarise(run), Result(run).save(tmp_path / "result.nc")
    in_small_parts(monkeypatch)
    read = Result.load(path)
    assert sum(1 for _ in netcdf.parts_of(read.dataset.variables["N"])) > 1
    assert read.summary() == usual
    assert Result.load(read.save(tmp_path / "again.nc")).dataset.identical(run)


def test_an_envelope_keeps_every_peak_and_both_ends(monkeypatch):
    run = long_run(4000)
    assert enveloped(run, ("Y",)) is run
    monkeypatch.setattr(histories, "PIECES", 100)
    drawn = enveloped(run, ("Y", "Q", "p0"))
    assert drawn.sizes["time"] == 200 and drawn.sizes["snapshot"] == run.sizes["snapshot"]
    for name in ("Y", "Q", "p0", "curvature", "distance"):
        for end in (np.fmin, np.fmax):
            ends = (end.reduce(data[name].values, axis=0) for data in (drawn, run))
            assert np.array_equal(*ends, equal_nan=True)
    assert np.array_equal(drawn["time"].values[[0, -1]], run["time"].values[[0, -1]])
    assert (np.diff(drawn["distance"].values) > 0.0).all()


@pytest.mark.parametrize(
    "work",
    [
        lambda result, folder: result.summary(),
        lambda result, folder: result.save(folder / "again.nc"),
        lambda result, folder: standard_figures(result.dataset),
    ],
    ids=["summary", "file", "pictures"],
)
def test_memory_grows_by_times_and_distances_alone(work: Callable[[Result, Path], object], monkeypatch, tmp_path):
    """Two numbers a sample that last, and as many meanwhile, of the 160 that a sample has."""
    in_small_parts(monkeypatch)
    monkeypatch.setattr(histories, "PIECES", 500)
    peaks, sizes = [], (3000, 9000)
    for samples in sizes:
        result = Result.load(Result(long_run(samples)).save(tmp_path / f"{samples}.nc"))
        work(result, tmp_path)  # what is imported does not count
        tracemalloc.start()
        work(result, tmp_path)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert (peaks[1] - peaks[0]) / (sizes[1] - sizes[0]) < 4 * 8 < 0.03 * result.dataset.nbytes / sizes[1]
