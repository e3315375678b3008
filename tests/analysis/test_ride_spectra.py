"""Spectra, third-octaves and frequency weightings against closed forms and published values."""

from math import pi, sqrt

import numpy as np
import pytest
from support.synthetic_run import run, sines

from wrsim.analysis.ride import WEIGHTINGS, comfort, evaluate_ride, spectrum, third_octaves, weighted
from wrsim.errors import InputError
from wrsim.scenario.sections.run import RideSection

RATE = 400.0
TIME = np.arange(0.0, 120.0, 1.0 / RATE)


def noise(seed: int = 1) -> np.ndarray:
    """White noise whose power spectral density is 1/(RATE/2) for a variance of 1."""
    return np.random.default_rng(seed).standard_normal(TIME.size)


def test_the_density_of_white_noise_is_its_variance_over_the_band():
    density = spectrum(noise(), RATE)
    assert density.frequency[1] == pytest.approx(0.1)
    assert density.segments == 23
    level = 2.0 / RATE
    inside = (density.frequency > 1.0) & (density.frequency < 190.0)
    # the mean of 1890 lines of 23 half-dependent segments: 0.6 %
    assert density.density[inside].mean() == pytest.approx(level, rel=0.02)
    assert density.rms() == pytest.approx(1.0, rel=0.01)


def test_a_sine_has_its_power_in_its_band_and_third_octaves_share_out_all_of_it():
    bands_of_sine = third_octaves(spectrum(3.0 * np.sin(2.0 * pi * 5.0 * TIME), RATE))
    of_five = bands_of_sine.nominal.index(5.0)
    assert bands_of_sine.rms[of_five] == pytest.approx(3.0 / sqrt(2.0), rel=1e-3)
    assert np.delete(bands_of_sine.rms, of_five).max() < 1e-3
    density = spectrum(noise(), RATE)
    bands = third_octaves(density, 1.0)
    assert bands.nominal[:4] == (1.0, 1.25, 1.6, 2.0)
    assert bands.high[:-1] == pytest.approx(bands.low[1:])
    whole = density.rms(bands.low[0], bands.high[-1])
    assert sqrt((bands.rms**2).sum()) == pytest.approx(whole, rel=1e-12)
    # 3 dB an octave: white noise
    assert bands.rms[10:] == pytest.approx(np.sqrt(2.0 / RATE * (bands.high - bands.low)[10:]), rel=0.06)
    bands = third_octaves(spectrum(noise(), RATE, resolution=1.0), 0.4)
    assert (bands.high - bands.low).min() >= 1.0
    with pytest.raises(InputError, match="too few for a spectrum"):
        spectrum(np.zeros(20), RATE)


@pytest.mark.parametrize(
    ("name", "frequency", "value"),
    [("Wk", 1.0, 0.482), ("Wk", 8.0, 1.036), ("Wk", 31.5, 0.405), ("Wd", 1.0, 1.011), ("Wd", 4.0, 0.512),
     ("Wd", 8.0, 0.253)],
)  # fmt: skip
def test_weightings_have_the_factors_of_the_table_of_ISO_2631(name, frequency, value):
    # table 3 of ISO 2631-1 [mem], three digits at nominal frequencies
    assert abs(WEIGHTINGS[name].response(np.array([frequency])))[0] == pytest.approx(value, abs=6e-4)


def test_the_weighted_rms_is_the_weighted_power():
    signal = noise(3)
    density = spectrum(signal, RATE)
    power = np.trapezoid(abs(WEIGHTINGS["Wb"].response(density.frequency)) ** 2 * density.density, density.frequency)
    assert weighted(signal, RATE, "Wb").std() == pytest.approx(sqrt(power), rel=0.02)


def test_comfort_of_a_steady_vibration_is_six_times_its_weighted_sum():
    amplitudes = np.array([0.1, 0.2, 0.3])
    acceleration = np.outer(np.sin(2.0 * pi * 3.0 * TIME), amplitudes)
    factors = np.array([abs(WEIGHTINGS[n].response(np.array([3.0])))[0] for n in ("Wd", "Wd", "Wb")])
    evaluated = comfort(acceleration, RATE)
    expected = factors * amplitudes / sqrt(2.0)
    assert len(evaluated.continuous) == 24
    assert evaluated.weighted_rms == pytest.approx(expected, rel=5e-3)
    assert evaluated.continuous[5:-1] == pytest.approx(np.tile(expected, (18, 1)), rel=1e-3)
    assert evaluated.mean == pytest.approx(6.0 * sqrt((expected**2).sum()), rel=5e-3)
    assert np.isnan(comfort(acceleration[:100], RATE).mean)


def test_the_comfort_of_a_vibration_that_grows_is_that_of_its_95th_percentile_block():
    # 24 blocks of 1, 2, ... 24 times the first; the switch from one to the next rings for a little
    growing = np.sin(2.0 * pi * 3.0 * TIME) * (1.0 + TIME // 5.0)
    evaluated = comfort(np.outer(growing, np.ones(3)), RATE)
    steady = np.array([abs(WEIGHTINGS[n].response(np.array([3.0])))[0] for n in ("Wd", "Wd", "Wb")]) / sqrt(2.0)
    assert evaluated.percentiles == pytest.approx((1.0 + 0.95 * 23.0) * steady, rel=0.01)


def test_the_ride_of_sines_is_known():
    evaluated = evaluate_ride(sines())
    assert evaluated.points == ("front", "rear")
    rms = evaluated.data["rms"]
    assert rms.sel(point="front", axis="y").item() == pytest.approx(0.3 / sqrt(2.0), rel=1e-3)
    assert rms.sel(point="front", axis="x").item() == 0.0
    band = evaluated.data["band_rms"].sel(point="rear", axis="z")
    assert band.sel(band=5.0).item() == pytest.approx(1.0 / sqrt(2.0), rel=2e-3)
    factor = abs(WEIGHTINGS["Wb"].response(np.array([5.0])))[0]
    weighted_rms = evaluated.data["weighted_rms"].sel(point="rear", axis="z").item()
    assert weighted_rms == pytest.approx(factor / sqrt(2.0), rel=0.01)
    assert evaluated.data.attrs["blocks"] == 12


def test_the_stretch_and_the_resolution_come_from_the_scenario():
    text = "[ride]\nfrom_m = 200\nto_m = 800\nresolution_Hz = 0.5\n"
    evaluated = evaluate_ride(sines(scenario_text=text))
    assert (evaluated.start, evaluated.end) == (pytest.approx(200.0), pytest.approx(800.0))
    assert evaluated.duration == pytest.approx(30.0)
    assert evaluated.data["frequency"].values[1] == pytest.approx(0.5)
    late = sines()
    late.dataset["distance"][0] = -1.9e-6  # of a position that an implicit step takes back
    with pytest.raises(
        InputError, match=r"^from_m = 2000: the run has no samples there; it goes from 0.00 to 1200.00 m$"
    ):
        evaluate_ride(late, RideSection(from_m=2000.0))
    with pytest.raises(InputError, match=r"no points: accelerations are stored at the \[\[points\]\]"):
        evaluate_ride(run(100.0))
