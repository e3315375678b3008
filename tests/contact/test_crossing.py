"""A wheel on a crossing, real and artificial, beside CONTACT's numbers (shared reference, crossing_56e1)."""

import csv
from dataclasses import replace
from functools import cache
from itertools import pairwise
from math import cos, hypot, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from support.contacts import HALF_SPACING, PLAIN, RADIUS, contact_model, settle, wheel_profile
from support.crossings import CROSSING, crossing, lifted, on

from wrsim.analysis.poses.solver import PoseSolver
from wrsim.contact.channels import WheelOnRail
from wrsim.contact.model import Contact, ContactModel
from wrsim.geometry.profile.points import ProfilePoints, interpolated
from wrsim.geometry.profile.profile import Profile
from wrsim.geometry.profile.sections import ProfileArc, ProfileLine, circle, profile_from_sections
from wrsim.geometry.track.rail_surface import RailSection, RailSurface
from wrsim.geometry.track.rolled_rail import rolled_rail

RISE = 0.1


def blunt(start: float, corner: float) -> Profile:
    """A level top, 10 mm wide from ``start`` on, its corners rounded down to 80 degrees [m]."""
    end, steep = start + 0.01, np.radians(80.0)
    arcs = ProfileArc(start, -corner, corner, steep, 0.0), ProfileArc(end, -corner, corner, 0.0, -steep)
    return profile_from_sections("blunt", "rail", (arcs[0], ProfileLine(start, 0.0, end, 0.0), arcs[1]))


def test_the_felt_section_is_the_upper_envelope_where_branches_cross() -> None:
    """The wing's outer corner moves outward: what is felt of it ahead and behind crosses with a notch between them."""
    surface = crossing(-0.3, -0.1)
    felt = rolled_rail(surface, RADIUS)
    u = np.linspace(0.015, 0.034, 400)
    for s in (-0.2434, -0.1438):
        highest = np.full(u.size, -1.0)
        for x in np.linspace(-0.04, 0.04, 201):
            for piece in surface.pieces:
                rows = piece.spline(s + x)
                top = rows[rows[:, 1] > -5e-3]
                drop = RADIUS - sqrt(RADIUS**2 - x**2)
                highest = np.maximum(highest, np.interp(u, top[:, 0], top[:, 1], -1.0, -1.0) - drop)
        rows = felt.section(s)
        rows = rows[rows[:, 1] > -5e-3]
        assert np.interp(u, rows[:, 0], rows[:, 1]) == pytest.approx(highest, abs=1e-5)


def test_an_edge_far_from_the_contact_makes_no_step_there() -> None:
    """At .877 m the edge beside the nose's gap is felt 3 mm longer from one station to the next: rows were counted from
    it, and between them the gauge corner stood up to 38 um too low."""
    felt = rolled_rail(crossing(0.83, 0.92), RADIUS)
    heights = []
    for s in np.arange(0.865, 0.89, 2.5e-4):
        rows = felt.section(float(s))
        top = rows[(rows[:, 1] > -5e-3) & (rows[:, 0] < 0.0)]
        heights.append(np.interp((-0.024, -0.01), top[:, 0], top[:, 1]))
    assert np.ptp(np.array(heights), axis=0).max() < 1e-6


@pytest.fixture(scope="module")
def over_the_crossing() -> ContactModel:
    surface = crossing(0.1, 0.33)
    model = contact_model(
        wheel_profile("S1002"), surface.sections[0].profile, normal="strips", tangential="fastrip", friction=0.3
    )
    return replace(model, rolled=rolled_rail(surface, RADIUS))


def at_rest(model: ContactModel, lateral: float, load: float, place: float) -> tuple[Contact, float]:
    """The contact of a wheel that rolls with that load, and how far it has sunk."""

    def lowered(z: float) -> Contact:
        return model.evaluate((0.0, lateral, RADIUS - z), velocity=(1.0, 0, 0), omega=(0, 1.0 / RADIUS, 0), place=place)

    sunk = brentq(lambda z: lowered(z).force[2] - load, -2e-3, 2e-3, xtol=1e-9)
    return lowered(sunk), sunk


