"""A layer between wheel and rail: CONTACT's test bank, the limits of soft, hard and plastic layers, refusals."""

from math import inf

import numpy as np
import pytest
from numpy.testing import assert_allclose
from support.ellipse import COEFFICIENTS, MEAN_RADIUS, SHEAR_MODULUS, roll, total
from support.hertz import Ellipse, EllipseGrid

from wrsim import ContactSettings, InputError
from wrsim.contact import Layer, Material
from wrsim.contact.creep.flexibility import kalker_coefficients
from wrsim.contact.half_space.influence import Compliance, Operator
from wrsim.contact.half_space.rolling import solve_rolling

LOAD, MU, G, A, B = 106.7e3, 0.33, 82e9, 6.304e-3, 12.61e-3
STEEL = Material(2.0 * G * 1.28, 0.28)
TRACTION = np.array([
    # CONTACT 25.2 (E.A.H. Vollebregt, Apache-2.0), test bank examples_plast/tractcurve_plast: FX/FN at these creepages;
    # 106.7 kN, a/b 0.5, yield stress 150 MPa
    [0.0004, 0.0012, 0.002, 0.0032, 0.0056, 0.02],
    [0.085701, 0.214335, 0.290829, 0.329307, 0.329868, 0.33],  # no layer
    [0.085701, 0.212487, 0.285021, 0.326271, 0.329868, 0.33],  # hardening 9111.1 MPa/mm
    [0.085701, 0.210837, 0.273966, 0.300630, 0.307461, 0.327492],  # 828.28 MPa/mm
    [0.085701, 0.210540, 0.270930, 0.291852, 0.292050, 0.292116],  # none
])  # fmt: skip
HARDENING = (inf, 9111.1e9, 828.28e9, 0.0)
SOFT = Layer(1.25e-3, 8.2e9)  # elastic, with friction that falls with the slip by half in 1.25 m/s, at 10 m/s
FALLING = np.array([
    # CONTACT 25.2 (E.A.H. Vollebregt, Apache-2.0), test bank examples/tractcurv, second series, and its friction
    [0.001, 0.002, 0.004, 0.006, 0.01, 0.016, 0.02, 0.05, 0.1, 0.25],
    [0.0602, 0.1154, 0.2013, 0.2554, 0.3009, 0.3117, 0.3099, 0.2845, 0.2495, 0.1876],
])  # fmt: skip


def exact(creepage, layer=None, across=40, mu=MU):
    """Longitudinal force over the load; what was solved, the bound and the grid."""
    grid = EllipseGrid(Ellipse(A, B, 1.5 * LOAD / (np.pi * A * B)), across)
    layer = layer or Layer()
    operator = Operator(grid.count, grid.count, grid.ds, grid.dx, Compliance.of(STEEL, STEEL, layer.flexibility))
    p = grid.pressure()
    p *= LOAD / (p.sum() * grid.cell)
    slip = grid.rigid_slip(creepage, 0.0, 0.0)
    yields = layer.yield_stress, layer.hardening
    traction = solve_rolling(operator, mu * p, slip, 1.0, 1e-5, None, *yields)
    assert traction.converged
    return -grid.resultants(traction.q)[0] / LOAD, traction, mu * p, grid


@pytest.mark.parametrize("series", range(4))
def test_a_layer_that_yields_follows_contact(series):
    hardening = HARDENING[series]
    layer = Layer(yield_stress=150e6, hardening=hardening) if hardening < inf else None
    assert_allclose([exact(x, layer)[0] for x in TRACTION[0]], TRACTION[1 + series], atol=5e-4)


# measured: 0.0014 with 40 elements, 0.0074, 0.0093 at a creepage of 0.6 %; without the layer 0.17
@pytest.mark.parametrize(("model", "most"), [("half-space", 2e-3), ("fastsim", 0.01), ("fastrip", 0.01)])
def test_a_thick_elastic_layer_follows_contact(model, most):
    tractions = []
    for creepage in FALLING[0]:
        mu = 0.14 + 0.19 * 0.5 ** (creepage * 10.0 / 1.25)
        if model == "half-space":
            tractions.append(exact(creepage, SOFT, 30, mu)[0])
            continue
        choices = {"radius": np.sqrt(A * B), "peak": 1.5 * LOAD / (np.pi * A * B), "friction": mu, "model": model}
        tractions.append(-total(roll(A / B, creepage, layer=SOFT.flexibility, **choices))[0] / LOAD)
    assert_allclose(tractions, FALLING[1], atol=most)


