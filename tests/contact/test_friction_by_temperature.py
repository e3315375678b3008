"""Friction by the temperature of the surface: the closed form, its limits, CONTACT's test bank, the exact solver."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from support.contacts import bench, pair_model, settle
from support.ellipse import roll, total

from wrsim import ContactSettings, InputError
from wrsim.contact import Heating, Layer
from wrsim.contact.models import exact_model

LOAD, A, B, SPEED, MU = 106.7e3, 6.304e-3, 12.61e-3, 10.0, 0.33
PEAK = 1.5 * LOAD / (np.pi * A * B)
FALLING = Heating(-0.19, 1200.0, 0.0, 0.0)
TRACTION = np.array([
    # CONTACT 25.2 (E.A.H. Vollebregt, Apache-2.0), test bank examples_temp/euro_tractcurv: creepage, FX/FN without and
    # with friction that falls by 0.19 over 1200 K; 106.7 kN, a/b 0.5, 10 m/s, mu 0.33, both bodies at 0 degC
    [0.0012, 0.214335, 0.214302], [0.0032, 0.329307, 0.328581], [0.01, 0.329967, 0.327360], [0.04, 0.33, 0.319374],
    [0.075, 0.33, 0.310497],
])  # fmt: skip
MODELS = ["fastsim, blended", "fastrip"]


def strips(creepage, heating=None, model="fastrip", layer=None, phi=0.0, **choices):
    """Longitudinal force over the load of the ellipse, largest temperature, strips."""
    heating, layer = heating or Heating(bulk=0.0), layer or Layer()
    numbers = {
        "history": 1, "warming": heating.warming, "bulk": heating.bulk, "heat_from": heating.friction_from,
        "heat_slope": heating.friction_change / heating.friction_over, "heat_change": heating.friction_change,
        "yield_stress": layer.yield_stress, "hardening": layer.hardening, "layer": layer.flexibility,
    }  # fmt: skip
    choices = {"strips": 17, "direction": SPEED, "friction": MU} | choices
    rows = roll(0.5, creepage, phi=phi, model=model, radius=np.sqrt(A * B), peak=PEAK, **numbers, **choices)
    return -total(rows)[0] / rows["N"].sum(), rows["temperature"].max(), rows


def closed_form(creepage, heating, places=400):
    """Temperatures in the middle of the ellipse in full sliding with a coefficient that stays: the integral of q over
    the root of the distance by Gauss and Chebyshev, with x' - x = (x_l - x) u^2."""
    x = np.linspace(-A, A, places)[:, None]
    u, weights = 0.5 * np.array(np.polynomial.legendre.leggauss(60)) + [[0.5], [0.0]]
    ahead = x + (A - x) * u**2
    power = MU * PEAK * np.sqrt(np.maximum(1.0 - (ahead / A) ** 2, 0.0)) * creepage * SPEED
    integral = 2.0 * np.sqrt(A - x[:, 0]) * (power * weights).sum(axis=1)
    beta = np.sqrt(heating.conductivity * heating.heat_capacity * heating.density)
    return heating.bulk + 0.5 * integral / (beta * np.sqrt(np.pi * SPEED))


@pytest.mark.parametrize("model", MODELS)
def test_full_sliding_has_the_temperature_of_a_fast_source(model):
    heating = Heating(bulk=15.0)
    expected = closed_form(0.2, heating).max() - 15.0
    # an eighth of a percent more by the elastic slip; 20 cells, 17 strips
    assert strips(0.2, heating, model)[1] - 15.0 == pytest.approx(expected, rel=0.005)
    assert strips(0.2, heating, model, cells=100)[1] - 15.0 == pytest.approx(expected, rel=0.002)


@pytest.mark.parametrize("model", MODELS)
def test_temperature_alone_moves_no_force(model):
    for creepage, eta, phi in ((1e-3, 0.0, 0.0), (2e-3, -1e-3, 0.3), (0.1, 0.05, 1.0)):
        plain = roll(0.5, creepage, eta, phi, model=model, friction=MU, strips=17)
        heated = roll(0.5, creepage, eta, phi, model=model, friction=MU, strips=17, history=1, yield_stress=np.inf)
        for name in ("Fx", "Fy", "Mz", "mu"):
            assert_allclose(heated[name], plain[name], rtol=1e-9, atol=1e-9 * np.abs(plain[name]).max())


def test_tractions_follow_contact_as_far_as_its_temperatures_do():
    """CONTACT counts an element's own heat twice, 12 % too much temperature: 0.004 of the load from a creepage of 0.1
    on (docs/validation)."""
    for creepage, plain, falling in TRACTION:
        assert strips(creepage)[0] == pytest.approx(plain, abs=1.5e-3)
        assert strips(creepage, FALLING)[0] == pytest.approx(falling, abs=3e-3)


