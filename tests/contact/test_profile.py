"""Laws of the profile curve: arclength, frames, curvature, joins, changes, tables."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.examples import examples
from support.rows import rows_of

from wrsim import InputError, Profile, load_profile
from wrsim.contact.profiles.flange import flange_dimensions
from wrsim.contact.profiles.models import write_depths
from wrsim.contact.profiles.sections import ProfileArc, ProfileLine, circle, profile_from_sections, rail_head
from wrsim.contact.profiles.wear import BRIDGE, Removal, area_off, bin_edges, depths_of, on_unworn, smoothed_table, worn

table = rows_of(__file__)

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
    L = np.linspace(h, profile.length - h, 5_003)
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


def test_inclination_turns_the_top_and_clipping_keeps_the_curve():
    inclined = RAIL.inclined(1 / 40)
    crown, foot = RAIL.top, (0.0, -0.172)  # foot of the rail, 172 mm below: it stays outside of the crown
    turned_foot = -np.sin(np.arctan(1 / 40)) * foot[1]
    assert turned_foot > inclined.at(RAIL.arclength_of(crown[0]))[0]
    # The head now leans inward, so its highest point lies on the field side: 300 sin(atan(1/40)) mm along R300.
    assert inclined.top[0] == pytest.approx(0.3 * np.sin(np.arctan(1 / 40)), abs=1e-12)
    assert inclined.tangent(RAIL.arclength_of(0.0))[1] == pytest.approx(np.sin(np.arctan(1 / 40)), abs=1e-12)
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


def test_profiles_that_cannot_be_or_would_overlap_are_refused() -> None:
    line = ProfileLine(-0.02, 0.0, 0.0, 0.0)
    with pytest.raises(InputError, match=r"sections 1 and 2 \(at u = 0 mm\) are 0.01 mm apart; allowed: 0.001 mm"):
        profile_from_sections("gap", "rail", [line, ProfileLine(0.0, 1e-5, 0.02, 1e-5)])
    with pytest.raises(InputError, match=r"meet in a corner of -49.96 mrad; allowed: 0.1 mrad"):
        profile_from_sections("corner", "rail", [line, ProfileLine(0.0, 0.0, 0.02, -0.001)])
    with pytest.raises(InputError, match="arc of radius 80 mm has no room"):
        rail_head("r", [0.3, 0.08, 0.013], [0.02, 0.01], 0.05, 0.03)
    with pytest.raises(InputError, match=r"depth 10 mm ends before the straight sides begin; allowed: above 14\.3"):
        rail_head("r", [0.3, 0.08, 0.013], [0.010228, 0.0260265], 0.05, 0.010)
    with pytest.raises(ValueError, match="read-only"):
        S1002.u[0] = 1.0
    # a groove deeper than the radius of the flange's tip
    new = wheel()
    edges = bin_edges(new, 0.25e-3)
    u = new.at(0.5 * (edges[1:] + edges[:-1]))[0]
    areas = 15e-3 * np.exp(-(((u + 55e-3) / 6e-3) ** 2))
    with pytest.raises(InputError, match="makes the profile overlap itself"):
        worn(new, [depths_of(new, areas, CUTOFF)], "x")


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


# Worn profiles by formula: what is taken off, what is left, and what is refused.
WORN_WHEEL = load_profile(MODELS / "wheels/S1002_worn.toml")
WORN_RAIL = load_profile(MODELS / "rails/60E1_worn.toml")


def bell(x: np.ndarray) -> np.ndarray:
    return np.where(np.abs(x) < 1.0, np.cos(0.5 * np.pi * x) ** 2, 0.0)


def away(profile, u, w):
    """Distance of points from a profile: the nearest point on it, by Newton's method."""
    rows, step = profile.table(2e-5)
    distances = []
    for x, y in zip(u, w, strict=True):
        L = step * int(np.argmin(np.hypot(rows[:, 0] - x, rows[:, 1] - y)))
        for _ in range(4):
            L = float(np.clip(L, 0.0, profile.length))
            tu, tw = profile.tangent(L)
            pu, pw = profile.at(L)
            L += float((x - pu) * tu + (y - pw) * tw)
        pu, pw = profile.at(float(np.clip(L, 0.0, profile.length)))
        distances.append(float(np.hypot(x - pu, y - pw)))
    return np.array(distances)


def test_the_worn_wheel_lacks_the_two_bells_of_its_formula():
    # between the flange tip and the field side, where the profile is a function of u
    u = np.linspace(-0.054, 0.059, 401)
    new = S1002.at(S1002.arclength_of(u))[1]
    taken = 1.1e-3 * bell((u - 2e-3) / 26e-3) + 1.6e-3 * bell((u + 43e-3) / 10e-3)
    np.testing.assert_allclose(WORN_WHEEL.at(WORN_WHEEL.arclength_of(u))[1], new + taken, rtol=0, atol=1e-9)


