"""FASTSIM on an ellipse: Kalker's linear theory at small creepage, Coulomb at large, the exact solution in between."""

import csv
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.contacts import finite
from support.ellipse import COEFFICIENTS, FORCE, MEAN_RADIUS, SHEAR_MODULUS, roll, total

from wrsim.contact.creep_coefficients import creep_coefficients
from wrsim.core.contact.tangential.flexibility import kalker_coefficients

ASPECTS = [0.1, 0.3, 1.0, 2.5, 10.0]
FRICTION = 0.3
BOUND = {False: "fastsim", True: "fastsim, parabolic"}
WITH_BOUND = pytest.mark.parametrize("parabolic", [False, True], ids=["elliptic", "parabolic"])

signed = st.floats(-6.0, -1.0).map(lambda x: 10.0**x) | st.floats(-6.0, -1.0).map(lambda x: -(10.0**x)) | st.just(0.0)
spins = st.floats(-3.0, 2.0).map(lambda x: 10.0**x) | st.floats(-3.0, 2.0).map(lambda x: -(10.0**x)) | st.just(0.0)
aspects = st.floats(-1.5, 1.5).map(lambda x: 10.0**x)


@pytest.mark.parametrize("aspect", ASPECTS)
def test_small_creepages_meet_kalkers_linear_theory(aspect):
    # demanded 1 %; 0.01 % of cells remain (second order in their number), 0.1 % where the bound is touched
    c11, c22, c23 = kalker_coefficients(COEFFICIENTS, aspect)
    unit, small, fine = SHEAR_MODULUS * MEAN_RADIUS**2, 1e-8, {"strips": 100, "cells": 100}
    along, across = total(roll(aspect, xi=small, **fine)), total(roll(aspect, eta=small, **fine))
    turning = total(roll(aspect, phi=small / MEAN_RADIUS, **fine))
    assert along[0] == pytest.approx(-unit * c11 * small, rel=1e-3)
    assert across[1] == pytest.approx(-unit * c22 * small, rel=1e-3)
    assert turning[1] == pytest.approx(-unit * c23 * small, rel=1e-3)
    assert along[1] == across[0] == 0.0
    assert abs(turning[0]) < 1e-9 * abs(turning[1])


def test_creep_coefficients_are_kalkers_table():
    # Kalker 1990, table E3, a/b = 1 at nu = 0, 1/4, 1/2
    for poisson, row in ((0.0, (3.40, 3.40, 1.33)), (0.25, (4.12, 3.67, 1.47)), (0.5, (5.20, 3.98, 1.63))):
        assert kalker_coefficients(creep_coefficients(poisson), 1.0) == pytest.approx(row, rel=1e-12)


def test_creep_coefficients_are_continuous_and_rise_with_length():
    aspects = np.logspace(-3.0, 3.0, 2001)
    values = np.array([kalker_coefficients(COEFFICIENTS, a) for a in aspects])
    assert (np.diff(values, axis=0) > -1e-9).all()
    assert (np.abs(np.diff(np.log(values), axis=0)) < 0.03).all()


@WITH_BOUND
@pytest.mark.parametrize("aspect", ASPECTS)
def test_full_sliding_gives_mu_n_against_the_slip(aspect, parabolic):
    for xi, eta in ((0.1, 0.0), (-0.1, 0.0), (0.0, 0.1), (0.0, -0.1)):
        force = total(roll(aspect, xi, eta, model=BOUND[parabolic]))[:2]
        weight = roll(aspect)["N"].sum()
        np.testing.assert_allclose(force, -FRICTION * weight * np.sign([xi, eta]), rtol=1e-12)
    force = total(roll(aspect, 0.06, -0.08, model=BOUND[parabolic]))[:2]
    assert np.hypot(*force) == pytest.approx(FRICTION * weight, rel=1e-12)


@pytest.mark.parametrize(("aspect", "degrees"), [(0.1, 9.0), (0.5, 6.1), (1.0, 3.8), (2.0, 1.4), (10.0, 3.0)])
def test_oblique_sliding_is_turned_by_the_unequal_flexibilities(aspect, degrees):
    # Not opposite to the slip but to (xi/L1, eta/L2): known of FASTSIM with three flexibilities, stated here.
    worst = 0.0
    for angle in np.linspace(0.0, 0.5 * np.pi, 19):
        force = total(roll(aspect, 0.1 * np.cos(angle), 0.1 * np.sin(angle)))
        worst = max(worst, abs(np.degrees(np.arctan2(-force[1], -force[0]) - angle)))
    assert worst == pytest.approx(degrees, abs=0.15)


@WITH_BOUND
@given(aspect=aspects, xi=signed, eta=signed, phi=spins, friction=st.floats(0.0, 2.0))
def test_no_strip_pulls_more_than_friction_allows(aspect, xi, eta, phi, friction, parabolic):
    rows = roll(aspect, xi, eta, phi, friction=friction, model=BOUND[parabolic], strips=12, cells=8)
    assert finite(rows)
    force, limit = np.hypot(rows["Fx"], rows["Fy"]), friction * rows["N"]
    assert (force <= limit * (1.0 + 1e-12) + 1e-300).all()


