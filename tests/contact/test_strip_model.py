"""The strip model: exact for Hertz, close to CONTACT on profiles, continuous where Kik-Piotrowski jumps."""

import csv
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from support import contacts
from support.allocations import allocations
from support.hertz import hertz
from support.influence import made_table
from support.rows import rows_of
from support.sweeps import jumps, steepest

from wrsim.contact.batch import search_for
from wrsim.contact.half_space.solver import HalfSpace
from wrsim.contact.models import contact_model as wheel_on_rail
from wrsim.contact.pose import Pose
from wrsim.contact.prescribed_load import MOST_RESIDUALS, meet_load
from wrsim.contact.profiles.models import load_profile
from wrsim.contact.profiles.sections import circle
from wrsim.contact.profiles.wear import Removal, worn
from wrsim.contact.records import STATUS_NOT_CONVERGED
from wrsim.contact.settings import USUAL, ContactSettings, HalfSpaceSettings, Material
from wrsim.contact.status import SUBSTITUTED
from wrsim.contact.strips.derivatives import jacobian
from wrsim.contact.strips.equations import block_of, residuals
from wrsim.contact.strips.influence import displacement_at, find_terms
from wrsim.contact.strips.newton import JACOBIAN_PRICE
from wrsim.contact.strips.records import EDGES, VECTORS, V
from wrsim.contact.surfaces.out_of_round import RadiusTable
from wrsim.contact.tables import combined_modulus, influence_table
from wrsim.contact.wheel_rail import wheel_rail
from wrsim.jit import kernel
from wrsim.jit.dense import invert

table = rows_of(__file__)

JUMP, TWO_SOLUTIONS = 0.005, 0.04  # of the load; where the locus turns aside and a cold start finds two solutions
FAR_SHIFTED = 6.6e-3, 0.460661647, -19.1e-3  # lateral shift, height, yaw: strips as long as 32 mm reach over a waist
DATA = Path(__file__).parents[1] / "data"
STRIPS = {"normal": "strips"}


def potential(xi, t):
    """f(1, xi, t) from its definition, int sqrt((1 - x^2)/((xi - x)^2 + t^2)) dx."""
    nearest = np.arcsin(np.clip(xi, -1.0, 1.0))
    return quad(lambda v: np.cos(v) ** 2 / np.hypot(xi - np.sin(v), t), -0.5 * np.pi, 0.5 * np.pi,
                points=[nearest], epsabs=1e-12, epsrel=1e-12, limit=400)[0]  # fmt: skip


BESIDE = [0.0, 0.3, 0.99, 1.0, 1.01, 4.0, 60.0]


@pytest.mark.parametrize("xi", BESIDE)
@pytest.mark.parametrize("t", [1e-3, 0.5, 4.0, 300.0])
def test_primitive_of_the_influence_of_a_strip(xi, t):
    # int sqrt(1 - x^2) asinh(t/|xi - x|) dx: the other order of the two integrals
    nearest = np.arcsin(min(xi, 1.0))
    exact = quad(lambda v: np.cos(v) ** 2 * np.arcsinh(t / max(abs(xi - np.sin(v)), 1e-300)), -0.5 * np.pi,
                 0.5 * np.pi, points=[nearest], epsabs=1e-13, epsrel=1e-12, limit=400)[0]  # fmt: skip
    vectors = np.zeros((VECTORS, 1))
    vectors[[V.FROM, V.TO, V.INVERSE, V.PUSH, V.MIDDLE, V.NB], 0] = 0.0, t, 1.0, 1.0, 0.0, 1.0
    displacement = displacement_at(influence_table(), vectors, 0, 1, 0.0, 0.0, xi, 3, 0.0, 1.0, False, False)
    assert displacement.fore == pytest.approx(exact, rel=2e-5)
    assert displacement.aft == pytest.approx(displacement.fore, rel=1e-12)


def test_the_table_of_the_package_is_that_of_its_integral():
    np.testing.assert_allclose(influence_table(), made_table(), rtol=1e-12)


@pytest.mark.parametrize("xi", BESIDE)
@pytest.mark.parametrize("t", [0.01, 0.4, 3.0])
def test_terms_of_the_derivatives_are_those_of_the_displacement(xi, t):
    vectors = np.zeros((VECTORS, 1))
    vectors[[V.FROM, V.TO, V.INVERSE, V.PUSH, V.MIDDLE, V.NB], 0] = -0.3 * t, 1.2 * t, 1.0, 1.0, 0.0, 1.0
    terms = vectors[V.TERMS : V.TERMS + 5]
    find_terms(influence_table(), vectors, 0, 1, 0.0, xi, False, *terms)
    u, u_xi, turn, start, end = terms[:, 0]
    step = 1e-5
    beside = displacement_at(influence_table(), vectors.copy(), 0, 1, 0.0, xi, step, 3, 0.0, 1.0, False, False)
    assert u == pytest.approx(beside.middle, rel=1e-12)
    assert u_xi == pytest.approx((beside.fore - beside.aft) / (2.0 * step), rel=1e-4, abs=1e-6)
    assert (start, end) == pytest.approx((potential(xi, 0.3 * t), potential(xi, 1.2 * t)), rel=1e-4)
    assert turn == pytest.approx(1.2 * t * end + 0.3 * t * start, rel=1e-12)


