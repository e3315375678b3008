"""Stress and fatigue below the surface: closed forms, Hertz's contacts, balance of forces, laws of fatigue."""

from math import pi

import numpy as np
import pytest
from numpy.testing import assert_allclose
from support.contacts import PAIRS, contact_model, flat_rail, pair_model, round_wheel
from support.rows import data_rows

from wrsim import InputError
from wrsim.contact import FatigueLimits, Stress, SurfaceLoads, surface_loads
from wrsim.contact.settings import HalfSpaceSettings
from wrsim.contact.subsurface.fatigue import fatigue, passage, smallest_spheres
from wrsim.contact.subsurface.loads import LoadedRows

DEPTHS = np.array([0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1, 1.25, 1.667, 2.5, 5])
COMPONENTS = {"xx": 0, "ss": 1, "zz": 2}
LIMITS = FatigueLimits(300e6, 180e6)


def loads_on(rows: LoadedRows, nu: float = 0.28) -> SurfaceLoads:
    half = float(rows.a.max()), float((abs(rows.s) + 0.5 * rows.ds).max())
    return SurfaceLoads((rows,), 1, ((-half[0], half[0]), (-half[1], half[1])), float(rows.tractions[0].max()), nu)


def square(p: float, qx: float = 0.0, qs: float = 0.0, parts: int = 1) -> SurfaceLoads:
    """A square of 1 m, its middle a little aside."""
    ones, tractions = np.ones(parts), np.empty((3, parts, parts))
    tractions[:] = np.reshape((p, qx, qs), (3, 1, 1))
    s = 2e-4 + (np.arange(parts) + 0.5) / parts - 0.5
    return loads_on(LoadedRows(s, ones / parts, 1e-4 * ones, 0.5 * ones, tractions))


def ellipse(a: float, b: float, rows: int, parts: int, nu: float = 0.3, mu: float = 0.0) -> SurfaceLoads:
    """Hertz's pressure of peak 1 in uniform elements, with tractions mu p along x."""
    s = b * ((np.arange(rows) + 0.5) * 2.0 / rows - 1.0)
    half = a * np.sqrt(1.0 - (s / b) ** 2)
    x = np.linspace(-1.0, 1.0, parts + 1)
    means = np.diff(0.5 * (x * np.sqrt(1.0 - x * x) + np.arcsin(x))) * parts / 2.0
    p = (half / a)[:, None] * means
    return loads_on(LoadedRows(s, np.full(rows, 2.0 * b / rows), 0.0 * s, half, np.stack([p, mu * p, 0.0 * p])), nu)


def measure(stress: Stress, name: str) -> np.ndarray:
    if name.startswith("sigma"):
        return stress.principal[..., int(name[-1]) - 1]
    return stress.components[..., COMPONENTS[name]] if name in COMPONENTS else getattr(stress, name)


@pytest.mark.parametrize("row", data_rows("subsurface_square.csv"), ids=lambda r: "-".join(list(r.values())[:3]))
def test_a_loaded_square_has_the_extremes_of_contact(row):
    loads = square(1.0, 0.999 * (row["case"] == "2"))
    across = np.linspace(-2.0, 2.0, 21) if row["points"] == "block" else np.array([1e-5])
    x, y, z = np.meshgrid(across, across, DEPTHS, indexing="ij")
    values, expected = measure(loads.stress(x, y, z), row["measure"]), float(row["value_MPa"])
    largest = float(values.max() if expected > 0.0 else values.min())
    assert_allclose(largest, expected, rtol=0.01, atol=5e-4)  # printed with three decimals
    place = np.abs([axis - float(row[name]) for axis, name in zip((x, y, z), ("x_mm", "y_mm", "z_mm"), strict=True)])
    values_at_place = values[(place < 1e-4).all(axis=0)]
    assert_allclose(values_at_place, expected, rtol=0.01, atol=5e-4)


