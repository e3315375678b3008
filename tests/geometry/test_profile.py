"""Laws of the profile curve: arclength, frames, curvature, joins, changes, tables."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.examples import examples

from wrsim.errors import InputError
from wrsim.geometry.profile.models import load_profile
from wrsim.geometry.profile.profile import Profile
from wrsim.geometry.profile.sections import ProfileArc, ProfileLine, circle, profile_from_sections, rail_head

MODELS = Path(__file__).parents[2] / "models"
S1002 = load_profile(MODELS / "wheels/S1002.toml")
RAIL = load_profile(MODELS / "rails/60E1.toml")
DESIGNED = [S1002, RAIL, load_profile(MODELS / "rails/54E1.toml")]

designed = pytest.mark.parametrize("profile", DESIGNED, ids=lambda p: p.name)


def places(profile: Profile, n: int = 20_011) -> np.ndarray:
    """Arclengths all over the profile, ends included."""
    return np.linspace(0.0, profile.length, n)


@designed
def test_the_parameter_is_true_arclength(profile):
    # 1e-8: where S1002's rounded sections are faded into each other, a third derivative jumps inside an interval.
    h = 1e-6
    L = np.linspace(h, profile.length - h, 20_011)
    inside = np.abs(L[:, None] - profile.arclength).min(axis=1) > h  # difference quotients span no node
    (u1, w1), (u0, w0) = profile.at(L[inside] + h), profile.at(L[inside] - h)
    speed = np.hypot(u1 - u0, w1 - w0) / (2.0 * h)
    np.testing.assert_allclose(speed, 1.0, rtol=0, atol=1e-8)


def test_normals_point_out_of_the_material():
    assert RAIL.normal(RAIL.arclength_of(0.0))[1] == pytest.approx(1.0)
    assert S1002.normal(S1002.arclength_of(0.0))[1] < -0.99


@designed
def test_curvature_is_the_rate_of_the_tangent_angle(profile):
    h = 1e-6
    L = np.linspace(h, profile.length - h, 5003)
    inside = np.abs(L[:, None] - profile.arclength).min(axis=1) > h
    rate = (profile.slope_angle(L + h) - profile.slope_angle(L - h))[inside] / (2.0 * h)
    # 1e-16/h of round-off in the quotient, and the same again in the curvature
    np.testing.assert_allclose(rate, profile.curvature(L)[inside], atol=1e-6)


@designed
def test_position_and_direction_are_continuous_at_every_node(profile):
    L = profile.arclength[1:-1]
    tiny = 1e-12
    np.testing.assert_allclose(profile.at(L - tiny), profile.at(L), atol=3e-12)
    np.testing.assert_allclose(profile.slope_angle(L - tiny), profile.slope_angle(L), atol=1e-9)


@given(radius=st.floats(0.005, 10.0), part=st.floats(0.05, 0.95), hollow=st.booleans())
def test_an_arc_has_the_curvature_of_its_radius(radius, part, hollow):
    sign = -1.0 if hollow else 1.0
    half_width = min(part * radius, 0.05)
    arc = circle("arc", "rail", sign * radius, half_width)
    L = places(arc, 101)
    u, w = arc.at(L)
    np.testing.assert_allclose(np.hypot(u, w + sign * radius), radius, rtol=1e-12)
    # round-off of coordinates up to 50 mm over the square of the shortest interval, 5 um
    np.testing.assert_allclose(arc.curvature(L), -sign / radius, atol=1e-5)
    assert arc.length == pytest.approx(2.0 * radius * np.arcsin(half_width / radius), rel=1e-12)


@settings(max_examples=examples(25))
@given(angle=st.floats(-3.0, 3.0), du=st.floats(-1.0, 1.0), dw=st.floats(-1.0, 1.0))
def test_rotation_and_shift_keep_length_curvature_and_distances(angle, du, dw):
    moved = S1002.rotated(angle).shifted(du, dw)
    L = places(S1002, 501)
    assert moved.length == S1002.length
    np.testing.assert_allclose(moved.curvature(L), S1002.curvature(L), atol=1e-4)  # round-off of coordinates ~1 m
    u, w = S1002.at(L)
    c, s = np.cos(angle), np.sin(angle)
    np.testing.assert_allclose(moved.at(L), [c * u - s * w + du, s * u + c * w + dw], atol=1e-14)


def test_inclination_turns_the_top_towards_the_track_centre():
    inclined = RAIL.inclined(1 / 40)
    crown, foot = RAIL.top, (0.0, -0.172)  # foot of the rail, 172 mm below: it stays outside of the crown
    turned_foot = -np.sin(np.arctan(1 / 40)) * foot[1]
    assert turned_foot > inclined.at(RAIL.arclength_of(crown[0]))[0]
    # The head now leans inward, so its highest point lies on the field side: 300 sin(atan(1/40)) mm along R300.
    assert inclined.top[0] == pytest.approx(0.3 * np.sin(np.arctan(1 / 40)), abs=1e-12)
    assert inclined.tangent(RAIL.arclength_of(0.0))[1] == pytest.approx(np.sin(np.arctan(1 / 40)), abs=1e-12)


def test_clipping_keeps_the_curve():
    first, last = S1002.arclength_of(-0.03), S1002.arclength_of(0.02)
    piece = S1002.clipped(first, last)
    assert piece.length == pytest.approx(last - first, abs=1e-15)
    L = places(piece, 3001)
    np.testing.assert_allclose(piece.at(L), S1002.at(L + first), atol=1e-15)
    np.testing.assert_allclose(piece.curvature(L), S1002.curvature(L + first), atol=1e-4)


def test_arclength_of_finds_the_running_surface_where_u_occurs_twice():
    # Tilted by 10 degrees the gauge flank overhangs: the point met first from the top is wanted.
    tilted = RAIL.rotated(np.radians(10.0))
    u_low = float(tilted.u[0])
    L = tilted.arclength_of(u_low)
    assert L > 0.005
    assert tilted.at(L)[0] == pytest.approx(u_low, abs=1e-15)


@designed
def test_table_rows_are_the_curve_at_uniform_arclength(profile):
    rows, step = profile.table(1e-4)
    assert rows.shape == (int(np.ceil(profile.length / 1e-4)) + 1, 5)
    assert step <= 1e-4 and step * (len(rows) - 1) == pytest.approx(profile.length, rel=1e-15)
    L = np.minimum(step * np.arange(len(rows)), profile.length)
    np.testing.assert_array_equal(rows[:, :2].T, profile.at(L))
    np.testing.assert_array_equal(rows[:, 2:4].T, profile.tangent(L))
    np.testing.assert_array_equal(rows[:, 4], profile.curvature(L))


def test_cubics_through_the_table_converge_with_fourth_order_on_an_arc():
    arc = circle("arc", "rail", 0.013, 0.009)
    errors = []
    for step in (4e-4, 2e-4, 1e-4):
        rows, step = arc.table(step)
        # middle of a cubic Hermite interval
        middle = 0.5 * (rows[1:, :2] + rows[:-1, :2]) + step / 8.0 * (rows[:-1, 2:4] - rows[1:, 2:4])
        true = np.column_stack(arc.at(step * (np.arange(len(rows) - 1) + 0.5)))
        errors.append(np.hypot(*(middle - true).T).max())
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    np.testing.assert_allclose(orders, 4.0, atol=0.1)


def test_sections_out_of_tune_by_rounding_are_joined_smoothly():
    # A line 0.1 um above and turned by 10 urad against the arc that follows it.
    arc = ProfileArc(0.0, -0.05, 0.05, 0.0, -0.5)
    line = ProfileLine(-0.02, 1e-7 - 0.02e-5, 0.0, 1e-7)
    profile = profile_from_sections("joined", "rail", [line, arc])
    u, w = profile.at(places(profile))
    true = np.where(u < 0.0, 0.0, np.sqrt(0.05**2 - np.maximum(u, 0.0) ** 2) - 0.05)
    assert np.abs(w - true).max() < 3e-7
    # The disagreement is faded over 2 mm: no spike of curvature at the join.
    k = profile.curvature(places(profile))
    assert k.min() > -20.2 and k.max() < 0.2


def test_sections_that_do_not_meet_are_refused():
    line = ProfileLine(-0.02, 0.0, 0.0, 0.0)
    with pytest.raises(InputError, match=r"sections 1 and 2 \(at u = 0 mm\) are 0.01 mm apart; allowed: 0.001 mm"):
        profile_from_sections("gap", "rail", [line, ProfileLine(0.0, 1e-5, 0.02, 1e-5)])
    with pytest.raises(InputError, match=r"meet in a corner of -49.96 mrad; allowed: 0.1 mrad"):
        profile_from_sections("corner", "rail", [line, ProfileLine(0.0, 0.0, 0.02, -0.001)])


def test_rail_heads_that_cannot_be_are_refused():
    with pytest.raises(InputError, match="arc of radius 80 mm has no room"):
        rail_head("r", [0.3, 0.08, 0.013], [0.02, 0.01], 0.05, 0.03)
    with pytest.raises(InputError, match=r"depth 10 mm ends before the straight sides begin; allowed: above 14\.3"):
        rail_head("r", [0.3, 0.08, 0.013], [0.010228, 0.0260265], 0.05, 0.010)


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda: RAIL.at(0.2), r"'60E1': arclength 200 mm is off the curve; allowed: 0 to 133.3"),
        (lambda: RAIL.at([0.0, np.nan]), "arclength nan mm is off the curve"),
        (lambda: RAIL.arclength_of([0.0, 0.05]), r"no point at u = 50 mm; allowed: -37.1848 to 37.1848 mm"),
        (lambda: RAIL.table(0.0), "table step 0 mm; allowed: above 0"),
        (lambda: RAIL.clipped(0.02, 0.01), "clip from 20 to 10 mm of arclength; allowed: rising"),
        (lambda: RAIL.gauge_point(0.05), r"no gauge point 50 mm below the top; .* goes 38 mm deep"),
        (lambda: circle("c", "rail", 0.3, 0.03).gauge_point(), "no gauge point 14 mm below the top"),
        (lambda: S1002.gauge_point(), "'S1002': is of a wheel; only rails have a gauge point"),
        (lambda: circle("c", "axle", 0.3, 0.03), "kind is 'axle'; allowed: 'wheel', 'rail'"),
    ],
)
def test_questions_off_the_curve_are_answered_with_what_is_allowed(ask, message):
    with pytest.raises(InputError, match=message):
        ask()


def test_profiles_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        S1002.u[0] = 1.0
