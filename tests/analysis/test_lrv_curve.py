"""The light rail wheelset in its tram curve, as far as the beginning of the arc: tread, flange root, flank."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from wrsim import load, run

SCENARIO = Path(__file__).parents[2] / "scenarios" / "lrv_curve.toml"


@pytest.fixture(scope="module")
def dataset() -> xr.Dataset:
    shortened = {"run.start_distance_m": 2.5, "run.distance_m": 12.5, "output.patches_at_m": [3, 10, 15]}
    return run(load(SCENARIO).with_values(shortened)).wheelset()


def at(dataset: xr.Dataset, distance: float) -> xr.Dataset:
    """The outer (left) wheel there."""
    index = int(np.argmin(np.abs(dataset["distance"].values - distance)))
    return dataset.isel(time=index).sel(wheel="left")


def test_the_bogie_turns_the_axle_with_the_curvature(dataset: xr.Dataset) -> None:
    """0.9 m / 25 m = 36 mrad at the arc; the creep forces bend the springs by 1 % of that. The curve goes right, a
    leading axle points to its outside: to the left."""
    assert float(at(dataset, 14.8)["yaw"]) == pytest.approx(0.9 / 25.0, rel=0.03)


def test_in_the_curve_the_outer_wheel_rides_on_its_root_with_a_curved_patch(dataset: xr.Dataset) -> None:
    """One patch on the root between 8 and 12.5 m: its angle varies by more than 15 degrees from 10 m on."""
    root = at(dataset, 10.0)
    assert int(root["n_patches"]) == 1
    assert 30.0 < float(np.degrees(root["contact_angle"][0])) < 45.0
    # the exact solver at this moment (wrsim resolve): 18.7 degrees, 1097 MPa; docs/theory/strip_model.md on large yaw
    assert float(np.degrees(root["contact_angle_variation"][0])) == pytest.approx(18.7, abs=1.6)
    assert float(root["p0"][0]) == pytest.approx(1097e6, rel=0.03)


def test_at_a_large_angle_of_attack_root_and_flank_share_the_wheel(dataset: xr.Dataset) -> None:
    """The flank, at 70 degrees, touches ahead of the axle: by R tan(angle) tan(attack), the contact locus; attack is
    that to the rail where it is touched."""
    both = at(dataset, 14.8)
    assert int(both["n_patches"]) == 2
    angle = float(both["contact_angle"][1])
    assert np.degrees(angle) == pytest.approx(70.0, abs=0.5)
    depth = 0.375 + 0.012  # the flank is some 12 mm below the tape circle
    lever = depth * np.tan(angle)
    ahead = lever * np.tan(float(both["yaw"])) / (1.0 - lever / 25.0)
    assert float(both["x_contact"][1]) == pytest.approx(ahead, rel=0.02)
    assert 0.1 < float(both["N"][1] / both["N"][0]) < 0.3


def test_nothing_jumps_between_one_patch_and_two(dataset: xr.Dataset) -> None:
    """The second patch sets in with the load zero and takes it from the first: Y stays within 2 % of itself over the
    half metre around it, where it rings by less than 1 %."""
    distance, y = dataset["distance"].values, dataset["Y"].sel(wheel="left").values
    second = dataset["N"].sel(wheel="left", patch=1).values
    begins = int(np.flatnonzero(np.isfinite(second) & (distance > 10.0))[0])
    assert second[begins] < 200.0
    near = np.abs(distance - distance[begins]) < 0.25
    assert np.ptp(y[near]) < 0.02 * y[begins]
