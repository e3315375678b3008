"""The shipped ride of the coach, in short: from even track onto ERRI low."""

import numpy as np
from support.runs import SCENARIOS
from support.vehicles import COARSE, manchester

from wrsim.analysis import run
from wrsim.analysis.ride import evaluate_ride
from wrsim.scenario.loading import load

EVEN = 30.0  # metres at the begin of the track without irregularities


def test_the_coach_is_quiet_up_to_the_uneven_track_and_its_springs_keep_the_floor_quieter_than_the_frames():
    keys = COARSE | {"run.start_distance_m": 5.0, "run.distance_m": 65.0, "ride.from_m": 40.0}
    result = run(load(SCENARIOS / "manchester_ride_160.toml").with_values(keys))
    assert result.status == "completed"
    dataset = result.dataset
    first = manchester().wheelsets[0].x
    even = dataset["distance"].values + first < EVEN
    assert 5 < even.sum() < dataset.sizes["time"] // 2
    for channel in ("point_ay", "point_az"):
        values = dataset[channel].values
        # steady motion, to what Newton's method leaves over, before the first wheel meets the irregularities
        assert np.abs(values[even]).max() < 1e-3 * np.abs(values[~even]).max()
    points = evaluate_ride(result).as_dict()["points"]
    for end in ("front", "rear"):
        for axis in ("y", "z"):
            floor, above = (points[f"{where} {end}"]["rms_m_s2"][axis] for where in ("floor", "frame"))
            assert 0.0 < floor < 0.5 * above