@pytest.mark.parametrize(
    "shifts", [("0.97",), pytest.param(("0.81", "0.89", "1.05", "1.15"), marks=pytest.mark.campaign)]
)
def test_the_load_passes_from_wing_to_nose_as_in_contact(over_the_crossing: ContactModel, shifts) -> None:
    """CONTACT's numbers: shared reference, crossing_56e1/transfer_s239.csv."""
    with (CROSSING / "transfer_s239.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["y_ws_mm"] in shifts]
    for lateral in dict.fromkeys(row["y_ws_mm"] for row in rows):
        own = [row for row in rows if row["y_ws_mm"] == lateral]
        contact, sunk = at_rest(over_the_crossing, 1e-3 * float(lateral), 1e4, 0.239)
        assert 1e3 * sunk == pytest.approx(float(own[0]["z_ws_mm"]), abs=0.0005)
        for row in own:
            y = 1e-3 * float(row["y_tr_mm"]) - 0.75
            patch = min(contact.patches, key=lambda p: abs(p["o"] - y))
            place = 1e-3 * np.array([float(row["x_tr_mm"]), 0.0, -float(row["z_tr_mm"])])
            assert hypot(patch["o"] - y, patch["x"] - place[0], patch["b"] - place[2]) < 3e-4
            assert patch["N"] == pytest.approx(float(row["Fn_N"]), abs=120.0)
            # of the nose, where it carries enough. The wing's patch lies slanted where its curvature changes
            if patch["o"] > 0.0 or patch["N"] > 3e3:
                off = 0.03 if patch["o"] < 0.0 else 0.07 if patch["N"] > 3e3 else 0.09
                assert patch["p0"] == pytest.approx(1e6 * float(row["pmax_MPa"]), rel=off)


def test_wing_and_nose_share_the_load_160_mm_behind_the_tip_as_in_contact(over_the_crossing: ContactModel) -> None:
    """CONTACT's numbers: shared reference, crossing_56e1/README.md. 1 um sideways moves 150 N from one to the other."""
    patches = at_rest(over_the_crossing, 3.52e-3, 1e4, 0.16)[0].patches
    assert len(patches) == 2
    for o, y, force, p0 in ((-1.0, 718.20, 4790.0, 1584e6), (1.0, 782.08, 6171.0, 635e6)):
        patch = next(p for p in patches if p["o"] * o > 0.0)
        assert 750.0 + 1e3 * patch["o"] == pytest.approx(y, abs=0.2)
        assert patch["N"] == pytest.approx(force, abs=200.0)
        assert patch["p0"] == pytest.approx(p0, rel=0.05)


def through(exact: Profile, ends: list[float], apart: float) -> Profile:
    """A profile through points of another, about ``apart`` from each other between the ends of its parts [m]."""
    parts = [np.linspace(a, b, 1 + int((b - a) / apart - 1e-6), endpoint=False) for a, b in pairwise(ends)]
    u, w = exact.at(np.append(np.concatenate(parts), ends[-1]))
    return interpolated(ProfilePoints("points", u, w, np.arange(u.size)), "points", "rail")


def as_in_contact(start: float, corner: float, features: tuple[float, float]) -> Profile:
    """A section ``blunt`` as CONTACT has it: its file has points .2 mm apart, and its surface is cubic between points
    .5 mm apart from feature to feature: a jump of curvature from 200 to 0 1/m is rounded.

    features: that its file of sections marks, counted from 30 mm below the first corner on [m].
    """
    top, steep, flank = blunt(start, corner), np.radians(80.0), 0.03
    along = flank * np.array([cos(steep), sin(steep)])
    (u0, w0), (u1, w1) = (np.array(top.at(a)).ravel() for a in (0.0, top.length))
    before, behind = (
        ProfileLine(u0 - along[0], w0 - along[1], u0, w0),
        ProfileLine(u1, w1, u1 + along[0], w1 - along[1]),
    )
    end = start + 0.01
    corners = ProfileArc(start, -corner, corner, steep, 0.0), ProfileArc(end, -corner, corner, 0.0, -steep)
    parts = (before, corners[0], ProfileLine(start, 0.0, end, 0.0), corners[1], behind)
    exact = profile_from_sections("blunt", "rail", parts)
    edges = np.cumsum([0.0, flank, corner * steep, 0.01, corner * steep, flank])
    filed = through(exact, edges.tolist(), 0.2e-3)
    return through(filed, [0.0, *features, filed.length], 0.5e-3)


@pytest.mark.parametrize(("normal", "force", "p0"), [("strips", 0.05, 0.02), ("half-space", 0.01, 0.01)])
def test_an_artificial_nose_is_touched_and_pressed_as_in_contact(normal: str, force: float, p0: float) -> None:
    """S1002 on a nose that rises 1:10, where its corner of 5 mm meets the level top: 10 090 N, 2 478 MPa, approach
    .03368 mm, 45.757 mm ahead of the axle (shared reference; section: test bank of CONTACT,
    testbank/profiles/cross_nose)."""
    places = np.linspace(-0.1, 0.1, 21)
    model = on(
        lifted(as_in_contact(5e-3, 5e-3, (33.0541e-3, 50.9076e-3)), places, RISE * places),
        normal,
        wheel_profile("S1002"),
    )
    (patch,) = model.evaluate((0.0, 0.0, RADIUS + 2.1275e-3)).patches
    assert patch["x"] == pytest.approx(45.757e-3, abs=5e-5)
    # CONTACT tells the middle of the overlap, 5.127 mm, here it is the deepest point
    assert patch["o"] == pytest.approx(5.127e-3, abs=3e-4)
    assert patch["N"] == pytest.approx(10090.0, rel=force)
    assert patch["p0"] == pytest.approx(2478e6, rel=p0)
    assert patch["approach"] == pytest.approx(0.03368e-3, rel=0.025)


@pytest.mark.parametrize("top", [
    pytest.param(blunt(0.02, 0.01), marks=pytest.mark.campaign), as_in_contact(0.02, 0.01, (36.1086e-3, 61.8166e-3)),
])  # fmt: skip
@pytest.mark.parametrize(("normal", "share"), [("strips", 0.015), ("half-space", 0.01)])
def test_an_artificial_wing_that_recedes_is_touched_and_pressed_as_in_contact(top, normal: str, share: float) -> None:
    """S1002 100 mm along a wing that recedes 1:10, .6589 mm deep: 10 160 N, 29.231 mm outside, 2 589 MPa (shared
    reference; section, a level top with corners of 10 mm: test bank of CONTACT, testbank/profiles/wing_rail); as it is
    drawn, and as CONTACT has it."""
    wing = RailSurface("wing", tuple(RailSection(s, top.shifted(0.1 * s, 0.0)) for s in np.linspace(0.0, 0.2, 21)))
    choices = {"tangential": "fastrip" if normal == "strips" else "half-space"}
    model = on(wing, normal, wheel_profile("S1002"), friction=0.3, **choices)
    rolling = {"velocity": (2.0, 0.0, 0.0), "omega": (0.0, 4.3481181, 0.0)}
    contact = model.evaluate((0.0, 0.0, RADIUS - 0.6589e-3), place=0.1, **rolling)
    assert contact.force[2] == pytest.approx(10160.0, rel=share)
    (patch,) = contact.patches
    assert patch["o"] == pytest.approx(29.231e-3, abs=2e-5)
    near = 0.05 if top.name == "blunt" else {"strips": 0.025, "half-space": 0.005}[normal]
    assert patch["p0"] == pytest.approx(2589e6, rel=near)


# A rail corner in hollow wheel arcs against CONTACT on its curved surface: how well the curved patch is met.
CORNER = 0.013


@cache
def errors(approach):
    """Rows: wheel radius [m]; errors of the patch's span of angles, of p0, of the resultant and its direction [rad]."""
    lines = (Path(__file__).parents[1] / "data/contact_grooves.csv").read_text().splitlines()
    rows = []
    for text in csv.DictReader(line for line in lines if not line.startswith("#")):
        r = {name: float(value) for name, value in text.items()}
        hollow = circle("hollow", "wheel", 1e-3 * r["R_wheel_mm"], 0.95e-3 * r["R_wheel_mm"])
        corner = circle("corner", "rail", CORNER, 0.98 * CORNER)
        radius = 1e-3 * r["R_roll_mm"]
        model = contact_model(hollow, corner, radius=radius, approach=approach, **PLAIN)
        stand = PoseSolver([WheelOnRail(model, 1, HALF_SPACING, (HALF_SPACING, 0.0))], False, radius)
        solved, contact = settle(stand, 1e-3 * r["y_ws_mm"], 0.0, r["Fz_req_N"])
        assert not solved.message
        (lobe,) = contact.patches
        span = np.degrees(lobe["angle_max"] - lobe["angle_min"]) * lobe["n_strips"] / (lobe["n_strips"] - 1.0)
        rows.append(
            (
                1e-3 * r["R_wheel_mm"],
                span / (r["ang_at_smax_deg"] - r["ang_at_smin_deg"]) - 1.0,
                lobe["p0"] / (1e6 * r["pmax_MPa"]) - 1.0,
                np.hypot(*stand.force[1:]) / r["Fres_N"] - 1.0,
                np.arctan2(-stand.force[1], stand.force[2]) - np.radians(r["force_angle_deg"]),
            )
        )
    return np.array(rows)


def test_resultants_of_conformal_patches():
    # the direction of the sum of the strips' forces; the vertical load is prescribed
    found = errors("projected")
    assert len(found) > 30
    assert np.abs(found[:, 3]).max() < 0.02
    assert np.abs(found[:, 4]).max() < 0.02


def test_a_projected_approach_comes_nearer_than_a_constant_one():
    # a rigid approach closes only its share along each normal: in every groove the narrower patch is the better one
    projected, constant = errors("projected"), errors("constant")
    assert (np.abs(projected[:, 1]) < np.abs(constant[:, 1])).all()
    assert (np.abs(projected[:, 2]) < np.abs(constant[:, 2])).all()
