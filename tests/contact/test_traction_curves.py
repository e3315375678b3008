"""Traction of a locomotive's wheel over the creepage beside CONTACT (../shared/reference/traction_curves.csv)."""

import csv
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import ellipe, ellipk
from support.ellipse import POISSON, SHEAR_MODULUS, roll, total

from wrsim import InputError, load

REFERENCE = Path(__file__).resolve().parents[2].parent / "shared/reference/traction_curves.csv"
LOAD, CURVATURE, ASPECT, SPEED = 106.7e3, 0.8, 0.5, 10.0  # N, z = A x^2 [1/m], a/b, m/s
FALLING = {"fall_ratio": 0.1368 / 0.36, "fall_decay": np.log(2.0) / 0.99}
"""mu = 0.1368 + 0.2232 2^(-s/0.99) in our law, of 0.36 at rest."""
REDUCED = {"slope_k0": 0.54, "slope_alpha_inf": 0.02, "slope_beta": 0.62}
RANGES = [
    (3, "fastsim, parabolic", 0.33, {}, 0.01),
    (1, "fastrip", 0.33, {}, 0.01),
    (4, "fastsim, parabolic", 0.36, FALLING | REDUCED, 0.01),
]


def curve(series):
    """Creepages and longitudinal force over the load."""
    with REFERENCE.open() as file:
        rows = [row for row in csv.DictReader(file) if row["series"] == str(series)]
    return np.array([[float(row["creepage"]), float(row["FX_N"]) / LOAD] for row in rows]).T


def ellipse():
    """sqrt(a b) [m] and largest pressure [Pa] of Hertz (Johnson, Contact Mechanics, equation 4.25)."""
    modulus, e2 = SHEAR_MODULUS / (1.0 - POISSON), 1.0 - ASPECT**2
    shape = (ellipe(e2) / ASPECT**2 - ellipk(e2)) * ASPECT**3 / e2
    a = np.cbrt(1.5 * LOAD * shape / (np.pi * modulus * CURVATURE))
    return a / np.sqrt(ASPECT), 1.5 * LOAD * ASPECT / (np.pi * a * a)


def traction(model, friction, creepage, numbers):
    radius, peak = ellipse()
    choices = {"radius": radius, "peak": peak, "direction": SPEED, "strips": 60, "cells": 60, **numbers}
    return total(roll(ASPECT, xi=creepage, model=model, friction=friction, **choices))[0] / LOAD


@pytest.mark.parametrize("series, model, friction, numbers, most", RANGES)
def test_traction_follows_contact(series, model, friction, numbers, most):
    creepage, force = curve(series)
    found = [traction(model, friction, x, numbers) for x in creepage]
    assert_allclose(found, force, atol=most)


@pytest.mark.parametrize("model", ["fastsim", "fastrip"])
def test_the_reduction_begins_with_its_part_of_kalker_and_ends_with_friction(model):
    """k = k_0 at no creepage; the force never exceeds mu N, to which it comes at large creepages."""
    small = traction(model, 0.3, 1e-7, REDUCED) / traction(model, 0.3, 1e-7, {})
    assert_allclose(small, 0.54, rtol=1e-3)
    assert_allclose(traction(model, 0.3, 0.9, REDUCED), -0.3, rtol=0.02)


def test_no_reduction_is_the_plain_model_to_the_bit():
    numbers = {"slope_k0": 1.0, "slope_alpha_inf": 1.0, "slope_beta": 5.0}
    for model in ("fastsim", "fastrip"):
        assert traction(model, 0.3, 1e-3, numbers) == traction(model, 0.3, 1e-3, {})


def test_slope_reduction_belongs_to_fastsim_and_fastrip():
    scenario = load(Path(__file__).resolve().parents[2] / "scenarios/traction.toml")
    settings = scenario.spec.contact.settings()
    assert (settings.slope_k0, settings.slope_alpha_inf, settings.slope_beta) == (0.54, 0.02, 0.62)
    with pytest.raises(InputError, match=r'slope_k0 = 0\.54: goes with tangential = "fastsim" or "fastrip" only'):
        scenario.with_values({"contact.tangential": "polach"})