@pytest.mark.parametrize("model", MODELS)
def test_friction_stays_between_its_ends_and_is_that_of_its_temperature(model):
    for change in (-0.25, 0.3):
        for span in (1e-3, 50.0, 1e5):
            force, hottest, rows = strips(0.3, Heating(change, span, 40.0, 20.0), model)
            low, high = sorted((MU, MU + change))
            assert low - 1e-9 <= force <= high + 1e-9
            assert (rows["mu"] >= low - 1e-9).all() and (rows["mu"] <= high + 1e-9).all()
            assert hottest > 40.0
        # steep: all of the change but at the leading edge; flat: none of it; warm bodies: all of it at once
        assert strips(0.3, Heating(change, 1e-3, 40.0, 20.0), model)[0] == pytest.approx(MU + change, rel=0.05)
        assert strips(0.3, Heating(change, 1e9, 40.0, 20.0), model)[0] == pytest.approx(MU, rel=1e-5)
        assert strips(0.3, Heating(change, 10.0, 40.0, 60.0), model)[0] == pytest.approx(MU + change, rel=1e-9)
    assert strips(0.3, Heating(-0.5, 1e-3, 40.0, 20.0), model)[0] < 0.05


@pytest.mark.parametrize("model", MODELS)
def test_rolling_backwards_and_mirrored_is_the_same(model):
    force, hottest, _ = strips(0.01, FALLING, model)
    back = strips(-0.01, FALLING, model, direction=-SPEED)
    assert back[0] == pytest.approx(-force) and back[1] == pytest.approx(hottest)


@pytest.mark.parametrize("model", MODELS)
def test_temperature_has_no_spikes_where_slip_begins(model):
    """From cell to cell the slip zone grows; the temperature follows to a tenth of its value in full sliding."""
    for soft in (0.0, 2e-13):
        for spin in (0.0, 0.3):
            creepages = np.linspace(1e-4, 4e-3, 80)
            hottest = [strips(x, None, model, Layer(soft, 1.0), spin, friction=0.12)[1] for x in creepages]
            assert np.abs(np.diff(hottest)).max() < 0.1 * hottest[-1]


def test_a_layer_that_yields_in_fastsim_is_near_the_exact_one():
    for hardening, exact in ((828.28e9, 0.307461), (0.0, 0.292050)):  # CONTACT at 0.0056, see test_third_body
        force = strips(0.0056, None, "fastsim, blended", Layer(yield_stress=150e6, hardening=hardening))[0]
        assert force == pytest.approx(exact, abs=0.01)
    assert strips(0.0056, None, "fastsim, blended", Layer(yield_stress=150e6, hardening=1e18))[0] == pytest.approx(
        strips(0.0056, None, "fastsim, blended")[0], rel=1e-3
    )


def test_the_exact_solver_and_strips_heat_alike_at_a_pose():
    """A wheel that spins on its rail at a creepage of 0.05: temperature over pressure, friction and force."""
    heating = Heating(-0.1, 300.0)
    model = pair_model("S1002/60E1 1:40", normal="strips", temperature=heating)
    stand = bench(model)
    settle(stand, 0.0, 0.0, 80e3)
    pose = stand.wheels[0].model.arrays.pose.copy()
    values = []
    for each in (model, exact_model(model)):
        law = replace(each.settings, tangential="half-space" if each is not model else None)
        contacts = [
            replace(each, settings=settings).evaluate(
                pose[:3], pose[3:6], (SPEED, 0.0, 0.0), (0.0, 1.05 * SPEED / model.radius, 0.0)
            )
            for settings in (law, replace(law, temperature=None))
        ]
        assert all(contact.status == 0 for contact in contacts)
        hot, cold = contacts
        force = hot.force[0] / cold.force[0]
        mu = [sum((s["mu"] * s["N"]).sum() for s in contact.strips) for contact in contacts]
        assert mu[0] / mu[1] == pytest.approx(force, abs=2e-3)
        assert (cold.patches["temperature"] == 0.0).all()
        values.append((force, (hot.patches["temperature"].max() - 20.0) / hot.patches["p0"].max()))
    assert_allclose(values[0][0], values[1][0], atol=4e-3)
    assert_allclose(values[0][1], values[1][1], rtol=0.025)


def test_other_models_refuse_temperature():
    with pytest.raises(InputError, match=r'"linear" takes no friction by temperature: take "fastsim" or "fastrip" or'):
        ContactSettings(tangential="linear", temperature=Heating()).check()