def test_the_worn_rail_lies_under_the_unworn_one_by_its_formula():
    L = np.linspace(0.0, RAIL.length, 301)
    s = L - RAIL.top_arclength
    taken = 2e-3 * bell((s + 37.90764816e-3) / 18e-3)
    (u, w), (nu, nw) = RAIL.at(L), RAIL.normal(L)
    distance = away(WORN_RAIL, u - taken * nu, w - taken * nw)
    joins = RAIL.arclength[np.abs(RAIL.curvature_after - RAIL.curvature_before) > 1e-3]
    beside = np.abs(L[:, None] - joins).min(axis=1) < 1.2 * BRIDGE
    assert np.abs(distance[~beside]).max() < 1e-9
    # two corners of 6 and 17 mrad, where arcs met: bridged over 0.1 mm, 0.5 um off at most
    assert np.abs(distance).max() < 5e-7
    # the field side is new, below the gauge corner the rail is hollow
    assert WORN_RAIL.curvature(WORN_RAIL.arclength_of(0.02)) == pytest.approx(-1 / 0.08, rel=1e-6)
    hollow = WORN_RAIL.curvature(np.linspace(0.0, 0.045, 4001)).max()
    assert 1e3 / hollow == pytest.approx(55.0, abs=2.0)


def test_the_worn_rail_stands_where_contact_places_it():
    # rail origin of this profile in CONTACT 25.2, gauge 1435 mm, 1:40; it takes the highest sample as the top (1e-4 mm)
    inclined = WORN_RAIL.inclined(1 / 40)
    assert 1435.0 / 2 - 1e3 * inclined.gauge_point()[0] == pytest.approx(751.195462, abs=2e-4)
    assert 1e3 * inclined.top[1] == pytest.approx(0.093706, abs=1e-4)


@pytest.mark.parametrize("profile", [WORN_WHEEL, WORN_RAIL], ids=["wheel", "rail"])
def test_a_worn_profile_is_kept_by_true_arclength(profile):
    (v,) = profile._evaluate(np.linspace(0.0, profile.length, 40_001), 1)
    speed = np.hypot(*v.T)
    # 2e-5 on the bridged corners, whose quintics are given their own lengths
    assert np.abs(speed - 1.0).max() < 2e-5
    assert np.percentile(np.abs(speed - 1.0), 99.0) < 1e-8


HEAD = 'name = "w"\nbody = "rail"\ndate = 2026-01-31\nsource = "test"\nkind = "worn"\n'
DEEP = '[[removals]]\ndirection = "normal"\ndepth_mm = {}\nmiddle_mm = -38\nhalf_width_mm = {}\n'


@pytest.mark.parametrize(("text", "message"), table("wear_that_makes_no_profile_is_refused"))
def test_wear_that_makes_no_profile_is_refused(tmp_path, text, message):
    path = tmp_path / "profile.toml"
    path.write_text(HEAD + text, encoding="utf-8")
    with pytest.raises(InputError, match=message):
        load_profile(path)


def test_wear_adds_up_over_files_until_it_folds_the_curve(tmp_path):
    (tmp_path / "first.toml").write_text(HEAD + 'base = "60E1.toml"\n' + DEEP.format(0.5, 10), encoding="utf-8")
    second = tmp_path / "second.toml"
    second.write_text(
        HEAD + 'base = "first.toml"\n[[removals]]\ndirection = "vertical"\ndepth_mm = 1\nmiddle_mm = 0\n'
        "half_width_mm = 20\n",
        encoding="utf-8",
    )
    assert load_profile(second).at(load_profile(second).arclength_of(0.0))[1] == pytest.approx(-1e-3, abs=1e-12)
    groove = circle("groove", "rail", -0.02, 0.019)
    thin = rail_head("thin", [0.012], [], 0.05, 0.06)
    with pytest.raises(InputError, match=r"it turns back at u = .* mm; allowed: less depth"):
        worn(groove, [Removal("normal", -0.021, 0.0, 0.02)], "filled up")
    with pytest.raises(InputError, match=r"crosses itself at u = .* mm; allowed"):
        worn(thin, [Removal("normal", 0.015, s, 0.015) for s in (-0.043, 0.043)], "eaten through")


# Losses on a profile, place by place: mass, smoothing, overlap; dimensions of the flange.
CUTOFF = 5e-3
Array = np.ndarray


def wheel() -> Profile:
    return load_profile("wheels/S1002.toml")


def losses(profile: Profile, depth: float = 1e-3) -> Array:
    """Tread and flange root, and one bin alone."""
    edges = bin_edges(profile, 0.25e-3)
    u = profile.at(0.5 * (edges[1:] + edges[:-1]))[0]
    areas = depth * np.exp(-(((u + 33e-3) / 3e-3) ** 2)) + 0.7 * depth * np.exp(-(((u - 5e-3) / 10e-3) ** 2))
    areas[np.searchsorted(u, -20e-3)] += depth
    return areas


