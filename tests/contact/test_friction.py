"""Friction that depends on the place and on the slip: limits, smoothness, the same everywhere it is used."""

from dataclasses import replace
from math import radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.contacts import RADIUS, bench, columns, pair_model, settle, strips_of
from support.scenario_texts import CURVE, edited, faults

from wrsim.contact.half_space import HalfSpace
from wrsim.contact.models import fast_model
from wrsim.contact.settings import ContactSettings, Friction
from wrsim.scenario.build import build
from wrsim.scenario.loading import load_text

PAIR = "S1002/60E1 1:40"
GREASED = Friction(0.4, gauge_corner=0.1, ramp=(radians(10.0), radians(30.0)))
FALLING = Friction(0.4, falling_ratio=0.5, falling_decay=0.6)
BOTH = replace(GREASED, falling_ratio=0.5)
MODELS = ("fastsim", "fastrip", "polach", "shen-hedrick-elkins")


def normals(degrees):
    angle = np.radians(degrees)
    return np.stack([-np.sin(angle), np.cos(angle)], axis=-1)


def slide(friction, lateral, along, tangential="fastsim", speed=20.0):
    """A wheel pressed on its rail at that shift, slipping along the rail by a share of the speed."""
    stand = bench(pair_model(PAIR, friction=friction, tangential=tangential))
    settle(stand, lateral, 0.0, 60e3)
    model = stand.wheels[0].model
    pose = model.arrays.pose.copy()
    contact = model.evaluate(pose[:3], pose[3:6], (speed, 0.0, 0.0), (0.0, (1.0 + along) * speed / RADIUS, 0.0))
    return model, contact


def test_zones_by_contact_angle():
    mu = GREASED.coefficient(normals(np.array([-40.0, 0.0, 10.0, 30.0, 70.0])), np.zeros(5))
    assert mu == pytest.approx([0.4, 0.4, 0.4, 0.1, 0.1])
    fine = GREASED.coefficient(normals(np.linspace(-40.0, 80.0, 120_001)), np.zeros(120_001))
    assert (np.diff(fine) <= 0.0).all()
    # smooth: the steepest part of the ramp is 3/2 of the mean slope (0.3 over 20 degrees), but for tan's bend
    assert np.abs(np.diff(fine)).max() < 1.6 * 0.3 / 20.0 * 1e-3
    assert np.abs(np.diff(fine, 2)).max() < 1e-8


def test_friction_falls_from_static_to_its_limit():
    slip = np.array([0.0, 1.0, 1e3])
    assert FALLING.coefficient(normals(np.zeros(3)), slip) == pytest.approx([0.4, 0.2 * (1.0 + np.exp(-0.6)), 0.2])


@settings(max_examples=40)
@given(lateral=st.floats(-5e-3, 8e-3), along=st.floats(-0.05, 0.05), speed=st.floats(0.0, 80.0))
def test_strips_have_the_friction_of_their_place_and_slip(lateral, along, speed):
    model, contact = slide(BOTH, lateral, along, speed=speed)
    rows = strips_of(contact)
    rigid = np.sqrt(rows["xi"] ** 2 + rows["eta"] ** 2 + (rows["phi"] * rows["a"]) ** 2 / 3.0)
    slip = np.hypot(speed, model.arrays.settings["least_speed"]) * rigid
    np.testing.assert_allclose(rows["mu"], BOTH.coefficient(columns(rows, "no nb"), slip), rtol=1e-12)


@pytest.mark.parametrize("tangential", MODELS)
def test_full_sliding_gives_each_strip_its_own_mu_n(tangential):
    # Shifts from the tread to the flange; at 15 % creepage every strip slides, spin turns it by little. Polach counts
    # the lateral slip that spin makes at the leading edge against the forces, on the flange 2 %.
    for lateral in (2e-3, 5.5e-3, 7e-3):
        for friction in (GREASED, FALLING, BOTH):
            rows = strips_of(slide(friction, lateral, 0.15, tangential)[1])
            limit = rows["mu"] * rows["N"]
            force = np.hypot(rows["Fx"], rows["Fy"])
            assert (force <= limit * (1.0 + 1e-12)).all()
            assert force.sum() == pytest.approx(limit.sum(), rel=0.025 if tangential == "polach" else 0.01)
            assert 0.05 <= rows["mu"].min() <= rows["mu"].max() <= 0.4


def test_friction_alike_in_both_zones_and_friction_that_does_not_fall_are_a_plain_coefficient():
    for lateral in (2e-3, 7e-3):
        plain = slide(0.4, lateral, 2e-3)[1]
        for law in (Friction(0.4), Friction(0.4, gauge_corner=0.4), Friction(0.4, falling_ratio=1.0)):
            np.testing.assert_array_equal(slide(law, lateral, 2e-3)[1].force, plain.force)