@pytest.mark.parametrize("t", [0.01, 0.4, 3.0])
def test_the_row_of_the_middle_is_that_of_the_table(t):
    vectors = np.zeros((VECTORS, 1))
    vectors[[V.FROM, V.TO, V.INVERSE, V.PUSH, V.MIDDLE, V.NB], 0] = -0.3 * t, 1.2 * t, 1.0, 1.0, 0.0, 1.0
    displacements, terms = [], []
    for aligned in (True, False):
        fresh = vectors.copy()
        displacements.append(
            displacement_at(influence_table(), fresh, 0, 1, 0.0, 0.0, 0.5, 2, 0.0, 1.0, False, aligned)[:2]
        )
        find_terms(influence_table(), fresh, 0, 1, 0.0, 0.0, aligned, *fresh[V.TERMS : V.TERMS + 5])
        terms.append(fresh[V.TERMS : V.TERMS + 5, 0])
    assert displacements[0] == pytest.approx(displacements[1], rel=1e-12)
    np.testing.assert_allclose(terms[0], terms[1], rtol=1e-12, atol=1e-15)


@kernel
def worked(system, n, count, derive):
    """So many residuals, with Jacobians and their inverses or without."""
    total = 0.0
    for _ in range(count):
        total += residuals(system, n)
        if derive:
            jacobian(system, n)
            invert(system.matrix, system.memo[0].unknowns, system.vectors[V.PIVOT])
    return total


@pytest.mark.parametrize(("lateral", "yaw", "grids"), [(0.0, 0.0, 1), (3e-3, 0.01, 1), (5.5e-3, 0.0, 2)])
def test_a_budget_is_kept_and_half_as_many_strips_are_at_hand(lateral, yaw, grids):
    """From cold: never more than the budget; with 0.4 of what it takes N is within .2 % with half as many strips; with
    enough of it the contact is that without a budget, from the coarse one and from cold."""
    stand = contacts.bench(contacts.pair_model("S1002/60E1 1:40", normal="strips"), rolling=False)
    height, arrays = contacts.settle(stand, lateral, yaw, 60e3)[0].height, stand.wheels[0].model.arrays
    memo = arrays.rows.memo[0]

    def force(budget: float, cold: bool = True) -> tuple[float, int]:
        arrays.follow(not cold)
        memo.grids_before = 0 if cold else memo.grids_before
        memo.budget, memo.work = budget, 0.0
        stand.evaluate(lateral, height, yaw, 0.0)
        assert memo.work <= budget
        return float(arrays.rows.patches["N"].sum()), int(memo.strips)

    free, strips = force(np.inf)
    needed = memo.work
    assert strips == 16 and memo.grids == grids
    for share in (0.01, 0.05, 0.1, 0.2):
        force(share * needed)
    coarse, strips = force(0.4 * needed)
    assert strips == 8 and 1e-5 < abs(coarse / free - 1.0) < 2e-3
    for cold in (False, True):
        normal_force, strips = force(1400.0, cold)
        assert strips == 16 and normal_force == pytest.approx(free, rel=1e-8)


@pytest.mark.campaign
@pytest.mark.parametrize(("lateral", "grids"), [(0.0, 1), (5.5e-3, 2)])
def test_jacobians_and_residuals_take_as_much_time_as_a_budget_counts(lateral, grids):
    """Beside a residual of one grid: one of two grids, and Jacobians with their inverse."""
    benches = []
    for y in (0.0, lateral):
        stand = contacts.bench(contacts.pair_model("S1002/60E1 1:40", normal="strips"), rolling=False)
        stand.evaluate(y, contacts.settle(stand, y, 0.0, 60e3)[0].height, 0.0, 0.0)
        benches.append(contacts.strip_system(stand.wheels[0].model))
    took = np.full(3, np.inf)
    for _ in range(50):
        for i, ((system, n), derive) in enumerate(((benches[0], False), (benches[1], False), (benches[1], True))):
            began = time.perf_counter()
            worked(system, n, 20, derive)
            took[i] = min(took[i], time.perf_counter() - began)
    residual = 0.5 * (grids + grids**2)
    assert took[1] / took[0] == pytest.approx(residual, rel=0.3)
    assert (took[2] - took[1]) / took[0] == pytest.approx(JACOBIAN_PRICE * grids * residual, rel=0.4)


@pytest.mark.parametrize(
    ("pair", "lateral", "yaw", "influence"),
    [
        ("S1002/60E1 1:40", 0.0, 0.0, "half-space"),
        ("worn/worn 1:40", 1e-3, 0.02, "half-space"),
        ("S1002/60E1 1:40", 6.59e-3, 3e-3, "angle-corrected"),  # 45 degrees from end to end, with creep forces
    ],
)
def test_newton_s_matrix_is_the_derivative_of_the_residuals(pair, lateral, yaw, influence):
    turned = influence != "half-space"
    choices = {"damping": 0.0} if turned else contacts.PLAIN
    choices = choices | {"half_space": HalfSpaceSettings(influence=influence)}
    plain = contacts.bench(contacts.pair_model(pair, **contacts.PLAIN), rolling=False)
    stand = contacts.bench(contacts.pair_model(pair, normal="strips", strips=12, **choices), rolling=turned)
    stand.evaluate(lateral, contacts.settle(plain, lateral, yaw, 60e3)[0].height, yaw, 0.0)
    system, n = contacts.strip_system(stand.wheels[0].model)
    f, x = system.vectors[V.F], system.vectors[V.X]
    residuals(system, n)
    jacobian(system, n)
    solved = system.vectors[V.UNKNOWN_INDEX, : system.memo[0].unknowns].astype(int)
    matrix, differences = system.matrix[: solved.size, : solved.size].copy(), np.zeros((solved.size,) * 2)
    for column, unknown in zip(differences.T, solved, strict=True):
        value, step = (
            x[unknown],
            1e-5 * x[unknown] if unknown < 2 * n else 1e-8,
        )  # a^2 and factors; edges and middles [m]
        for side in (1.0, -1.0):
            x[unknown] = value + side * step
            residuals(system, n)
            column += side * f[solved] / (2.0 * step)
        x[unknown] = value
    allowed = np.full_like(matrix, 1e-6)
    behind = solved % block_of(n) - 2 * n
    allowed[np.ix_(behind < 0, (behind == 0) | (behind == 1))] = 1e-3  # read between rows
    if yaw:  # weights of a parabola of a^2, and of strips in the means of a line, count as fixed
        allowed[solved < n], allowed[behind >= EDGES] = 1e-3, 1e-2
    if turned:  # lateral forces lie straight between rows, and their lift stays where half lengths change
        allowed = np.maximum(allowed, 2e-2)
    assert (np.abs(matrix - differences) <= allowed * np.abs(differences).max(axis=0)).all()


