"""The exact solver on wheels and rails: Hertz, CONTACT's published and computed cases, laws over poses."""

from functools import cache
from math import sqrt

import numpy as np
import pytest
from scipy.optimize import brentq
from support.contacts import HALF_SPACING, PLAIN, bench, contact_model, contact_of, flat_rail, pair_model, round_wheel
from support.hertz import Ellipse
from support.rows import data_rows

from wrsim import ContactSettings, Pose
from wrsim.contact import models
from wrsim.contact.channels import WheelOnRail
from wrsim.contact.half_space import HalfSpace
from wrsim.contact.half_space.surface_kernel import _meet_section
from wrsim.contact.half_space.zones import _box
from wrsim.contact.profiles.sections import circle
from wrsim.contact.settings import Material
from wrsim.jit.linalg import Vec
from wrsim.simulation.pose_solver import HalfSpacePoseSolver

EXACT = {"normal": "half-space", "tangential": "half-space"}
FRICTIONLESS = EXACT | {"tangential": "none"}


def solve(model, pose, solver=HalfSpace(), before=None):  # noqa: B008 (frozen)
    model.arrays.pose[:] = pose
    return solver.solve_pose(model, before)


def lowered(radius, approach, yaw=0.0, lateral=0.0, speed=0.0):
    """Pose of a wheel over a rail whose crown is the origin, rolling without slip at its tape circle."""
    axle = (-np.sin(yaw), np.cos(yaw), 0.0)
    omega = speed / radius
    return (0.0, lateral, radius - approach, *axle, speed, 0.0, 0.0, omega * axle[0], omega * axle[1], 0.0)


def pose_solver(pair="S1002/60E1 1:40", solver=HalfSpace(), **choices):  # noqa: B008
    choices = EXACT | choices
    model = pair_model(pair, **choices)
    fast = bench(model, rolling=choices.get("tangential") != "none")
    return HalfSpacePoseSolver(fast.wheels, fast.speed > 0.0, 0.46, solver)


# Hertz


def test_a_round_wheel_on_a_plane_is_hertz():
    model = contact_model(round_wheel(0.3), flat_rail(), radius=0.46, **FRICTIONLESS)
    # half axes whose curvatures are those of the wheel
    shape = brentq(lambda q: np.divide(*Ellipse(1.0, q).curvatures) - 0.3 / 0.46, 0.3, 3.0)
    unit = Ellipse(1.0, shape)
    a = np.sqrt(0.1e-3 / unit.approach * unit.curvatures[0] * 2.0 * 0.46)
    ellipse = Ellipse(a, a * shape, 1e9 * 0.1e-3 / unit.approach / a)
    assert ellipse.approach == pytest.approx(0.1e-3)
    (patch,) = solve(model, lowered(0.46, 0.1e-3)).patches
    assert patch.approach == pytest.approx(0.1e-3, rel=1e-6)
    assert patch.normal_force == pytest.approx(ellipse.force, rel=2e-3)
    assert patch.p0 == pytest.approx(ellipse.p0, rel=2e-3)
    assert patch.area == pytest.approx(ellipse.area, rel=5e-3)
    (region,) = patch.regions
    assert region.s[1] - region.s[0] == pytest.approx(2.0 * ellipse.b, rel=0.01)
    assert region.ends.max() - region.starts.min() == pytest.approx(2.0 * ellipse.a, rel=0.01)


# CONTACT's published cases


@pytest.mark.parametrize(
    ("groove", "influence", "spin", "approach", "p0", "width", "length"),
    [
        (10.25, "half-space", 1.0002301, 0.02237, 530.2, 5.75, 6.23),
        (10.25, "angle-corrected", 1.0002301, 0.02237, 520.6, 5.75, 6.23),
        pytest.param(10.10, "half-space", 1.0004411, 0.01939, 409.3, 8.75, 5.46, marks=pytest.mark.campaign),
        pytest.param(10.10, "angle-corrected", 1.0004411, 0.01928, 397.6, 8.75, 5.27, marks=pytest.mark.campaign),
        pytest.param(10.05, "half-space", 1.0006, 0.01743, 348.7, None, None, marks=pytest.mark.campaign),
        pytest.param(10.05, "angle-corrected", 1.0006, 0.01718, 336.1, None, None, marks=pytest.mark.campaign),
    ],
)
def test_ball_in_a_deep_groove(groove, influence, spin, approach, p0, width, length):
    # after Li 2002; CONTACT 25.2, testbank groove_li: ball 10 mm, rolling radius 420 mm, 10 kN, G 80 GPa, mu 0.3
    steel = Material(2.0 * 80e9 * 1.28, 0.28)
    ball, trough = circle("ball", "wheel", -0.010, 0.0096), circle("groove", "rail", -1e-3 * groove, 0.0098)
    settings = ContactSettings(**EXACT, damping=0.0, wheel=steel, rail=steel)
    model = models.contact_model(ball, trough, 0.42, settings, 0.3)
    solver = HalfSpace((0.0958333e-3, 0.25e-3), influence=influence)

    def pressed(depth):
        return solve(model, (0.0, 0.0, 0.42 - depth, 0.0, 1.0, 0.0, 0.42, 0.0, 0.0, 0.0, spin, 0.0), solver)

    depth_at_load = brentq(
        lambda d: pressed(d).force[2] - 1e4, 1e-3 * approach * 0.98, 1e-3 * approach * 1.02, xtol=1e-9
    )
    (patch,) = pressed(depth_at_load).patches
    assert 1e3 * depth_at_load == pytest.approx(approach, rel=2e-3)
    assert 1e-6 * patch.p0 == pytest.approx(p0, rel=2e-3)
    if width is not None:
        assert 0.25 * patch.p.any(axis=1).sum() == pytest.approx(width, abs=1e-9)
        assert 0.0958333 * patch.p.any(axis=0).sum() == pytest.approx(length, abs=0.1)