def test_a_greased_gauge_corner_leaves_the_tread_alone():
    # at 0 mm the patch lies on the top of the rail, at 7 mm on the flange
    np.testing.assert_array_equal(slide(GREASED, 0.0, 0.02)[1].force, slide(0.4, 0.0, 0.02)[1].force)
    greased, dry = slide(GREASED, 7e-3, 0.02)[1], slide(0.4, 7e-3, 0.02)[1]
    assert abs(greased.force[0]) < 0.5 * abs(dry.force[0])


@pytest.mark.parametrize("tangential", MODELS)
def test_creep_forces_have_no_jumps_where_friction_changes(tangential):
    # the patch wanders over the ramp into the gauge corner, slip through the falling branch
    def force(lateral, along):
        contact = slide(BOTH, lateral, along, tangential)[1]
        return np.array([columns(lobe, "Fx Fy").sum() for lobe in contact.patches]).sum()

    for along in (2e-3, 2e-2):
        steps = np.abs(np.diff([force(y, along) for y in np.linspace(6.0e-3, 6.02e-3, 21)]))
        assert steps.max() < 1e-3 * 60e3
    steps = np.abs(np.diff([force(5.5e-3, x) for x in np.linspace(5e-3, 6e-3, 51)]))
    assert steps.max() < 2e-3 * 60e3


def test_the_exact_solver_takes_the_same_friction():
    # creepage of 5 %: everything slides, so that the sum of the strips' mu N is the force
    stand = bench(pair_model(PAIR, friction=GREASED, normal="half-space", tangential="half-space"))
    fast = bench(fast_model(stand.wheels[0].model))
    settle(fast, 6e-3, 0.0, 60e3)
    model = stand.wheels[0].model
    pose = model.arrays.pose
    pose[:] = fast.wheels[0].model.arrays.pose
    pose[6:] = (20.0, 0.0, 0.0, 0.0, 1.05 * 20.0 / RADIUS, 0.0)
    exact = HalfSpace(resolution=16).solve_pose(model)
    (patch,) = exact.patches
    mu = GREASED.coefficient(patch.grid.normal, np.zeros(len(patch.grid.normal)))
    assert np.ptp(mu[patch.p.any(axis=1)]) > 0.1
    np.testing.assert_allclose(np.hypot(*patch.q)[patch.p > 0.0], (mu[:, None] * patch.p)[patch.p > 0.0], rtol=1e-3)


def friction_of(text):
    return build(load_text(edited(CURVE, "friction = 0.35", text), "case.toml")).contact.friction


def test_scenarios_take_a_number_or_a_table_for_both_rails_or_for_each():
    table = "{static = 0.4, gauge_corner = 0.1, gauge_corner_from_deg = 10, gauge_corner_full_deg = 30}"
    assert friction_of(f"friction = {table}") == (GREASED, GREASED)
    assert friction_of(f"friction_left = 0.3\nfriction_right = {table}") == (0.3, GREASED)
    falling = "[contact.friction]\nstatic = 0.4\nfalling_ratio = 0.5"
    assert friction_of(falling) == (FALLING, FALLING)
    assert ContactSettings().friction == (0.35, 0.35)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('friction = "dry"', "must be a number from 0 to 2 (dry steel 0.3 to 0.5) or a table ([contact.friction])"),
        ("friction = {}", "contact.friction.static is missing"),
        ("friction = {static = 3}", "contact.friction.static = 3: must be a number from 0 to 2"),
        ("friction = {mu = 0.3}", "did you mean 'static'?"),
        ("friction = {static = 0.3, gauge_corner_from_deg = 10}", "gauge_corner_from_deg = 10: goes with gauge_corner"),
        ("friction = {static = 0.3, falling_decay_s_per_m = 1}", "falling_decay_s_per_m = 1: goes with falling_ratio"),
        (
            "friction = {static = 0.3, gauge_corner = 0.1, gauge_corner_from_deg = 40}",
            "gauge_corner_full_deg: must be above gauge_corner_from_deg (40)",
        ),
        ("friction = {static = 0.3, left = 0.2}", "'left' belongs in [contact] as friction_left"),
        ("friction = 0.3\npolach_kA = 0.4", "polach_kS: must not be above polach_kA (0.4)"),
    ],
)
def test_bad_friction_is_refused(text, message, tmp_path):
    assert any(message in line for line in faults(edited(CURVE, "friction = 0.35", text), tmp_path))
