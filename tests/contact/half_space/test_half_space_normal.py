"""The normal problem on a grid: Hertz' ellipses, order of convergence, the laws of contact."""

import numpy as np
import pytest
from support.hertz import Ellipse, EllipseGrid

from wrsim.contact.half_space.influence import NN, SS, XS, XX, Compliance, Operator, integrals
from wrsim.contact.half_space.normal import Pressure, solve_normal
from wrsim.contact.half_space.patch import stretches
from wrsim.contact.half_space.solver import NormalSolution
from wrsim.contact.settings import Material

ELLIPSES = {"circle": Ellipse(4e-3, 4e-3), "wide": Ellipse(2e-3, 7e-3), "long": Ellipse(9e-3, 1.5e-3)}


def figures(pressure, grid):
    """Area, p0 and force over Hertz'."""
    _, start, end = stretches(pressure.p)
    e, cell = grid.ellipse, grid.dx * grid.ds
    return (end - start).sum() * cell / e.area, pressure.p.max() / e.p0, pressure.p.sum() * cell / e.force


@pytest.mark.parametrize("shape", ELLIPSES)
@pytest.mark.parametrize("off", [(0.0, 0.0), (0.3, 0.5)])
def test_hertz_s_ellipse_at_the_default_resolution(shape, off):
    grid = EllipseGrid(ELLIPSES[shape], 36, off)
    pressure = solve_normal(grid.operator(), grid.penetration(), 1e-5)
    area, p0, force = figures(pressure, grid)
    # measured: area 0.25 %, p0 and force 0.03 %
    assert area == pytest.approx(1.0, abs=5e-3)
    assert p0 == pytest.approx(1.0, abs=1e-3)
    assert force == pytest.approx(1.0, abs=1e-3)
    assert np.abs(pressure.p - grid.pressure())[grid.pressure() > 0.3e9].max() < 0.015e9
    # the first guess is a semi-ellipse of the right height: a flat or a high one takes a step more
    assert solve_normal(grid.operator(), grid.penetration()).steps <= 8


def test_force_converges_at_second_order():
    errors = []
    for across in (12, 24, 48, 96):
        # mean over places of the grid: a single one scatters with the elements that the edge cuts
        offs = [(0.0, 0.0), (0.5, 0.5), (0.25, 0.0), (0.0, 0.3)]
        grids = [EllipseGrid(ELLIPSES["circle"], across, off) for off in offs]
        errors.append(np.mean([figures(solve_normal(g.operator(), g.penetration(), 1e-7), g)[2] - 1.0 for g in grids]))
    slope = -np.polyfit(np.log([12, 24, 48, 96]), np.log(errors), 1)[0]
    assert slope > 1.5


def test_pressures_push_and_surfaces_do_not_overlap():
    grid = EllipseGrid(ELLIPSES["wide"], 30, (0.2, 0.1))
    # a rough surface: several regions in contact
    rough = 4e-6 * np.random.default_rng(5).uniform(-1.0, 1.0, (grid.count, grid.count))
    pen = grid.penetration() + rough
    operator = grid.operator()
    pressure = solve_normal(operator, pen, 1e-6)
    assert pressure.converged
    gap = operator.normal(pressure.p) - pen
    assert np.abs(gap - pressure.gap).max() < 1e-12
    assert pressure.p.min() == 0.0
    assert gap.min() > -1e-6 * pen.max()
    assert np.abs(gap[pressure.p > 0.0]).max() <= 1e-6 * pen.max()


def test_the_solution_does_not_depend_on_the_start_nor_on_units():
    grid = EllipseGrid(ELLIPSES["long"], 24)
    operator, pen = grid.operator(), grid.penetration()
    cold = solve_normal(operator, pen, 1e-8)
    warm = solve_normal(operator, pen, 1e-8, np.full(pen.shape, 1e8))
    assert warm.p == pytest.approx(cold.p, abs=1e-5 * cold.p.max())
    assert solve_normal(operator, pen, 1e-6, cold.p).steps == 0
    assert solve_normal(operator, 1e-9 * pen, 1e-8).p == pytest.approx(1e-9 * cold.p, rel=1e-9)


@pytest.mark.parametrize(
    ("element", "reaches"), [((0, 2), True), ((-1, 2), True), ((2, 0), True), ((2, -1), True), ((1, 1), False)]
)
def test_contact_reaches_the_edge_in_the_outermost_elements_only(element, reaches):
    grid = EllipseGrid(ELLIPSES["circle"], 4)
    p = np.zeros((5, 5))
    p[element] = 1e6
    assert NormalSolution(grid, grid.operator(), Pressure(p, p, 1, 0.0, True)).reaches_edge is reaches


# Influence of loaded rectangles: closed forms against quadrature, convolutions against plain sums.
STEEL = Material(210e9, 0.28)
EQUAL = Compliance.of(STEEL, STEEL)
UNEQUAL = Compliance.of(STEEL, Material(70e9, 0.35))
KERNELS = (
    lambda x, s: 1.0 / np.hypot(x, s),
    lambda x, s: x**2 / np.hypot(x, s) ** 3,
    lambda x, s: s**2 / np.hypot(x, s) ** 3,
    lambda x, s: x * s / np.hypot(x, s) ** 3,
    lambda x, s: x / (x**2 + s**2),
    lambda x, s: s / (x**2 + s**2),
)


def rectangle(x, s, dx, ds):
    return integrals(x + dx * np.array([-0.5, 0.5]), s + ds * np.array([-0.5, 0.5]))[:, 0, 0]


