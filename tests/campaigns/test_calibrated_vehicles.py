"""Calibrations of vehicles whose truth is known: twins, a planted yaw stiffness, another program's series.

The short form of the first, with formulas in the place of runs, is in tests/study/test_calibration.py."""

import numpy as np
import pytest
from support.scripts import script

from wrsim import calibrate

scripts = script("campaigns/calibration.py")


@pytest.mark.campaign
def test_intervals_of_twins_hold_the_truth_of_85_to_95_percent_of_120(tmp_path):
    held = [inside for seed in range(20) for inside in scripts.hits(scripts.twin(tmp_path / f"{seed}", seed), 2)[0]]
    assert len(held) == 120 and 0.85 <= np.mean(held) <= 0.95


@pytest.mark.campaign
def test_a_planted_yaw_stiffness_is_found_within_2_percent_from_30_steady_curves(tmp_path):
    (row,) = calibrate(scripts.curves(tmp_path), tmp_path / "out", pictures=False)["keys"]
    assert row["value"] == pytest.approx(24000.0, rel=0.02) and row["told"]
    assert row["low"] <= 24000.0 <= row["high"]


@pytest.mark.campaign
@pytest.mark.reference
def test_a_metro_car_comes_to_the_parameters_of_another_program_or_says_that_they_are_not_told(reference, tmp_path):
    """Within 5 %, friction 0.02: the contact law of the other program differs by up to the noise that is given."""
    outcome = calibrate(scripts.metro_car(reference, tmp_path), tmp_path / "out", pictures=False)
    told = {row["key"] for row in outcome["keys"] if row["told"]}
    assert told >= {"vehicle.carbody.mass_kg", "vehicle.bogie.bushing.stiffness_kN_per_m.0", "contact.friction.static"}
    for row, (true, _) in zip(outcome["keys"], scripts.OFF.values(), strict=True):
        if row["key"] == "contact.friction.static":
            assert row["value"] == pytest.approx(true, abs=0.02)
        elif row["told"]:
            assert row["value"] == pytest.approx(true, rel=0.05), row["key"]
        assert row["low"] <= true <= row["high"], row["key"]