def test_yielding_is_opposite_to_the_slip_and_reaches_the_hardened_stress():
    layer = Layer(yield_stress=150e6, hardening=2e12)
    _, traction, bound, grid = exact(2e-3, layer)
    yields = traction.state == 3.0
    assert yields.sum() > 100
    size, slip = np.hypot(*traction.q), np.hypot(*traction.slip)
    plastic = np.where(yields, slip, 0.0)[:, ::-1].cumsum(axis=1)[:, ::-1] * grid.dx
    assert_allclose(size[yields], (layer.yield_stress + layer.hardening * plastic)[yields], rtol=1e-3)
    assert_allclose(-(traction.q * traction.slip).sum(axis=0)[yields], (size * slip)[yields], rtol=1e-3)
    assert (size <= bound * (1.0 + 1e-9)).all()


def test_a_layer_that_hardens_at_once_is_none_and_one_that_does_not_shears_off():
    rigid = Layer(yield_stress=1e7, hardening=1e17)
    assert exact(2e-3, rigid)[0] == pytest.approx(exact(2e-3)[0], rel=1e-3)
    # with a stress that stays, and with one that softens at once to a tenth
    force, _, bound, grid = exact(0.05, Layer(yield_stress=1e8))
    assert force == pytest.approx(np.minimum(bound, 1e8).sum() * grid.cell / LOAD, rel=1e-3)
    _, soft, bound, grid = exact(0.2, Layer(yield_stress=1e8, hardening=-1e12))
    behind = (grid.x < 0.0) & (bound > 3e8)
    assert_allclose(np.hypot(*soft.q)[behind], 1e7, rtol=1e-6)


def test_a_very_soft_layer_is_a_bed_of_springs():
    """Tractions then grow by creepage over flexibility: a force of 8/3 a^2 b xi / L, met at first order."""
    layer = Layer(thickness=1.0, shear_modulus=1e9)
    expected = 8.0 / 3.0 * A * A * B * 1e-6 / layer.flexibility / LOAD
    errors = [exact(1e-6, layer, across)[0] / expected - 1.0 for across in (20, 160)]
    assert 0.0 < errors[1] < 0.15 * errors[0] < 0.015


# FaStrip's zone of adhesion ends within a cell: 1e-5 with 160 strips and cells, 1e-3 with 40 and 20
@pytest.mark.parametrize(
    ("model", "count", "most"), [("fastsim", 20, 1e-5), ("fastsim, blended", 20, 1e-5), ("fastrip", 160, 1e-4)]
)
def test_an_elastic_layer_takes_its_part_of_kalker_s_stiffness_and_nothing_of_friction(model, count, most):
    def force(creepage, layer=0.0):
        return total(roll(1.0, creepage, model=model, layer=layer, strips=2 * count, cells=count))[0]

    plain = force(1e-7)
    soft = 8.0 * MEAN_RADIUS / (3.0 * kalker_coefficients(COEFFICIENTS, 1.0).c11 * SHEAR_MODULUS)  # L1 of the circle
    softer = [force(1e-7, part * soft) for part in (1.0, 2.0)]
    # the compliances of bodies and layer add up
    assert 1.0 / softer[1] - 1.0 / softer[0] == pytest.approx(1.0 / softer[0] - 1.0 / plain, rel=most)
    assert softer[0] == pytest.approx(0.5 * plain, rel=0.01)
    assert force(0.3, soft) == pytest.approx(force(0.3))


def test_models_without_a_layer_say_which_have_one():
    with pytest.raises(InputError, match=r'"polach" takes no layer between .* "fastsim" or "fastrip" or "half-space"'):
        ContactSettings(tangential="polach", layer=Layer(2e-5, 1e9)).check()
    with pytest.raises(InputError, match=r'"fastrip" takes no layer that yields: take "fastsim" or "half-space"'):
        ContactSettings(layer=Layer(yield_stress=1e8)).check()
