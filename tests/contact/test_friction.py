"""Friction that depends on the place and on the slip: limits, smoothness, the same everywhere it is used."""

from dataclasses import replace
from functools import cache
from math import radians
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from support.contacts import RADIUS, bench, columns, numbers, pair_model, settle, strips_of

from wrsim import ContactModel, Friction
from wrsim.contact.creep.laws import CREEP_LAWS, KERNEL_LAWS
from wrsim.contact.half_space import HalfSpace
from wrsim.contact.models import fast_model
from wrsim.contact.settings import FrictionAlong

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


# Friction that changes along the track: what a wheel feels is the law of its place, everywhere it is used.
DRY, GREASY, FALLS = Friction(0.4), Friction(0.4, gauge_corner=0.1), Friction(0.2, falling_ratio=0.5)
ALONG = FrictionAlong((10.0, 12.0, 20.0, 21.0), (DRY, GREASY, GREASY, FALLS))


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
        along = rolling(pair_model(PAIR, friction=ALONG, **choices), place)
        plain = rolling(pair_model(PAIR, friction=ALONG.at(place), **choices), 0.0)
        assert numbers(along) == pytest.approx(numbers(plain), rel=1e-12, abs=1e-12)
        np.testing.assert_allclose(strips_of(along)["mu"], strips_of(plain)["mu"], rtol=1e-13)


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
