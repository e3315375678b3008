"""Friction that depends on the place and on the slip: limits, smoothness, the same everywhere it is used."""

from dataclasses import replace
from functools import cache
from math import radians
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from support.contacts import RADIUS, bench, columns, numbers, pair_model, settle, strips_of
from support.rows import rows_of
from support.runs import FAST, LEADING, arc, setup_of
from support.scenario_texts import CURVE, edited, faults

from wrsim import ContactModel, ContactSettings, Friction, Result, load_text
from wrsim.analysis.motion.run import run_in_time
from wrsim.contact.creep.laws import CREEP_LAWS, KERNEL_LAWS
from wrsim.contact.half_space import HalfSpace
from wrsim.contact.models import fast_model
from wrsim.contact.settings import FrictionAlong
from wrsim.scenario.build import build

table = rows_of(__file__)

PAIR = "S1002/60E1 1:40"
GREASED = Friction(0.4, gauge_corner=0.1, ramp=(radians(10.0), radians(30.0)))
FALLING = Friction(0.4, falling_ratio=0.5, falling_decay=0.6)
BOTH = replace(GREASED, falling_ratio=0.5)
MODELS = tuple(name for name in KERNEL_LAWS if CREEP_LAWS[name].saturates)


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


def test_friction_changes_by_zones_of_the_angle_and_falls_from_static_to_its_limit():
    mu = GREASED.coefficient(normals(np.array([-40.0, 0.0, 10.0, 30.0, 70.0])), np.zeros(5))
    assert mu == pytest.approx([0.4, 0.4, 0.4, 0.1, 0.1])
    fine = GREASED.coefficient(normals(np.linspace(-40.0, 80.0, 120_001)), np.zeros(120_001))
    assert (np.diff(fine) <= 0.0).all()
    # smooth: the steepest part of the ramp is 3/2 of the mean slope (0.3 over 20 degrees), but for tan's bend
    assert np.abs(np.diff(fine)).max() < 1.6 * 0.3 / 20.0 * 1e-3
    assert np.abs(np.diff(fine, 2)).max() < 1e-8
    slip = np.array([0.0, 1.0, 1e3])
    assert FALLING.coefficient(normals(np.zeros(3)), slip) == pytest.approx([0.4, 0.2 * (1.0 + np.exp(-0.6)), 0.2])


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


def test_equal_zones_are_a_plain_coefficient_and_grease_on_the_corner_leaves_the_tread_alone():
    for lateral in (2e-3, 7e-3):
        plain = slide(0.4, lateral, 2e-3)[1]
        for law in (Friction(0.4), Friction(0.4, gauge_corner=0.4), Friction(0.4, falling_ratio=1.0)):
            np.testing.assert_array_equal(slide(law, lateral, 2e-3)[1].force, plain.force)
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


@pytest.mark.parametrize(("text", "message"), table("bad_friction_is_refused"))
def test_bad_friction_is_refused(text, message, tmp_path):
    assert any(message in line for line in faults(edited(CURVE, "friction = 0.35", text), tmp_path))


# Friction that changes along the track: what a wheel feels is the law of its place, everywhere it is used.
DRY, GREASY, FALLS = Friction(0.4), Friction(0.4, gauge_corner=0.1), Friction(0.2, falling_ratio=0.5)
ALONG = FrictionAlong((10.0, 12.0, 20.0, 21.0), (DRY, GREASY, GREASY, FALLS))
WET = {"from_m": 12.0, "friction": 0.15, "side": "right", "transition_m": 2.0}


@cache
def pressed() -> NDArray[np.float64]:
    """Origin and axle of a wheel that is pressed on its flange root and tread."""
    stand = bench(pair_model(PAIR, tangential="none"))
    settle(stand, 5.5e-3, 0.004, 60e3)
    return stand.wheels[0].model.arrays.pose[:6].copy()


def rolling(model: ContactModel, place: float) -> Any:
    """That wheel, with creepages and spin."""
    return model.evaluate(pressed()[:3], pressed()[3:], (20.0, 0.1, 0.0), (0.1, 43.6, 0.02), place)


@pytest.mark.parametrize("normal", ["strips", "kik-piotrowski"])
@pytest.mark.parametrize("tangential", KERNEL_LAWS)
def test_a_wheel_feels_the_law_of_its_place(normal: str, tangential: str) -> None:
    choices = {"normal": normal, "tangential": tangential, "strips": 12, "cells": 6}
    for place in (0.0, 11.3, 15.0, 20.6, 30.0):
        there = rolling(pair_model(PAIR, friction=ALONG, **choices), place)
        plain = rolling(pair_model(PAIR, friction=ALONG.at(place), **choices), 0.0)
        assert numbers(there) == pytest.approx(numbers(plain), rel=1e-12, abs=1e-12)
        np.testing.assert_allclose(strips_of(there)["mu"], strips_of(plain)["mu"], rtol=1e-13)


