"""The curved patch: strips between two outlines, their places, normals, lengths; what a rigid approach closes."""

import numpy as np
import pytest
from support.contacts import (
    HALF_SPACING,
    PLAIN,
    RADIUS,
    bench,
    columns,
    contact_model,
    pair_model,
    rail_origin,
    round_wheel,
    settle,
)

from wrsim.contact.model import EPSILON
from wrsim.geometry.profile.sections import circle

POSES = [("S1002/60E1 1:40", 2e-3), ("S1002/60E1 1:40", 6e-3), ("S1002/60E1 1:40", 8e-3), ("worn/worn 1:40", 0.0)]


@pytest.fixture(params=POSES, ids=lambda p: f"{p[0]} {1e3 * p[1]:g} mm")
def patch(request):
    """(model, origin of the wheel in rail axes, lobe, strips) of a single patch without yaw, 60 kN."""
    pair, lateral = request.param
    model = pair_model(pair, strips=41, **PLAIN)
    solved, contact = settle(bench(model, rolling=False), lateral, 0.0, 60e3)
    o, b = rail_origin(model.rail)
    (lobe,), (strips,) = contact.patches, contact.strips
    return model, np.array([HALF_SPACING + lateral - o, solved.height - b]), lobe, strips


def points(model, origin, lobe, s):
    """Points of rail and wheel at arclength s from the main points, with their unit tangents; (2, n) each."""
    rail = np.array(model.rail.at(lobe["arc_rail"] + s)), np.array(model.rail.tangent(lobe["arc_rail"] + s))
    u, w = model.wheel.at(lobe["arc_wheel"] + s)
    wheel = origin[:, None] + np.array([u, w - RADIUS]), np.array(model.wheel.tangent(lobe["arc_wheel"] + s))
    return rail, wheel


def test_strips_tile_the_patch_from_edge_to_edge(patch):
    _, _, lobe, strips = patch
    np.testing.assert_allclose(np.diff(strips["s"]), strips["ds"][0], rtol=1e-9)
    np.testing.assert_array_equal(strips["ds"], strips["ds"][0])
    assert strips["s"][0] - 0.5 * strips["ds"][0] == pytest.approx(lobe["start"], abs=1e-15)
    assert strips["s"][-1] + 0.5 * strips["ds"][0] == pytest.approx(lobe["end"], abs=1e-15)
    assert lobe["width"] == pytest.approx(lobe["end"] - lobe["start"], abs=1e-15)
    assert lobe["start"] < 0.0 < lobe["end"]


def test_strips_stand_midway_between_points_of_equal_arclength(patch):
    # 2e-8: where curvature jumps the kernel's table leaves the profile by up to 1e-8 m
    model, origin, lobe, strips = patch
    (rail, _), (wheel, _) = points(model, origin, lobe, strips["s"])
    np.testing.assert_allclose(columns(strips, "o b").T, 0.5 * (rail + wheel), atol=2e-8)


def test_normals_are_unit_vectors_on_the_bisector_and_across_the_midline(patch):
    model, origin, lobe, strips = patch
    normals = columns(strips, "no nb")
    # the tables' tangents are unit vectors to (step times curvature)^4; beside a join to 6e-7, turned by 2e-4
    np.testing.assert_allclose(np.hypot(*normals.T), 1.0, rtol=1e-6)
    assert np.median(np.abs(np.hypot(*normals.T) - 1.0)) < 1e-8
    (_, rail_tangent), (_, wheel_tangent) = points(model, origin, lobe, strips["s"])
    mean = rail_tangent + wheel_tangent
    mean /= np.hypot(*mean)
    np.testing.assert_allclose(normals.T, [-mean[1], mean[0]], atol=2e-4)
    # [S 27], the difference quotient over two strips
    chord = columns(strips[2:], "o b") - columns(strips[:-2], "o b")
    along = np.abs((chord * normals[1:-1]).sum(axis=1)) / np.hypot(*chord.T)
    assert along.max() < 0.25 * strips["ds"][0] / 13e-3  # a jump of curvature from 0 to 1/13 mm within the chord
    assert (normals[:, 1] > 0.0).all()  # from rail to wheel