@pytest.mark.parametrize(("pair", "lateral", "yaw", "wrong"), table("a_yawed_wheel_presses_as_the_half_space_does"))
def test_a_yawed_wheel_presses_as_the_half_space_does(pair, lateral, yaw, wrong):
    model = contacts.pair_model(pair, **STRIPS, **contacts.PLAIN)
    contacts.settle(contacts.bench(model, rolling=False), lateral, yaw, 60e3)
    lobes = model.arrays.patches[: model.arrays.total.lobes]
    exact = HalfSpace(resolution=20).solve_pose(model)
    assert lobes["p0"].max() == pytest.approx(max(patch.p0 for patch in exact.patches), rel=wrong)
    assert lobes["N"].sum() == pytest.approx(exact.normal_force, rel=0.01)


@pytest.mark.parametrize(("lateral", "load"), table("a_peak_as_narrow_as_three_strips_is_that_of_the_half_space"))
def test_a_peak_as_narrow_as_three_strips_is_that_of_the_half_space(lateral, load):
    """A peak of 0.6 mm beside a wide flat one on the flange root. 64 strips are up to 0.031 low there."""
    model = contacts.pair_model("S1002/54E1 1:20", **STRIPS, **contacts.PLAIN)
    contacts.settle(contacts.bench(model, rolling=False), lateral, 2e-3, load)
    exact = HalfSpace(element=(4e-4, 1e-4)).solve_pose(model)
    assert model.arrays.patches["p0"].max() == pytest.approx(exact.patches[0].p0, rel=0.035)


def test_the_peak_does_not_jump_where_another_strip_becomes_the_largest():
    stand = contacts.bench(contacts.pair_model("S1002/54E1 1:20", **STRIPS, **contacts.PLAIN), rolling=False)
    lateral = np.linspace(6.594e-3, 6.599e-3, 51)
    heights = np.linspace(*(contacts.settle(stand, y, 2e-3, 100e3)[0].height for y in lateral[[0, -1]]), lateral.size)
    peaks, largest = np.empty(lateral.size), np.empty(lateral.size, int)
    for i, (y, height) in enumerate(zip(lateral, heights, strict=True)):
        stand.evaluate(y, height, 2e-3, 0.0)
        contact = contacts.contact_of(stand)
        peaks[i], largest[i] = contact.patches[0]["p0"], contact.strips[0]["p"].argmax()
    assert largest[0] != largest[-1]
    steps = np.abs(np.diff(peaks)) / peaks[1:]
    assert steps.max() < 2.0 * np.median(steps)


@pytest.mark.parametrize("strips, wrong", [(12, 0.02), (16, 0.016), (48, 0.008)])
@pytest.mark.parametrize("ratio", [0.022, 0.1, 0.5, 1.0, 2.0, 10.0])
def test_hertz_ellipses_are_exact_up_to_the_strips(ratio, strips, wrong):
    # unlike Kik-Piotrowski: a, b, area, N and p0 themselves; A/B from slender across to slender along
    radius, approach = 0.46, 5e-6
    wheel = contacts.round_wheel(ratio * radius, min(0.02, 0.5 * ratio * radius))
    model = contacts.contact_model(wheel, contacts.flat_rail(), normal="strips", strips=strips, **contacts.PLAIN)
    lobe = model.evaluate((0.0, 0.0, radius - approach)).patches[0]
    length = 2.0 * ratio * radius
    exact = hertz(ratio, approach / length)
    modulus = combined_modulus(model.settings)
    measured = (
        0.5 * lobe["length"] / length / exact.a,
        0.5 * lobe["width"] / length / exact.b,
        lobe["area"] / length**2 / exact.area,
        lobe["N"] / (modulus * length**2) / exact.force,
        lobe["p0"] / modulus / exact.p0,
    )
    assert measured == pytest.approx((1.0,) * 5, abs=wrong)
    # of the strips' own pressures 1/(6 n^2) is their width's
    assert measured[4] == pytest.approx(1.0, abs=0.06 / strips**2 + 3e-4)