@pytest.mark.parametrize("load", np.eye(3).tolist())
def test_stress_below_a_square_is_that_of_point_loads(load):
    # Boussinesq's and Cerruti's stress zz is 3 z^2 (load . r) / (2 pi r^5), compression by a load towards the point
    x, s, z = 0.9, -0.6, 0.3
    middles = (np.arange(200) + 0.5) / 200 - 0.5
    dx, ds = x - 1e-4 - middles[:, None], s - 2e-4 - middles
    r = np.sqrt(dx**2 + ds**2 + z**2)
    towards = load[0] * z + load[1] * dx + load[2] * ds
    expected = -(3.0 * z**2 * towards / (2.0 * pi * r**5)).mean()
    assert_allclose(square(*load).stress(x, s, z).components[2], expected, rtol=1e-4)
    traction = square(*load).stress(x, s, z).components[[4, 3]]
    assert_allclose(traction, [-(3 * z * d * towards / (2 * pi * r**5)).mean() for d in (dx, ds)], rtol=1e-4)


def test_the_surface_bears_the_tractions_and_parts_add_up():
    loads = square(1.0, 0.2, -0.3, parts=4)
    inside = loads.stress(0.1, 0.07, 0.0).components
    assert_allclose(inside[[2, 4, 3]], [-1.0, -0.2, 0.3], atol=1e-12)
    assert_allclose(loads.stress(0.8, 0.1, 0.0).components[2:5], 0.0, atol=1e-12)
    for place in (
        (0.1, 0.07, 0.0),
        (0.25 + 1e-4, 2e-4, 0.0),
        (0.2, 0.25 + 2e-4, 0.0),
        (0.6, -0.3, 0.4),
    ):  # also where parts meet
        whole = square(1.0, 0.2, -0.3).stress(*place)
        assert_allclose(loads.stress(*place).components, whole.components, atol=1e-11)


def test_a_line_contact_has_its_largest_shear_where_hertz_has_it():
    # Johnson 1985, section 4.4: 0.300 p0 at 0.786 a
    z = np.linspace(0.7, 0.9, 201)
    row = ellipse(1.0, 1.0, 1, 400)
    long = loads_on(row.rows[0]._replace(ds=np.array([1e4]), a=np.ones(1)))
    shear = 0.5 * long.stress(0.0, 0.0, z).tresca
    assert_allclose([shear.max(), z[shear.argmax()]], [0.300, 0.786], rtol=3e-3)


@pytest.mark.parametrize("normal", ["strips", "kik-piotrowski", "half-space"])
def test_a_point_contact_has_its_largest_shear_where_hertz_has_it(normal):
    # Johnson 1985, section 4.4, nu = 0.3: 0.31 p0 at 0.48 a; STEEL has 0.28: 0.314 at 0.474
    coarse = HalfSpaceSettings(resolution=24)
    model = contact_model(round_wheel(0.46), flat_rail(), normal=normal, tangential="none", half_space=coarse)
    model.evaluate((0.0, 0.0, 0.46 - 5e-5))
    (rail,) = surface_loads(model)
    a = 0.5 * model.arrays.patches["length"][0]
    largest = rail.extreme("tresca")
    assert_allclose(0.5 * largest.value / rail.p0, 0.314, rtol=0.01)
    assert_allclose([largest.x / a, largest.s / a, largest.depth / a], [0.0, 0.0, 0.474], atol=0.02)
    (wheel,) = surface_loads(model, "wheel")
    assert wheel.extreme() == rail.extreme()


def test_stress_converges_with_the_elements():
    exact = ellipse(1.0, 0.7, 128, 128, mu=0.2).stress([0.2, -0.5], 0.1, [0.3, 0.5]).components
    errors = [np.abs(ellipse(1.0, 0.7, n, n, mu=0.2).stress([0.2, -0.5], 0.1, [0.3, 0.5]).components - exact).max()
              for n in (8, 16, 32)]  # fmt: skip
    assert errors[-1] < 3e-3
    assert np.log2(errors[0] / errors[2]) / 2.0 > 1.3  # the ends of the strips make 3/2


