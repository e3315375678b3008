"""Filters and cubics of the package are those of scipy, whose modules take half a second to import.

Machines without fused products give the same bits; a fused product rounds once where two round, which recursions over
poles near 1 amplify.
"""

import numpy as np
import pytest
from scipy.interpolate import PPoly, pchip_interpolate
from scipy.signal import butter, sosfiltfilt

from wrsim.contact.tables import monotone_cubic
from wrsim.jit.butterworth import butterworth, zero_phase
from wrsim.results.filters import sliding_mean


@pytest.mark.parametrize("order", [2, 4])
@pytest.mark.parametrize("kind", ["lowpass", "highpass"])
@pytest.mark.parametrize("corner", [0.3, 20.0, 80.0])
def test_a_filter_forward_and_backward_is_that_of_scipy(order: int, kind: str, corner: float) -> None:
    signal = np.cumsum(np.random.default_rng(order).normal(size=(900, 2)), axis=0)
    sections = butter(order, corner, kind, fs=200.0, output="sos")
    light = butterworth(order, corner, kind == "highpass", 200.0)
    assert np.allclose(light, sections[:, [0, 1, 2, 4, 5]], rtol=1e-14, atol=0.0)
    expected = sosfiltfilt(sections, signal, axis=0, padlen=300)
    assert np.abs(zero_phase(light, signal, 300) - expected).max() < 1e-12 * np.abs(signal).max()
    assert np.array_equal(zero_phase(light, signal[:, 0], 300), zero_phase(light, signal, 300)[:, 0])


def test_a_sliding_mean_is_the_integral_of_a_linear_signal_over_its_window() -> None:
    rng = np.random.default_rng(1)
    place, signal = np.cumsum(rng.uniform(0.01, 0.1, 400)), rng.normal(size=(400, 2))
    middles = np.linspace(place[0] + 0.5, place[-1] - 0.5, 90)
    rows = np.array([np.diff(signal, axis=0) / np.diff(place)[:, None], signal[:-1]])
    integral = PPoly(rows, place).antiderivative()
    expected = integral(middles + 0.5) - integral(middles - 0.5)
    assert np.allclose(sliding_mean(place, signal, middles, 1.0), expected, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("rounded", [False, True])
def test_a_monotone_cubic_is_that_of_fritsch_and_butland(rounded: bool) -> None:
    """Rounded values have level pieces and turning points."""
    rng = np.random.default_rng(2)
    for count in (3, 8, 19):
        x, y = np.cumsum(rng.uniform(0.1, 1.0, count)), rng.normal(size=(count, 3))
        y = np.round(y) if rounded else y
        places = np.append(np.linspace(x[0], x[-1], 40), x)
        expected = pchip_interpolate(x, y, places)
        assert np.allclose(monotone_cubic(x, y, places), expected, rtol=0.0, atol=1e-13)