def test_no_contact_where_both_profiles_have_ended():
    # the ball reaches 74 degrees to either side, the groove 77; what continues them straight would overlap there
    ball, trough = circle("ball", "wheel", -0.010, 0.0096), circle("groove", "rail", -0.01005, 0.0098)
    model = contact_model(ball, trough, radius=0.42, **FRICTIONLESS)
    (patch,) = solve(model, (0.0, 0.0, 0.42 - 17e-6, *([0.0, 1.0] + [0.0] * 7)), HalfSpace()).patches
    (region,) = patch.regions
    assert np.abs(np.degrees(region.angle)).max() < 40.0


@cache
def groove_rows():
    return [{name: float(value) for name, value in row.items()} for row in data_rows("contact_grooves.csv")]


@pytest.mark.parametrize("row", groove_rows()[::12], ids=lambda r: f"R{r['R_wheel_mm']:g}-{r['N_nom_N']:g}")
def test_rail_corner_in_hollow_arcs(row):
    radius = 1e-3 * row["R_roll_mm"]
    hollow = circle("hollow", "wheel", 1e-3 * row["R_wheel_mm"], 0.95e-3 * row["R_wheel_mm"])
    model = contact_model(hollow, circle("corner", "rail", 0.013, 0.98 * 0.013), radius=radius, **FRICTIONLESS)
    b = HalfSpacePoseSolver([WheelOnRail(model, 1, HALF_SPACING, (HALF_SPACING, 0.0))], False, radius)
    assert not b.solve(Pose("", 1e-3 * row["y_ws_mm"], 0.0, row["Fz_req_N"])).message
    (patch,) = b.contacts[0].patches
    (region,) = patch.regions
    assert 1e-6 * patch.p0 == pytest.approx(row["pmax_MPa"], rel=2e-3)
    assert 1e3 * patch.approach == pytest.approx(row["pen_mm"], rel=2e-3)
    assert 1e6 * patch.area == pytest.approx(row["area_mm2"], rel=0.02)
    assert np.degrees(np.arctan2(-b.force[1], b.force[2])) == pytest.approx(row["force_angle_deg"], abs=0.1)
    assert np.hypot(*b.force[1:]) == pytest.approx(row["Fres_N"], rel=1e-3)
    # the tables count whole rows of 0.1 mm, each 0.44 degrees; their places lie up to a degree beside the resultant's
    span = np.degrees(region.angle[0] - region.angle[1])
    assert span == pytest.approx(row["ang_at_smax_deg"] - row["ang_at_smin_deg"], abs=0.7)


# S1002 on 60E1 against CONTACT


def static_cases():
    by_case = {}
    for row in data_rows("contact_own_static.csv"):
        by_case.setdefault(row["case_id"], []).append(row)
    single = [rows[0] for rows in by_case.values() if len(rows) == 1 and rows[0]["n_components"] == "1"]
    return [r for r in single if r["cant_label"] == "1:40"][::18]


def solve_case(row, pairing):
    element = {24000.0: 2e-4, 60000.0: 2.5e-4, 100000.0: 3e-4}[float(row["Fz_req_N"])]
    b = pose_solver(
        solver=HalfSpace((element, element), pairing=pairing), tangential="half-space" if row["tang"] == "3" else "none"
    )
    solved = b.solve(Pose("", 1e-3 * float(row["y_ws_mm"]), float(row["yaw_rad"]), float(row["Fz_req_N"])))
    assert not solved.message
    return b, b.contacts[0].patches[0]


