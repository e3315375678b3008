"""Friction that changes along the track: what a wheel feels is the law of its place, everywhere it is used."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from support.contacts import bench, numbers, pair_model, settle, strips_of
from support.runs import FAST, LEADING, arc, setup_of
from support.scenario_texts import CURVE, edited, faults

from wrsim.analysis.motion.run import run_in_time
from wrsim.contact.model import ContactModel
from wrsim.contact.settings import Friction, FrictionAlong, HalfSpaceSettings
from wrsim.results import Result
from wrsim.scenario.build import build
from wrsim.scenario.loading import load_text

PAIR = "S1002/60E1 1:40"
DRY, GREASED, FALLING = Friction(0.4), Friction(0.4, gauge_corner=0.1), Friction(0.2, falling_ratio=0.5)
ALONG = FrictionAlong((10.0, 12.0, 20.0, 21.0), (DRY, GREASED, GREASED, FALLING))
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
@pytest.mark.parametrize("tangential", ["fastsim", "fastrip", "polach", "linear", "shen-hedrick-elkins"])
def test_a_wheel_feels_the_law_of_its_place(normal: str, tangential: str) -> None:
    choices = {"normal": normal, "tangential": tangential, "strips": 12, "cells": 6}
    for place in (0.0, 11.3, 15.0, 20.6, 30.0):
        there = rolling(pair_model(PAIR, friction=ALONG, **choices), place)
        plain = rolling(pair_model(PAIR, friction=ALONG.at(place), **choices), 0.0)
        assert numbers(there) == pytest.approx(numbers(plain), rel=1e-12, abs=1e-12)
        np.testing.assert_allclose(strips_of(there)["mu"], strips_of(plain)["mu"], rtol=1e-13)


def test_the_exact_solver_feels_the_law_of_its_place() -> None:
    coarse = HalfSpaceSettings(resolution=8)
    exact = {"normal": "half-space", "tangential": "half-space", "max_patches": 1, "half_space": coarse}
    there = rolling(pair_model(PAIR, friction=FrictionAlong((0.0, 1.0), (DRY, FALLING)), **exact), 0.5)
    plain = rolling(pair_model(PAIR, friction=Friction(0.3, falling_ratio=0.75), **exact), 0.0)
    assert numbers(there) == pytest.approx(numbers(plain), rel=1e-12, abs=1e-12)


def test_the_same_law_at_all_places_is_a_plain_law_to_the_bit() -> None:
    for law in (DRY, GREASED, FALLING):
        along = FrictionAlong((0.0, 0.3, 1.0), (law,) * 3)
        assert numbers(rolling(pair_model(PAIR, friction=along), 0.1)) == numbers(
            rolling(pair_model(PAIR, friction=law), 0.0)
        )


def test_friction_changes_smoothly_between_places_and_stays_beyond_them() -> None:
    s = np.linspace(9.0, 13.0, 40_001)
    corner = ALONG.numbers(s)[:, 1]
    rate = np.gradient(corner, s)
    assert corner[s <= 10.0] == pytest.approx(0.4) and corner[s >= 12.0] == pytest.approx(0.1)
    assert rate.min() == pytest.approx(-1.5 * 0.3 / 2.0, rel=1e-6)  # of 3 x^2 - 2 x^3, in its middle
    assert np.abs(np.diff(rate)).max() < 1e-4
    assert ALONG.numbers(99.0) == pytest.approx(FALLING.numbers)


@pytest.fixture(scope="module")
def wetted() -> Result:
    """A leading axle in a full curve whose outer rail gets wet on the way, from 12 to 14 m."""
    return in_curve({"friction_sections": [WET]})


def in_curve(contact: dict[str, Any], start: float = 10.0, way: float = 8.0) -> Result:
    keys = {"contact": {"friction": 0.4} | contact} | FAST | {"run.distance_m": way}
    return run_in_time(setup_of([arc(40.0, 200.0, 60.0)], 10.0, LEADING, start=start, values=keys))


def test_a_run_says_which_friction_acts_under_each_wheel(wetted: Result) -> None:
    dataset = wetted.wheelset()
    at, mu = dataset["distance"].values, dataset["rail_friction"].values
    assert mu[:, 0] == pytest.approx(0.4)
    np.testing.assert_array_equal(mu, dataset["rail_friction_corner"].values)
    x = np.clip((at - 12.0) / 2.0, 0.0, 1.0)
    # the outer rail is longer than the centre line by .4 %: a few um of a metre within the transition
    assert mu[:, 1] == pytest.approx(0.4 - 0.25 * x * x * (3.0 - 2.0 * x), abs=2e-5)


def test_behind_a_change_the_wheelset_runs_as_where_friction_is_always_so(wetted: Result) -> None:
    wet = in_curve({"friction_sections": [WET | {"from_m": 1.0}]}, way=0.2)
    dry = in_curve({}, way=0.2)
    ours = wetted.wheelset()
    for name in ("Y", "T_gamma"):
        first, last = (r.wheelset()[name].values[0] for r in (dry, wet))
        np.testing.assert_array_equal(ours[name].values[0], first)  # the start knows the friction of its place
        assert np.abs(last / first - 1.0).max() > 0.05
        assert ours[name].values[-1] == pytest.approx(last, rel=5e-3)


def test_a_run_that_starts_behind_a_change_starts_as_where_friction_is_always_so() -> None:
    wet = in_curve({"friction": 0.2}, way=0.1, start=20.0)
    ours = in_curve({"friction_sections": [WET | {"friction": 0.2, "side": "both"}]}, way=0.1, start=20.0)
    for name in ("Y", "Q", "lateral_shift", "T_gamma"):
        np.testing.assert_array_equal(ours.dataset[name].values, wet.dataset[name].values)


def friction_of(text: str, more: str, folder: Path | None = None) -> Any:
    return build(load_text(edited(text, "friction = 0.35", more), folder or ".")).contact.friction


def test_a_table_and_sections_say_the_same(tmp_path: Path) -> None:
    (tmp_path / "mu.csv").write_text("at_m,left,right\n0,0.35,0.35\n60,0.35,0.35\n62,0.35,0.1\n")
    table = friction_of(CURVE, 'friction = 0.35\nfriction_table = "mu.csv"', tmp_path)
    row = 'friction_sections = [{from_m = 60, friction = 0.1, side = "right", transition_m = 2}]'
    sections = friction_of(CURVE, f"friction = 0.35\n{row}")
    s = np.linspace(0.0, 100.0, 1001)
    for ours, theirs in zip(table, sections, strict=True):
        np.testing.assert_allclose(ours.numbers(s), theirs.numbers(s), rtol=1e-12)


def test_where_nothing_runs_friction_is_that_of_one_place() -> None:
    rows = "friction_sections = [{from_m = 60, friction = 0.1, transition_m = 2}]\nfriction_at_m = "
    steady = CURVE.replace('"curving"', '"steady"').split("[[track.segments]]")[0]
    for place, mu in ((0.0, 0.35), (61.0, 0.225), (70.0, 0.1)):
        more = f"[contact]\nfriction = 0.35\n{rows}{place}\n[steady]\nradius_m = 300\n"
        left, right = build(load_text(steady + more, "case.toml")).contact.friction
        assert left.numbers == pytest.approx(Friction(mu).numbers)
        assert left == right


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("friction_sections = [{from_m = 60}]", "contact.friction_sections[0].friction is missing"),
        ("friction_sections = [{friction = 0.1}]", "contact.friction_sections[0].from_m is missing"),
        ("friction_sections = [{at_m = 60, friction = 0.1}]", "did you mean 'from_m'?"),
        ("friction_sections = [{from_m = 60, friction = 3}]", "friction_sections[0].friction = 3: must be a number"),
        ("friction_sections = [{from_m = 999, friction = 0.1}]", "must be on the track, which is 190 m long"),
        (
            "friction_sections = [{from_m = 60, friction = 0.1}, {from_m = 60.5, friction = 0.2}]",
            "contact.friction_sections[1].from_m: must be 61 or more, where its rail",
        ),
        ("friction_at_m = 3", "contact.friction_at_m = 3: goes with friction_sections or friction_table"),
        ('friction_table = "mu.csv"', "mu.csv:3: at_m = 4 after 5: must rise from row to row"),
        ('friction_table = "high.csv"', "high.csv:2: left = 7: must be a number from 0 to 2"),
        ('friction_table = "none.csv"', "none.csv"),
        ('friction_table = "mu.csv"\nfriction_sections = [{from_m = 60, friction = 0.1}]', "cannot stand next to"),
    ],
)
def test_bad_friction_along_the_track_is_refused(more: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "mu.csv").write_text("at_m,left,right\n5,0.3,0.3\n4,0.3,0.3\n")
    (tmp_path / "high.csv").write_text("at_m,left,right\n5,7,0.3\n")
    found = faults(edited(CURVE, "friction = 0.35", f"friction = 0.35\n{more}"), tmp_path)
    assert any(message in line for line in found), found
