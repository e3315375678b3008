"""GZ18, a metro car, in steady curves against two other codes; needs the tables of its source (--reference).

The figures are those of ORVD 4706df9 for the leading wheelset in the full curve, turned into our axes; they equal the
curves published for SIMPACK to the width of a line. Forces of a contact are taken apart at the contact angle."""

import numpy as np
import pytest
from support.scripts import ROOT, script

from wrsim.analysis import run
from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.start import start_state
from wrsim.analysis.stationary.statics import static_state
from wrsim.analysis.steady import steady_in_curve
from wrsim.scenario.build import build
from wrsim.scenario.loading import load

gz18 = script("campaigns/gz18.py")
theirs = script("campaigns/gz18_contact_law.py")

MM, MRAD, N, MU = 0.1, 0.15, 0.02, 0.3
"""How near: lateral shift [mm], yaw [mrad], N as a part of it, creep forces as 5 % of mu N."""

LATERAL = {"r300": 8.834, "r600": 7.991}  # outward [mm]
YAW = {"r300": 7.520, "r600": 3.468}  # nose outward [mrad]
CONTACTS = {  # outer wheel, inner wheel: N, force on the wheel forward, outward push on the rail in its plane [kN]
    "r300": ((79.03, 10.51, -19.01), (59.07, -10.85, 12.94)),
    "r600": ((67.62, 14.76, -12.18), (68.64, -14.98, 13.38)),
}


def close(line: str, wheel: int, forces: tuple[float, float, float]) -> None:
    """The forces of a contact [kN] are theirs."""
    expected = CONTACTS[line][wheel]
    assert forces[0] == pytest.approx(expected[0], rel=N)
    assert np.subtract(forces[1:], expected[1:]) == pytest.approx(np.zeros(2), abs=0.05 * MU * expected[0])


@pytest.mark.campaign
@pytest.mark.reference
@pytest.mark.parametrize("line", ["r300", "r600"])
@pytest.mark.parametrize("normal", ["strips", "kik-piotrowski"])
def test_the_leading_wheelset_stands_in_a_curve_as_in_other_codes(line, normal, reference, tmp_path):
    sample = run(gz18.steady(reference, tmp_path, line, {"contact.normal": normal})).dataset.isel(pose=0, wheelset=0)
    assert 1e3 * sample["yaw"].item() == pytest.approx(YAW[line], abs=MRAD)
    for wheel in range(2):
        wheel_sample = sample.isel(wheel=wheel)
        angle = wheel_sample["contact_angle"].values[np.nanargmax(wheel_sample["N"].values)]
        c, s = np.cos(angle), np.sin(angle)
        y, q = (wheel_sample[name].item() / 1e3 for name in "YQ")
        close(line, wheel, (q * c + y * s, -wheel_sample["X"].item() / 1e3, y * c - q * s))
    if line == "r300":  # in r600 their contact law stands it elsewhere: the next test
        assert 1e3 * sample["lateral_shift"].item() == pytest.approx(LATERAL[line], abs=MM)


@pytest.mark.campaign
@pytest.mark.reference
def test_where_the_wider_curve_stands_apart_the_contact_law_is_why(reference, tmp_path):
    """With their contact in the place of ours, nothing else changed, all of the figures are theirs."""
    setup = build(gz18.steady(reference, tmp_path, "r600", {"contact.cells": 8}))
    ours = steady_in_curve(setup, setup.plan.points[0])
    before = 1e3 * theirs.pose_of(ours.law, ours, 0).lateral[0]
    law, equilibrium = theirs.their_steady_motion(ours)
    pose = theirs.pose_of(law, equilibrium, 0)
    assert 1e3 * pose.lateral[0] == pytest.approx(LATERAL["r600"], abs=MM)
    assert 1e3 * pose.yaw[0] == pytest.approx(YAW["r600"], abs=MRAD)
    for wheel, c in enumerate(law.contacts[0]):
        close("r600", wheel, (c.normal / 1e3, c.fx / 1e3, -c.fy / 1e3))
    assert abs(before - LATERAL["r600"]) > 2.0 * abs(1e3 * pose.lateral[0] - LATERAL["r600"])


@pytest.mark.campaign
@pytest.mark.reference
def test_their_contact_law_is_read_as_the_source_has_it(reference, tmp_path):
    """The offset of the rail that the source prints carries the static load, and gives the rolling radius printed."""
    setup = build(gz18.steady(reference, tmp_path))
    wheel = setup.vehicle.wheelsets[0].wheelset.left
    pose = np.array([0.0, 0.7465 - setup.track.rail_origins[0][0], 0.42 - 0.0003055705525365684])
    pose_at_rest = np.concatenate([pose, [0.0, 1.0, 0.0], np.zeros(6)])  # at rest
    contact, wrench = theirs.contact(pose_at_rest, wheel.profile, setup.rails[0], wheel.radius, 10.0)
    assert wrench[2] == pytest.approx(68295.994, rel=0.005)
    height = theirs.sections(wheel.profile, setup.rails[0])[-1](contact.across)
    assert pose[2] - height == pytest.approx(0.42024171, abs=1e-6)


def test_independent_wheels_of_the_source_stand_as_it_says():
    """49 287.489 N a wheel; they come from the masses alone."""
    loads = static_state(build(load(ROOT / "scenarios/irw_r300.toml")).vehicle).wheel_loads
    assert loads == pytest.approx(np.full((4, 2), 49287.489), rel=1e-6)


@pytest.mark.campaign
@pytest.mark.reference
def test_independent_wheels_of_the_source_roll_on_straight_track_as_it_says(reference, tmp_path):
    """38.782287 rad/s at 60 km/h in its start state."""
    setup = build(gz18.scenario(reference, tmp_path, "r300", car="irw"))
    law = force_law(setup)
    q, q_t = start_state(setup, law)
    law(0.0, q, q_t, np.zeros(law.size))
    spins = q_t[6 * np.arange(4) + 5]
    # the source takes creepages in the middle of the overlap, half the approach nearer to the axle
    approach = np.array([pair[0].model.arrays.patches["approach"][0] for pair in law.wheels])
    radii = law.speed / spins - 0.5 * approach
    assert law.speed / radii == pytest.approx(np.full(4, 38.782287), rel=2e-5)  # 9 um of the radius
    assert q_t[list(law.twists.values())] == pytest.approx(np.zeros(4), abs=1e-6)