@pytest.mark.parametrize(("x", "s"), [(2.0, 1.0), (-1.5, 0.0), (0.0, -2.0), (3.0, -2.0), (0.8, 0.7)])
def test_integrals_over_a_rectangle_equal_quadrature(x, s):
    dx, ds = 1.0, 0.6
    node, weight = np.polynomial.legendre.leggauss(60)
    weights = weight[:, None] * weight * dx * ds / 4.0
    quadrature = [(weights * f(x - 0.5 * dx * node[:, None], s - 0.5 * ds * node)).sum() for f in KERNELS]
    assert rectangle(x, s, dx, ds) == pytest.approx(quadrature, abs=1e-12)


def test_constants_and_a_square_s_yield_are_love_s_and_hertz_s_closed_forms():
    # integral of 1/r over the unit square from its centre: 4 asinh(1)
    influence_on_itself = rectangle(0.0, 0.0, 1.0, 1.0)
    assert influence_on_itself[NN] == pytest.approx(4.0 * np.arcsinh(1.0), rel=1e-14)
    assert influence_on_itself[XX] == pytest.approx(influence_on_itself[SS], rel=1e-14)
    assert influence_on_itself[XX] + influence_on_itself[SS] == pytest.approx(influence_on_itself[NN], rel=1e-14)
    assert influence_on_itself[XS] == 0.0
    assert EQUAL.modulus == pytest.approx(210e9 / 2.0 / (1.0 - 0.28**2))
    assert EQUAL.coupling == 0.0


def dense(compliance, rows, columns, ds, dx, angles):
    """All nine influences (3, rows, columns, 3, rows, columns) by plain sums, in the order x, s, n."""
    table = integrals(dx * (np.arange(2 * columns) - columns + 0.5), ds * (np.arange(2 * rows) - rows + 0.5))
    j, i = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    lag = (i[:, :, None, None] - i + columns - 1, j[:, :, None, None] - j + rows - 1)
    nn, xx, ss, xs, xn, sn = (table[k][lag] for k in range(6))
    n, t, k = compliance.normal, compliance.tangential, compliance.coupling
    flat = np.array([[n * nn + t * xx, t * xs, k * xn], [t * xs, n * nn + t * ss, k * sn], [-k * xn, -k * sn, n * nn]])
    alpha = (angles[None, :] - angles[:, None])[:, None, :, None]  # source minus receiver
    cos, sin = np.cos(alpha), np.sin(alpha)
    turned = flat.copy()
    turned[1] = flat[1] * cos - flat[2] * sin
    turned[2] = flat[2] * cos + flat[1] * sin
    return np.ascontiguousarray(turned.transpose(0, 2, 3, 1, 4, 5))


@pytest.mark.parametrize("compliance", [EQUAL, UNEQUAL])
@pytest.mark.parametrize("curved", [False, True])
@pytest.mark.parametrize("forward", [1.0, -1.0])
def test_convolutions_equal_plain_sums(compliance, curved, forward):
    rows, columns, ds, dx = 5, 7, 3e-4, 2e-4
    angles = 0.3 * np.linspace(-1.0, 1.2, rows) ** 2 + 0.2 if curved else np.zeros(rows)
    operator = Operator(rows, columns, ds, dx, compliance, angles if curved else None)
    # one column more, so that the displacement one element ahead is inside
    wide = dense(compliance, rows, columns + 2, ds, dx, angles)
    random = np.random.default_rng(3)
    load = random.normal(size=(3, rows, columns))
    p, q = load[2], load[:2]
    padded = np.zeros((3, rows, columns + 2))
    padded[:, :, 1:-1] = load
    u = {
        "p": np.einsum("ajibkl,bkl->aji", wide[:, :, :, 2:], padded[2:]),
        "q": np.einsum("ajibkl,bkl->aji", wide[:, :, :, :2], padded[:2]),
    }
    inner, ahead = slice(1, -1), slice(2, None) if forward > 0.0 else slice(0, -2)

    def slip(displacement):
        return (displacement[:2, :, inner] - displacement[:2, :, ahead]) / dx

    for ours, plain in (
        (operator.normal(p), u["p"][2, :, inner]),
        (operator.slip(q, forward), slip(u["q"])),
        (operator.normal_of_tractions(q), u["q"][2, :, inner]),
        (operator.slip_of_pressure(p, forward), slip(u["p"])),
    ):
        scale = max(np.abs(plain).max(), 1e-3 * np.abs(slip(u["q"])).max() if ours.ndim == 3 else 0.0)
        assert np.abs(ours - plain).max() <= 1e-9 * scale


def test_rows_without_coupling_act_alone():
    operator = Operator(4, 4, 1e-4, 1e-4, EQUAL)
    assert not operator.coupled
    assert not operator.normal_of_tractions(np.ones((2, 4, 4))).any()
    assert not operator.slip_of_pressure(np.ones((4, 4)), 1.0).any()
    rows, columns = 6, 4
    first = (np.arange(rows) < 3).astype(float)[:, None]
    shares = ((first, first), (1.0 - first, 1.0 - first))
    apart = Operator(rows, columns, 1e-4, 1e-4, EQUAL, shares=shares)
    alone = Operator(3, columns, 1e-4, 1e-4, EQUAL)
    p = np.random.default_rng(1).uniform(size=(rows, columns))
    assert apart.normal(p)[:3] == pytest.approx(alone.normal(p[:3]), rel=1e-12)
    q = np.stack([p, -p])
    assert apart.slip(q, 1.0)[:, :3] == pytest.approx(alone.slip(np.ascontiguousarray(q[:, :3]), 1.0), abs=1e-18)