@pytest.mark.parametrize("row", static_cases(), ids=lambda r: r["case_id"])
def test_s1002_on_60e1_as_contact_pairs_the_profiles(row):
    b, patch = solve_case(row, "level")
    normal = float(row["Fn_N"])
    assert 1e-6 * patch.p0 == pytest.approx(float(row["pmax_MPa"]), rel=0.03)  # a peak between two elements
    assert 1e3 * patch.approach == pytest.approx(float(row["pen_mm"]), rel=8e-3)
    assert patch.normal_force == pytest.approx(normal, rel=0.01)
    assert -b.force[0] == pytest.approx(float(row["FX_tr_N"]), abs=3e-3 * normal)
    assert -b.force[1] == pytest.approx(float(row["FY_tr_N"]), abs=3e-3 * normal)
    area = np.count_nonzero(patch.p) * patch.grid.cell  # as CONTACT counts it; flanges: 5 rows of elements
    assert 1e6 * area == pytest.approx(float(row["area_mm2"]), rel=0.09)


def test_opposite_points_move_the_flange_s_normal():
    # On a flank CONTACT's pairing errs by approach tan(angle) along it: half of that in place, a quarter in the
    # normal's angle per difference of curvatures. The load then asks for another normal force.
    row = next(r for r in static_cases() if float(r["y_ws_mm"]) > 7.4)
    ours, theirs = solve_case(row, "opposite")[1], solve_case(row, "level")[1]
    angle = ours.regions[0].angle[0]
    assert angle > 1.0
    shift = 0.25 * ours.approach * np.tan(angle) / 13e-3
    turned = np.mean(ours.regions[0].angle) - np.mean(theirs.regions[0].angle)
    assert 0.3 * shift < turned < 2.0 * shift


# laws


def test_default_elements_are_converged_and_a_narrow_peak_gets_finer_rows():
    pose = Pose("", 3e-3, 0.005, 60e3)
    coarse, fine = pose_solver(), pose_solver(solver=HalfSpace(resolution=80))
    figures = []
    for b in (coarse, fine):
        assert not b.solve(pose).message
        patch = b.contacts[0].patches[0]
        figures.append([patch.p0, patch.area, patch.approach, patch.normal_force, *b.force[:2]])
    assert figures[0] == pytest.approx(figures[1], rel=6e-3)
    # where the rail's radius jumps from 80 to 13 mm S1002 at 6.5 mm presses a second peak, half a millimetre wide
    b = pose_solver("S1002/60E1 1:20", **FRICTIONLESS)
    b.solve(Pose("", 6.5e-3, 0.0, 24e3))
    (patch,) = b.contacts[0].patches
    fine = solve(b.wheels[0].model, b.wheels[0].model.arrays.pose.copy(), HalfSpace((patch.grid.dx, 2e-5))).patches[0]
    assert patch.grid.ds < 1.2e-4
    assert patch.p0 == pytest.approx(fine.p0, rel=0.01)


def test_forces_are_the_sum_over_the_patch():
    b = pose_solver()
    b.solve(Pose("", 6e-3, 0.0, 80e3))
    contact = b.contacts[0]
    patch = contact.patches[0]
    grid, p, q = patch.grid, patch.p, patch.q
    cell = grid.dx * grid.ds
    force, moment = np.zeros(3), np.zeros(3)
    for j, (no, nb) in enumerate(grid.normal):
        for i in np.flatnonzero(p[j]):
            f = cell * np.array([q[0, j, i], p[j, i] * no + q[1, j, i] * nb, p[j, i] * nb - q[1, j, i] * no])
            force += f
            place = grid.centre[j] + 0.5 * grid.axis["gap"][j] * grid.normal[j]
            moment += np.cross(np.array([grid.x[i], *place]) - b.wheels[0].model.arrays.pose[:3], f)
    assert patch.force == pytest.approx(force, rel=1e-9)
    assert patch.moment == pytest.approx(moment, rel=1e-9)
    assert contact.force == pytest.approx(sum(p.force for p in contact.patches))


def test_a_wheelset_finds_its_roll():
    b = HalfSpacePoseSolver(
        bench(pair_model("S1002/60E1 1:40", **EXACT), sides=(1, -1)).wheels, True, 0.46, HalfSpace(resolution=16)
    )
    solved = b.solve(Pose("", 3e-3, 0.002, 110e3))
    assert not solved.message
    assert b.force[2] == pytest.approx(110e3, rel=1e-4)
    assert abs(b.moment[0]) < 1e-3 * 110e3 * HALF_SPACING
    assert 0.0 < solved.roll < 1e-3