def test_overlaps_far_apart_press_each_other_down_as_in_the_half_space():
    # root and tread at once, 6 mm between their overlaps: with distances between contacts N is 4 % off
    model = contacts.pair_model("S1002/54E1 1:20", **STRIPS, **contacts.PLAIN)
    contacts.settle(contacts.bench(model, rolling=False), 5.627e-3, 2e-3, 60e3)
    normal_force = model.arrays.patches["N"][: model.arrays.total.lobes].sum()
    assert normal_force == pytest.approx(HalfSpace(resolution=24).solve_pose(model).normal_force, rel=0.005)


@pytest.mark.parametrize(("groove", "spin", "approach", "p0"), table("a_ball_in_a_deep_groove_with_turned_influence"))
def test_a_ball_in_a_deep_groove_with_turned_influence(groove, spin, approach, p0):
    """Published with CONTACT, version 3 of its corrections (after Li 2002): 10 kN, friction 0.3, patches of 33 to 67
    degrees. By the influence of a plane half-space p0 is 2.0, 3.0 and 3.8 % higher, without creep forces 1.7 to 3.7."""
    steel = Material(2.0 * 80e9 * 1.28, 0.28)
    ball, trough = circle("ball", "wheel", -0.010, 0.0096), circle("groove", "rail", -1e-3 * groove, 0.0098)
    turned = {"half_space": HalfSpaceSettings(influence="angle-corrected"), "wheel": steel, "rail": steel}
    model = wheel_on_rail(ball, trough, 0.42, ContactSettings(**STRIPS, damping=0.0, **turned), 0.3)

    def pressed(depth):
        return model.evaluate((0.0, 0.0, 0.42 - depth), velocity=(0.42, 0.0, 0.0), omega=(0.0, spin, 0.0))

    depth_at_load = brentq(lambda depth: pressed(depth).force[2] - 1e4, 0.9 * approach, 1.1 * approach, xtol=1e-10)
    # measured: 0.001 and 0.003
    assert depth_at_load == pytest.approx(approach, rel=0.002)
    assert pressed(depth_at_load).patches["p0"].max() == pytest.approx(p0, rel=0.005)


@pytest.mark.parametrize("yaw", [13e-3, 16e-3, 20e-3, 24e-3, 28e-3])
def test_a_tip_against_a_steep_face_is_hertz_however_slanted(yaw):
    """The back of a tram's flange, an arc of 9 mm, on the straight guard face: a narrow ellipse along the wheel's
    circumference, which leans by 3 to 10 degrees against the rail. Strips lie beside one another along x by three half
    lengths and more."""
    rail, radius = load_profile(contacts.MODELS / "rails/grooved_narrow.toml"), 0.33
    model = contacts.contact_model(contacts.wheel_profile("tram"), rail, radius=radius, tangential="none", **STRIPS)
    stand = contacts.bench(model, rolling=False)
    lobes = model.arrays.patches

    def approach(lateral):
        stand.evaluate(lateral, radius + 1e-4, yaw, 0.0)  # the tread is lifted
        return lobes[0]["approach"] if model.arrays.total.lobes else 0.0

    closed = next(y for y in np.arange(0.0, -3e-3, -1e-5) if approach(y) > 0.0)
    touching = brentq(lambda y: approach(y) - 2.5e-5, closed - 4e-5, closed + 1e-5)
    depth = approach(touching)
    assert model.arrays.total.lobes == 1 and np.degrees(lobes[0]["angle"]) == pytest.approx(-80.538, abs=0.1)
    around = radius / np.cos(lobes[0]["angle"])
    exact = hertz(9e-3 / around, depth / (2.0 * 9e-3))
    modulus = combined_modulus(model.settings)
    # measured: 0.040 with 13, 20 and 24 mrad: strips have straight ends; 0.056 where a^2 is held half as firmly
    assert lobes[0]["p0"] / modulus == pytest.approx(exact.p0, rel=0.05)
    assert lobes[0]["N"] / (modulus * (2.0 * 9e-3) ** 2) == pytest.approx(exact.force, rel=0.03)


def test_creep_forces_do_not_jump_where_a_lobe_beyond_a_gap_becomes_part_of_another():
    """At 5.83 mm the lobe on the tread has no main point of its own any more: one patch with a gap in it, whose far
    part must not count as if the whole width between were touched. A jump there made wagons chatter."""
    stand = contacts.bench(contacts.pair_model("S1002/60E1 1:40", tangential="fastrip", **STRIPS))
    forces, strips = [], []
    for lateral in np.arange(5.79e-3, 5.871e-3, 1e-5):
        patches = contacts.settle(stand, lateral, 1.3e-3, 127e3)[1].patches
        forces.append([patches["Fx"].sum() / 127e3, patches["Fy"].sum() / 127e3])
        strips.append(int(np.count_nonzero(patches["N"])))
    assert strips[0] == 2 and strips[-1] == 1
    changes = np.abs(np.diff(forces, axis=0)).max(axis=1)
    assert changes.max() < 2.0 * np.median(changes)