@pytest.mark.parametrize("approach", ["constant", "projected"])
def test_strips_are_as_long_as_the_closed_gap_demands(approach):
    # [S 22-25] written out: gap of the separated outlines along the bisector, h = eps delta c - g, x_L = sqrt(2 R h)
    model = pair_model("S1002/60E1 1:40", strips=41, approach=approach, **PLAIN)
    solved, contact = settle(bench(model, rolling=False), 6e-3, 0.0, 60e3)
    o, b = rail_origin(model.rail)
    (lobe,), (strips,) = contact.patches, contact.strips
    origin = np.array([HALF_SPACING + 6e-3 - o, solved.height - b])
    (rail, _), (wheel, _) = points(model, origin, lobe, strips["s"])
    main, normals = columns(lobe, "no nb"), columns(strips, "no nb")
    delta = lobe["approach"]
    gap = ((wheel + delta * main[:, None] - rail) * normals.T).sum(axis=0)
    share = normals @ main if approach == "projected" else 1.0
    h = EPSILON * delta * share - gap
    # 1e-8 of the table's places over h of 50 um, more at the edges
    np.testing.assert_allclose(strips["a"] ** 2 / (2.0 * strips["r_t"]), h, atol=2e-8)
    _, w = model.wheel.at(lobe["arc_wheel"] + strips["s"])
    tu, tw = model.wheel.tangent(lobe["arc_wheel"] + strips["s"])
    np.testing.assert_allclose(strips["r_t"], (RADIUS - w) * np.hypot(1.0, tw / tu), rtol=1e-3)  # [S 19]


def groove(wheel_radius, rail_radius, approach, strips=41):
    """A round wheel that lies in a hollow rail; radii in metres."""
    rail = circle("hollow", "rail", -rail_radius, 0.9 * rail_radius)
    return contact_model(round_wheel(wheel_radius, 0.9 * wheel_radius), rail, approach=approach, strips=strips, **PLAIN)


@pytest.mark.parametrize(("wheel_radius", "rail_radius"), [(0.013, 0.0135), (0.013, 0.015), (0.02, 0.05)])
def test_the_contact_angle_varies_by_width_over_mean_radius(wheel_radius, rail_radius):
    # the midline turns by the mean of both curvatures; the angles are those of the outer strips' centres
    lobe = groove(wheel_radius, rail_radius, "projected").evaluate((0.0, 0.0, RADIUS - 5e-5)).patches[0]
    width = lobe["width"] * (1.0 - 1.0 / lobe["n_strips"])
    mean_curvature = 0.5 * (1.0 / wheel_radius + 1.0 / rail_radius)
    variation = lobe["angle_max"] - lobe["angle_min"]
    assert variation > 0.05
    assert variation == pytest.approx(width * mean_curvature, rel=1e-6)
    # in the middle of a symmetric groove
    assert lobe["angle"] == pytest.approx(0.0, abs=1e-9)
    assert lobe["angle_mean"] == pytest.approx(0.0, abs=1e-9)
    assert lobe["angle_max"] == pytest.approx(-lobe["angle_min"], abs=1e-6)


@pytest.mark.parametrize("yaw", [0.005, 0.02])
def test_yaw_shifts_the_strips_along_the_rail(yaw):
    # on a cone of half angle g the line of contact leans: x = r sin(theta), sin(theta) = rho' e_t / q from the locus
    model = pair_model("S1002/60E1 1:40", **PLAIN)
    _, contact = settle(bench(model, rolling=False), 0.007, yaw, 60e3)
    lobe, strips = contact.patches[0], contact.strips[0]
    u, w = model.wheel.at(lobe["arc_wheel"])
    tu, tw = model.wheel.tangent(lobe["arc_wheel"])
    sine = tw / tu * np.tan(yaw)
    assert lobe["x"] == pytest.approx(-u * np.sin(yaw) + (RADIUS - w) * sine * np.cos(yaw), rel=1e-3)
    assert np.ptp(strips["x"]) > 1e-6
