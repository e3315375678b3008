"""What the compiled kernels of the exact solver promise: the same numbers without the compiler, and no allocation."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numba import njit
from support.allocations import allocations
from support.hertz import Ellipse, EllipseGrid

from wrsim.contact.half_space import HalfSpace
from wrsim.contact.half_space.zones import find_footprints
from wrsim.core.contact.half_space import gmres, normal, patch, rolling
from wrsim.core.contact.half_space.rigid_slip import rigid_slip
from wrsim.core.contact.half_space.surface import AXIS, fill_gap, lay_axis

EVALUATE = """
from support.contacts import pair_model
from wrsim.contact.half_space import HalfSpace
model = pair_model("S1002/60E1 1:40", normal="half-space", tangential="half-space")
solver = HalfSpace(resolution=8, influence="angle-corrected")
model.arrays.pose[:] = (0.0, 4e-3, 0.46 - 1e-4, -4e-3, 1.0, 0.0, 10.0, 0.0, 0.0, 0.0, 10.0 / 0.46, 0.0)
contact = solver.solve_pose(model)
"""


def answer(contact):
    patch = contact.patches[0]
    return [*contact.force, *contact.moment, patch.p0, patch.area, patch.wear, patch.grid.pen.max()]


def test_kernels_give_the_same_numbers_without_the_compiler():
    names = {}
    exec(EVALUATE, names)
    run = subprocess.run(
        [sys.executable, "-c", EVALUATE + "\nfrom test_half_space_kernels import answer\nprint(*answer(contact))"],
        env=os.environ
        | {
            "NUMBA_DISABLE_JIT": "1",
            "PYTHONPATH": os.pathsep.join(str(Path(__file__).parents[n]) for n in (0, 1, 2)),
        },
        capture_output=True,
        text=True,
        check=True,
    )
    assert [float(x) for x in run.stdout.split()] == pytest.approx(answer(names["contact"]), rel=1e-8)


@njit
def surface(n, wheel, rail, pose, axis, gap, w):
    for _ in range(n):
        lay_axis(wheel, rail, 0.06, 0.06, False, -4e-3, 1e-3, axis)
        fill_gap(wheel, rail, axis, -2e-3, 1e-3, gap[0], gap[1])
        rigid_slip(pose, 0.05, axis, -2e-3, 1e-3, gap[1], w)


@njit
def pressures(n, descent, at, p, starts, ends):
    for _ in range(n):
        normal.errors(descent)
        normal.turn(descent, at, 1.0)
        normal.advance(descent, at)
        normal.admit(descent, 1e-6)
        patch.measure(p, 1e-4, 1e-4, starts, ends)


@njit
def tractions(n, equations, q, slip, out, z, w):
    for _ in range(n):
        rolling.march(slip, equations.bound, 1e-12, 1e-4, 1.0, q)
        rolling.evaluate(equations, q, slip, out)
        rolling.derivative(equations, q, slip, out)
        rolling.move(q, out, 0.5, equations.bound)
        gmres.extend(z, w, 1, z[0], w[0])


def test_kernels_allocate_nothing():
    names = {}
    exec(EVALUATE, names)
    footprints, _, _ = find_footprints(names["model"].arrays, HalfSpace())
    bodies = footprints[0].axis.bodies
    grid = EllipseGrid(Ellipse(4e-3, 4e-3), 8)
    p = grid.pressure()
    vectors = np.random.default_rng(2).uniform(size=(4, 2, *p.shape))
    flat = [field.ravel() for field in (p.copy(), p - 1e8, p > 0.0, p.copy(), p.copy(), p.copy(), p.copy())]
    equations = rolling.Equations(0.3 * p, 1e12, 1e12, 1.0, np.zeros_like(p), vectors[0].copy(), np.ones_like(p))
    scratch = np.random.default_rng(3).uniform(size=(2, 2, 50))
    for function, arguments in (
        (surface, (bodies.wheel, bodies.rail, bodies.pose, np.zeros(9, AXIS), *np.zeros((2, 2, 9, 5)))),
        (pressures, (normal.Descent(*flat[:6]), flat[6], p, *np.zeros((2, len(p))))),
        (tractions, (equations, *vectors[1:], *scratch)),
    ):
        # what is left is one record for each Python array at the door
        assert allocations(function, 1000, *arguments) == allocations(function, 1, *arguments)