def test_contacts_grow_together_without_jumps():
    # tread and gauge corner of S1002 on 60E1 at 5.06 mm: zones approach each other as the wheel comes down
    b = pose_solver(solver=HalfSpace((3e-4, 3e-4)), **FRICTIONLESS)
    b.solve(Pose("", 5.0e-3, 0.0, 5e3))
    pose = b.wheels[0].model.arrays.pose.copy()
    model, start = b.wheels[0].model, pose[2]
    forces, patches = [], set()
    for z in np.linspace(start, start - 60e-6, 61):
        pose[2] = z
        contact = solve(model, pose, HalfSpace((3e-4, 3e-4)))
        forces.append(contact.normal_force)
        patches.add(sum(len(p.regions) for p in contact.patches))
    steps = np.diff(forces)
    assert len(patches) > 1
    assert (steps > 0.0).all()
    assert np.abs(np.diff(steps)).max() < 0.3 * steps.max()


@pytest.mark.parametrize("lateral", [6.3e-3, 6.46e-3])
def test_ground_far_beside_a_main_point_is_pressed_by_one_patch_alone(lateral):
    # a flange, the root beside it and the tread press each other down: main points of one patch 48 mm apart
    yaw, strips, kik_piotrowski = (
        25e-3,
        *(bench(pair_model("S1002/60E1 1:20", normal=normal, **PLAIN)) for normal in ("strips", "kik-piotrowski")),
    )
    strips.evaluate(lateral, kik_piotrowski.solve(Pose("", lateral, yaw, 150e3)).height, yaw, 0.0)
    model, of_strips = strips.wheels[0].model, contact_of(strips)
    contact = solve(model, model.arrays.pose, HalfSpace(resolution=20))
    pressed = [patch.grid.axis["arc_wheel"][patch.pressure.p.any(axis=1)] for patch in contact.patches]
    ends = np.sort([(arc.min(), arc.max()) for arc in pressed], axis=0).ravel()
    assert (np.diff(ends) > 0.0).all()
    assert contact.normal_force == pytest.approx(of_strips.normal_force, rel=0.005)


def test_damping_multiplies_the_pressure_by_the_rate_of_approach():
    # N (1 + c v cos(angle)) as in the strip models; never a pull
    model = pair_model("S1002/60E1 1:40", normal="half-space", tangential="none", damping=2.0)
    origin = np.array([0.0, 0.0, 0.46 - 0.0])
    origin[2] -= model.evaluate(origin).closest + 60e-6
    rest, nearing, leaving = (model.evaluate(origin, velocity=(0.0, 0.0, v)) for v in (0.0, -0.1, 2.0))
    angle = rest.patches["angle"][0]
    assert nearing.normal_force == pytest.approx(rest.normal_force * (1.0 + 0.2 * np.cos(angle)), rel=1e-3)
    assert leaving.normal_force == 0.0


def test_the_overlap_of_rows_without_shift_is_as_long_ahead_as_behind():
    rows = np.zeros(5, [("r_t", float), ("x", float)])
    rows["r_t"] = 0.5
    s_x = _box(rows, np.array([-1e-5, 1e-5, 4e-5, 1e-5, -1e-5]), 1, 3, 1e-4)
    assert s_x == pytest.approx((0.5e-4, 3.5e-4, -sqrt(4e-5), sqrt(4e-5)))


@pytest.mark.parametrize("length", [1.0, 3.0])
def test_a_normal_meets_the_cubic_through_a_section_whatever_the_length_of_its_tangents(length):
    angle = np.linspace(-0.1, 0.1, 4)
    section = np.column_stack((np.sin(angle), np.cos(angle), length * np.cos(angle), -length * np.sin(angle)))
    for no in (-0.05, 0.02):
        meeting = _meet_section(section, np.array([0, 4]), Vec(0.0, 0.0, 0.999), no, sqrt(1.0 - no**2), 0.0)
        foot = np.hypot(meeting[0] * no, 0.999 + meeting[0] * sqrt(1.0 - no**2))
        assert meeting[1] and foot == pytest.approx(1.0, abs=2e-7)  # h^4/128: as long as the chord


def test_elements_of_a_wheel_are_those_of_its_deepest_patch():
    b = pose_solver(solver=HalfSpace(resolution=8), **FRICTIONLESS)
    b.solve(Pose("", 6e-3, 0.04, 60e3))
    deepest, second = sorted(b.solver.solve_pose(b.wheels[0].model).patches, key=lambda patch: -patch.approach)
    elements = b.solver.elements_at(b.wheels[0].model)
    assert elements == (deepest.grid.dx, deepest.grid.ds) != (second.grid.dx, second.grid.ds)
