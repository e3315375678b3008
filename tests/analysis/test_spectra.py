"""Spectra of channels of runs: closed forms of sines, and a polygon on rails on sleepers."""

import csv
from math import pi, sqrt

import numpy as np
import pytest
from support.commands import ok
from support.rows import rows_of
from support.runs import SCENARIOS
from support.synthetic_run import Q0, run

import wrsim
from wrsim import InputError, load, spectra

table = rows_of(__file__)

SPEED, LENGTH, AMPLITUDE = 20.0, 200.0, 3e3
FREQUENCY = 162.3  # between two lines of the spectra


def wave(s):
    return AMPLITUDE * np.sin(2.0 * pi * FREQUENCY * s / SPEED)


def synthetic():
    """Q of the left wheel a sine; on the right one of 60 Hz on the first half of the track, of 240 Hz on the second."""
    right = lambda s: Q0 + AMPLITUDE * np.sin(2.0 * pi * np.where(s < 0.5 * LENGTH, 60.0, 240.0) * s / SPEED)  # noqa: E731
    shift = lambda s: 1e-3 * np.sin(2.0 * pi * FREQUENCY * s / SPEED)  # noqa: E731
    return run(LENGTH, SPEED, 5e-4, q=lambda s: (Q0 + wave(s), right(s)), lateral_shift=shift)


@pytest.mark.parametrize("order", [1, 2])
def test_derivatives_of_a_sine_have_powers_of_its_angular_frequency(order):
    outcome = spectra(synthetic(), "lateral_shift", derivative=order)
    expected = (2.0 * pi * FREQUENCY) ** order * 1e-3 / sqrt(2.0)
    assert float(outcome.value["rms"].item()) == pytest.approx(expected, rel=0.01)
    assert outcome.value.attrs["unit"] == ("m/s", "m/s2")[order - 1]


def test_the_spectrogram_has_each_frequency_where_it_is():
    right = spectra(synthetic(), "Q", piece_m=4.0).value["spectrogram"].isel(wheelset=0).sel(wheel="right")
    strongest = right.idxmax("line")
    first, second = right["place"] < 0.5 * LENGTH - 4.0, right["place"] > 0.5 * LENGTH + 4.0
    # a piece lasts 0.2 s: lines every 5 Hz
    assert np.abs(strongest[first] - 60.0).max() <= 5.0 and np.abs(strongest[second] - 240.0).max() <= 5.0
    assert float(np.diff(right["place"]).mean()) == pytest.approx(2.0)
    only = spectra(synthetic(), "Q", from_m=0.6 * LENGTH).value
    assert only.attrs["from_m"] == pytest.approx(0.6 * LENGTH)
    assert float(only["density"].isel(wheelset=0).sel(wheel="right").idxmax()) == pytest.approx(240.0, abs=2.0)


def test_a_polygon_on_sleepers_is_a_line_in_the_force_and_at_the_axle_box():
    """f = n v / (2 pi R)."""
    order, speed, radius = 18, 80.0, 0.46
    keys = {"vehicle.out_of_round": [{"kind": "harmonic", "wheel": "left", "order": order, "amplitude_mm": 0.02}]}
    keys |= {"vehicle.speed_kmh": speed, "run.step_us": 250, "run.output_interval_ms": 5.0, "run.distance_m": 7.0}
    keys |= {"contact.normal": "kik-piotrowski", "run.fast_channels": ["Q", "axle_box_acceleration"]}
    result = wrsim.run(load(SCENARIOS / "flat_on_sleepers.toml").with_values(keys))
    expected = order * speed / 3.6 / (2.0 * pi * radius)
    for channel in ("Q", "axle_box_acceleration"):
        spectrum = spectra(result, channel).value.sel(wheelset="wheelset", wheel="left")
        assert spectrum.attrs["rate_Hz"] == pytest.approx(2000.0)
        assert float(spectrum["density"].idxmax()) == pytest.approx(expected, abs=float(spectrum["frequency"][1]))
        line = float(spectrum["band"][int(spectrum["band_rms"].argmax("band"))])
        assert spectrum["band_low"].sel(band=line) <= expected <= spectrum["band_high"].sel(band=line)


@pytest.mark.usefixtures("sketched")
def test_the_command_leaves_tables_and_a_picture(tmp_path):
    synthetic().save(tmp_path / "result.nc")
    assert "Vertical force" in ok("spectra", tmp_path, "Q").output
    rows = list(csv.DictReader((tmp_path / "third_octaves_Q.csv").read_text().splitlines()))
    (row,) = [r for r in rows if float(r["band_Hz"]) == 160.0]
    assert float(row["left_N"]) == pytest.approx(AMPLITUDE / sqrt(2.0), rel=0.01)
    assert {"spectra_Q.csv", "spectra_Q.png"} <= {p.name for p in tmp_path.iterdir()}


@pytest.mark.parametrize("channel, options, message", table("what_has_no_spectrum_is_one_clear_error"))
def test_what_has_no_spectrum_is_one_clear_error(channel, options, message):
    with pytest.raises(InputError, match=message):
        spectra(synthetic(), channel, **options)
