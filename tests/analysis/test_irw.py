"""The light rail vehicle with independent wheels in its curve of 300 m: laws that hold with any profiles."""

from functools import cache

import numpy as np
import pytest
import xarray as xr
from support.runs import FAST, SCENARIOS

from wrsim.analysis import run
from wrsim.scenario.loading import load


@cache
def through(contact: str) -> xr.Dataset:
    """The shipped scenario from the full curve on, 6 m in steady motion: from straight track its dampers creep for a
    minute."""
    keys = {"run.start_distance_m": 150.0, "run.distance_m": 6.0, "vehicle.drive": "train", "contact.normal": contact}
    found = run(load(SCENARIOS / "irw_r300.toml").with_values(FAST | keys)).dataset
    assert found.attrs["status"] == "completed"
    return found


def test_no_creep_forces_lengthwise_steer():
    """The shipped rigid wheelsets have some 10 kN here (GZ18); these have what angle of attack and drag leave."""
    found = through("kik-piotrowski")
    assert np.abs(found["X"].values).max() < 300.0
    assert np.abs(found["X"].diff("wheel").values).max() < 200.0


@pytest.mark.parametrize("normal", ["kik-piotrowski", pytest.param("strips", marks=pytest.mark.campaign)])
def test_it_stays_where_the_search_for_its_steady_motion_puts_it(normal):
    """A run that starts in the full curve: the wheels stay within 20 um and Q within 1 % for 6 m, with the front bogie
    at the outer rail and the rear one at the inner rail.
    """
    found = through(normal)
    shift, load_ = found["lateral_shift"].values, found["Q"].values
    assert np.abs(shift - shift[0]).max() < 20e-6
    assert np.abs(load_ - load_[0]).max() < 0.01 * load_.mean()
    assert (shift[0, :2] > 9e-3).all()
    assert (shift[0, 2:] < -9e-3).all()
