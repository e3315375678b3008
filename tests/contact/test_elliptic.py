"""The integral across a strip against scipy's elliptic integrals, from a remote point to the strip itself."""

import numpy as np
import pytest
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
