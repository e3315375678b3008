"""A run knows neither where north is nor what is left: turned, shifted and mirrored tracks, more than a full circle.

The full contact model is in the loop; S1002 on 60E1 through a transition into a sharp curve, with contact on tread and
flange root. Where both touch, strips come and go, and where one does a step earlier or later the strip model leaves up
to 4e-7 of the load open: the leading wheelset has Kik-Piotrowski's contact.
"""

from functools import cache

import numpy as np
import pytest
import xarray as xr
from support.runs import FAST, LEADING, STEERING, arc, mirrored, relaid, setup_of, straight, transition

from wrsim.analysis.motion.run import run_in_time
from wrsim.scenario.build import Setup

LATERAL = ("lateral_shift", "yaw", "roll", "curvature", "cant", "y_contact", "guide_force_y", "guide_moment", "sum_Y")
"""Channels that change their sign in a mirror; those of wheels and patches are written outward and do not."""


@cache
def setup(vehicle: str) -> Setup:
    """2 m straight, 6 m of transition, 2 m of the arc at 12 m/s. Newton's method leaves the last digits open."""
    coarse = FAST if vehicle == LEADING else {"contact.strips": 12, "contact.cells": 6}
    values = {"run.integrator": "rk44"} | coarse
    return setup_of([straight(2.0), transition(6.0), arc(2.0, 150.0, 50.0, 5.0)], 12.0, vehicle, values=values)


@cache
def reference(vehicle: str) -> xr.Dataset:
    """The run on the track as it is."""
    dataset = run_in_time(setup(vehicle)).wheelset()
    assert dataset.attrs["status"] == "completed"
    return dataset


def largest_differences(one: xr.Dataset, other: xr.Dataset) -> dict[str, float]:
    """Largest difference of every channel over its largest value; places without a value must agree."""
    found = {}
    for name, channel in one.data_vars.items():
        if channel.dtype.kind == "f":
            a, b = channel.values, other[name].values
            assert np.array_equal(np.isnan(a), np.isnan(b)), name
            scale = np.nanmax(np.abs(a), initial=0.0)
            found[str(name)] = np.nanmax(np.abs(a - b), initial=0.0) / (scale or 1.0)
        elif channel.dtype.kind in "iu":
            assert np.array_equal(channel.values, other[name].values), name
    return found


@pytest.mark.parametrize(
    ("vehicle", "heading", "start"),
    [
        (LEADING, 15.0, (1000.0, 2000.0, 300.0)),
        pytest.param(STEERING, np.pi, (30.0, -40.0, 5.0), marks=pytest.mark.campaign),
    ],
)
def test_a_run_does_not_depend_on_the_direction_and_the_place_of_the_track(vehicle, heading, start):
    laid = run_in_time(relaid(setup(vehicle), heading, start)).wheelset()
    differences = largest_differences(reference(vehicle), laid)
    # 1e-6 is asked; 2 km from the origin a coordinate has a round-off of 2e-13 m, 5e-9 of the approach
    worst = max(differences, key=lambda name: differences[name])
    assert differences[worst] < 1e-6, worst


@pytest.mark.parametrize("vehicle", [LEADING, pytest.param(STEERING, marks=pytest.mark.campaign)])
def test_a_left_curve_mirrors_a_right_curve(vehicle):
    mirror = run_in_time(mirrored(setup(vehicle))).wheelset()
    mirror = mirror.isel(wheel=[1, 0])
    for name in LATERAL:
        mirror[name] = -mirror[name]
    # labels of the snapshots name the sides, and the snapshots are those of the same places
    differences = largest_differences(reference(vehicle), mirror)
    # 63 MN/m times the round-off of 16 m, over 0.3 kN
    assert differences.pop("guide_force_x") < 1e-8
    # a difference of forces four times as large, of the wheels that change places
    differences["sum_Y"] *= float(abs(mirror["sum_Y"]).max() / abs(mirror["Y"]).max())
    worst = max(differences, key=lambda name: differences[name])
    # strips end their search at 1e-9 of what presses them; the start agrees to 1e-12
    assert differences[worst] < 1e-7, worst


@pytest.mark.parametrize(("start", "end"), [(0.96, 1.03), pytest.param(0.01, 1.03, marks=pytest.mark.campaign)])
def test_more_than_a_full_circle_is_steady_all_the_way_round(start, end):
    # 25 m of radius is tight even for a tram. The circle is long, hence few strips and cells, and a step that only the
    # saturated creep forces of such a curve allow
    radius, speed = 25.0, 10.0
    coarse = FAST | {"contact.strips": 8, "run.output_interval_ms": 20, "run.step_us": 500}
    way = 2.0 * np.pi * radius
    circle = setup_of([arc(end * way, radius, 160.0, 15.0)], speed, STEERING, start=start * way, values=coarse)
    dataset = run_in_time(circle).wheelset()
    assert dataset.attrs["status"] == "completed"
    assert dataset["distance"].values[0] < way < dataset["distance"].values[-1]
    for name in ("lateral_shift", "yaw", "roll", "spin_rate", "Y", "Q", "X", "contact_angle", "N", "p0"):
        channel = dataset[name].values
        # the long step tracks the turning to 5e-5 (a step of 200 us to 1e-7); at the track's end it goes straight on
        assert np.nanmax(np.ptp(channel[:-2], axis=0)) < 2e-4 * np.nanmax(np.abs(channel)), name
