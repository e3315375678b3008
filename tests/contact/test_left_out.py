"""Places along the rail that strips leave out, on rails that change along the track; flats: test_out_of_round.py."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from support.contacts import rail_profile, wheel_profile

from wrsim import ContactSettings, contact_model
from wrsim.contact.left_out import share_left_out
from wrsim.contact.records import STATUS_LEFT_OUT
from wrsim.contact.surfaces.rail_surface import RailSection, RailSurface
from wrsim.contact.wheel_rail import place_bodies

R = 0.46
WHEEL, RAIL = wheel_profile("S1002"), rail_profile("60E1", 40)
HEIGHTS = {
    "dip of 2 x 20 mrad": lambda s: 0.02 * abs(s),
    "squat, 30 mm long": lambda s: -0.15e-3 * (1.0 + np.cos(2.0 * np.pi * np.clip(s / 0.03, -0.5, 0.5))),
    "hill": lambda s: -s * s,
}


def models(height, *normals):
    sections = [RailSection(s, RAIL.shifted(0.0, height(s))) for s in np.arange(-0.1, 0.101, 0.002).tolist()]
    surface = RailSurface("rail", tuple(sections))
    choices = [ContactSettings(normal=normal, tangential="none", damping=0.0) for normal in normals]
    return [contact_model(WHEEL, RAIL, R, settings, 0.3, surface) for settings in choices]


@pytest.mark.parametrize("name", HEIGHTS)
def test_a_place_before_or_behind_a_dip_is_told_with_its_force(name):
    """Against the exact solver's patches at the same pose; where the rail is convex there is no other place. The
    estimate has the curvature of the first place, and the second one presses that down in the exact solver only."""
    strips, kik, exact = models(HEIGHTS[name], "strips", "kik-piotrowski", "half-space")
    rng, shares = np.random.default_rng(2), []
    for place in (-0.025, 0.025, *rng.uniform(-2.5e-3, 2.5e-3, 12).tolist()):
        yaw = rng.uniform(-4e-3, 4e-3)
        axle = -np.sin(yaw), np.cos(yaw), 0.0
        start = [[0.0, rng.uniform(-3e-3, 0.0), 0.465, *axle, *np.zeros(6)]]
        pose = strips.solve_many(start, rng.uniform(3e4, 1.2e5), threads=1, place=place).poses[0, :3]
        contact, other = strips.evaluate(pose, axle, place=place), kik.evaluate(pose, axle, place=place)
        whole = exact.evaluate(pose, axle, place=place)
        missing = 1.0 - contact.normal_force / whole.normal_force
        assert whole.status == 0
        if not 0.01 < missing < 0.08:
            assert bool(contact.status & STATUS_LEFT_OUT) == (missing > 0.05)
        if missing > 0.15:
            assert other.status & STATUS_LEFT_OUT
        forces = np.sort(whole.patches["N"])[::-1]
        if forces.size > 1 and forces[1] > 0.05 * forces[0]:
            a = strips.arrays.rows
            share = share_left_out(*place_bodies(a)[:2], a.model[0], a.patches, a.strips, contact.patches.size)
            shares.append(share / (forces[1] / forces[0]))
    assert (len(shares) > 3) == (name != "hill")
    if shares:
        assert_allclose(np.median(shares), 1.0, atol=0.25)