@WITH_BOUND
@given(aspect=aspects, xi=signed, eta=signed, phi=spins, direction=st.sampled_from([1.0, -1.0]))
def test_creep_forces_only_take_power(aspect, xi, eta, phi, direction, parabolic):
    rows = roll(aspect, xi, eta, phi, model=BOUND[parabolic], direction=direction, strips=12, cells=8)
    power = rows["Fx"] * rows["xi"] + rows["Fy"] * rows["eta"] + rows["Mz"] * rows["phi"]
    assert power.sum() <= 1e-12 * np.abs(power).sum()


@given(aspect=aspects, xi=signed, eta=signed, phi=spins)
def test_rolling_backwards_is_the_mirror_image(aspect, xi, eta, phi):
    # the plane x -> -x turns xi and phi round, and with them Fx and the moment
    ahead = total(roll(aspect, xi, eta, phi, strips=12, cells=8))
    back = total(roll(aspect, -xi, eta, -phi, direction=-1.0, strips=12, cells=8))
    np.testing.assert_array_equal(back, ahead * [-1.0, 1.0, -1.0])


@given(aspect=aspects, xi=signed, eta=signed, phi=spins)
def test_mirrored_creepages_give_mirrored_forces(aspect, xi, eta, phi):
    force = total(roll(aspect, xi, eta, phi, strips=12, cells=8))
    mirrored = total(roll(aspect, xi, -eta, -phi, strips=12, cells=8))  # the plane y -> -y
    np.testing.assert_allclose(mirrored, force * [1.0, -1.0, -1.0], rtol=1e-9, atol=1e-9 * FORCE)


def test_cells_converge():
    # creepages about the end of the linear range, with spin: 20 cells are within 2 % of mu N of many
    for aspect in (0.5, 1.0, 2.0):
        fine = total(roll(aspect, 1e-3, 1e-3, 0.3, strips=200, cells=400))
        errors = [
            np.abs(total(roll(aspect, 1e-3, 1e-3, 0.3, strips=200, cells=n)) - fine)[:2].max() for n in (20, 40, 80)
        ]
        assert errors[0] < 0.02 * FRICTION * FORCE
        assert errors[2] < 0.5 * errors[0]


def reference():
    path = Path(__file__).parents[1] / "data/tangential.csv"
    return list(csv.DictReader(line for line in path.read_text().splitlines() if not line.startswith("#")))


# Largest |difference| of fx, fy over mu N and of the moment over mu N sqrt(a b), measured with 66 x 66 cells.
# Against the program's own FASTSIM pure creepages agree to the cells; oblique ones differ because it blends the three
# flexibilities into one. Its parabolic bound is one paraboloid over the ellipse, ours a parabola on every strip: nearer
# to the exact solution. Against that 5 % is what FASTSIM is known for, 10 % with spin and oblique slip.
ACCURACY = [
    ("fastsim_ell", False, False, 0.015, 0.02),
    ("fastsim_ell", False, True, 0.05, 0.03),
    ("fastsim_par", True, False, 0.04, 0.06),
    ("fastsim_par", True, True, 0.135, 0.08),
    ("contact", False, False, 0.06, 0.035),
    ("contact", False, True, 0.10, 0.055),
    ("contact", True, False, 0.075, 0.08),
    ("contact", True, True, 0.10, 0.08),
]


@pytest.mark.parametrize(
    ("method", "parabolic", "combined", "force", "moment"),
    ACCURACY,
    ids=[f"{m}, {'parabolic' if p else 'elliptic'}, {'combined' if c else 'pure'}" for m, p, c, _, _ in ACCURACY],
)
def test_forces_beside_contact(method, parabolic, combined, force, moment):
    rows = [r for r in reference() if r["method"] == method and (r["kind"] == "comb") == combined]
    assert len(rows) >= 27
    errors = []
    for row in rows:
        creepages = float(row["cksi"]), float(row["ceta"]), 1e3 * float(row["cphi_radpmm"])
        ours = total(roll(float(row["a_over_b"]), *creepages, strips=66, cells=66, model=BOUND[parabolic]))
        ours /= FRICTION * FORCE * np.array([1.0, 1.0, MEAN_RADIUS])
        errors.append(ours - [float(row["fx"]), float(row["fy"]), float(row["mz_norm"])])
    errors = np.abs(errors).max(axis=0)
    assert errors[:2].max() < force
    assert errors[2] < moment


def test_spin_pushes_in_contacts_direction():
    for row in reference():
        if row["method"] == "contact" and row["kind"] == "spin":
            force = total(roll(float(row["a_over_b"]), phi=1e3 * float(row["cphi_radpmm"])))
            assert force[1] * float(row["fy"]) > 0.0