@pytest.mark.parametrize(
    ("normal", "tangential"),
    [("strips", "fastrip"), ("strips", "polach"), ("kik-piotrowski", "fastsim"), ("half-space", "half-space")],
)
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_tractions_of_elements_sum_up_to_the_forces(normal, tangential, direction):
    coarse = HalfSpaceSettings(resolution=12)
    model = pair_model(next(iter(PAIRS)), normal=normal, tangential=tangential, half_space=coarse)
    pose = (0.0, 2e-3, 0.46), (0.0, 1.0, 0.0), (direction * 20.0, 0.03, 0.0), (0.0, direction * 20.05 / 0.46, 0.0)
    for height in np.arange(0.46, 0.45, -4e-5):
        contact = model.evaluate((*pose[0][:2], height), *pose[1:])
        if contact.normal_force > 5e4:
            break
    (loads, *_) = surface_loads(model)
    areas = [2.0 * rows.a * rows.ds / rows.tractions.shape[2] for rows in loads.rows]
    force = sum((rows.tractions.sum(axis=2) * area).sum(axis=1) for rows, area in zip(loads.rows, areas, strict=True))
    expected = [sign * contact.patches[name].sum() for sign, name in ((1.0, "N"), (-1.0, "Fx"), (-1.0, "Fy"))]
    assert_allclose(force, expected, rtol=1e-9, atol=1e-9 * expected[0])
    bound = 0.3 * loads.rows[0].tractions[0] * (1.0 + 1e-9)
    assert (np.hypot(*loads.rows[0].tractions[1:]) <= bound + 1e-4 * loads.p0).all()


def test_fatigue_reaches_one_at_the_limits_of_reversed_bending_and_torsion():
    swing = np.sin(np.linspace(0.0, 2.0 * pi, 73))
    history = np.zeros((2, 73, 6))
    history[0, :, 0], history[1, :, 5] = 300e6 * swing, 180e6 * swing
    for values in fatigue(history, LIMITS):
        assert_allclose(values, 1.0, rtol=1e-6)
    # a constant stress does not fatigue, but for its hydrostatic part
    still = np.zeros((1, 3, 6))
    still[..., 3:] = 1e8
    assert_allclose(fatigue(still, LIMITS), 0.0, atol=1e-9)
    still[..., :3] = 30e6
    assert_allclose(fatigue(still, LIMITS), [[LIMITS.dang_van / 6.0], [LIMITS.crossland / 6.0]], rtol=1e-9)


def test_spheres_are_the_smallest():
    points = np.random.default_rng(3).normal(size=(20, 40, 5))
    centre, radius = smallest_spheres(points)
    reach = np.linalg.norm(points - centre[:, None], axis=-1)
    assert_allclose(reach.max(axis=1), radius)
    # the centre lies among the points on the sphere: no step away from it keeps them all inside
    for each, distances, r in zip(points - centre[:, None], reach, radius, strict=True):
        touching = each[distances > r * (1.0 - 1e-4)]
        assert all((touching @ d).max() > -1e-3 * r for d in np.random.default_rng(1).normal(size=(200, 5)))


def test_a_passage_without_friction_is_worst_below_the_surface():
    loads = ellipse(6e-3, 4e-3, 16, 20)
    loads = loads_on(loads.rows[0]._replace(tractions=1e9 * loads.rows[0].tractions))
    depth = np.linspace(1e-4, 6e-3, 16)
    values = passage(loads, np.zeros(16), depth, LIMITS)
    for criterion in values:
        assert 1e-3 < depth[criterion.argmax()] < 4e-3
        assert criterion.max() > 1.5 * criterion[-1]


def test_faults_of_stresses_and_limits_are_told():
    with pytest.raises(InputError, match="depth 0 or above"):
        square(1.0).stress(0.0, 0.0, -0.1)
    with pytest.raises(InputError, match=r"torsion_limit_MPa = 150: must lie from 173\.2 .* to 300"):
        FatigueLimits(300e6, 150e6)
    with pytest.raises(InputError, match="body = 'track': must be rail or wheel"):
        surface_loads(pair_model(next(iter(PAIRS))), "track")
