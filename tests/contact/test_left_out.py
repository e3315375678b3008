"""Strips on rails that bend along the track: the mean over the length of contact, and places that they leave out;
flats: test_out_of_round.py."""

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


def models(height, *normals, apart=0.002):
    sections = [RailSection(s, RAIL.shifted(0.0, height(s))) for s in np.arange(-0.1, 0.1001, apart).tolist()]
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
        contact, kik_contact = strips.evaluate(pose, axle, place=place), kik.evaluate(pose, axle, place=place)
        whole = exact.evaluate(pose, axle, place=place)
        missing = 1.0 - contact.normal_force / whole.normal_force
        assert whole.status == 0
        if not 0.01 < missing < 0.08:
            assert bool(contact.status & STATUS_LEFT_OUT) == (missing > 0.05)
        if missing > 0.15:
            assert kik_contact.status & STATUS_LEFT_OUT
        forces = np.sort(whole.patches["N"])[::-1]
        if forces.size > 1 and forces[1] > 0.05 * forces[0]:
            a = strips.arrays.rows
            share = share_left_out(*place_bodies(a)[:2], a.model[0], a.patches, a.strips, contact.patches.size)
            shares.append(share / (forces[1] / forces[0]))
    assert (len(shares) > 3) == (name != "hill")
    if shares:
        assert_allclose(np.median(shares), 1.0, atol=0.25)


def wave(length, amplitude):
    return lambda s: amplitude * np.cos(2.0 * np.pi * s / length)


def pressed(model, load, place=0.0, lateral=-1e-3):
    """The pose under a load, and the contact there."""
    start = [[0.0, lateral, model.radius + 5e-3, 0.0, 1.0, *np.zeros(7)]]
    pose = model.solve_many(start, load, threads=1, place=place).poses[0, :3]
    return pose, model.evaluate(pose, place=place)


@pytest.mark.parametrize("place", [0.0, 0.3], ids=["crest", "trough"])
@pytest.mark.parametrize("normal", ["strips", "kik-piotrowski"])
def test_a_long_wave_bends_as_its_top_everywhere(normal, place):
    """A wheel of the radius 1/(1/R +- amplitude (2 pi/length)^2) on a straight rail parts from it as fast."""
    bend = 2e-3 * (2.0 * np.pi / 0.6) ** 2
    (waved,) = models(lambda s: wave(0.6, 2e-3)(s + place), normal)
    settings = ContactSettings(normal=normal, tangential="none", damping=0.0)
    like_radius = 1.0 / (1.0 / R + (bend if place == 0.0 else -bend))
    plain = contact_model(WHEEL, RAIL, like_radius, settings, 0.3)
    contact, same = pressed(waved, 8e4)[1], pressed(plain, 8e4)[1]
    assert_allclose(same.patches["approach"], contact.patches["approach"], rtol=1e-3)
    assert_allclose(same.patches["p0"], contact.patches["p0"], rtol=2e-3)


@pytest.mark.parametrize(("length", "amplitude"), [(0.02, 1e-5), (0.03, 2e-5), (0.03, 3e-5)])
def test_a_wave_as_short_as_the_contact_presses_as_in_the_exact_solver(length, amplitude):
    """The exact solver takes the whole gap. A rail that bends everywhere as the trough does in its middle presses more,
    up to 7 %. The force acts where the exact one does: seen from the axle by its moment over itself."""
    strips, exact = models(wave(length, amplitude), "strips", "half-space", apart=0.001)
    off = []
    for phase in (0.0, 0.1, 0.25, 0.4, 0.5):
        pose, contact = pressed(strips, 8e4, phase * length)
        whole = exact.evaluate(pose, place=phase * length)
        assert_allclose(contact.normal_force, whole.normal_force, rtol=0.025)
        assert_allclose(contact.patches["p0"], whole.patches["p0"], rtol=0.02)
        off.append(1e3 * (contact.moment[1] / contact.normal_force - whole.moment[1] / whole.normal_force))
    assert np.abs(off).max() < 0.2
    bend = 0.5 * amplitude * (2.0 * np.pi / length) ** 2
    (hollow,) = models(lambda s: bend * s * s - amplitude, "strips")
    of_one_bend = hollow.evaluate(pose).normal_force
    assert of_one_bend - whole.normal_force > 2.0 * abs(contact.normal_force - whole.normal_force)
    assert of_one_bend > (1.07 if amplitude == 3e-5 else 1.02) * whole.normal_force
