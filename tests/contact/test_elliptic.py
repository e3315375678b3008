"""The integral across a strip against scipy's elliptic integrals, from a remote point to the strip itself."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import elliprd

from wrsim.core.contact.normal.elliptic import strip_potential

ROUND_OFF = 1e-12  # demanded; 3e-15 is reached


@pytest.mark.parametrize("a", [1e-5, 3e-3, 0.02])
def test_potential_of_a_strip_in_closed_form(a):
    ratio = np.concatenate([np.logspace(-6.0, 6.0, 121)])  # m from 1 - 1e-12 to 1e-12
    m, m1 = 1.0 / (1.0 + ratio**2), ratio**2 / (1.0 + ratio**2)
    exact = 2.0 * a * np.sqrt(1.0 + ratio**2) * m * elliprd(0.0, m1, 1.0) / 3.0
    np.testing.assert_allclose([strip_potential(a, a * r) for r in ratio], exact, rtol=ROUND_OFF)
    np.testing.assert_allclose([strip_potential(a, -a * r) for r in ratio], exact, rtol=ROUND_OFF)


@pytest.mark.parametrize("s", [1e-4, 1e-3, 1e-2])
def test_potential_of_a_strip_by_quadrature(s):
    a = 4e-3

    def integrand(angle):
        """With x = a sin(angle)."""
        return 2.0 * (a * np.cos(angle)) ** 2 / np.hypot(a * np.sin(angle), s)

    # adaptive quadrature of a smooth function: its own error is below 1e-12
    assert strip_potential(a, s) == pytest.approx(quad(integrand, 0.0, 0.5 * np.pi, epsrel=1e-13)[0], rel=1e-11)


def test_beside_a_strip_the_potential_is_a_logarithm():
    # the next term of the expansion is of order (s/a)^2 ln(a/s)
    a = 4e-3
    for ratio in (1e-2, 1e-3, 1e-4, 1e-6):
        asymptote = 2.0 * a * (np.log(4.0 / ratio) - 1.0)
        assert strip_potential(a, ratio * a) == pytest.approx(asymptote, rel=ratio**2)


def test_far_from_a_strip_only_its_content_counts():
    # a semi-ellipse of content pi a^2 / 2 seen from s, next term (a/s)^2 / 8
    a = 4e-3
    assert strip_potential(a, 1e3 * a) == pytest.approx(0.5 * np.pi * a**2 / (1e3 * a), rel=2e-7)