def test_the_same_law_at_all_places_is_a_plain_law_and_others_change_smoothly() -> None:
    for law in (DRY, GREASY, FALLS):
        along = FrictionAlong((0.0, 0.3, 1.0), (law,) * 3)
        assert numbers(rolling(pair_model(PAIR, friction=along), 0.1)) == numbers(
            rolling(pair_model(PAIR, friction=law), 0.0)
        )
    s = np.linspace(9.0, 13.0, 40_001)
    corner = ALONG.numbers(s)[:, 1]
    rate = np.gradient(corner, s)
    assert corner[s <= 10.0] == pytest.approx(0.4) and corner[s >= 12.0] == pytest.approx(0.1)
    assert rate.min() == pytest.approx(-1.5 * 0.3 / 2.0, rel=1e-6)  # of 3 x^2 - 2 x^3, in its middle
    assert np.abs(np.diff(rate)).max() < 1e-4
    assert ALONG.numbers(99.0) == pytest.approx(FALLS.numbers)


@pytest.fixture(scope="module")
def wetted() -> Result:
    """A leading axle in a full curve whose outer rail gets wet on the way, from 12 to 14 m."""
    return in_curve({"friction_sections": [WET]})


def in_curve(contact: dict[str, Any], start: float = 10.0, way: float = 8.0) -> Result:
    keys = {"contact": {"friction": 0.4} | contact} | FAST | {"run.distance_m": way}
    return run_in_time(setup_of([arc(40.0, 200.0, 60.0)], 10.0, LEADING, start=start, values=keys))


def test_a_run_says_which_friction_acts_and_runs_behind_a_change_as_with_that_alone(wetted: Result) -> None:
    dataset = wetted.wheelset()
    at, mu = dataset["distance"].values, dataset["rail_friction"].values
    assert mu[:, 0] == pytest.approx(0.4)
    np.testing.assert_array_equal(mu, dataset["rail_friction_corner"].values)
    x = np.clip((at - 12.0) / 2.0, 0.0, 1.0)
    # the outer rail is longer than the centre line by .4 %: a few um of a metre within the transition
    assert mu[:, 1] == pytest.approx(0.4 - 0.25 * x * x * (3.0 - 2.0 * x), abs=2e-5)
    wet = in_curve({"friction_sections": [WET | {"from_m": 1.0}]}, way=0.2)
    dry = in_curve({}, way=0.2)
    ours = wetted.wheelset()
    for name in ("Y", "T_gamma"):
        first, last = (r.wheelset()[name].values[0] for r in (dry, wet))
        np.testing.assert_array_equal(ours[name].values[0], first)  # the start knows the friction of its place
        assert np.abs(last / first - 1.0).max() > 0.05
        assert ours[name].values[-1] == pytest.approx(last, rel=5e-3)


def friction_along(text: str, more: str, folder: Path | None = None) -> Any:
    return build(load_text(edited(text, "friction = 0.35", more), folder or ".")).contact.friction


def test_a_table_and_sections_say_the_same_and_standing_wheels_feel_one_place(tmp_path: Path) -> None:
    (tmp_path / "mu.csv").write_text("at_m,left,right\n0,0.35,0.35\n60,0.35,0.35\n62,0.35,0.1\n")
    table = friction_along(CURVE, 'friction = 0.35\nfriction_table = "mu.csv"', tmp_path)
    row = 'friction_sections = [{from_m = 60, friction = 0.1, side = "right", transition_m = 2}]'
    sections = friction_along(CURVE, f"friction = 0.35\n{row}")
    s = np.linspace(0.0, 100.0, 1001)
    for ours, theirs in zip(table, sections, strict=True):
        np.testing.assert_allclose(ours.numbers(s), theirs.numbers(s), rtol=1e-12)
    rows = "friction_sections = [{from_m = 60, friction = 0.1, transition_m = 2}]\nfriction_at_m = "
    steady = CURVE.replace('"curving"', '"steady"').split("[[track.segments]]")[0]
    for place, mu in ((0.0, 0.35), (61.0, 0.225), (70.0, 0.1)):
        more = f"[contact]\nfriction = 0.35\n{rows}{place}\n[steady]\nradius_m = 300\n"
        left, right = build(load_text(steady + more, "case.toml")).contact.friction
        assert left.numbers == pytest.approx(Friction(mu).numbers)
        assert left == right


@pytest.mark.parametrize(("more", "message"), table("bad_friction_along_the_track_is_refused"))
def test_bad_friction_along_the_track_is_refused(more: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "mu.csv").write_text("at_m,left,right\n5,0.3,0.3\n4,0.3,0.3\n")
    (tmp_path / "high.csv").write_text("at_m,left,right\n5,7,0.3\n")
    found = faults(edited(CURVE, "friction = 0.35", f"friction = 0.35\n{more}"), tmp_path)
    assert any(message in line for line in found), found
