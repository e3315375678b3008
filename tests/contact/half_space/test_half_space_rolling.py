"""Steady rolling on a grid: Carter's strip, Kalker's coefficients, full sliding, symmetries, CONTACT's cases."""

from functools import cache

import numpy as np
import pytest
from support.ellipse import FORCE, total
from support.ellipse import roll as strips
from support.hertz import COMPLIANCE, Ellipse, EllipseGrid
from support.rows import data_rows, rows_of

from wrsim.contact.creep.flexibility import kalker_coefficients
from wrsim.contact.half_space.influence import Operator
from wrsim.contact.half_space.normal import solve_normal
from wrsim.contact.half_space.rolling import solve_rolling
from wrsim.contact.tables import creep_coefficients

table = rows_of(__file__)

MU = 0.3
G = 82e9
PATCH = Ellipse(6e-3, 3e-3)
CREEP_A = 6.3036e-3  # half axis [m]
MIXED = (8e-4, -5e-4, 0.3)


@cache
def roll(xi, eta, phi, friction=MU, forward=1.0, ellipse=PATCH, across=24, tolerance=1e-5):
    grid = EllipseGrid(ellipse, across)
    traction = solve_rolling(
        grid.operator(), friction * grid.pressure(), grid.rigid_slip(xi, eta, phi), forward, tolerance
    )
    assert traction.converged
    return traction, grid


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_carter_s_strip(share):
    # A long cylinder: rows of equal pressure, looked at in the middle. In plane strain the traction is
    # mu p less mu p0 (c/a) sqrt(c^2 - (x - (a - c))^2)/c over the adhesion zone of length 2 c at the leading edge,
    # c/a = 1 - xi E*/(2 mu p0), and the force mu N (1 - (c/a)^2) (Carter 1926; Johnson 1985, section 8.3).
    a, across, rows, ds = 2e-3, 60, 81, 5e-4
    columns = across + 4
    dx = 2.0 * a / across
    x = (np.arange(columns) - 0.5 * (columns - 1)) * dx
    p = 1e9 * np.sqrt(np.maximum(1.0 - (x / a) ** 2, 0.0)) * np.ones((rows, 1))
    operator = Operator(rows, columns, ds, dx, COMPLIANCE)
    c = 1.0 - share
    xi = 2.0 * MU * 1e9 * share / COMPLIANCE.modulus
    w = np.zeros((2, rows, columns))
    w[0] = xi
    q = solve_rolling(operator, MU * p, w).q[0, rows // 2]
    inside = np.maximum((c * a) ** 2 - (x - (1.0 - c) * a) ** 2, 0.0)
    exact = -MU * 1e9 * (np.sqrt(np.maximum(1.0 - (x / a) ** 2, 0.0)) - np.sqrt(inside) / a)
    assert q.sum() / exact.sum() == pytest.approx(1.0, abs=0.01)
    assert np.abs(q - exact).max() < 0.06 * MU * 1e9


@pytest.mark.parametrize("ratio", [0.05, 0.5, 1.0, 2.0])
def test_initial_slopes_are_kalker_s_coefficients(ratio):
    # the rest is the difference quotient over one element: first order, 1.5 % at 40 elements, 0.4 % at 80
    ellipse = Ellipse(5e-3 * np.sqrt(ratio), 5e-3 / np.sqrt(ratio))
    c = 5e-3
    expected = kalker_coefficients(creep_coefficients(0.28), ratio)
    slopes = []
    for creepages, component in (((1e-6, 0.0, 0.0), 0), ((0.0, 1e-6, 0.0), 1), ((0.0, 0.0, 1e-6 / c), 1)):
        traction, grid = roll(*creepages, ellipse=ellipse, across=80)
        slopes.append(-grid.resultants(traction.q)[component] / (G * 1e-6 * c * c))
    assert slopes == pytest.approx(expected, rel=0.01)


def test_a_solution_that_ends_too_soon_says_so_with_its_last_error(monkeypatch):
    grid = EllipseGrid(PATCH, 24)
    known = grid.operator(), MU * grid.pressure(), grid.rigid_slip(*MIXED)
    errors = []
    for steps in (1, 5):
        monkeypatch.setattr("wrsim.contact.half_space.rolling.NEWTON_STEPS", steps)
        traction = solve_rolling(*known, tolerance=1e-12)
        assert not traction.converged
        errors.append(traction.error)
    assert 0.0 < errors[1] < 0.5 * errors[0]


def test_full_sliding_is_mu_n_against_the_slip():
    traction, grid = roll(0.03, -0.04, 0.0)
    force = grid.resultants(traction.q)
    normal = grid.pressure().sum() * grid.cell
    assert (traction.state != 1.0).all()
    assert np.hypot(*force[:2]) == pytest.approx(MU * normal, rel=1e-3)
    assert force[0] / force[1] == pytest.approx(-0.75, rel=0.02)


@pytest.mark.parametrize("creepages", [MIXED, (2e-3, 1e-3, 0.0), (0.0, 0.0, 0.8)])
def test_laws_of_friction_hold_in_every_element(creepages):
    traction, grid = roll(*creepages)
    bound = MU * grid.pressure()
    size, slip = np.hypot(*traction.q), np.hypot(*traction.slip)
    largest = slip[bound > 0.0].max()
    assert (size <= bound * (1.0 + 1e-9)).all()
    assert slip[traction.state == 1.0].max() < 1e-3 * largest
    sliding = (traction.state == 2.0) & (slip > 0.02 * largest)
    assert size[sliding] == pytest.approx(bound[sliding], rel=1e-3)
    against = -(traction.q * traction.slip).sum(axis=0)[sliding]
    assert against == pytest.approx((size * slip)[sliding], rel=5e-3)
    # the elastic part of the slip does no work; the difference quotient over an element takes some
    power = -(traction.q * traction.slip).sum()
    work = -(traction.q * grid.rigid_slip(*creepages)).sum()
    assert 0.0 < power < work


def test_dissipation_tends_to_the_work_of_the_creep_forces():
    shares = []
    for across in (12, 24, 48, 96):
        traction, grid = roll(*MIXED, across=across)
        power, work = ((traction.q * w).sum() for w in (traction.slip, grid.rigid_slip(*MIXED)))
        shares.append(1.0 - power / work)
    assert (np.diff(shares) < 0.0).all()
    assert -np.polyfit(np.log([12, 24, 48, 96]), np.log(shares), 1)[0] > 0.8


def test_forces_scale_and_vanish_without_bound_or_creepage():
    assert not roll(*MIXED, friction=0.0)[0].q.any()
    assert not roll(0.0, 0.0, 0.0)[0].q.any()
    # lengths x 3 and spin / 3 at equal pressures: tractions stay
    traction, _ = roll(*MIXED)
    large, _ = roll(MIXED[0], MIXED[1], MIXED[2] / 3.0, ellipse=Ellipse(3.0 * PATCH.a, 3.0 * PATCH.b))
    assert large.q == pytest.approx(traction.q, abs=1e-3 * 3e8)


def test_mirrored_and_backwards_rolling_mirror_the_forces():
    traction, _ = roll(*MIXED)
    across, _ = roll(MIXED[0], -MIXED[1], -MIXED[2])
    assert across.q[0] == pytest.approx(traction.q[0, ::-1], abs=1e-3 * 3e8)
    assert across.q[1] == pytest.approx(-traction.q[1, ::-1], abs=1e-3 * 3e8)
    opposite, _ = roll(-MIXED[0], -MIXED[1], -MIXED[2])
    assert opposite.q == pytest.approx(-traction.q, abs=1e-3 * 3e8)
    # turned by half a turn about the normal: x, s and both tractions change their signs, the spin does not
    grid = EllipseGrid(PATCH, 24)
    bound = MU * grid.pressure()
    w = grid.rigid_slip(*MIXED)
    forwards = solve_rolling(grid.operator(), bound, w, 1.0, 1e-6)
    backwards = solve_rolling(grid.operator(), bound, np.ascontiguousarray(-w[:, ::-1, ::-1]), -1.0, 1e-6)
    assert backwards.q == pytest.approx(-forwards.q[:, ::-1, ::-1], abs=1e-3 * bound.max())


def contact_rows():
    return [r for r in data_rows("tangential.csv") if r["method"] == "contact"][::5]


@pytest.mark.parametrize("row", contact_rows(), ids=lambda r: r["case_id"])
def test_contact_s_tangential_cases(row):
    # the same elements as CONTACT's (66 over 1.1 times the axes): the same solution
    ratio, c = float(row["a_over_b"]), 5e-3
    grid = EllipseGrid(Ellipse(c * np.sqrt(ratio), c / np.sqrt(ratio)), 60)
    bound = _bound(grid)
    w = grid.rigid_slip(float(row["cksi"]), float(row["ceta"]), 1e3 * float(row["cphi_radpmm"]))
    traction = solve_rolling(grid.operator(), bound, w)
    ours = grid.resultants(traction.q) / (MU * grid.ellipse.force * np.array([1.0, 1.0, c]))
    assert ours == pytest.approx([float(row[name]) for name in ("fx", "fy", "mz_norm")], abs=5e-4)


WIDE = [(0.0, -0.4, 0.5), (0.15, 0.15, 1.5), (0.4, -0.4, 0.0)]
WIDE += [
    pytest.param(*case, marks=pytest.mark.campaign) for case in ((0.4, 0.0, 0.5), (0.0, 0.4, 0.5), (0.0, 0.0, 1.0))
]


@pytest.mark.parametrize(("xi", "eta", "phi"), WIDE)
def test_fast_models_on_wide_patches(xi, eta, phi):
    # a/b 0.3, scaled creepages as in CONTACT's cases; measured over 59 of them: .058 and .033 of mu N at worst
    c, ratio = 5e-3, 0.3
    grid = EllipseGrid(Ellipse(c * np.sqrt(ratio), c / np.sqrt(ratio)), 60)
    unit = MU * FORCE / (G * c * c)
    creepages = unit * xi, unit * eta, unit * phi / c
    exact = grid.resultants(solve_rolling(grid.operator(), _bound(grid), grid.rigid_slip(*creepages)).q)
    for model, within in (("fastsim, blended", 0.06), ("fastrip", 0.035)):
        fast = total(strips(ratio, *creepages, model=model, friction=MU, strips=66, cells=66))
        assert np.abs(fast - exact)[:2].max() < within * MU * FORCE


@cache
def _bound(grid):
    return MU * solve_normal(grid.operator(), grid.penetration(), 1e-6).p


def test_fastsim_s_published_case():
    # CONTACT user guide: a 8, b 4 mm, N 82 kN, eta -.000625, phi .000625 /mm: FY -14940 N, MZ -48210 N mm, pmax 1223
    grid = EllipseGrid(Ellipse(8e-3, 4e-3, 1.5 * 82e3 / (np.pi * 32e-6)), 40)
    pressure = solve_normal(grid.operator(), grid.penetration(), 1e-6)
    traction = solve_rolling(grid.operator(), MU * pressure.p, grid.rigid_slip(0.0, -6.25e-4, 0.625))
    assert pressure.p.max() == pytest.approx(1223e6, rel=2e-3)
    assert grid.ellipse.approach == pytest.approx(0.09266e-3, rel=1e-3)
    assert grid.resultants(traction.q) == pytest.approx([0.0, -14940.0, -48.21], rel=0.01, abs=10.0)


@pytest.mark.parametrize(
    ("xi", "force"), [(1e-5, 247.0), (1.2e-3, 22820.0), (2.4e-3, 33330.0), (3.6e-3, 35180.0), (6e-3, 35200.0)]
)
def test_published_creep_curve(xi, force):
    # CONTACT user guide: N 106.7 kN, A .0008 /mm, a/b .5, mu .33
    ellipse = Ellipse(CREEP_A, 2.0 * CREEP_A, 1.5 * 106.7e3 / (2.0 * np.pi * CREEP_A**2))
    assert ellipse.curvatures[0] == pytest.approx(0.8, rel=1e-3)
    grid = EllipseGrid(ellipse, 50)
    traction = solve_rolling(grid.operator(), 0.33 / MU * _bound(grid), grid.rigid_slip(xi, 0.0, 0.0))
    assert -grid.resultants(traction.q)[0] == pytest.approx(force, rel=0.01)


# CONTACT user guide, example "conformal", case 2: interpenetration [mm] over s = 0, .4, ... 7.6 mm at x = 0
CORNER = (
    0.090886, 0.09065786, 0.08997365, 0.08883393, 0.08723969, 0.08519227, 0.08269341, 0.07974523, 0.07635024,
    0.07251131, 0.06823168, 0.06351499, 0.05836522, 0.05278672, 0.0467842, 0.04036271, 0.03352765, 0.02628477,
    0.01864015, 0.01060019,
)  # fmt: skip


@pytest.mark.parametrize(("gap", "published"), table("published_rail_corner"))
def test_published_rail_corner(gap, published):
    # R 10 against -10.2, A .00076859 /mm, approach .09089 mm, xi -.004, eta -.0098995, phi -.0015372 /mm, 0.4 mm
    d, rows, columns = 4e-4, 39, 51
    x = (np.arange(columns) - 25) * d
    s = ((np.arange(rows) - 19) * d)[:, None]
    across = 0.09089e-3 - 0.98039 * s**2 if gap == "quadratic" else 1e-3 * np.interp(abs(s), np.arange(20) * d, CORNER)
    operator = Operator(rows, columns, d, d, COMPLIANCE)
    pressure = solve_normal(operator, across - 0.76859 * x**2, 1e-6)
    p, cell = pressure.p, d * d
    w = np.stack(np.broadcast_arrays(-4e-3 + 1.5372 * s, -9.8995e-3 - 1.5372 * (x + d / 6.0)))
    q = solve_rolling(operator, MU * p, np.ascontiguousarray(w)).q
    moment = (x * q[1] - s * q[0]).sum()
    figures = (p.sum() * cell, q[0].sum() * cell, q[1].sum() * cell, moment * cell, p.max())
    assert figures == pytest.approx(published[:5], rel=2e-3)
    assert 0.4 * p.any(axis=0).sum() == pytest.approx(published[5])
    assert 0.4 * p.any(axis=1).sum() == pytest.approx(published[6])