def enclosed(a: Profile, b: Profile, points: int = 100_001) -> float:
    """Area between two profiles of the same ends, as a polygon [m2]."""
    share = np.linspace(0.0, 1.0, points)
    (x0, y0), (x1, y1) = (p.at(share * p.length) for p in (a, b))
    x, y = np.concatenate([x0, x1[::-1]]), np.concatenate([y0, y1[::-1]])
    return 0.5 * abs(float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()))


def test_a_new_s1002_has_the_dimensions_of_its_standard_and_a_cone_no_flange() -> None:
    """Flange 32.5 mm thick and 28 mm high (EN 13715); qR of the new profile is 10.8 mm."""
    dimensions = flange_dimensions(wheel())
    assert dimensions.thickness == pytest.approx(32.5e-3, abs=1e-6)
    assert dimensions.height == pytest.approx(28.0e-3, abs=1e-6)
    assert dimensions.steepness == pytest.approx(10.8e-3, abs=0.02e-3)
    with pytest.raises(InputError, match="no flange"):
        flange_dimensions(load_profile("wheels/cone_1in20.toml"))


def test_a_tread_that_wears_makes_the_flange_higher_and_thicker() -> None:
    """A tread that loses 1 mm all over: Sh grows by that, and Sd is measured 1 mm nearer to the root."""
    new = wheel()
    edges = bin_edges(new, 0.25e-3)
    u = new.at(0.5 * (edges[1:] + edges[:-1]))[0]
    areas = 1e-3 / (1.0 + np.exp(-(u + 10e-3) / 1e-3))
    old, now = flange_dimensions(new), flange_dimensions(worn(new, [depths_of(new, areas, CUTOFF)], "hollow"))
    assert now.height - old.height == pytest.approx(1e-3, rel=2e-3)
    face = (new.u > -40e-3) & (new.u < -30e-3)
    assert now.thickness == pytest.approx(70e-3 + np.interp(-9e-3, new.w[face], new.u[face]), abs=1e-5)


@pytest.mark.parametrize("name", ["wheels/S1002.toml", "rails/60E1.toml"])
def test_area_off_the_profile_is_area_lost(name: str) -> None:
    """By the depths to round-off, and between the two curves as a polygon."""
    profile = load_profile(name)
    areas = losses(profile)
    table = depths_of(profile, areas, CUTOFF)
    lost = areas.sum() * profile.length / areas.size
    assert sum(area_off(profile, table)) == pytest.approx(lost, rel=1e-13)
    assert enclosed(profile, worn(profile, [table], "worn")) == pytest.approx(lost, rel=1e-6)


def test_smoothing_keeps_the_sum_and_halves_a_wave_of_the_cutoff() -> None:
    areas = losses(wheel())
    smooth = smoothed_table(areas, 0.25e-3, CUTOFF)
    assert smooth.sum() == pytest.approx(areas.sum(), rel=1e-13)
    assert smooth.min() >= 0.0
    x = np.arange(4000) * 0.1e-3
    wave = np.sin(2.0 * np.pi * x / CUTOFF)
    middle = smoothed_table(wave, 0.1e-3, CUTOFF)[1000:3000]
    assert np.abs(middle).max() == pytest.approx(0.5, abs=1e-3)


def test_losses_on_the_worn_profile_come_back_to_the_unworn_one() -> None:
    """Their sum stays, and each stays at its place: on the profile that lost nothing they are the same."""
    new = wheel()
    areas = losses(new)
    np.testing.assert_allclose(on_unworn(new, None, new.length, areas, areas.size), areas, rtol=1e-9, atol=1e-15)
    table = depths_of(new, areas, CUTOFF)
    profile = worn(new, [table], "worn")
    count = int(np.ceil(profile.length / 0.25e-3))
    lost = np.random.default_rng(1).random(count)
    back = on_unworn(new, table, profile.length, lost, areas.size)
    assert back.sum() * new.length / areas.size == pytest.approx(lost.sum() * profile.length / count, rel=1e-12)


def test_a_table_of_depths_is_a_model_file(tmp_path: Path) -> None:
    new = wheel()
    table = depths_of(new, losses(new), CUTOFF)
    (tmp_path / "depths.csv").write_text(write_depths(table))
    head = 'name = "x"\nbody = "wheel"\nkind = "worn"\ndate = 2026-11-22\nsource = "test"\n'
    (tmp_path / "wheel.toml").write_text(head + 'base = "S1002.toml"\ndepths = "depths.csv"\n')
    read = load_profile(tmp_path / "wheel.toml")
    made = worn(new, [table], "x")
    np.testing.assert_allclose(read.w, made.w, rtol=0.0, atol=1e-15)
    (tmp_path / "depths.csv").write_text("place_mm,depth_mm\n0,0\n1,0\n1,0\n2,0\n")
    with pytest.raises(InputError, match=r"depths.csv:4: place_mm = .*: must rise from row to row"):
        load_profile(tmp_path / "wheel.toml")