@pytest.mark.parametrize(
    ("inclination", "load"), [("1:40", "24000"), ("1:40", "100000"), ("1:20", "24000"), ("1:20", "100000")]
)
def test_pressure_and_approach_are_those_of_contact(inclination, load):
    # frictionless rows with one region (in two regions one approach is not defined)
    with open(DATA / "contact_own_static.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    model = contacts.pair_model(f"S1002/60E1 {inclination}", **STRIPS, tangential="none")
    stand = contacts.bench(model, rolling=False)
    peaks, approaches, truth = [], [], HalfSpace(resolution=30)
    for r in rows:
        if (r["cant_label"], r["tang"], r["Fz_req_N"]) != (inclination, "0", load):
            continue
        if r["n_patches"] != "1" or r["n_components"] != "1":
            continue
        solved, contact = contacts.settle(stand, 1e-3 * float(r["y_ws_mm"]), float(r["yaw_rad"]), float(load))
        assert not solved.message
        # on the flange, 8 mm, our own exact solver is .4 and 2.2 % beside these rows of CONTACT
        exact = 1e-6 * truth.solve_pose(model).patches[0].p0 / float(r["pmax_MPa"])
        assert abs(exact - 1.0) < 0.023
        peaks.append(1e-6 * contact.patches["p0"].max() / float(r["pmax_MPa"]) - exact)
        main = contact.patches[contact.patches["N"].argmax()]
        approaches.append(1e3 * main["approach"] / float(r["pen_mm"]) - 1.0)
    assert len(peaks) >= 9
    # measured: 0.0015, 0.0055; 0.005, 0.0265 (the largest on the flange, 8 and 9 mm; the exact solver's is as large)
    assert np.mean(np.abs(peaks)) < 0.003 and np.max(np.abs(peaks)) < 0.009
    assert np.mean(np.abs(approaches)) < 0.007 and np.max(np.abs(approaches)) < 0.03


def test_where_a_run_came_from_does_not_show():
    model = contacts.pair_model("S1002/60E1 1:40", **STRIPS, **contacts.PLAIN)
    stand = contacts.bench(model)
    contacts.settle(stand, 4e-3, 0.004, 60e3)
    arrays = model.arrays
    pose = arrays.pose.copy()
    arrays.follow(True)
    forces = []
    for step in (1e-6, -7e-6, 40e-6):
        arrays.pose[1] = pose[1] + 10 * step
        arrays.evaluate()
        for k in range(10, -1, -1):
            arrays.pose[1] = pose[1] + k * step
            arrays.evaluate()
        forces.append(arrays.force)
    arrays.follow(False)
    arrays.evaluate()
    # demanded: 1e-7 of the load
    assert np.abs(np.array(forces) - arrays.force).max() < 1e-7 * 60e3


def runs(arrays):
    """Strips of each stretch of contact without a gap; single ones are left out."""
    rows = []
    for i in range(arrays.total.lobes):
        strips_of_lobe = arrays.strips[i, : arrays.patches[i].n_strips].copy()
        strips_of_lobe["s"] += arrays.patches[i].arc_rail
        rows.append(strips_of_lobe)
    strips = np.concatenate(rows)
    gaps = strips["s"][1:] - 0.5 * strips["ds"][1:] - strips["s"][:-1] - 0.5 * strips["ds"][:-1]
    return [run for run in np.split(strips, np.flatnonzero(gaps > 1e-8) + 1) if len(run) > 1]


@pytest.mark.parametrize(("wheel", "lateral", "yaw", "wrong"), table("no_end_stands_out"))
def test_no_end_stands_out_and_every_region_bears_what_the_half_space_does(wheel, lateral, yaw, wrong):
    model = contacts.contact_model(
        contacts.wheel_profile(wheel), contacts.rail_profile("worn", 40), **STRIPS, **contacts.PLAIN
    )
    contacts.settle(contacts.bench(model, rolling=False), lateral, yaw, 100e3)
    borne = []
    for run in runs(model.arrays):
        q = run["N"] / run["ds"]
        borne.append(run["N"].sum())
        assert len(run) < 3 or (q[0] < 1.25 * q[1] and q[-1] < 1.25 * q[-2])
    exact = [region.normal_force for patch in HalfSpace().solve_pose(model).patches for region in patch.regions]
    assert sorted(borne) == pytest.approx(sorted(exact), rel=wrong)


@pytest.mark.parametrize("pair", ["S1002/60E1 1:40", "worn/60E1 1:40", "worn/worn 1:40"])
def test_random_poses_are_solved_afresh(pair):
    # one lobe or several, shoulders, flanks, 1 to 300 um deep at large yaw: 1 of 20 000 was not
    random = np.random.default_rng(5)
    stand = contacts.bench(contacts.pair_model(pair, **STRIPS, **contacts.PLAIN), rolling=False)
    model = stand.wheels[0].model
    for _ in range(10):
        lateral, yaw = random.uniform(-12e-3, 12e-3), random.uniform(-60e-3, 60e-3)
        touching = contacts.settle(stand, lateral, yaw, 10.0)[0].height
        for depth in 1e-6 * 300.0 ** random.uniform(0.0, 1.0, 4):
            stand.evaluate(lateral, touching - depth, yaw, 0.0)
            assert not model.arrays.evaluate() & STATUS_NOT_CONVERGED, (lateral, yaw, depth)


@pytest.mark.parametrize(("lateral", "yaw", "depth"), [
    (0.451427e-3, 1.109182e-3, 8.54e-6), (1.607743e-3, -56.540297e-3, 10.98e-6), (0.560710e-3, 9.755513e-3, 11.2e-6),
])  # fmt: skip
def test_a_shoulder_that_all_but_touches_beyond_a_gap_is_solved(lateral, yaw, depth):
    # edges moved out to it, no strip touched there, and they were drawn in again: most of these were not solved
    stand = contacts.bench(contacts.pair_model("S1002/60E1 1:40", **STRIPS, **contacts.PLAIN), rolling=False)
    model = stand.wheels[0].model
    touching = contacts.settle(stand, lateral, yaw, 10.0)[0].height
    forces = []
    for share in np.linspace(0.97, 1.03, 13):
        stand.evaluate(lateral, touching - share * depth, yaw, 0.0)
        assert not model.arrays.evaluate() & STATUS_NOT_CONVERGED
        forces.append(model.arrays.patches["N"][: model.arrays.total["lobes"]].sum())
    assert np.all(np.diff(forces) > 0.0)


@pytest.mark.parametrize(("lateral", "yaw", "loads", "wrong"), [
    (9.557560e-3, 53.265511e-3, (15.8e3, 12e3, 10e3), 0.08),
    pytest.param(9.159597e-3, -59.530927e-3, (3.3e3, 2.5e3, 2e3), 0.13, marks=pytest.mark.campaign),
])  # fmt: skip
def test_a_narrow_contact_with_an_end_as_long_as_can_be_is_solved(lateral, yaw, loads, wrong):
    """The tip of a tram's flange on a grooved rail, 20 mm along the rail and 1.5 mm across, curvatures along the rail
    four times as large at one end: the gap along a strip is no parabola there."""
    rail = load_profile(contacts.MODELS / "rails/grooved.toml")
    model = contacts.contact_model(contacts.wheel_profile("tram"), rail, radius=0.3, **STRIPS, **contacts.PLAIN)
    stand = contacts.bench(model, rolling=False)
    for load in loads:
        _solved, contact = contacts.settle(stand, lateral, yaw, load)
        assert not model.arrays.evaluate() & STATUS_NOT_CONVERGED and model.arrays.substitutes == 0
        assert contact.normal_force == pytest.approx(HalfSpace(resolution=16).solve_pose(model).normal_force, rel=wrong)


@pytest.mark.parametrize(("pair", "lateral", "load"), [
    ("S1002/60E1 1:20", 6.478206e-3, 24e3), ("S1002/60E1 1:40", 6.605775e-3, 15e3),
])  # fmt: skip
def test_where_the_penetration_bends_within_a_strip_newton_s_method_is_quadratic(pair, lateral, load):
    # a slope read between rows is off by a quarter there: a fifth of the residual was gone in a step, and none solved
    stand = contacts.bench(contacts.pair_model(pair, **STRIPS, **contacts.PLAIN), rolling=False)
    model = stand.wheels[0].model
    height = contacts.settle(stand, lateral, 0.0, load)[0].height
    for less in np.linspace(-1e-6, 1e-6, 5):
        stand.evaluate(lateral, height + less, 0.0, 0.0)
        assert not model.arrays.evaluate() & STATUS_NOT_CONVERGED
        assert model.arrays.rows.memo[0].iterations < 60


WORN = ("S1002", "worn", 20)


def bench_of(wheel, rail, inclination):
    rail = contacts.rail_profile(rail, inclination)
    return contacts.bench(contacts.contact_model(contacts.wheel_profile(wheel), rail, **STRIPS, **contacts.PLAIN))


@pytest.mark.parametrize(("pair", "lateral", "yaw", "roll", "load", "residuals"), [
    # far grids come into contact one by one: both at once never settled, 76 500 times the median
    (WORN, 8.13006e-3, 37.8911e-3, -5.5088e-3, 76.4e3, 200),
    # the ground of two lobes goes on over a gap: no strip belongs to both, else N is 27 % high
    (WORN, 5.517967e-3, -14.4218e-3, -0.530688e-3, 119.7e3, 200),
    (("S1002", "54E1", 20), 5.285521957e-3, 13.119826549e-3, 0.065067402e-3, 184.222e3, 200),
    # a maximum below the chord from a higher one to the end of the overlap: without it N is 5.5 % low
    (("S1002", "worn", 40), 4.528706e-3, -4.445761e-3, 5.719399e-3, 132681.475, 400),
])  # fmt: skip
def test_poses_with_several_humps_carry_their_load_as_the_half_space_does(pair, lateral, yaw, roll, load, residuals):
    stand = bench_of(*pair)
    model = stand.wheels[0].model
    solved, contact = contacts.settle(stand, lateral, yaw, load, roll)
    assert (solved.message, solved.remark, model.arrays.status) == ("", "", 0)
    assert model.arrays.rows.memo[0].strips == 16
    assert model.arrays.rows.memo[0].iterations < residuals
    assert float(model.arrays.total["Fb"]) == pytest.approx(load, rel=1e-6)
    assert contact.force[2] == pytest.approx(HalfSpace(resolution=20).solve_pose(model).force[2], rel=2e-3)


def test_the_shallowest_contacts_are_solved_and_hertz_s():
    stand = bench_of("S1002", "60E1", 20)
    model = stand.wheels[0].model
    a = model.arrays
    stand.place(8.918934e-3, 0.48, -38.437184e-3, 8.955071e-3)
    for _ in range(60):
        a.evaluate()
        a.pose[2] -= a.total["closest"] if a.total["closest"] > 0.0 else 0.0
    touching, forces = float(a.pose[2]), []
    depths = 10.0 ** np.arange(-13.0, -5.0)
    for depth in depths:
        a.pose[2] = touching - depth
        assert a.evaluate() == 0
        forces.append(float(a.total["Fb"]))
    assert np.diff(np.log10(forces[2:])) == pytest.approx(1.5, abs=1e-3)


def test_a_load_in_a_jump_of_the_force_has_the_contact_of_the_half_space_and_says_so():
    stand = bench_of(*WORN)
    solved = stand.solve(Pose("jump", -0.961843e-3, 19.070867e-3, 64255.633, 8.858774e-3))
    assert "the contact is that of the half-space solver" in solved.remark and not solved.message
    held = stand.holders[0].model
    assert held.settings.normal == "half-space" and held.arrays.status & SUBSTITUTED
    assert float(held.arrays.total["Fb"]) == pytest.approx(64255.633, rel=1e-4)
    # the next pose is the strip model's again
    assert not stand.solve(Pose("plain", 0.0, 0.0, 60e3)).remark and stand.holders == stand.wheels


def test_a_load_takes_at_most_fifty_times_the_residuals_of_the_median():
    stand, draw, spent = bench_of("S1002", "60E1", 40), np.random.default_rng(3), []
    for _ in range(60):
        lateral, yaw, roll = draw.uniform(-1.0, 1.0, 3) * (12e-3, 40e-3, 10e-3)
        stand.place(lateral, 0.49, yaw, roll)
        a = stand.wheels[0].model.arrays
        search = search_for([draw.uniform(1e3, 200e3)], a.pose[2], contacts.RADIUS, a.model.E)[0]
        assert meet_load(a.buffer, a.index, search) & ~3 == 0
        spent.append(int(search["residuals"]))
    assert 0.7 < MOST_RESIDUALS / (50.0 * np.median(spent)) < 1.5


def test_a_measured_wheel_with_roughness_between_its_sections_carries_every_load_by_strips():
    draw = np.random.default_rng(5)
    sections, across = np.linspace(0.0, 2.0 * np.pi, 36, endpoint=False), np.linspace(-60e-3, 60e-3, 25)
    rough = RadiusTable(sections, across, draw.uniform(-5e-6, 5e-6, (36, 25)))
    rail = contacts.rail_profile("60E1", 40)
    model = wheel_on_rail(contacts.wheel_profile("S1002"), rail, 0.46, ContactSettings(), 0.3, out_of_round=[rough])
    stand = contacts.bench(model)
    for _ in range(20):
        lateral, yaw = draw.uniform(-1.0, 1.0, 2) * (8e-3, 5e-3)
        pose = Pose("rough", lateral, yaw, draw.uniform(20e3, 120e3), wheel_angle=draw.uniform(0.0, 2.0 * np.pi))
        solved = stand.solve(pose)
        assert (solved.message, solved.remark) == ("", "")


def rippled(seed, strips):
    """S1002 with furrows of .5 mm, some 40 um deep, on 60E1: more contacts than strips are made for."""
    r = np.random.default_rng(seed)
    furrows = [Removal("vertical", r.uniform(2e-5, 6e-5), c, 0.5e-3) for c in np.arange(-42e-3, 20e-3, 0.7e-3)]
    wheel = worn(contacts.wheel_profile("S1002"), furrows, "rippled")
    return contacts.contact_model(
        wheel, contacts.rail_profile("60E1", 40), normal="strips", strips=strips, **contacts.PLAIN
    )


@pytest.mark.parametrize(("seed", "strips", "lateral", "yaw", "solved"), [
    *(pytest.param(8, 12, y, 0.0, True, marks=pytest.mark.campaign) for y in (-3.2e-3, -2.0e-3)),
    (3, 16, 6.6e-3, 0.01, True), (3, 16, -3.2e-3, 0.05, False),
])  # fmt: skip
def test_what_cannot_be_solved_is_bounded_counted_and_told(seed, strips, lateral, yaw, solved):
    model = rippled(seed, strips)
    stand = contacts.bench(model, rolling=False)
    plain = contacts.bench(contacts.contact_model(model.wheel, model.rail, **contacts.PLAIN), rolling=False)
    stand.evaluate(lateral, contacts.settle(plain, lateral, yaw, 60e3)[0].height, yaw, 0.0)
    a = model.arrays
    assert bool(a.status & STATUS_NOT_CONVERGED) != solved
    assert a.substitutes == (0 if solved else 1)
    assert ("the strip model was not solved" in stand._problem(60e3)) != solved
    lobes = a.patches[: a.total.lobes]
    exact = HalfSpace(resolution=10).solve_pose(model).normal_force
    # measured: 0.899; and 0.778 by Kik-Piotrowski, which leaves out lobes beyond the fourth as well
    assert (0.88 if solved else 0.75) * exact < lobes["N"].sum() < 1.2 * exact
    for i, lobe in enumerate(lobes if solved else ()):
        strips = a.strips[i, : lobe["n_strips"]]
        # the displacement at the outer points, .866 a from the middle, is d less .75 a^2/(2 R), and above nothing
        assert (0.75 * strips["a"] ** 2 <= 2.0 * strips["r_t"] * np.maximum(strips["penetration"], 2e-8)).all()


def test_an_evaluation_allocates_nothing():
    for follow in (False, True):
        stand = contacts.bench(contacts.pair_model("S1002/60E1 1:40", **STRIPS))
        contacts.settle(stand, 4e-3, 0.004, 60e3)
        arrays = stand.wheels[0].model.arrays
        arrays.follow(follow)
        assert allocations(wheel_rail, arrays.buffer, arrays.index) == 0


def jumping(name: str) -> list[Any]:
    """Rows of the suite, of the campaign, and those with two solutions."""
    rare = {"_campaign": JUMP, "_two_solutions": TWO_SOLUTIONS}
    return [(*row, JUMP) for row in table(name)] + [
        pytest.param(*row, most, marks=pytest.mark.campaign)
        for kind, most in rare.items()
        for row in table(name + kind)
    ]


@pytest.mark.parametrize(("pair", "yaw", "load", "span", "most"), jumping("between_equal_radii"))
def test_forces_between_equal_radii_do_not_jump(pair, yaw, load, span, most):
    assert jumps(pair, yaw, load, tuple(span), most=4, **STRIPS, **contacts.PLAIN)[:, 1].max() < most


@pytest.mark.parametrize(("pair", "yaw", "lateral", "load", "most"), jumping("as_a_wheel_comes_down"))
def test_forces_do_not_jump_as_a_wheel_comes_down(pair, yaw, lateral, load, most):
    stand = contacts.bench(contacts.pair_model(pair, **STRIPS, **contacts.PLAIN), rolling=False)
    height = contacts.settle(stand, lateral, yaw, load)[0].height

    def force(less):
        stand.evaluate(lateral, height - less, yaw, 0.0)
        return stand.force / load

    assert steepest(force, np.arange(-6e-6, 6e-6, 5e-7), 3)[:, 1].max() < most


@pytest.mark.parametrize(("pair", "lateral", "yaw"), table("yaw_to_the_left_presses_as_yaw_to_the_right_does"))
def test_yaw_to_the_left_presses_as_yaw_to_the_right_does(pair, lateral, yaw):
    # a wheel of revolution on a rail that goes straight on: seen from behind the rail is the same. Rounding alone
    # differs, and Newton's method leaves 1e-9.
    stand = contacts.bench(contacts.pair_model(pair, **STRIPS, **contacts.PLAIN), rolling=False)
    a = stand.wheels[0].model.arrays
    height = contacts.settle(stand, lateral, yaw, 60e3)[0].height
    numbers = []
    for sign in (1.0, -1.0):
        stand.evaluate(lateral, height, sign * yaw, 0.0)
        count = int(a.total.lobes)
        numbers.append(np.concatenate([a.patches[name][:count] for name in ("N", "p0", "area")]))
        numbers.append(-sign * a.patches["x"][:count])
    assert numbers[2] == pytest.approx(numbers[0], rel=1e-7)
    assert numbers[3] == pytest.approx(numbers[1], rel=1e-7, abs=1e-9)


@pytest.mark.parametrize("yaw", [0.0, 0.012])
def test_a_hump_beyond_a_gap_has_strips_of_its_own(yaw):
    # one lobe with a shoulder that comes down beside it: its force grows from nothing, between edges of its own
    stand = contacts.bench(contacts.pair_model("worn/60E1 1:40", **STRIPS, **contacts.PLAIN), rolling=False)
    a = stand.wheels[0].model.arrays
    height = contacts.settle(stand, 5.6e-3, yaw, 100e3)[0].height
    borne = []
    for less in np.arange(34e-6, 14.4e-6, -0.5e-6):  # then the gap has closed
        stand.evaluate(5.6e-3, height + less, yaw, 0.0)
        regions = runs(a)
        assert a.total.lobes == 1 and all(len(run) == USUAL["strips"].strips for run in regions)
        borne.append(regions[1]["N"].sum() / regions[0]["N"].sum() if len(regions) == 2 else 0.0)
    steps = np.diff(borne)
    assert borne[0] == 0.0 and borne[-1] > 0.02
    # measured: 0.0001 in the first step, 0.0016 at most
    assert (steps > -1e-9).all() and steps.max() < 0.002 and steps[steps > 0.0][0] < 0.001


def test_force_does_not_jump_where_the_gap_between_two_lobes_opens():
    # what a third one does to the second reaches the first while they hang together (0.02 of the load)
    stand = contacts.bench(contacts.pair_model("S1002/60E1 1:20", **STRIPS, **contacts.PLAIN), rolling=False)
    points, force = stand.wheels[0].model.arrays.contacts, []
    for height in (0.459793312, 0.459793314):
        stand.evaluate(6.3e-3, height, -12.822652e-3, 0.0)
        force.append(stand.force[2])
        assert (points[1].saddle > 0.0) == (len(force) == 1)
    assert force[1] == pytest.approx(force[0], rel=1e-4)


@pytest.mark.parametrize(("pair", "lateral", "height", "yaw"), [
    ("S1002/60E1 1:20", 6.6e-3, 0.459917289, -18.8e-3), ("S1002/54E1 1:20", 6.6e-3, 0.460119058, -16.2e-3),
    ("S1002/60E1 1:40", *FAR_SHIFTED), ("worn/worn 1:40", 6.737723e-3, 0.4607864238615616, 16.476367e-3),
    ("S1002/60E1 1:40", 6.55e-3, 0.4606795318, 20e-3),
])  # fmt: skip
def test_long_strips_far_shifted_against_each_other_press_as_the_half_space_does(pair, lateral, height, yaw):
    # 5 and 7 % too low where shifts are left out; the last one 0.9 % where strips are no denser where the locus leans
    stand = contacts.bench(contacts.pair_model(pair, **STRIPS, **contacts.PLAIN), rolling=False)
    model = stand.wheels[0].model
    stand.evaluate(lateral, height, yaw, 0.0)
    normal_force = contacts.contact_of(stand).normal_force
    assert normal_force == pytest.approx(HalfSpace(resolution=12).solve_pose(model).normal_force, rel=0.005)
