"""The normal problem on a grid: Hertz' ellipses, order of convergence, the laws of contact."""

import numpy as np
import pytest
from support.hertz import Ellipse, EllipseGrid

from wrsim.contact.half_space.normal import Pressure, solve_normal
from wrsim.contact.half_space.patch import stretches
from wrsim.contact.half_space.solver import Pressed

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


def test_the_solution_does_not_depend_on_the_start():
    grid = EllipseGrid(ELLIPSES["long"], 24)
    operator, pen = grid.operator(), grid.penetration()
    cold = solve_normal(operator, pen, 1e-8)
    warm = solve_normal(operator, pen, 1e-8, np.full(pen.shape, 1e8))
    assert warm.p == pytest.approx(cold.p, abs=1e-5 * cold.p.max())
    assert solve_normal(operator, pen, 1e-6, cold.p).steps == 0


@pytest.mark.parametrize(
    ("element", "reaches"), [((0, 2), True), ((-1, 2), True), ((2, 0), True), ((2, -1), True), ((1, 1), False)]
)
def test_contact_reaches_the_edge_in_the_outermost_elements_only(element, reaches):
    grid = EllipseGrid(ELLIPSES["circle"], 4)
    p = np.zeros((5, 5))
    p[element] = 1e6
    assert Pressed(grid, grid.operator(), Pressure(p, p, 1, 0.0, True)).reaches_edge is reaches
